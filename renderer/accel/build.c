#include "accel/build.h"

#include "base/error.h"
#include "base/memory.h"

#include <string.h>

bool co_tree_grow(void **array, size_t *capacity, size_t count, size_t element, CohortError *err)
{
    if (count < *capacity)
        return true;
    size_t more = *capacity ? 2 * *capacity : 4, bytes = 0;
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

typedef struct Collapse {
    const CoBinaryNode *binary;
    const CoBuildPrim *prims;
    const CoLeafRule *rule;
    CoTree *tree;
    CohortError *err;
} Collapse;

// Opens the child of largest area until there are 8 or only leaves. Returns how many there are.
static int open_children(const CoBinaryNode *binary, size_t node, size_t children[CO_NODE_WIDTH])
{
    int count = 1;
    children[0] = node;
    while (count < CO_NODE_WIDTH) {
        int widest = -1;
        double widest_area = -1.0;
        for (int i = 0; i < count; i++) {
            const CoBinaryNode *child = &binary[children[i]];
            double area = co_box_area(&child->box);
            if (child->right && area > widest_area) {
                widest = i;
                widest_area = area;
            }
        }
        if (widest < 0)
            break;
        size_t opened = children[widest];
        children[widest] = opened + 1;
        children[count++] = binary[opened].right;
    }
    return count;
}

static bool emit_node(Collapse *collapse, size_t from, uint32_t *ref);

static bool emit_child(Collapse *collapse, size_t from, uint32_t *ref)
{
    const CoBinaryNode *node = &collapse->binary[from];
    if (node->right)
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
    if (!co_tree_grow(&nodes, &tree->node_capacity, tree->node_count, sizeof node, collapse->err))
        return false;
    tree->nodes = nodes;
    size_t index = tree->node_count++;
    CO_CHECK(index < CO_REF_NONE, collapse->err, COHORT_ERROR_LIMIT,
             "a tree of more than 2^31 - 2 nodes; split the mesh");
    size_t children[CO_NODE_WIDTH];
    int count = open_children(collapse->binary, from, children);
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

bool co_tree_build(CoBuildPrim *prims, size_t count, const CoLeafRule *rule, CoTree *out,
                   CohortError *err)
{
    memset(out, 0, sizeof *out);
    co_box_empty(&out->box);
    if (count == 0)
        return true;
    size_t bytes = 0;
    CoBinaryNode *binary = NULL;
    if (co_size_mul(2 * count, sizeof *binary, &bytes))
        binary = co_alloc(CO_MEMORY_ACCEL, bytes);
    CO_CHECK_MEMORY(binary, err);
    Collapse collapse = {binary, prims, rule, out, err};
    uint32_t root;
    bool is_done =
        co_binary_build(prims, count, rule, binary, err) && emit_node(&collapse, 0, &root);
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
