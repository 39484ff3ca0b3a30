#include "accel/build.h"

#include "accel/open.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"

#include <string.h>

#define TAG CO_MEMORY_ACCEL

enum {
    ALONE = 4096,  // prims that are one subtree
    SHORT = 262144 // fewer take less time than waiting for a thread a few times
};

// Where the reference of a subtree stands.
typedef struct Parent {
    uint32_t node, slot;
} Parent;

// Subtrees from left to right, and the binary tree above them. Each becomes records where its prims
// were; these are moved together, so that there is room for the nodes, then the ids that are left,
// so that there is room for the leaves.
typedef struct Build {
    CoPrimArray *prims;
    const CoLeafRule *rule;
    CoTreeParts *out;
    CohortError *err;
    size_t count; // of prims
    uint32_t threads;
    CoOpening opening;    // the ranges of the subtrees
    CoSubtrees subtrees;  // what they are built over
    CoPiece *pieces;      // they themselves
    Parent *parents;      // of each
    unsigned char *block; // the prims, then their records, then ids
    size_t block_bytes;
    _Atomic bool is_out_of_memory;
} Build;

void co_prims_free(CoPrimArray *prims)
{
    co_free(TAG, prims->prims, prims->capacity * sizeof *prims->prims);
    *prims = (CoPrimArray){0};
}

void co_tree_clear(CoTree *tree)
{
    co_free(TAG, tree->nodes, tree->node_capacity * sizeof *tree->nodes);
    memset(tree, 0, sizeof *tree);
    co_box_empty(&tree->box);
}

void co_tree_parts_clear(CoTreeParts *parts)
{
    co_tree_clear(&parts->tree);
    co_free(TAG, parts->leaves, parts->leaf_capacity);
    parts->leaves = NULL;
    parts->leaf_bytes = parts->leaf_capacity = 0;
}

static bool no_memory(const Build *build)
{
    return CO_FAIL(build->err, COHORT_ERROR_OUT_OF_MEMORY,
                   "no memory to build a tree over %zu things", build->count);
}

// The wide nodes above the subtrees, whose references are put in as they become known.
static uint32_t write_top(Build *build, uint32_t from)
{
    uint32_t index = (uint32_t)build->out->tree.node_count++, children[CO_NODE_WIDTH];
    int count = co_plan_children(build->opening.binary, from, children);
    CoWideNode *nodes = build->out->tree.nodes;
    co_wide_node_clear(&nodes[index]);
    for (int i = 0; i < count; i++) {
        const CoBinaryNode *child = co_binary_at(build->opening.binary, children[i]);
        uint32_t ref = CO_REF_NONE;
        if (co_binary_is_leaf(child))
            build->parents[child->leaf] = (Parent){index, (uint32_t)i};
        else
            ref = write_top(build, children[i]);
        co_wide_node_set(&nodes[index], i, &child->box, ref);
    }
    return index;
}

// One after the other where there is one thread.
static void for_pieces(Build *build, CoParallelFn *fn)
{
    size_t count = build->opening.range_count;
    co_parallel_for_parts(count, build->threads == 1 ? count : 1, fn, build);
}

static void build_pieces(void *context, size_t begin, size_t end, uint32_t worker)
{
    Build *build = context;
    const CoOpening *o = &build->opening;
    (void)worker;
    for (size_t i = begin; i < end; i++)
        if (!co_subtree_build(&build->subtrees, &o->ranges[i], o->range_count == 1,
                              &build->pieces[i]))
            build->is_out_of_memory = true;
}

static bool resize_block(Build *build, size_t bytes)
{
    if (bytes == build->block_bytes)
        return true;
    void *moved = NULL;
    if (bytes == 0)
        co_free(TAG, build->block, build->block_bytes);
    else if (!(moved = co_realloc(TAG, build->block, build->block_bytes, bytes)))
        return false;
    build->block = moved;
    build->block_bytes = bytes;
    return true;
}

// Moves what is in the block to its front and gives back the rest.
static bool pack(Build *build)
{
    size_t used = 0;
    for (size_t i = 0; i < build->opening.range_count; i++) {
        CoPiece *piece = &build->pieces[i];
        if (piece->capacity || piece->byte_count == 0)
            continue;
        memmove(build->block + used, piece->bytes, piece->byte_count);
        used += piece->byte_count;
    }
    if (!resize_block(build, used))
        return false;
    unsigned char *at = build->block;
    for (size_t i = 0; i < build->opening.range_count; i++) {
        CoPiece *piece = &build->pieces[i];
        if (piece->capacity || piece->byte_count == 0)
            continue;
        piece->bytes = at;
        at += piece->byte_count;
    }
    return true;
}

static bool find_places(Build *build)
{
    CoTreeParts *out = build->out;
    size_t count = build->opening.range_count, nodes = 0;
    uint32_t root = co_opening_root(&build->opening);
    if (count > 1)
        nodes = co_plan_count(build->opening.binary, root);
    for (size_t i = 0; i < count; i++) {
        build->pieces[i].node_base = nodes;
        build->pieces[i].leaf_base = out->leaf_bytes;
        nodes += build->pieces[i].node_count;
        out->leaf_bytes += build->pieces[i].leaf_bytes;
    }
    CO_CHECK(nodes < CO_REF_NONE, build->err, COHORT_ERROR_LIMIT,
             "a tree of more than 2^31 - 2 nodes; split the mesh");
    CO_CHECK(out->leaf_bytes / CO_LEAF_UNIT <= CO_REF_LEAF_PLACE, build->err, COHORT_ERROR_LIMIT,
             "a mesh whose leaves take more than 8 GiB; split the mesh");
    out->tree.nodes = co_alloc(TAG, nodes * sizeof *out->tree.nodes);
    if (!out->tree.nodes)
        return no_memory(build);
    out->tree.node_capacity = nodes;
    if (count > 1)
        write_top(build, root);
    out->tree.node_count = nodes;
    return true;
}

static void write_nodes(void *context, size_t begin, size_t end, uint32_t worker)
{
    Build *build = context;
    CoWideNode *nodes = build->out->tree.nodes;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        co_piece_write_nodes(&build->pieces[i], nodes);
        if (build->opening.range_count > 1)
            nodes[build->parents[i].node].child[build->parents[i].slot] = build->pieces[i].root;
    }
}

static void write_leaves(void *context, size_t begin, size_t end, uint32_t worker)
{
    Build *build = context;
    (void)worker;
    for (size_t i = begin; i < end; i++)
        co_piece_write_leaves(&build->pieces[i], build->rule, build->out->leaves);
}

static bool make_leaves(Build *build)
{
    CoTreeParts *out = build->out;
    if (out->leaf_bytes == 0)
        return true;
    out->leaves = co_alloc(TAG, out->leaf_bytes + CO_LEAF_TAIL);
    if (!out->leaves)
        return false;
    out->leaf_capacity = out->leaf_bytes + CO_LEAF_TAIL;
    for_pieces(build, write_leaves);
    memset(out->leaves + out->leaf_bytes, 0, CO_LEAF_TAIL);
    return true;
}

static bool build_all(Build *build)
{
    build->subtrees = (CoSubtrees){build->prims->prims, build->rule, build->opening.scale};
    build->block = (unsigned char *)build->prims->prims;
    build->block_bytes = build->prims->capacity * sizeof *build->prims->prims;
    *build->prims = (CoPrimArray){0};
    for_pieces(build, build_pieces);
    if (build->is_out_of_memory || !pack(build))
        return no_memory(build);
    if (!find_places(build))
        return false;
    for_pieces(build, write_nodes);
    return (pack(build) && make_leaves(build)) || no_memory(build);
}

static bool make_arrays(Build *build)
{
    size_t count = build->opening.range_count;
    build->parents = co_alloc(TAG, count * sizeof *build->parents);
    build->pieces = co_alloc_zero(TAG, count * sizeof *build->pieces);
    return build->parents && build->pieces;
}

static void free_build(Build *build)
{
    for (size_t i = 0; build->pieces && i < build->opening.range_count; i++)
        co_piece_clear(&build->pieces[i]);
    co_free(TAG, build->block, build->block_bytes);
    co_free(TAG, build->pieces, build->opening.range_count * sizeof *build->pieces);
    co_free(TAG, build->parents, build->opening.range_count * sizeof *build->parents);
    co_opening_clear(&build->opening);
    co_prims_free(build->prims);
}

uint32_t co_build_threads(size_t count)
{
    if (count <= ALONE || co_in_parallel())
        return 1;
    return count < SHORT ? co_worker_count_at_hand() : co_worker_count();
}

bool co_tree_build(CoPrimArray *prims, const CoLeafRule *rule, CoTreeParts *out, CohortError *err)
{
    *out = (CoTreeParts){0};
    co_box_empty(&out->tree.box);
    Build build = {.prims = prims, .rule = rule, .out = out, .err = err, .count = prims->count};
    bool is_done = true;
    if (prims->count) {
        size_t leaf = rule->flat > rule->most ? rule->flat : rule->most;
        build.threads = co_build_threads(prims->count);
        is_done =
            (co_opening_make(prims, leaf, build.threads, &build.opening) && make_arrays(&build)) ||
            no_memory(&build);
        out->tree.box = build.opening.box;
        is_done = is_done && build_all(&build);
    }
    free_build(&build);
    if (!is_done)
        co_tree_parts_clear(out);
    return is_done;
}
