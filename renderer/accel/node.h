// What a built tree looks like in memory: wide nodes, triangle leaves, the bottom and the top
// level.
//
// Private to the accel room: builders write it, kernels read it. The layout is one for all
// instruction sets, so a tree may be built once and walked by any.

#ifndef CO_ACCEL_NODE_H
#define CO_ACCEL_NODE_H

#include "accel/accel.h"

enum {
    CO_NODE_WIDTH = 8,
    CO_LEAF_WIDTH = 8,      // most triangles of a leaf, and most distinct points
    CO_GROUP_DEPTH_MAX = 8, // groups within groups, the root counted
    CO_TREE_DEPTH_MAX = 96, // see build.c; a walk's stack never holds more than 7 per level
    CO_STACK_SIZE = 7 * CO_TREE_DEPTH_MAX + 8
};

// A child: an inner node's index, or with CO_REF_LEAF a leaf. A leaf of a mesh has its triangle
// count - 1 in bits 28..30 and its place, in units of 16 bytes, below; a leaf of a group has the
// instance's index.
#define CO_REF_LEAF 0x80000000u
#define CO_REF_COUNT_SHIFT 28
#define CO_REF_LEAF_PLACE 0x0fffffffu
#define CO_REF_NONE 0x7fffffffu

// Up to 8 children. Rows: 2 axis + (0 = low plane, 1 = high plane). Children that are not there
// have planes at +inf and -inf, which no ray enters.
typedef struct CoWideNode {
    float planes[6][CO_NODE_WIDTH];
    uint32_t child[CO_NODE_WIDTH];
} CoWideNode;
_Static_assert(sizeof(CoWideNode) == 224, "a node is seven half cache lines");

// Up to 8 triangles that share at most 8 points, packed; each point stands once and is sheared
// once.
//
//   uint8_t  point_count
//   uint8_t  corner[3][n]          point of corner 0 of every triangle, then of corner 1, then 2
//   (to a multiple of 4)
//   uint32_t tri[n]                of the mesh
//   float    points[3][point_count] by axis
//   (to a multiple of 16)
//
// Kernels load 8 of everything and leave what is beyond the end alone: the last leaf has
// CO_LEAF_TAIL bytes behind it.
enum {
    CO_LEAF_UNIT = 16,
    CO_LEAF_TAIL = 64
};

typedef struct CoTriLeaf {
    size_t point_count;
    const uint8_t *corner[3];
    size_t base[3]; // of the points that corners count from; 0 in packed leaves
    const uint32_t *tri;
    const float *points[3];
} CoTriLeaf;

// Where tri starts in a leaf of n triangles.
static inline size_t co_leaf_tri_offset(size_t n)
{
    return (1 + 3 * n + 3) & ~(size_t)3;
}

static inline size_t co_leaf_size(size_t n, size_t points)
{
    size_t bytes = co_leaf_tri_offset(n) + sizeof(uint32_t) * n + 3 * sizeof(float) * points;
    return (bytes + CO_LEAF_UNIT - 1) & ~(size_t)(CO_LEAF_UNIT - 1);
}

static inline CoTriLeaf co_leaf_open(const unsigned char *bytes, size_t n)
{
    CoTriLeaf leaf = {.base = {0, 0, 0}};
    size_t points = bytes[0];
    leaf.point_count = points;
    leaf.corner[0] = bytes + 1;
    leaf.corner[1] = leaf.corner[0] + n;
    leaf.corner[2] = leaf.corner[1] + n;
    bytes += co_leaf_tri_offset(n);
    leaf.tri = (const uint32_t *)(const void *)bytes;
    leaf.points[0] = (const float *)(const void *)(leaf.tri + n);
    leaf.points[1] = leaf.points[0] + points;
    leaf.points[2] = leaf.points[1] + points;
    return leaf;
}

typedef struct CoBox {
    float lo[3], hi[3];
} CoBox;

// A tree of wide nodes; node 0 is the root; no nodes when there is nothing in it.
typedef struct CoTree {
    CoWideNode *nodes;
    size_t node_count, node_capacity;
    CoBox box; // of everything in it
    double built_cost; // what a walk was expected to cost when it was built; 0: not known yet
} CoTree;

struct CoBvh {
    CoTree tree;
    unsigned char *leaves;
    size_t leaf_bytes, leaf_capacity;
    // What leaf references count: leaves and CO_LEAF_UNIT, or the mesh's patches themselves.
    const unsigned char *leaf_at;
    size_t leaf_stride;
    // Of a mesh of patches, whose leaves are those of grid_leaf.h; else NULL.
    const CoPatchTable *patches;
    const float *points;
};

// All that a walk wants of an instance: one cache line.
typedef struct CoPlaced {
    CoBox box;            // group space, padded (see top.c); empty when there is nothing in it
    uint32_t first_path;  // paths of the instances before this one
    uint32_t hidden_from; // CohortHidden bits
    const CoBvh *bvh;     // of a mesh, with its nodes; NULL for groups
    const CoWideNode *nodes;
    bool is_in_place; // a mesh that stands in the group as it is, within the box
    unsigned char unused[15];
} CoPlaced;
_Static_assert(sizeof(CoPlaced) == 64, "an instance is a cache line");

struct CoTop {
    CoTree tree;
    CoPlaced *placed;     // instances
    uint32_t *first_path; // paths of the instances before this one: a prefix sum
    uint32_t count;       // of instances
    uint32_t depth;       // groups from here down, this one counted
    bool is_in_place;     // all that is not empty is
    uint64_t path_count;  // of all instances
};

#endif
