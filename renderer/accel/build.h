// Builds trees: binned surface-area heuristic into binary trees, then collapsed to 8 wide.
//
// Large ranges are split by passes of all threads until they are small; then one thread makes a
// binary tree over each, which takes the place of the prims that have become leaves. By then the
// size of everything is known: nodes are written where they stay, what is left is the numbers of
// the prims, and leaves are written from those. So a build never holds much more than its prims,
// or than its result. A small tree is built by one thread alone.
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

// A leaf that is to be written.
typedef struct CoLeafShape {
    uint32_t ids[CO_LEAF_WIDTH]; // below 2^31, in the order in which they are asked for later
    uint32_t count;
    uint32_t bytes; // a multiple of CO_LEAF_UNIT; 0: the reference is all of it
    uint32_t ref;   // less its place, which the builder adds
} CoLeafShape;

// What leaves look like. Its functions are called from any thread.
typedef struct CoLeafRule {
    // Whether these may be one leaf, which must hold for a single one, and what it is then.
    bool (*fits)(const void *context, const CoBuildPrim *prims, size_t count, CoLeafShape *out);
    // Writes one that has bytes; returns how many.
    size_t (*emit)(const void *context, const uint32_t *ids, size_t count, unsigned char *out);
    // Of these there will soon be leaves: hints, NULL if they are of no use. The second comes
    // before they are written.
    void (*approach)(const void *context, const CoBuildPrim *prims, size_t count);
    void (*expect)(const void *context, uint32_t near_id, uint32_t far_id);
    const void *context;
    size_t most; // prims of a leaf, up to CO_LEAF_WIDTH
    size_t flat; // of so many, each is a leaf of one node, however they lie: for things alike and
                 // side by side, CO_NODE_WIDTH; else 0
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

// How many threads build over so many prims: one where others would be waited for longer than they
// help, which depends on what else the machine does.
uint32_t co_build_threads(size_t count);
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

// The triangles of a leaf and the distinct points they share.
typedef struct CoLeafCorners {
    uint32_t points[CO_LEAF_WIDTH];
    uint8_t corner[3][CO_LEAF_WIDTH]; // into points
    uint32_t point_count;
} CoLeafCorners;

// Ascending.
void co_leaf_sort(uint32_t *numbers, size_t count);

static inline bool co_leaf_is_near(const uint32_t *tris, size_t count)
{
    return tris[count - 1] - tris[0] <= UINT16_MAX;
}

// Of triangles in order and so many bytes of points.
size_t co_leaf_bytes(const uint32_t *tris, size_t count, size_t point_bytes);

// What stands before a leaf's points, and behind them, see node.h. Return where they end.
unsigned char *co_leaf_put_corners(unsigned char *out, const CoLeafCorners *corners, size_t count);
unsigned char *co_leaf_put_runs(unsigned char *out, const uint32_t *tris, size_t count);

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

static inline bool co_box_is_empty(const CoBox *box)
{
    return !(box->lo[0] <= box->hi[0]);
}

// Its longest side; 0 of an empty one. In double, so that no finite box overflows.
static inline double co_box_size(const CoBox *box)
{
    double size = 0.0;
    for (int k = 0; k < 3; k++)
        size = fmax(size, (double)box->hi[k] - (double)box->lo[k]);
    return size;
}

// In double too.
static inline double co_box_area(const CoBox *box)
{
    double d[3];
    for (int k = 0; k < 3; k++)
        d[k] = (double)box->hi[k] - (double)box->lo[k];
    return d[0] < 0.0 ? 0.0 : d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
}

#endif
