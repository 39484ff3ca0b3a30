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
    CO_LEAF_WIDTH = 16,     // most triangles of a leaf
    CO_GROUP_DEPTH_MAX = 8, // groups within groups, the root counted
    CO_TREE_DEPTH_MAX = 96, // see build.c; a walk's stack never holds more than 7 per level
    CO_STACK_SIZE = 7 * CO_TREE_DEPTH_MAX + 8
};

// A child: an inner node's index, or with CO_REF_LEAF a leaf. A leaf of a mesh has its triangle
// count - 1 in bits 27..30 and its place, in units of CO_LEAF_UNIT, below; a leaf of a group has the
// instance's index.
#define CO_REF_LEAF 0x80000000u
#define CO_REF_COUNT_SHIFT 27
#define CO_REF_LEAF_PLACE 0x07ffffffu
#define CO_REF_NONE 0x7fffffffu

// Up to 8 children. Rows: 2 axis + (0 = low plane, 1 = high plane). Children that are not there
// have planes at +inf and -inf, which no ray enters.
typedef struct CoWideNode {
    float planes[6][CO_NODE_WIDTH];
    uint32_t child[CO_NODE_WIDTH];
} CoWideNode;
_Static_assert(sizeof(CoWideNode) == 224, "a node is seven half cache lines");

// Up to CO_LEAF_WIDTH triangles that share at most 16 points, packed; each point stands once and is
// sheared once.
//
//   uint32_t corner[3][(n + 7) / 8]  places of corner 0 of every triangle, of corner 1, 2: 4 bits
//                                    each from the lowest on. Corner 0 of triangle 0 is the last
//                                    point, which tells how many there are
//   uint32_t first                   a triangle of the mesh. CO_LEAF_NEAR: the least of all
//   float    points[3][p]            by axis
//   uint32_t tri[n - 1]              the other triangles; with CO_LEAF_NEAR uint16_t [n], all of
//                                    them, less the least
//   (to a multiple of 16)
//
// Kernels load 16 points and leave what is beyond the end alone: the last leaf has CO_LEAF_TAIL
// bytes behind it.
enum {
    CO_LEAF_UNIT = 16,
    CO_LEAF_TAIL = 64,
    CO_LEAF_POINTS = 16
};
#define CO_LEAF_NEAR 0x80000000u

typedef struct CoTriLeaf {
    uint32_t point_count;
    size_t row;             // words of a row of corners
    const uint32_t *corner; // three rows
    const float *points[3];
} CoTriLeaf;

static inline uint32_t co_leaf_count(uint32_t ref)
{
    return (ref >> CO_REF_COUNT_SHIFT & (CO_LEAF_WIDTH - 1u)) + 1;
}

static inline CoTriLeaf co_leaf_open(const unsigned char *bytes, uint32_t count)
{
    const uint32_t *words = (const void *)bytes;
    CoTriLeaf leaf = {.corner = words, .row = (count + 7) / 8};
    leaf.point_count = (words[0] & 15u) + 1;
    leaf.points[0] = (const float *)(const void *)(words + 3 * leaf.row + 1);
    leaf.points[1] = leaf.points[0] + leaf.point_count;
    leaf.points[2] = leaf.points[1] + leaf.point_count;
    return leaf;
}

static inline size_t co_leaf_size(uint32_t count, uint32_t points, bool is_near)
{
    size_t words = 3 * (size_t)((count + 7) / 8) + 1 + 3 * (size_t)points;
    size_t bytes = 4 * words + (is_near ? 2 * (size_t)count : 4 * (size_t)(count - 1));
    return (bytes + CO_LEAF_UNIT - 1) & ~(size_t)(CO_LEAF_UNIT - 1);
}

// Which point corner c of triangle i is.
static inline uint32_t co_leaf_corner(const CoTriLeaf *leaf, uint32_t c, uint32_t i)
{
    return leaf->corner[c * leaf->row + i / 8] >> 4 * (i & 7u) & 15u;
}

// The number of triangle i in the mesh.
static inline uint32_t co_leaf_tri(const CoTriLeaf *leaf, uint32_t i)
{
    uint32_t first = leaf->corner[3 * leaf->row];
    const void *others = leaf->points[2] + leaf->point_count;
    if (first & CO_LEAF_NEAR)
        return (first & ~CO_LEAF_NEAR) + ((const uint16_t *)others)[i];
    return i ? ((const uint32_t *)others)[i - 1] : first;
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
    const float *points; // of the mesh
    // Of a mesh of patches, whose leaves are those of grid_leaf.h; else NULL.
    const CoPatchTable *patches;
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
