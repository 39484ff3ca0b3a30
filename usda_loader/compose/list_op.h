// List ops: editing a list from the weakest layer to the strongest.

#ifndef CO_COMPOSE_LIST_OP_H
#define CO_COMPOSE_LIST_OP_H

#include "compose/composer.h"

// An item of any list op. `a`, `b`, `offset` and `scale` decide equality; the rest tags along.
typedef struct CoListItem {
    const void *a, *b; // tokens, or a number cast to a pointer
    double offset, scale;
    const void *source; // whoever authored it
    const void *extra;
    uint32_t line;
} CoListItem;

typedef struct CoList {
    CoListItem *items;
    size_t count, capacity;
    bool is_scratch; // grows in the composer's scratch arena
} CoList;

// Turns item `i` of one of an op's lists into a CoListItem; false drops it.
typedef bool CoListItemFn(void *context, const CoListOp *op, CoListOpKind kind, size_t i,
                          CoListItem *out);

// Edits `list` by `op`: explicit replaces; else delete, add, prepend, append, reorder.
void co_list_apply(CoComposer *c, CoList *list, const CoListOp *op, CoListItemFn *item,
                   void *context);

// Moves the elements of `list` named in `order` (equal by `a`) into that order; each takes along
// the unnamed ones that follow it.
void co_list_reorder(CoComposer *c, CoList *list, const CoListItem *order, size_t count);

bool co_list_item_equal(const CoListItem *a, const CoListItem *b);
void co_list_push(CoComposer *c, CoList *list, CoListItem item);

#endif
