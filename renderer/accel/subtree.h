// One subtree: a binary tree over a small range, planned for collapse as it is built, then written
// as wide nodes. In between it is records in the place of the prims: of each leaf the ids of its
// prims, and every node of the tree behind those of its children.
//
// Private to the builder. Threads: any, each on subtrees of its own.

#ifndef CO_ACCEL_SUBTREE_H
#define CO_ACCEL_SUBTREE_H

#include "accel/split.h"

// A node of a binary tree. Where it is, is said in units of CO_LEAF_UNIT from the first record on.
// Its right child ends where it begins. A build holds many, so what is asked for but once is in a
// plan.
typedef struct CoBinaryNode {
    CoBox box;
    uint32_t left; // child; of a leaf CO_REF_LEAF and how many ids are before it
    union {
        uint32_t leaf; // its reference; above subtrees, the number of one
        uint32_t plan; // see subtree.c
    };
} CoBinaryNode;
_Static_assert(sizeof(CoBinaryNode) == 32, "half a cache line");

enum {
    CO_BINARY_UNITS = sizeof(CoBinaryNode) / CO_LEAF_UNIT
};

static inline const CoBinaryNode *co_binary_at(const void *records, uint32_t at)
{
    return (const void *)((const unsigned char *)records + (size_t)at * CO_LEAF_UNIT);
}

static inline bool co_binary_is_leaf(const CoBinaryNode *node)
{
    return node->left & CO_REF_LEAF;
}

// What a node's parent wants to know to plan itself.
typedef struct CoPlan {
    float cost[CO_NODE_WIDTH]; // [j]: expected cost with at most j children, j = 1 .. 7
} CoPlan;

// The first id of a leaf, among those of all leaves.
#define CO_ID_FIRST 0x80000000u

enum {
    CO_RECORDS_HELD = 512 // bytes of records that wait for prims to become leaves
};

// The records of one subtree, then its ids, at any address. They are where its prims were unless
// they are more, then in a block of CO_MEMORY_ACCEL. References are relative to the subtree.
typedef struct CoPiece {
    unsigned char *bytes;
    size_t byte_count, capacity;   // 0 where the prims were
    size_t node_count, leaf_bytes; // that are to be written
    size_t node_base, leaf_base;   // and where
    uint32_t root;                 // record, then reference
    bool is_node;                  // the root becomes one
} CoPiece;

// Plans a node over two halves that are planned, NULL for a leaf.
void co_plan_node(CoBinaryNode *node, const CoPlan halves[2], double scale, CoPlan *out);

// Lists the children of the wide node made of a binary one that is not a leaf, from the left;
// returns how many.
int co_plan_children(const void *records, uint32_t from, uint32_t children[CO_NODE_WIDTH]);

// How many wide nodes a binary tree becomes whose root is not a leaf.
size_t co_plan_count(const void *records, uint32_t from);

// What subtrees are built over.
typedef struct CoSubtrees {
    CoBuildPrim *prims; // of the whole tree
    const CoLeafRule *rule;
    double scale; // of areas, so that a walk's cost compares with a node's memory
} CoSubtrees;

// Builds over a range, whose prims are gone then. has_node: the root is to be a node even where it
// could be a leaf. False when memory ends; the piece is empty then.
bool co_subtree_build(const CoSubtrees *in, const CoRange *range, bool has_node, CoPiece *out);

// Writes the nodes of a piece, and leaves it the ids alone.
void co_piece_write_nodes(CoPiece *piece, CoWideNode *nodes);

// Writes its leaves.
void co_piece_write_leaves(const CoPiece *piece, const CoLeafRule *rule, unsigned char *leaves);
void co_piece_clear(CoPiece *piece);

#endif
