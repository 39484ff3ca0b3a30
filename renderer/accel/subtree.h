// One subtree: a binary tree over a small range, planned for collapse as it is built, then written
// as wide nodes and leaves.
//
// Private to the builder. Threads: one, each with a CoSubtree of its own.

#ifndef CO_ACCEL_SUBTREE_H
#define CO_ACCEL_SUBTREE_H

#include "accel/split.h"

// A node of a binary tree. Its left child is the next one. A build holds many, so what is asked for
// but once is in a plan.
typedef struct CoBinaryNode {
    CoBox box;
    uint32_t right; // 0 for a leaf
    union {
        uint32_t leaf; // its reference; above subtrees, the number of one
        uint32_t plan; // see subtree.c
    };
} CoBinaryNode;
_Static_assert(sizeof(CoBinaryNode) == 32, "half a cache line");

// What a node's parent wants to know to plan itself.
typedef struct CoPlan {
    float cost[CO_NODE_WIDTH]; // [j]: expected cost with at most j children, j = 1 .. 7
} CoPlan;

enum {
    CO_LEAVES_HELD = 512 // bytes of leaves that wait for prims to become leaves
};

// One thread's scratch. Nodes and the leaves that lie apart are blocks of CO_MEMORY_ACCEL that grow,
// as few ranges need what the worst does, and stay for the next subtree.
typedef struct CoSubtree {
    CoBuildPrim *prims; // of the whole tree
    const CoLeafRule *rule;
    double scale; // of areas, so that a walk's cost compares with a node's memory
    CoBinaryNode *nodes;
    size_t node_count, node_capacity;
    unsigned char *emitted; // leaves without a place, room for CO_LEAVES_HELD and the next one
    unsigned char *leaves;  // the others: over prims that have become leaves, or apart
    unsigned char *apart;
    size_t held, leaf_bytes, apart_capacity;
    size_t first;    // prim of the range
    CoRange pending; // the leaf that is not written yet; without prims: none
    uint32_t pending_node;
    bool is_out_of_memory;
} CoSubtree;

// The leaves of one subtree and its nodes behind them, at any address. They lie where its prims were
// unless they are more, then in a block of CO_MEMORY_ACCEL. References are relative to the piece.
typedef struct CoPiece {
    unsigned char *bytes;
    size_t leaf_bytes, node_count;
    uint32_t root; // reference
    bool is_apart;
    size_t leaf_base, node_base; // where they go
} CoPiece;

// Plans a node over two halves that are planned, NULL for a leaf.
void co_plan_node(CoBinaryNode *node, const CoPlan halves[2], double scale, CoPlan *out);

// Lists the children of the wide node made of a binary one that is not a leaf, by their indices;
// returns how many.
int co_plan_children(const CoBinaryNode *nodes, size_t from, uint32_t children[CO_NODE_WIDTH]);

// How many wide nodes a binary tree becomes whose root is not a leaf.
size_t co_plan_count(const CoBinaryNode *nodes, size_t from);

// Builds over a range, whose prims are gone then. has_node: the root is to be a node even where it
// could be a leaf. False when memory ends; the piece is empty then.
bool co_subtree_build(CoSubtree *subtree, const CoRange *range, bool has_node, CoPiece *out);
void co_subtree_clear(CoSubtree *subtree);
void co_piece_leave_nodes(CoPiece *piece); // forgets them
void co_piece_clear(CoPiece *piece);
static inline size_t co_piece_bytes(const CoPiece *piece)
{
    return piece->leaf_bytes + piece->node_count * sizeof(CoWideNode);
}

#endif
