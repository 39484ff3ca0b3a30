// What a built tree looks like in memory: wide nodes, triangle leaves, the bottom and the top
// level.
//
// Private to the accel room: builders write it, kernels read it. The layout is one for all
// instruction sets, so a tree may be built once and walked by any.

#ifndef CO_ACCEL_NODE_H
#define CO_ACCEL_NODE_H

#include "accel/accel.h"

#include <stdatomic.h>

enum {
    CO_NODE_WIDTH = 8,
    CO_LEAF_WIDTH = 16,     // most triangles of a leaf, and most distinct points
    CO_TREE_DEPTH_MAX = 96, // see build.c; a walk's stack never holds more than 7 per level
    CO_STACK_SIZE = 7 * CO_TREE_DEPTH_MAX + 8
};

// A child: an inner node's index, or with CO_REF_LEAF a leaf. A leaf of a mesh has its place, in
// units of CO_LEAF_UNIT, below; a leaf of a group has the instance's index.
#define CO_REF_LEAF 0x80000000u
#define CO_REF_LEAF_PLACE 0x7fffffffu
#define CO_REF_NONE 0x7fffffffu

// Up to 8 children. Rows: 2 axis + (0 = low plane, 1 = high plane). Children that are not there
// have planes at +inf and -inf, which no ray enters.
typedef struct CoWideNode {
    float planes[6][CO_NODE_WIDTH];
    uint32_t child[CO_NODE_WIDTH];
} CoWideNode;
_Static_assert(sizeof(CoWideNode) == 224, "a node is seven half cache lines");

// Up to 16 triangles over at most 16 points, packed; each point stands once and is sheared once.
// Triangles stand in the order of their numbers, which mostly come in runs.
//
//   uint8_t  sizes                   n - 1, and p - 1 from bit 4 on
//   uint8_t  corner[3][(n + 1) / 2]  point of corner 0 of every triangle, then of corner 1, 2: 4
//                                    bits each, the lower first
//   (to a multiple of 4)
//   uint32_t first                   number of triangle 0 in the mesh; CO_LEAF_NEAR: see skipped
//   float    points[3][p]            by axis
//   uint16_t starts                  bit i: i begins a run
//   uint32_t skipped[]               of each run but the first: numbers skipped before it in all;
//                                    with CO_LEAF_NEAR uint16_t, else at a multiple of 4
//   (to a multiple of 4)
//
// Kernels load 16 of everything and leave what is beyond the end alone: the last leaf has
// CO_LEAF_TAIL bytes behind it.
enum {
    CO_LEAF_UNIT = 4,
    CO_LEAF_TAIL = 64
};
#define CO_LEAF_NEAR 0x80000000u

typedef struct CoTriLeaf {
    uint32_t count, point_count;
    size_t row;            // bytes of corners
    const uint8_t *corner; // three rows
    const float *points[3];
    bool is_flat; // of a mesh that is
} CoTriLeaf;

// Where `first` is in a leaf of so many.
static inline size_t co_leaf_first(uint32_t count)
{
    return (1 + 3 * (size_t)((count + 1) / 2) + 3) & ~(size_t)3;
}

static inline CoTriLeaf co_leaf_open(const unsigned char *bytes)
{
    CoTriLeaf leaf = {.count = (bytes[0] & 15u) + 1, .point_count = (bytes[0] >> 4) + 1u};
    leaf.row = (leaf.count + 1) / 2;
    leaf.corner = bytes + 1;
    leaf.points[0] = (const float *)(const void *)(bytes + co_leaf_first(leaf.count) + 4);
    leaf.points[1] = leaf.points[0] + leaf.point_count;
    leaf.points[2] = leaf.points[1] + leaf.point_count;
    return leaf;
}

// Which point corner c of triangle i is.
static inline uint32_t co_leaf_corner(const CoTriLeaf *leaf, uint32_t c, uint32_t i)
{
    return (uint32_t)leaf->corner[c * leaf->row + i / 2] >> 4 * (i & 1u) & 15u;
}

// The number of triangle i in the mesh.
static inline uint32_t co_leaf_tri(const CoTriLeaf *leaf, uint32_t i)
{
    const uint32_t first = *((const uint32_t *)(const void *)leaf->points[0] - 1);
    const uint16_t *starts = (const void *)(leaf->points[2] + leaf->point_count);
    uint32_t runs = (uint32_t)__builtin_popcount(*starts & ((2u << i) - 1u)), skipped = 0;
    if (runs > 1 && first & CO_LEAF_NEAR)
        skipped = starts[runs - 1];
    else if (runs > 1)
        skipped = ((const uint32_t *)(const void *)starts)[runs - 1];
    return (first & ~CO_LEAF_NEAR) + i + skipped;
}

typedef struct CoBox {
    float lo[3], hi[3];
} CoBox;

// A tree of wide nodes; node 0 is the root; no nodes when there is nothing in it.
typedef struct CoTree {
    CoWideNode *nodes;
    size_t node_count, node_capacity;
    CoBox box;         // of everything in it
    double built_cost; // what a walk was expected to cost when it was built; 0: not known yet
} CoTree;

// Head of a block that BVHs share; the thread that fills it is one of the users.
typedef struct CoBvhBlock {
    atomic_size_t users;
    size_t used; // bytes
} CoBvhBlock;

// What leaves of patches are, see grid_leaf.h.
typedef enum CoGridLeafKind {
    CO_GRID_BLOCK = 0,
    CO_GRID_TILE,
    CO_GRID_LIST,
    CO_GRID_NUMBERED
} CoGridLeafKind;

struct CoBvh {
    CoTree tree;
    unsigned char *leaves;
    size_t leaf_bytes, leaf_capacity;
    CoBvhBlock *block; // that nodes and leaves stand in, or NULL
    bool is_flat;      // the mesh is
    bool has_shards;   // boxes of leaves are less than those of their triangles, see shards.h
    // What leaf references count: leaves and CO_LEAF_UNIT, or the mesh's patches themselves.
    const unsigned char *leaf_at;
    size_t leaf_stride;
    // Of a mesh of patches, whose leaves are those of grid_leaf.h; else NULL.
    const CoPatchTable *patches;
    const struct CoGridPlan *plans; // see grid_plan.h
    CoGridLeafKind grid;
    uint32_t block_shift; // log2 of blocks of a patch, where these are leaves
    const float *points;
    uint32_t last_point;
};

// All that a walk wants of an instance: one cache line.
typedef struct CoPlaced {
    CoBox box;            // group space, padded (see top.c); empty when there is nothing in it
    uint32_t first_path;  // paths of the instances before this one: a prefix sum
    uint32_t hidden_from; // CohortHidden bits
    const CoBvh *bvh;     // of a mesh, with its nodes; NULL for groups
    const CoWideNode *nodes;
    uint32_t root;    // of the mesh, or its leaf if it has but one
    uint32_t layer;   // that it stands in; CO_LAYER_NONE: the group's own tree
    bool is_in_place; // a mesh that stands in the group as it is, within its box, not too fine
    bool is_baked;    // bvh is over the points where the group has them: rays stay what they are
    bool is_layer;    // no instance: one of the layers, which stand behind them
    unsigned char unused[5];
} CoPlaced;
_Static_assert(sizeof(CoPlaced) == 64, "an instance is a cache line");

// Instances that lie close together in a group that is much wider, see layers.h.
typedef struct CoLayer {
    CoTree tree;
    uint32_t parent;  // the layer that it stands in, which comes before it; or CO_LAYER_NONE
    bool is_in_place; // all of it is
} CoLayer;
#define CO_LAYER_NONE 0xffffffffu

struct CoTop {
    CoTree tree;
    CoPlaced *placed; // instances, then layers
    CoLayer *layers;
    size_t layer_capacity;
    uint32_t layer_count;
    CoBvh **baked; // of instances that have trees of their own, see bake.h
    uint32_t baked_count, baked_capacity;
    uint32_t count;      // of instances
    uint32_t depth;      // groups from here down, this one counted
    bool is_in_place;    // all that is not empty is
    uint64_t path_count; // of all instances
};

#endif
