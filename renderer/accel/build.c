#include "accel/build.h"

#include "accel/open.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/pages.h"
#include "base/parallel.h"

#include <string.h>

#define TAG CO_MEMORY_ACCEL

enum {
    STEP_SHARE = 32 // what lies apart is put in its place by this part of all
};

// Where the reference of a subtree stands.
typedef struct Parent {
    uint32_t node, slot;
} Parent;

// Subtrees from left to right, and the binary tree above them. Each is built where its prims were;
// then all are moved together, so that there is room for the nodes, and at last the leaves alone.
typedef struct Build {
    CoPrimArray *prims;
    const CoLeafRule *rule;
    CoTreeParts *out;
    CohortError *err;
    size_t count;       // of prims
    CoOpening opening;  // the ranges of the subtrees
    CoPiece *pieces;    // the subtrees
    Parent *parents;    // of the subtrees
    CoSubtree *workers; // scratch
    size_t worker_count;
    unsigned char *block; // the prims, then the leaves
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
        const CoBinaryNode *child = &build->opening.binary[children[i]];
        uint32_t ref = CO_REF_NONE;
        if (child->right)
            ref = write_top(build, children[i]);
        else
            build->parents[child->leaf] = (Parent){index, (uint32_t)i};
        co_wide_node_set(&nodes[index], i, &child->box, ref);
    }
    return index;
}

static size_t emitted_bytes(const Build *build)
{
    return CO_LEAVES_HELD + build->rule->most * build->rule->prim_bytes;
}

static bool make_workers(Build *build)
{
    size_t ranges = build->opening.range_count, count = co_worker_count();
    build->worker_count = count < ranges ? count : ranges;
    build->workers = co_alloc_zero(TAG, build->worker_count * sizeof *build->workers);
    bool is_done = build->workers;
    for (size_t i = 0; is_done && i < build->worker_count; i++) {
        CoSubtree *worker = &build->workers[i];
        *worker = (CoSubtree){
            .prims = build->prims->prims, .rule = build->rule, .scale = build->opening.scale};
        worker->emitted = co_alloc(TAG, emitted_bytes(build));
        is_done = worker->emitted;
    }
    return is_done;
}

static void free_workers(Build *build)
{
    for (size_t i = 0; build->workers && i < build->worker_count; i++) {
        CoSubtree *worker = &build->workers[i];
        co_free(TAG, worker->emitted, emitted_bytes(build));
        co_subtree_clear(worker);
    }
    co_free(TAG, build->workers, build->worker_count * sizeof *build->workers);
    build->workers = NULL;
}

static void build_pieces(void *context, size_t begin, size_t end, uint32_t worker)
{
    Build *build = context;
    const CoOpening *o = &build->opening;
    for (size_t i = begin; i < end; i++)
        if (!co_subtree_build(&build->workers[worker], &o->ranges[i], o->range_count == 1,
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

// Moves what is in the block to its front, with the nodes or without, and gives back the rest, but for
// the tail; and a block of large pages stays one.
static bool pack(Build *build, bool with_nodes)
{
    size_t used = 0, kept = co_pages_suit(build->block_bytes) ? CO_PAGES_ALIGNMENT : 0;
    for (size_t i = 0; i < build->opening.range_count; i++) {
        CoPiece *piece = &build->pieces[i];
        if (piece->is_apart)
            continue;
        size_t bytes = with_nodes ? co_piece_bytes(piece) : piece->leaf_bytes;
        memmove(build->block + used, piece->bytes, bytes);
        used += bytes;
    }
    kept = used == 0 ? 0 : kept < used + CO_LEAF_TAIL ? used + CO_LEAF_TAIL : kept;
    if (!resize_block(build, kept < build->block_bytes ? kept : build->block_bytes))
        return false;
    unsigned char *at = build->block;
    for (size_t i = 0; i < build->opening.range_count; i++) {
        CoPiece *piece = &build->pieces[i];
        if (piece->is_apart)
            continue;
        piece->bytes = at;
        at += with_nodes ? co_piece_bytes(piece) : piece->leaf_bytes;
    }
    return true;
}

// Says where each piece goes: leaves that are in the block come before those that are not.
static bool find_places(Build *build)
{
    CoTreeParts *out = build->out;
    size_t count = build->opening.range_count, nodes = 0;
    if (count > 1)
        nodes = co_plan_count(build->opening.binary, 0);
    for (size_t i = 0; i < count; i++) {
        build->pieces[i].node_base = nodes;
        nodes += build->pieces[i].node_count;
    }
    for (size_t i = 0; i < 2 * count; i++) {
        CoPiece *piece = &build->pieces[i % count];
        if (piece->is_apart != (i >= count))
            continue;
        piece->leaf_base = out->leaf_bytes;
        out->leaf_bytes += piece->leaf_bytes;
    }
    CO_CHECK(nodes < CO_REF_NONE, build->err, COHORT_ERROR_LIMIT,
             "a tree of more than 2^31 - 2 nodes; split the mesh");
    CO_CHECK(out->leaf_bytes / CO_LEAF_UNIT <= CO_REF_LEAF_PLACE, build->err, COHORT_ERROR_LIMIT,
             "a mesh whose leaves take more than 2 GiB; split the mesh");
    out->tree.nodes = co_alloc(TAG, nodes * sizeof *out->tree.nodes);
    if (!out->tree.nodes)
        return no_memory(build);
    out->tree.node_capacity = nodes;
    if (count > 1)
        write_top(build, 0);
    out->tree.node_count = nodes;
    return true;
}

static uint32_t moved_ref(uint32_t ref, uint32_t nodes, uint32_t places)
{
    return ref & CO_REF_LEAF ? ref + places : ref == CO_REF_NONE ? ref : ref + nodes;
}

static void place_nodes(void *context, size_t begin, size_t end, uint32_t worker)
{
    Build *build = context;
    CoWideNode *all = build->out->tree.nodes;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        CoPiece *piece = &build->pieces[i];
        uint32_t places = (uint32_t)(piece->leaf_base / CO_LEAF_UNIT);
        uint32_t base = (uint32_t)piece->node_base;
        CoWideNode *nodes = all + base;
        if (piece->node_count)
            memcpy(nodes, piece->bytes + piece->leaf_bytes, piece->node_count * sizeof *nodes);
        for (size_t n = 0; n < piece->node_count; n++)
            for (int k = 0; k < CO_NODE_WIDTH; k++)
                nodes[n].child[k] = moved_ref(nodes[n].child[k], base, places);
        if (build->opening.range_count > 1)
            all[build->parents[i].node].child[build->parents[i].slot] =
                moved_ref(piece->root, base, places);
        co_piece_leave_nodes(piece);
    }
}

// Puts the leaves that lie apart behind the others. By steps, where the block then stays in its
// place, so that each piece makes room for the next.
static bool place_apart(Build *build)
{
    size_t all = build->out->leaf_bytes + (build->out->leaf_bytes ? CO_LEAF_TAIL : 0);
    size_t step = co_pages_suit(all) ? all / STEP_SHARE : all;
    for (size_t i = 0; i < build->opening.range_count; i++) {
        CoPiece *piece = &build->pieces[i];
        if (!piece->is_apart)
            continue;
        size_t end = piece->leaf_base + piece->leaf_bytes;
        if (end > build->block_bytes && !resize_block(build, all - end < step ? all : end + step))
            return false;
        if (piece->leaf_bytes)
            memcpy(build->block + piece->leaf_base, piece->bytes, piece->leaf_bytes);
        co_piece_clear(piece);
    }
    if (!resize_block(build, all))
        return false;
    if (all)
        memset(build->block + all - CO_LEAF_TAIL, 0, CO_LEAF_TAIL);
    return true;
}

static bool make_arrays(Build *build)
{
    size_t count = build->opening.range_count;
    build->parents = co_alloc(TAG, count * sizeof *build->parents);
    build->pieces = co_alloc_zero(TAG, count * sizeof *build->pieces);
    return build->parents && build->pieces && make_workers(build);
}

static bool build_all(Build *build)
{
    size_t count = build->opening.range_count;
    build->block = (unsigned char *)build->prims->prims;
    build->block_bytes = build->prims->capacity * sizeof *build->prims->prims;
    *build->prims = (CoPrimArray){0};
    co_parallel_for(count, 1, build_pieces, build);
    free_workers(build);
    if (build->is_out_of_memory || !pack(build, true))
        return no_memory(build);
    if (!find_places(build))
        return false;
    co_parallel_for(count, 4, place_nodes, build);
    if (!pack(build, false) || !place_apart(build))
        return no_memory(build);
    build->out->leaves = build->block;
    build->out->leaf_capacity = build->block_bytes;
    build->block = NULL;
    return true;
}

static void free_build(Build *build)
{
    free_workers(build);
    for (size_t i = 0; build->pieces && i < build->opening.range_count; i++)
        co_piece_clear(&build->pieces[i]);
    co_free(TAG, build->block, build->block_bytes);
    co_free(TAG, build->pieces, build->opening.range_count * sizeof *build->pieces);
    co_free(TAG, build->parents, build->opening.range_count * sizeof *build->parents);
    co_opening_clear(&build->opening);
    co_prims_free(build->prims);
}

bool co_tree_build(CoPrimArray *prims, const CoLeafRule *rule, CoTreeParts *out, CohortError *err)
{
    *out = (CoTreeParts){0};
    co_box_empty(&out->tree.box);
    Build build = {.prims = prims, .rule = rule, .out = out, .err = err, .count = prims->count};
    bool is_done = true;
    if (prims->count) {
        is_done = (co_opening_make(prims, rule->flat > rule->most ? rule->flat : rule->most, &build.opening) && make_arrays(&build)) ||
                  no_memory(&build);
        out->tree.box = build.opening.box;
        is_done = is_done && build_all(&build);
    }
    free_build(&build);
    if (!is_done)
        co_tree_parts_clear(out);
    return is_done;
}
