// Cuts all prims into ranges small enough for one thread to build a subtree over each.
//
// Private to the builder. Threads: the large ranges are split by all of them, the others side by
// side. What comes out does not depend on how many there are.

#ifndef CO_ACCEL_OPEN_H
#define CO_ACCEL_OPEN_H

#include "accel/subtree.h"

// The ranges from left to right, and the binary tree above them, planned: children before their
// parent, the root last. A leaf of it has the number of its range in `leaf`.
typedef struct CoOpening {
    CoRange *ranges;
    CoBinaryNode *binary;
    size_t range_count, range_capacity, binary_count, binary_capacity;
    size_t largest; // prims of a range
    CoBox box;
    double scale; // see CoSubtree
} CoOpening;

// Takes at least one prim; `leaf` of them at most become a leaf. False when memory ends; *out is to
// be cleared all the same.
bool co_opening_make(const CoPrimArray *prims, size_t leaf, uint32_t threads, CoOpening *out);
static inline uint32_t co_opening_root(const CoOpening *opening)
{
    return (uint32_t)(opening->binary_count - 1) * CO_BINARY_UNITS;
}

void co_opening_clear(CoOpening *opening);

#endif
