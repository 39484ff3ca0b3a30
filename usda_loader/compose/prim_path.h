// Prim paths, interned: one object per path, so that equal paths are equal pointers.
//
// A path is a chain of elements from the root "/". An element is a prim name, or a variant
// selection {set=selection} of the prim before it, which only paths into layers have. Table and
// paths live in the arena given at init. Threads: one at a time while the table grows; paths
// themselves are constant.

#ifndef CO_COMPOSE_PRIM_PATH_H
#define CO_COMPOSE_PRIM_PATH_H

#include "base/arena.h"

typedef struct CoPath CoPath;
struct CoPath {
    const CoPath *parent;  // NULL for "/"
    const char *name;      // token of the prim, or of the variant set
    const char *selection; // token; NULL for prims
    const CoPath *prim;    // the same path without variant selections
    uint32_t length;       // elements
    uint32_t depth;        // prim elements only
    uint32_t number;       // in the order of making, "/" is 0
};

// Tells most paths apart without going to them, which in a big table is far.
typedef struct CoPathSlot {
    uint32_t hash, number; // number 0: empty
} CoPathSlot;

typedef struct CoPathTable {
    CoArena *arena;
    CoPathSlot *slots; // open addressing
    size_t capacity;   // a power of two, or 0
    CoPath **pages;    // paths by number, from 1 on
    size_t page_count, page_capacity;
    uint32_t count;
    CoPath root;
    const struct CoMap *identity;       // made when first asked for
    struct CoComposition *compositions; // of large maps: open addressing (map.c)
    size_t composition_count, composition_capacity;
    bool is_short; // memory for a path was refused
} CoPathTable;

void co_path_table_init(CoPathTable *table, CoArena *arena);

// All of these return NULL when memory is at an end.
const CoPath *co_path_child(CoPathTable *table, const CoPath *parent, const char *name);
const CoPath *co_path_variant(CoPathTable *table, const CoPath *parent, const char *set,
                              const char *selection);

// The path without making it: NULL when nothing has asked for it before.
const CoPath *co_path_find_child(const CoPathTable *table, const CoPath *parent, const char *name);

// `path` with its leading `from` exchanged for `to`; `path` must start with `from`.
const CoPath *co_path_replace_prefix(CoPathTable *table, const CoPath *path, const CoPath *from,
                                     const CoPath *to);

// Parses "/A/B", "B", "../C" or "." against `anchor` (used for relative text only). Anything that
// is no prim path gives NULL with *malformed = true; running out of memory gives NULL with false.
const CoPath *co_path_parse(CoPathTable *table, const char *text, size_t length,
                            const CoPath *anchor, bool *malformed);

bool co_path_has_prefix(const CoPath *path, const CoPath *prefix);

// The path cut to its first `length` elements.
const CoPath *co_path_cut(const CoPath *path, uint32_t length);

// Writes "/A{v=x}B" with a NUL, at most `size` bytes, and returns the full length.
size_t co_path_text(const CoPath *path, char *out, size_t size);

#endif
