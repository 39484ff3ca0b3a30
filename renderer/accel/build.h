// Builds trees: binned surface-area heuristic into binary trees, then collapsed to 8 wide.
//
// Large ranges are split by passes of all threads until they are small; then each is built,
// collapsed and packed by one thread, and what it needed is given back at once. So a build never
// holds much more than its result, and its memory does not grow with a binary tree over everything.
//
// Source: Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies"; the collapse
// is the cheapest one, by dynamic programming (Ylitie, Karras, Laine 2017, "Efficient Incoherent
// Ray Traversal on GPUs Through Compressed Wide BVHs", 3). Threads: building uses the pool; the
// tree is the same for any number of threads.

#ifndef CO_ACCEL_BUILD_H
#define CO_ACCEL_BUILD_H

#include "accel/node.h"

// One thing to put into a tree. lo <= hi, finite. Most of what a build holds at its peak, so there
// is no padding; four floats from lo or from hi on are within it.
typedef struct CoBuildPrim {
    float lo[3], hi[3];
    uint32_t id;
} CoBuildPrim;
_Static_assert(sizeof(CoBuildPrim) == 28, "boxes and ids alone");

// What leaves look like. Its functions are called from any thread.
typedef struct CoLeafRule {
    // True when these may be one leaf, which must hold for a single one. They are written as a leaf
    // later then.
    bool (*fits)(const void *context, const CoBuildPrim *prims, size_t count);
    // Writes a leaf to `out`, says its size, a multiple of CO_LEAF_UNIT, 0 where leaves are only
    // references, and gives its reference, less its place, which the builder adds.
    uint32_t (*emit)(const void *context, const CoBuildPrim *prims, size_t count,
                     unsigned char *out, size_t *bytes);
    // Of these there will soon be leaves: a hint, NULL if it is of no use.
    void (*approach)(const void *context, const CoBuildPrim *prims, size_t count);
    const void *context;
    size_t most;       // prims of a leaf
    size_t flat;       // of so many, each is a leaf of one node, however they lie: for things alike
                       // and side by side, CO_NODE_WIDTH; else 0
    size_t prim_bytes; // most bytes of a leaf by its prims
} CoLeafRule;

// A tree and its leaves. There are CO_LEAF_TAIL bytes of zero behind the last leaf.
typedef struct CoTreeParts {
    CoTree tree;
    unsigned char *leaves;
    size_t leaf_bytes, leaf_capacity;
} CoTreeParts;

// What a tree is to be built over; a block of CO_MEMORY_ACCEL.
typedef struct CoPrimArray {
    CoBuildPrim *prims;
    size_t count, capacity;
} CoPrimArray;

// Builds a tree over fewer than 2^31 prims and frees them on the way, on failure too. On failure
// *out is empty.
bool co_tree_build(CoPrimArray *prims, const CoLeafRule *rule, CoTreeParts *out, CohortError *err);
void co_tree_parts_clear(CoTreeParts *parts);
void co_tree_clear(CoTree *tree);
void co_prims_free(CoPrimArray *prims);

// Empties a node and sets one of its children.
void co_wide_node_clear(CoWideNode *node);
void co_wide_node_set(CoWideNode *node, int i, const CoBox *box, uint32_t ref);

void co_bvh_block_leave(CoBvhBlock *block);

// Measures the instances of a top again and numbers their paths. False when it is not the same ones
// that have a box.
bool co_top_measure(CoTop *top, const CoInstance *instances, const CoObject *objects);

static inline void co_box_empty(CoBox *box)
{
    for (int k = 0; k < 3; k++) {
        box->lo[k] = INFINITY;
        box->hi[k] = -INFINITY;
    }
}

static inline void co_box_extend(CoBox *box, const float lo[3], const float hi[3])
{
    for (int k = 0; k < 3; k++) {
        box->lo[k] = lo[k] < box->lo[k] ? lo[k] : box->lo[k];
        box->hi[k] = hi[k] > box->hi[k] ? hi[k] : box->hi[k];
    }
}

// In double, so that no finite box overflows.
static inline double co_box_area(const CoBox *box)
{
    double d[3];
    for (int k = 0; k < 3; k++)
        d[k] = (double)box->hi[k] - (double)box->lo[k];
    return d[0] < 0.0 ? 0.0 : d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
}

#endif
