#include "accel/build.h"

#include "accel/open.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"

#include <string.h>

#define TAG CO_MEMORY_ACCEL

enum {
    ROUND_SHARE = 12 // this part of the subtrees is under way at once
};

// Where the reference of a subtree stands.
typedef struct Parent {
    uint32_t node, slot;
} Parent;

// Subtrees from left to right, and the binary tree above them.
typedef struct Build {
    CoPrimArray *prims;
    const CoLeafRule *rule;
    CoTreeParts *out;
    CohortError *err;
    CoOpening opening;  // the ranges of the subtrees
    CoPiece *pieces;    // the subtrees
    Parent *parents;    // of the subtrees
    CoSubtree *workers; // scratch
    size_t worker_count;
    size_t round; // first subtree of the round
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
                   "no memory to build a tree over %zu things", build->prims->count);
}

// Makes an array exactly as large as it has to be.
static bool resize(void **array, size_t *capacity, size_t count, size_t element)
{
    if (count == *capacity)
        return true;
    void *moved = co_realloc(TAG, *array, *capacity * element, count * element);
    if (!moved)
        return false;
    *array = moved;
    *capacity = count;
    return true;
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
            build->parents[child->first] = (Parent){index, (uint32_t)i};
        co_wide_node_set(&nodes[index], i, &child->box, ref);
    }
    return index;
}

static bool make_top(Build *build)
{
    build->parents = co_alloc(TAG, build->opening.range_count * sizeof *build->parents);
    build->pieces = co_alloc_zero(TAG, build->opening.range_count * sizeof *build->pieces);
    if (!build->parents || !build->pieces)
        return false;
    if (build->opening.range_count == 1)
        return true;
    CoTree *tree = &build->out->tree;
    void *nodes = NULL;
    if (!resize(&nodes, &tree->node_capacity, co_plan_count(build->opening.binary, 0),
                sizeof *tree->nodes))
        return false;
    tree->nodes = nodes;
    write_top(build, 0);
    return true;
}

static bool make_workers(Build *build)
{
    size_t most = build->opening.largest, count = co_worker_count();
    build->worker_count = count < build->opening.range_count ? count : build->opening.range_count;
    build->workers = co_alloc_zero(TAG, build->worker_count * sizeof *build->workers);
    bool is_done = build->workers;
    for (size_t i = 0; is_done && i < build->worker_count; i++) {
        CoSubtree *worker = &build->workers[i];
        *worker = (CoSubtree){.rule = build->rule, .scale = build->opening.scale};
        worker->moved = co_alloc(TAG, most * sizeof *worker->moved);
        is_done = worker->moved;
    }
    return is_done;
}

static void free_workers(Build *build)
{
    for (size_t i = 0; build->workers && i < build->worker_count; i++) {
        CoSubtree *worker = &build->workers[i];
        co_free(TAG, worker->nodes, worker->node_capacity * sizeof *worker->nodes);
        co_free(TAG, worker->moved, build->opening.largest * sizeof *worker->moved);
        co_free(TAG, worker->leaves, worker->leaf_capacity);
    }
    co_free(TAG, build->workers, build->worker_count * sizeof *build->workers);
    build->workers = NULL;
}

static void build_pieces(void *context, size_t begin, size_t end, uint32_t worker)
{
    Build *build = context;
    for (size_t i = begin; i < end; i++) {
        size_t at = build->round + i;
        build->workers[worker].prims = build->prims->prims;
        if (!co_subtree_build(&build->workers[worker], &build->opening.ranges[at],
                              build->opening.range_count == 1, &build->pieces[at]))
            build->is_out_of_memory = true;
    }
}

static uint32_t moved_ref(uint32_t ref, uint32_t nodes, uint32_t places)
{
    return ref & CO_REF_LEAF ? ref + places : ref == CO_REF_NONE ? ref : ref + nodes;
}

// Puts pieces of a round to their places among all nodes and leaves.
static void place_pieces(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Build *build = context;
    CoTreeParts *out = build->out;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        CoPiece *piece = &build->pieces[build->round + i];
        uint32_t places = (uint32_t)(piece->leaf_base / CO_LEAF_UNIT);
        uint32_t base = (uint32_t)piece->node_base;
        CoWideNode *nodes = out->tree.nodes + base;
        if (piece->node_count)
            memcpy(nodes, piece->nodes, piece->node_count * sizeof *nodes);
        if (piece->leaf_bytes)
            memcpy(out->leaves + piece->leaf_base, piece->nodes + piece->node_count,
                   piece->leaf_bytes);
        for (size_t n = 0; n < piece->node_count; n++)
            for (int k = 0; k < CO_NODE_WIDTH; k++)
                nodes[n].child[k] = moved_ref(nodes[n].child[k], base, places);
        piece->root = moved_ref(piece->root, base, places);
        co_piece_clear(piece);
    }
}

// Makes room for a round's pieces and says where each goes.
static bool make_room(Build *build, size_t count)
{
    CoTreeParts *out = build->out;
    for (size_t i = build->round + count; i-- > build->round;) {
        CoPiece *piece = &build->pieces[i];
        piece->node_base = out->tree.node_count;
        piece->leaf_base = out->leaf_bytes;
        out->tree.node_count += piece->node_count;
        out->leaf_bytes += piece->leaf_bytes;
    }
    CO_CHECK(out->tree.node_count < CO_REF_NONE, build->err, COHORT_ERROR_LIMIT,
             "a tree of more than 2^31 - 2 nodes; split the mesh");
    CO_CHECK(out->leaf_bytes / CO_LEAF_UNIT <= CO_REF_LEAF_PLACE, build->err, COHORT_ERROR_LIMIT,
             "a mesh whose leaves take more than 2 GiB; split the mesh");
    void *nodes = out->tree.nodes, *leaves = out->leaves;
    bool is_done =
        resize(&nodes, &out->tree.node_capacity, out->tree.node_count, sizeof *out->tree.nodes);
    out->tree.nodes = nodes;
    if (is_done && out->leaf_bytes)
        is_done = resize(&leaves, &out->leaf_capacity, out->leaf_bytes + CO_LEAF_TAIL, 1);
    out->leaves = leaves;
    return is_done || no_memory(build);
}

// Subtrees from the last to the first, some at a time; the prims of those that are done are freed.
static bool build_round(Build *build, size_t count)
{
    CoPrimArray *prims = build->prims;
    void *kept = prims->prims;
    build->round -= count;
    co_parallel_for(count, 1, build_pieces, build);
    if (build->is_out_of_memory)
        return no_memory(build);
    if (build->round == 0)
        co_prims_free(prims);
    else if (resize(&kept, &prims->capacity, build->opening.ranges[build->round].first,
                    sizeof *prims->prims))
        prims->prims = kept;
    if (!make_room(build, count))
        return false;
    co_parallel_for(count, 1, place_pieces, build);
    for (size_t i = build->round; i < build->round + count && build->opening.range_count > 1; i++) {
        Parent parent = build->parents[i];
        build->out->tree.nodes[parent.node].child[parent.slot] = build->pieces[i].root;
    }
    return true;
}

static bool build_rounds(Build *build)
{
    size_t share = build->opening.range_count / ROUND_SHARE + 1, width = 4 * build->worker_count;
    size_t most = share < width ? width : share;
    build->round = build->opening.range_count;
    while (build->round > 0)
        if (!build_round(build, build->round < most ? build->round : most))
            return false;
    if (build->out->leaves)
        memset(build->out->leaves + build->out->leaf_bytes, 0, CO_LEAF_TAIL);
    return true;
}

static void free_build(Build *build)
{
    free_workers(build);
    for (size_t i = 0; build->pieces && i < build->opening.range_count; i++)
        co_piece_clear(&build->pieces[i]);
    co_free(TAG, build->pieces, build->opening.range_count * sizeof *build->pieces);
    co_free(TAG, build->parents, build->opening.range_count * sizeof *build->parents);
    co_opening_clear(&build->opening);
    co_prims_free(build->prims);
}

bool co_tree_build(CoPrimArray *prims, const CoLeafRule *rule, CoTreeParts *out, CohortError *err)
{
    *out = (CoTreeParts){0};
    co_box_empty(&out->tree.box);
    Build build = {.prims = prims, .rule = rule, .out = out, .err = err};
    bool is_done = true;
    if (prims->count) {
        is_done = (co_opening_make(prims, rule->most, &build.opening) && make_top(&build) &&
                   make_workers(&build)) ||
                  no_memory(&build);
        out->tree.box = build.opening.box;
        is_done = is_done && build_rounds(&build);
    }
    free_build(&build);
    if (!is_done)
        co_tree_parts_clear(out);
    return is_done;
}
