#include "compose/list_op.h"

#include <string.h>

bool co_list_item_equal(const CoListItem *a, const CoListItem *b)
{
    return a->a == b->a && a->b == b->b && a->offset == b->offset && a->scale == b->scale;
}

void co_list_push(CoComposer *c, CoList *list, CoListItem item)
{
    if (list->count == list->capacity) {
        size_t capacity = list->capacity ? list->capacity * 2 : 8;
        CoListItem *items = list->is_scratch ? co_composer_scratch(c, capacity, sizeof *items)
                                             : co_composer_array(c, capacity, sizeof *items);
        if (list->count)
            memcpy(items, list->items, list->count * sizeof *items);
        list->items = items;
        list->capacity = capacity;
    }
    list->items[list->count++] = item;
}

static size_t find(const CoList *list, const CoListItem *item)
{
    for (size_t i = 0; i < list->count; i++)
        if (co_list_item_equal(&list->items[i], item))
            return i;
    return list->count;
}

static void remove_item(CoList *list, const CoListItem *item)
{
    size_t at = find(list, item);
    if (at == list->count)
        return;
    list->count--;
    memmove(list->items + at, list->items + at + 1, (list->count - at) * sizeof *list->items);
}

static void insert_first(CoComposer *c, CoList *list, CoListItem item)
{
    co_list_push(c, list, item);
    memmove(list->items + 1, list->items, (list->count - 1) * sizeof *list->items);
    list->items[0] = item;
}

void co_list_reorder(CoComposer *c, CoList *list, const CoListItem *order, size_t count)
{
    if (!count || list->count < 2)
        return;
    CoList out = {.is_scratch = list->is_scratch};
    bool *taken = co_composer_scratch(c, list->count, sizeof *taken);
    bool *named = co_composer_scratch(c, list->count, sizeof *named);
    for (size_t i = 0; i < count; i++) {
        size_t at = find(list, &order[i]);
        if (at < list->count)
            named[at] = true;
    }
    // What stands before the first named element stays in front.
    for (size_t i = 0; i < list->count && !named[i]; i++) {
        taken[i] = true;
        co_list_push(c, &out, list->items[i]);
    }
    for (size_t i = 0; i < count; i++) {
        size_t at = find(list, &order[i]);
        if (at == list->count || taken[at])
            continue;
        do {
            taken[at] = true;
            co_list_push(c, &out, list->items[at]);
            at++;
        } while (at < list->count && !named[at]);
    }
    *list = out;
}

static void apply_kind(CoComposer *c, CoList *list, const CoListOp *op, CoListOpKind kind,
                       CoListItemFn *fn, void *context)
{
    size_t count = op->list[kind].count;
    CoList ordered = {.is_scratch = true};
    for (size_t i = 0; i < count; i++) {
        CoListItem item = {0};
        if (!fn(context, op, kind, kind == CO_LIST_PREPENDED ? count - 1 - i : i, &item))
            continue;
        switch (kind) {
        case CO_LIST_EXPLICIT:
        case CO_LIST_ADDED:
            if (find(list, &item) == list->count)
                co_list_push(c, list, item);
            break;
        case CO_LIST_PREPENDED:
            remove_item(list, &item);
            insert_first(c, list, item);
            break;
        case CO_LIST_APPENDED:
            remove_item(list, &item);
            co_list_push(c, list, item);
            break;
        case CO_LIST_DELETED:
            remove_item(list, &item);
            break;
        case CO_LIST_ORDERED:
            co_list_push(c, &ordered, item);
            break;
        case CO_LIST_KIND_COUNT:
            break;
        }
    }
    co_list_reorder(c, list, ordered.items, ordered.count);
}

void co_list_apply(CoComposer *c, CoList *list, const CoListOp *op, CoListItemFn *item,
                   void *context)
{
    if (op->is_explicit) {
        list->count = 0;
        apply_kind(c, list, op, CO_LIST_EXPLICIT, item, context);
        return;
    }
    static const CoListOpKind kinds[] = {CO_LIST_DELETED, CO_LIST_ADDED, CO_LIST_PREPENDED,
                                         CO_LIST_APPENDED, CO_LIST_ORDERED};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        apply_kind(c, list, op, kinds[i], item, context);
}
