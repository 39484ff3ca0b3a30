#include "accel/build.h"

#include "base/error.h"
#include "base/memory.h"

#include <string.h>

bool co_tree_grow(void **array, size_t *capacity, size_t count, size_t element, CohortError *err)
{
    if (count <= *capacity)
        return true;
    size_t more = count > 2 * *capacity ? count : 2 * *capacity, bytes = 0;
    void *moved = NULL;
    if (co_size_mul(more, element, &bytes))
        moved = co_realloc(CO_MEMORY_ACCEL, *array, *capacity * element, bytes);
    CO_CHECK_MEMORY(moved, err);
    *array = moved;
    *capacity = more;
    return true;
}

void co_tree_shrink(void **array, size_t *capacity, size_t count, size_t element)
{
    if (count == *capacity || count == 0)
        return;
    void *moved = co_realloc(CO_MEMORY_ACCEL, *array, *capacity * element, count * element);
    if (!moved)
        return;
    *array = moved;
    *capacity = count;
}

void co_tree_clear(CoTree *tree)
{
    co_free(CO_MEMORY_ACCEL, tree->nodes, tree->node_capacity * sizeof *tree->nodes);
    memset(tree, 0, sizeof *tree);
    co_box_empty(&tree->box);
}

// Costs of a walk relative to each other: testing a node's 8 boxes, testing a leaf's triangles.
#define NODE_COST 1.0f
#define LEAF_COST 1.2f

// How best to spend up to j children of a wide node on a binary subtree.
typedef struct Plan {
    float cost[CO_NODE_WIDTH]; // [j]: expected cost with at most j children, j = 1 .. 7
    uint8_t
        left[CO_NODE_WIDTH + 1]; // [j]: how many of them go left, j = 2 .. 8; 0: j - 1 do as well
} Plan;

typedef struct Collapse {
    const CoBinaryNode *binary;
    Plan *plans;
    const CoBuildPrim *prims;
    const CoLeafRule *rule;
    CoTree *tree;
    CohortError *err;
    double scale; // 1 / area of everything
} Collapse;

// The cheapest way to share j children between two subtrees.
static float share_children(const Plan *left, const Plan *right, int j, uint8_t *to_left)
{
    float best = INFINITY;
    *to_left = 1;
    for (int k = 1; k < j; k++) {
        if (k >= CO_NODE_WIDTH || j - k >= CO_NODE_WIDTH)
            continue;
        float cost = left->cost[k] + right->cost[j - k];
        if (cost < best) {
            best = cost;
            *to_left = (uint8_t)k;
        }
    }
    return best;
}

static void plan_subtree(Collapse *collapse, size_t from)
{
    const CoBinaryNode *node = &collapse->binary[from];
    Plan *plan = &collapse->plans[from];
    float area = (float)(co_box_area(&node->box) * collapse->scale);
    if (!node->left) {
        for (int j = 1; j < CO_NODE_WIDTH; j++)
            plan->cost[j] = area * LEAF_COST;
        return;
    }
    plan_subtree(collapse, node->left);
    plan_subtree(collapse, node->left + 1);
    const Plan *left = &collapse->plans[node->left], *right = left + 1;
    float as_node = share_children(left, right, CO_NODE_WIDTH, &plan->left[CO_NODE_WIDTH]);
    plan->cost[1] = as_node + area * NODE_COST;
    for (int j = 2; j < CO_NODE_WIDTH; j++) {
        plan->cost[j] = share_children(left, right, j, &plan->left[j]);
        if (plan->cost[j] < plan->cost[j - 1])
            continue;
        plan->cost[j] = plan->cost[j - 1];
        plan->left[j] = 0;
    }
}

// Lists the subtrees that take at most j children's places, after `count` others.
static int list_children(const Collapse *collapse, size_t from, int j, int count,
                         size_t children[CO_NODE_WIDTH])
{
    const CoBinaryNode *node = &collapse->binary[from];
    const Plan *plan = &collapse->plans[from];
    while (node->left && j > 1 && plan->left[j] == 0)
        j--;
    if (!node->left || j == 1) {
        children[count] = from;
        return count + 1;
    }
    count = list_children(collapse, node->left, plan->left[j], count, children);
    return list_children(collapse, node->left + 1, j - plan->left[j], count, children);
}

static bool emit_node(Collapse *collapse, size_t from, uint32_t *ref);

static bool emit_child(Collapse *collapse, size_t from, uint32_t *ref)
{
    const CoBinaryNode *node = &collapse->binary[from];
    if (node->left)
        return emit_node(collapse, from, ref);
    return collapse->rule->emit(collapse->rule->context, collapse->prims + node->first, node->count,
                                ref, collapse->err);
}

// Parents before children, in depth-first order: the index is taken before the children are made.
static bool emit_node(Collapse *collapse, size_t from, uint32_t *ref)
{
    CoTree *tree = collapse->tree;
    CoWideNode node;
    void *nodes = tree->nodes;
    if (!co_tree_grow(&nodes, &tree->node_capacity, tree->node_count + 1, sizeof node,
                      collapse->err))
        return false;
    tree->nodes = nodes;
    size_t index = tree->node_count++;
    CO_CHECK(index < CO_REF_NONE, collapse->err, COHORT_ERROR_LIMIT,
             "a tree of more than 2^31 - 2 nodes; split the mesh");
    size_t children[CO_NODE_WIDTH];
    int count = list_children(collapse, from, CO_NODE_WIDTH, 0, children);
    for (int i = 0; i < CO_NODE_WIDTH; i++) {
        for (int k = 0; k < 3; k++) {
            const CoBox *box = i < count ? &collapse->binary[children[i]].box : NULL;
            node.planes[2 * k][i] = box ? box->lo[k] : INFINITY;
            node.planes[2 * k + 1][i] = box ? box->hi[k] : -INFINITY;
        }
        node.child[i] = CO_REF_NONE;
        if (i < count && !emit_child(collapse, children[i], &node.child[i]))
            return false;
    }
    tree->nodes[index] = node;
    *ref = (uint32_t)index;
    return true;
}

static bool collapse_tree(const CoBinaryNode *binary, size_t binary_count, const CoBuildPrim *prims,
                          const CoLeafRule *rule, CoTree *out, CohortError *err)
{
    size_t bytes = binary_count * sizeof(Plan);
    Plan *plans = co_alloc(CO_MEMORY_ACCEL, bytes);
    CO_CHECK_MEMORY(plans, err);
    double area = co_box_area(&binary[0].box);
    Collapse collapse = {binary, plans, prims, rule, out, err, area > 0.0 ? 1.0 / area : 0.0};
    uint32_t root;
    plan_subtree(&collapse, 0);
    bool is_done = emit_node(&collapse, 0, &root);
    co_free(CO_MEMORY_ACCEL, plans, bytes);
    return is_done;
}

bool co_tree_build(CoBuildPrim *prims, uint32_t count, const CoLeafRule *rule, CoTree *out,
                   CohortError *err)
{
    memset(out, 0, sizeof *out);
    co_box_empty(&out->box);
    if (count == 0)
        return true;
    size_t bytes = 0;
    CoBinaryNode *binary = NULL;
    if (co_size_mul(2 * (size_t)count, sizeof *binary, &bytes))
        binary = co_alloc(CO_MEMORY_ACCEL, bytes);
    CO_CHECK_MEMORY(binary, err);
    size_t binary_count = co_binary_build(prims, count, rule, binary, err);
    bool is_done = binary_count && collapse_tree(binary, binary_count, prims, rule, out, err);
    if (is_done) {
        void *nodes = out->nodes;
        co_tree_shrink(&nodes, &out->node_capacity, out->node_count, sizeof *out->nodes);
        out->nodes = nodes;
        out->box = binary[0].box;
    } else {
        co_tree_clear(out);
    }
    co_free(CO_MEMORY_ACCEL, binary, bytes);
    return is_done;
}
