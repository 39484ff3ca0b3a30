// One subtree: a binary tree over a small range, planned for collapse as it is built, then written
// as wide nodes and leaves.
//
// Private to the builder. Threads: one, each with a CoSubtree of its own.

#ifndef CO_ACCEL_SUBTREE_H
#define CO_ACCEL_SUBTREE_H

#include "accel/split.h"

// A node of a binary tree. Its left child is the next one.
typedef struct CoBinaryNode {
    CoBox box;
    uint32_t first, count;           // range of prims
    uint32_t right;                  // 0 for a leaf,
    uint32_t leaf;                   // whose reference this is
    float cost[CO_NODE_WIDTH];       // [j]: expected cost with at most j children, j = 1 .. 7
    uint8_t left[CO_NODE_WIDTH + 1]; // [j]: how many of them go left; 0: j - 1 do as well
    uint8_t flat;                    // so many leaves follow, in place of two subtrees; else 0
} CoBinaryNode;

// Nodes and leaves are blocks of CO_MEMORY_ACCEL that grow, as few ranges need what the worst does.
typedef struct CoSubtree {
    CoBinaryNode *nodes;
    CoBuildPrim *moved; // room for all prims of the range
    CoBuildPrim *prims; // of the whole tree
    const CoLeafRule *rule;
    double scale; // of areas, so that a walk's cost compares with a node's memory
    unsigned char *leaves;
    size_t node_count, node_capacity, leaf_bytes, leaf_capacity;
    size_t pending; // 1 + the node whose leaf is not written yet, 0: none
    bool is_out_of_memory;
} CoSubtree;

// The nodes and leaves of one subtree, in one block. References are relative to it.
typedef struct CoPiece {
    CoWideNode *nodes; // the leaves follow them
    size_t node_count, leaf_bytes;
    uint32_t root;               // reference
    size_t node_base, leaf_base; // where they go
} CoPiece;

// Plans a node whose children, at `left` and `right`, are planned; for a leaf both are NULL.
void co_plan_node(CoBinaryNode *node, const CoBinaryNode *left, const CoBinaryNode *right,
                  double scale);

// Lists the subtrees that are the children of the wide node at `from`. Returns how many.
int co_plan_children(const CoBinaryNode *nodes, size_t from, uint32_t children[CO_NODE_WIDTH]);

// How many wide nodes the subtree at `from` takes.
size_t co_plan_count(const CoBinaryNode *nodes, size_t from);

// Builds over a range. has_node: the root is to be a node even where it could be a leaf. False when
// memory ends.
bool co_subtree_build(CoSubtree *subtree, const CoRange *range, bool has_node, CoPiece *out);
void co_piece_clear(CoPiece *piece);
static inline size_t co_piece_bytes(const CoPiece *piece)
{
    return piece->node_count * sizeof *piece->nodes + piece->leaf_bytes;
}

#endif
