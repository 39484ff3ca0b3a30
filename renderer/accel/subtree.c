#include "accel/subtree.h"

#include "base/memory.h"

#include <string.h>

// Costs of a walk relative to each other: testing a node's 8 boxes, testing a leaf's triangles.
#define NODE_COST 1.0f
#define LEAF_COST 1.2f
#define NODE_ROOM 1.0f // the memory of a node, see open.c

enum {
    NEAR = 64 // ranges of this size are leaves soon
};

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
    node->cost[1] = as_node + area * NODE_COST + NODE_ROOM;
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
    if (node->flat && j >= node->flat) {
        for (uint32_t i = 1; i <= node->flat; i++)
            children[count++] = (uint32_t)from + i;
        return count;
    }
    while (node->right && j > 1 && node->left[j] == 0)
        j--;
    if (!node->right || j == 1 || node->flat) {
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

// Room for one more node.
static bool reserve_node(CoSubtree *s)
{
    void *nodes = s->nodes;
    bool is_done =
        co_grow(CO_MEMORY_ACCEL, &nodes, s->node_count, &s->node_capacity, sizeof *s->nodes);
    s->nodes = nodes;
    return is_done;
}

// Room for one more leaf, of so many prims.
static bool reserve_leaf(CoSubtree *s, size_t count)
{
    size_t bytes = s->leaf_bytes + count * s->rule->prim_bytes;
    void *leaves = s->leaves;
    bool is_done = true;
    while (is_done && bytes > s->leaf_capacity)
        is_done = co_grow(CO_MEMORY_ACCEL, &leaves, bytes, &s->leaf_capacity, 1);
    s->leaves = leaves;
    return is_done;
}

// A leaf is written when the next one is found, by when the memory it asked for has arrived.
static void write_pending(CoSubtree *s)
{
    if (s->pending == 0)
        return;
    CoBinaryNode *node = &s->nodes[s->pending - 1];
    size_t bytes = 0, place = s->leaf_bytes / CO_LEAF_UNIT;
    s->pending = 0;
    if (!reserve_leaf(s, node->count)) {
        s->is_out_of_memory = true;
        return;
    }
    node->leaf = s->rule->emit(s->rule->context, s->prims + node->first, node->count,
                               s->leaves ? s->leaves + s->leaf_bytes : NULL, &bytes);
    node->leaf += (uint32_t)place;
    s->leaf_bytes += bytes;
}

static uint32_t grow(CoSubtree *s, const CoRange *range);

// A node of leaves alone. In a parent it takes one place, or one for each of them.
static void grow_flat(CoSubtree *s, const CoRange *range, uint32_t index)
{
    for (uint32_t i = 0; i < range->count; i++) {
        CoRange one = {.first = range->first + i, .count = 1, .depth = range->depth + 1};
        memcpy(one.box.lo, s->prims[one.first].lo, sizeof one.box.lo);
        memcpy(one.box.hi, s->prims[one.first].hi, sizeof one.box.hi);
        grow(s, &one);
    }
    if (s->is_out_of_memory)
        return;
    CoBinaryNode *node = &s->nodes[index];
    float leaves = 0.0f, area = (float)(co_box_area(&node->box) * s->scale);
    for (uint32_t i = 1; i <= range->count; i++)
        leaves += node[i].cost[1];
    for (uint32_t j = 1; j < CO_NODE_WIDTH; j++)
        node->cost[j] = leaves + (j < range->count ? area * NODE_COST + NODE_ROOM : 0.0f);
    node->right = index + 1;
    node->flat = (uint8_t)range->count;
}

static uint32_t grow(CoSubtree *s, const CoRange *range)
{
    uint32_t index = (uint32_t)s->node_count;
    s->is_out_of_memory = s->is_out_of_memory || !reserve_node(s);
    if (s->is_out_of_memory)
        return 0;
    s->nodes[s->node_count++] =
        (CoBinaryNode){.box = range->box, .first = range->first, .count = range->count};
    if (range->count <= s->rule->most &&
        s->rule->fits(s->rule->context, s->prims + range->first, range->count)) {
        write_pending(s);
        s->pending = index + 1;
        co_plan_node(&s->nodes[index], NULL, NULL, s->scale);
        return index;
    }
    if (range->count <= s->rule->flat) {
        grow_flat(s, range, index);
        return index;
    }
    CoRange halves[2];
    co_split_range(s->prims, range, s->moved, halves);
    for (int i = 0; i < 2 && s->rule->approach; i++)
        if (range->count > NEAR && halves[i].count <= NEAR)
            s->rule->approach(s->rule->context, s->prims + halves[i].first, halves[i].count);
    grow(s, &halves[0]);
    uint32_t right = grow(s, &halves[1]);
    CoBinaryNode *node = &s->nodes[index];
    node->right = right;
    if (!s->is_out_of_memory)
        co_plan_node(node, node + 1, &s->nodes[right], s->scale);
    return index;
}

// Parents before children, in depth-first order.
static uint32_t write_node(const CoSubtree *s, uint32_t from, CoPiece *out)
{
    uint32_t index = (uint32_t)out->node_count++, children[CO_NODE_WIDTH];
    CoWideNode *node = &out->nodes[index];
    int count = co_plan_children(s->nodes, from, children);
    co_wide_node_clear(node);
    for (int i = 0; i < count; i++) {
        const CoBinaryNode *child = &s->nodes[children[i]];
        co_wide_node_set(node, i, &child->box,
                         child->right ? write_node(s, children[i], out) : child->leaf);
    }
    return index;
}

bool co_subtree_build(CoSubtree *s, const CoRange *range, bool has_node, CoPiece *out)
{
    *out = (CoPiece){0};
    s->node_count = s->leaf_bytes = s->pending = 0;
    s->is_out_of_memory = false;
    grow(s, range);
    write_pending(s);
    if (s->is_out_of_memory)
        return false;
    bool is_node = has_node || s->nodes[0].right;
    size_t node_count = is_node ? co_plan_count(s->nodes, 0) : 0;
    size_t node_bytes = node_count * sizeof *out->nodes;
    if (node_bytes + s->leaf_bytes > 0) {
        out->nodes = co_alloc(CO_MEMORY_ACCEL, node_bytes + s->leaf_bytes);
        if (!out->nodes)
            return false;
    }
    out->root = is_node ? write_node(s, 0, out) : s->nodes[0].leaf;
    out->leaf_bytes = s->leaf_bytes;
    if (s->leaf_bytes)
        memcpy(out->nodes + node_count, s->leaves, s->leaf_bytes);
    return true;
}

void co_piece_clear(CoPiece *piece)
{
    co_free(CO_MEMORY_ACCEL, piece->nodes, co_piece_bytes(piece));
    piece->nodes = NULL;
    piece->node_count = piece->leaf_bytes = 0;
}
