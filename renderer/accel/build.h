// Builds trees: binned surface-area heuristic into a binary tree, then collapsed to 8 wide.
//
// Source: Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies"; the collapse
// is the cheapest one, by dynamic programming (Ylitie, Karras, Laine 2017, "Efficient Incoherent
// Ray Traversal on GPUs Through Compressed Wide BVHs", 3). Threads: building uses the pool; the
// tree is the same for any number of threads.

#ifndef CO_ACCEL_BUILD_H
#define CO_ACCEL_BUILD_H

#include "accel/node.h"

// One thing to put into a tree. lo <= hi, finite.
typedef struct CoBuildPrim {
    float lo[3];
    uint32_t id;
    float hi[3];
    uint32_t unused;
} CoBuildPrim;

// What leaves look like.
typedef struct CoLeafRule {
    // True when these may be one leaf; must hold for a single one. Called from any thread.
    bool (*fits)(const void *context, const CoBuildPrim *prims, size_t count);
    // Stores a leaf and gives its reference. False on failure, with *err set. Called in order.
    bool (*emit)(void *context, const CoBuildPrim *prims, size_t count, uint32_t *ref,
                 CohortError *err);
    void *context;
    size_t most; // prims of a leaf
} CoLeafRule;

// Builds a tree over prims [0, count), count < 2^31, which are reordered. On failure *out is an
// empty tree.
bool co_tree_build(CoBuildPrim *prims, uint32_t count, const CoLeafRule *rule, CoTree *out,
                   CohortError *err);
void co_tree_clear(CoTree *tree);

// Grows an array to hold at least `count` elements. The capacity is in elements.
bool co_tree_grow(void **array, size_t *capacity, size_t count, size_t element, CohortError *err);

// Gives back what an array holds beyond `count`; a failure to do so is harmless.
void co_tree_shrink(void **array, size_t *capacity, size_t count, size_t element);

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

// A binary tree in the making. Node numbers depend on the threads' timing, the tree does not:
// whoever walks it goes by its shape.
typedef struct CoBinaryNode {
    CoBox box;
    uint32_t first, count; // range of prims
    uint32_t left;         // 0 for a leaf; the right child is the next one
} CoBinaryNode;

// Builds into nodes[0 .. 2 count - 2] and returns how many there are; 0 on failure. count >= 1.
size_t co_binary_build(CoBuildPrim *prims, uint32_t count, const CoLeafRule *rule,
                       CoBinaryNode *nodes, CohortError *err);

#endif
