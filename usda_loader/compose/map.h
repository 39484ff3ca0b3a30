// Map functions: how an arc carries paths and times from its source to its target.
//
// A map is a set of path pairs, source -> target; the longest matching pair decides. A path that no
// pair covers has no image. Times go t -> t * scale + offset. Maps are constant once made.

#ifndef CO_COMPOSE_MAP_H
#define CO_COMPOSE_MAP_H

#include "compose/prim_path.h"

typedef struct CoMapPair {
    const CoPath *source;
    const CoPath *target; // NULL: the source is cut off
} CoMapPair;

typedef struct CoMap {
    double offset, scale;
    uint32_t count;
    bool is_in_steps;  // see co_map_compose_exactly
    uint32_t capacity; // of each half of `slots`; 0: few pairs, looked through one by one
    uint32_t *slots;   // pairs by source, then pairs by target: their number + 1
    CoMapPair pairs[];
} CoMap;

// All makers take what they need from the table's arena and return NULL when memory is at an end.
const CoMap *co_map_identity(CoPathTable *table);

// source -> target, and "/" -> "/" as well if `has_root`.
CoMap *co_map_pair(CoPathTable *table, const CoPath *source, const CoPath *target, bool has_root,
                   double offset, double scale);

// Of `count` pairs as they stand.
CoMap *co_map_pairs(CoPathTable *table, const CoMapPair *pairs, size_t count);

const CoMap *co_map_with_root(CoPathTable *table, const CoMap *map);
const CoMap *co_map_compose(CoPathTable *table, const CoMap *outer, const CoMap *inner);

// The same, and where one of the maps goes in steps, as those of references do whose paths are then
// relocated, no path that `inner` has no image for has one in the whole. For targets; the maps that
// classes are passed on by do without.
const CoMap *co_map_compose_exactly(CoPathTable *table, const CoMap *outer, const CoMap *inner);
CoMap *co_map_inverse(CoPathTable *table, const CoMap *map);
bool co_map_equal(const CoMap *a, const CoMap *b);
bool co_map_is_identity(const CoMap *map);

// The image of a path without variant selections, or NULL if it has none. Memory running out looks
// the same, except that table->arena has then refused (callers test that once, at the end).
const CoPath *co_map_to_target(CoPathTable *table, const CoMap *map, const CoPath *path);
const CoPath *co_map_to_source(CoPathTable *table, const CoMap *map, const CoPath *path);

#endif
