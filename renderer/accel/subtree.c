#include "accel/subtree.h"

#include "base/memory.h"

// Costs of a walk relative to each other: testing a node's 8 boxes, testing a leaf's triangles.
#define NODE_COST 1.0f
#define LEAF_COST 1.2f

// The cheapest way to share j children between two subtrees.
static float share_children(const CoBinaryNode *left, const CoBinaryNode *right, int j,
                            uint8_t *to_left)
{
    float best = INFINITY;
    *to_left = 1;
    for (int k = 1; k < j; k++) {
        float cost = left->cost[k] + right->cost[j - k];
        if (cost < best) {
            best = cost;
            *to_left = (uint8_t)k;
        }
    }
    return best;
}

void co_plan_node(CoBinaryNode *node, const CoBinaryNode *left, const CoBinaryNode *right,
                  double scale)
{
    float area = (float)(co_box_area(&node->box) * scale);
    if (!left) {
        for (int j = 1; j < CO_NODE_WIDTH; j++)
            node->cost[j] = area * LEAF_COST;
        return;
    }
    float as_node = share_children(left, right, CO_NODE_WIDTH, &node->left[CO_NODE_WIDTH]);
    node->cost[1] = as_node + area * NODE_COST;
    for (int j = 2; j < CO_NODE_WIDTH; j++) {
        node->cost[j] = share_children(left, right, j, &node->left[j]);
        if (node->cost[j] < node->cost[j - 1])
            continue;
        node->cost[j] = node->cost[j - 1];
        node->left[j] = 0;
    }
}

// Lists the subtrees that take at most j children's places, after `count` others.
static int list_children(const CoBinaryNode *nodes, size_t from, int j, int count,
                         uint32_t children[CO_NODE_WIDTH])
{
    const CoBinaryNode *node = &nodes[from];
    while (node->right && j > 1 && node->left[j] == 0)
        j--;
    if (!node->right || j == 1) {
        children[count] = (uint32_t)from;
        return count + 1;
    }
    count = list_children(nodes, from + 1, node->left[j], count, children);
    return list_children(nodes, node->right, j - node->left[j], count, children);
}

int co_plan_children(const CoBinaryNode *nodes, size_t from, uint32_t children[CO_NODE_WIDTH])
{
    return list_children(nodes, from, CO_NODE_WIDTH, 0, children);
}

size_t co_plan_count(const CoBinaryNode *nodes, size_t from)
{
    uint32_t children[CO_NODE_WIDTH];
    int count = co_plan_children(nodes, from, children);
    size_t wide = 1;
    for (int i = 0; i < count; i++)
        if (nodes[children[i]].right)
            wide += co_plan_count(nodes, children[i]);
    return wide;
}

void co_wide_node_clear(CoWideNode *node)
{
    for (int i = 0; i < CO_NODE_WIDTH; i++) {
        for (int k = 0; k < 3; k++) {
            node->planes[2 * k][i] = INFINITY;
            node->planes[2 * k + 1][i] = -INFINITY;
        }
        node->child[i] = CO_REF_NONE;
    }
}

void co_wide_node_set(CoWideNode *node, int i, const CoBox *box, uint32_t ref)
{
    for (int k = 0; k < 3; k++) {
        node->planes[2 * k][i] = box->lo[k];
        node->planes[2 * k + 1][i] = box->hi[k];
    }
    node->child[i] = ref;
}

static uint32_t grow(CoSubtree *s, const CoRange *range)
{
    uint32_t index = (uint32_t)s->node_count++;
    CoBinaryNode *node = &s->nodes[index];
    size_t bytes = 0;
    node->box = range->box;
    node->first = range->first;
    node->count = range->count;
    node->right = 0;
    if (range->count <= s->rule->most &&
        s->rule->fits(s->rule->context, s->prims + range->first, range->count, &bytes)) {
        s->leaf_bytes += bytes;
        co_plan_node(node, NULL, NULL, s->scale);
        return index;
    }
    CoRange halves[2];
    co_split_range(s->prims, range, s->moved, halves);
    uint32_t left = grow(s, &halves[0]);
    node->right = grow(s, &halves[1]);
    co_plan_node(node, &s->nodes[left], &s->nodes[node->right], s->scale);
    return index;
}

typedef struct Writer {
    const CoSubtree *subtree;
    CoWideNode *nodes;
    unsigned char *leaves;
    size_t node_count, leaf_bytes;
} Writer;

static uint32_t write_leaf(Writer *w, const CoBinaryNode *node)
{
    const CoLeafRule *rule = w->subtree->rule;
    const CoBuildPrim *prims = w->subtree->prims + node->first;
    size_t bytes = 0, place = w->leaf_bytes / CO_LEAF_UNIT;
    rule->fits(rule->context, prims, node->count, &bytes);
    uint32_t ref = rule->emit(rule->context, prims, node->count, w->leaves + w->leaf_bytes);
    w->leaf_bytes += bytes;
    return ref + (uint32_t)place;
}

// Parents before children, in depth-first order.
static uint32_t write_node(Writer *w, uint32_t from)
{
    const CoBinaryNode *nodes = w->subtree->nodes;
    uint32_t index = (uint32_t)w->node_count++, children[CO_NODE_WIDTH];
    CoWideNode *out = &w->nodes[index];
    int count = co_plan_children(nodes, from, children);
    co_wide_node_clear(out);
    for (int i = 0; i < count; i++) {
        const CoBinaryNode *child = &nodes[children[i]];
        uint32_t ref = child->right ? write_node(w, children[i]) : write_leaf(w, child);
        co_wide_node_set(out, i, &child->box, ref);
    }
    return index;
}

bool co_subtree_build(CoSubtree *s, const CoRange *range, bool has_node, CoPiece *out)
{
    s->node_count = 0;
    s->leaf_bytes = 0;
    grow(s, range);
    bool is_node = has_node || s->nodes[0].right;
    *out = (CoPiece){.node_count = is_node ? co_plan_count(s->nodes, 0) : 0, .leaf_bytes = s->leaf_bytes};
    size_t node_bytes = out->node_count * sizeof *out->nodes;
    if (co_piece_bytes(out) > 0) {
        out->nodes = co_alloc(CO_MEMORY_ACCEL, co_piece_bytes(out));
        if (!out->nodes) {
            *out = (CoPiece){0};
            return false;
        }
    }
    Writer writer = {s, out->nodes, (unsigned char *)out->nodes + node_bytes, 0, 0};
    out->root = is_node ? write_node(&writer, 0) : write_leaf(&writer, &s->nodes[0]);
    return true;
}

void co_piece_clear(CoPiece *piece)
{
    co_free(CO_MEMORY_ACCEL, piece->nodes, co_piece_bytes(piece));
    piece->nodes = NULL;
    piece->node_count = piece->leaf_bytes = 0;
}
