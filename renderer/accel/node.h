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
// count - 1 in bits 28..30 and its index below; a leaf of a group has the instance's index.
#define CO_REF_LEAF 0x80000000u
#define CO_REF_COUNT_SHIFT 28
#define CO_REF_LEAF_INDEX 0x0fffffffu
#define CO_REF_NONE 0x7fffffffu

// Up to 8 children. Rows: 2 axis + (0 = low plane, 1 = high plane). Children that are not there
// have planes at +inf and -inf, which no ray enters.
typedef struct CoWideNode {
    float planes[6][CO_NODE_WIDTH];
    uint32_t child[CO_NODE_WIDTH];
} CoWideNode;
_Static_assert(sizeof(CoWideNode) == 224, "a node is seven half cache lines");

// Up to 8 triangles that share at most 8 points; each point stands once and is sheared once.
typedef struct CoTriLeaf {
    float points[3][CO_LEAF_WIDTH];   // by axis
    uint8_t corner[3][CO_LEAF_WIDTH]; // point of corner 0, 1, 2 by triangle
    uint8_t padding[8];
    uint32_t tri[CO_LEAF_WIDTH]; // of the mesh
} CoTriLeaf;
_Static_assert(sizeof(CoTriLeaf) == 160, "a leaf is five half cache lines");

typedef struct CoBox {
    float lo[3], hi[3];
} CoBox;

// A tree of wide nodes; node 0 is the root; no nodes when there is nothing in it.
typedef struct CoTree {
    CoWideNode *nodes;
    size_t node_count, node_capacity;
    CoBox box; // of everything in it
} CoTree;

struct CoBvh {
    CoTree tree;
    CoTriLeaf *leaves;
    size_t leaf_count, leaf_capacity;
};

struct CoTop {
    CoTree tree;
    CoBox *boxes;         // of the instances, group space, padded (see top.c)
    uint32_t *first_path; // paths of the instances before this one: a prefix sum
    uint32_t count;       // of instances
    uint32_t depth;       // groups from here down, this one counted
    uint64_t path_count;  // of all instances
};

#endif
