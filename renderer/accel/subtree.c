#include "accel/subtree.h"

#include "base/memory.h"

#include <string.h>

// Costs of a walk relative to each other: testing a node's 8 boxes, testing a leaf's triangles.
#define NODE_COST 1.0f
#define LEAF_COST 1.2f
#define NODE_ROOM 1.0f // the memory of a node, see open.c

#define TAG CO_MEMORY_ACCEL

enum {
    NEAR = 64, // ranges of this size are leaves soon
    STEP = 64,  // arrays grow by this much at least
    PRIMS_OF_NODE = 5 // at most, as a first guess
};

// An inner node's plan: in 3 bits for each j from 2 on how many of j children go left, 0: it has as
// many as with j - 1; above them how many leaves follow in place of two subtrees, mostly 0.
enum {
    SHARE_BITS = 3,
    FLAT_SHIFT = SHARE_BITS * (CO_NODE_WIDTH - 1)
};

static int share_of(const CoBinaryNode *node, int j)
{
    return (int)(node->plan >> SHARE_BITS * (j - 2) & ((1u << SHARE_BITS) - 1));
}

// The cheapest way to share j children between two subtrees.
static float share_children(const CoPlan halves[2], int j, uint32_t *to_left)
{
    float best = INFINITY;
    *to_left = 1;
    for (int k = 1; k < j; k++) {
        float cost = halves[0].cost[k] + halves[1].cost[j - k];
        if (cost < best) {
            best = cost;
            *to_left = (uint32_t)k;
        }
    }
    return best;
}

void co_plan_node(CoBinaryNode *node, const CoPlan halves[2], double scale, CoPlan *out)
{
    float area = (float)(co_box_area(&node->box) * scale);
    if (!halves) {
        for (int j = 1; j < CO_NODE_WIDTH; j++)
            out->cost[j] = area * LEAF_COST;
        return;
    }
    uint32_t share, plan;
    float as_node = share_children(halves, CO_NODE_WIDTH, &share);
    plan = share << SHARE_BITS * (CO_NODE_WIDTH - 2);
    out->cost[1] = as_node + area * NODE_COST + NODE_ROOM;
    for (int j = 2; j < CO_NODE_WIDTH; j++) {
        out->cost[j] = share_children(halves, j, &share);
        if (out->cost[j] < out->cost[j - 1])
            plan |= share << SHARE_BITS * (j - 2);
        else
            out->cost[j] = out->cost[j - 1];
    }
    node->plan = plan;
}

// Lists the subtrees that take at most j children's places, after `count` others.
static int list_children(const CoBinaryNode *nodes, size_t from, int j, int count,
                         uint32_t children[CO_NODE_WIDTH])
{
    const CoBinaryNode *node = &nodes[from];
    int flat = node->right ? (int)(node->plan >> FLAT_SHIFT) : 0;
    if (flat && j >= flat) {
        for (int i = 1; i <= flat; i++)
            children[count++] = (uint32_t)from + (uint32_t)i;
        return count;
    }
    while (node->right && j > 1 && share_of(node, j) == 0)
        j--;
    if (!node->right || j == 1 || flat) {
        children[count] = (uint32_t)from;
        return count + 1;
    }
    count = list_children(nodes, from + 1, share_of(node, j), count, children);
    return list_children(nodes, node->right, j - share_of(node, j), count, children);
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

// Room for so many elements, in steps that leave little unused.
static bool reserve(void **array, size_t *capacity, size_t count, size_t element)
{
    if (count <= *capacity)
        return true;
    size_t more = *capacity + *capacity / 4, wanted = count < more ? more : count + STEP;
    void *moved = co_realloc(TAG, *array, *capacity * element, wanted * element);
    if (!moved)
        return false;
    *array = moved;
    *capacity = wanted;
    return true;
}

static bool reserve_node(CoSubtree *s)
{
    void *nodes = s->nodes;
    bool is_done = reserve(&nodes, &s->node_capacity, s->node_count + 1, sizeof *s->nodes);
    s->nodes = nodes;
    return is_done;
}

// Puts what has been emitted to the other leaves: where prims are dead, as far as there is room, or
// apart, once too much of it waits for that or nothing more is to come.
static bool put_leaves(CoSubtree *s, size_t dead, bool is_last)
{
    size_t room = dead - s->leaf_bytes, bytes = s->held < room ? s->held : room;
    if (s->leaves != s->apart && s->held - bytes > (is_last ? 0 : CO_LEAVES_HELD)) {
        void *apart = s->apart;
        if (!reserve(&apart, &s->apart_capacity, s->leaf_bytes + s->held, 1))
            return false;
        s->apart = apart;
        if (s->leaf_bytes)
            memcpy(s->apart, s->leaves, s->leaf_bytes);
        s->leaves = s->apart;
    }
    if (s->leaves == s->apart) {
        void *apart = s->apart;
        bytes = s->held;
        if (!reserve(&apart, &s->apart_capacity, s->leaf_bytes + bytes, 1))
            return false;
        s->leaves = s->apart = apart;
    }
    if (bytes)
        memcpy(s->leaves + s->leaf_bytes, s->emitted, bytes);
    s->leaf_bytes += bytes;
    s->held -= bytes;
    if (s->held)
        memmove(s->emitted, s->emitted + bytes, s->held);
    return true;
}

// A leaf is written when the next one is found, by when the memory it asked for has arrived, and
// before any prim that comes after its own is touched.
static void write_pending(CoSubtree *s, bool is_last)
{
    const CoRange leaf = s->pending;
    size_t bytes = 0, place = (s->leaf_bytes + s->held) / CO_LEAF_UNIT;
    if (leaf.count == 0)
        return;
    s->pending.count = 0;
    uint32_t ref = s->rule->emit(s->rule->context, s->prims + leaf.first, leaf.count,
                                 s->emitted + s->held, &bytes);
    s->nodes[s->pending_node].leaf = ref + (uint32_t)place;
    s->held += bytes;
    size_t dead = leaf.first + leaf.count - s->first;
    s->is_out_of_memory = !put_leaves(s, dead * sizeof *s->prims, is_last);
}

static uint32_t grow(CoSubtree *s, const CoRange *range, CoPlan *out);

// A node of leaves alone. In a parent it takes one place, or one for each of them.
static void grow_flat(CoSubtree *s, const CoRange *range, uint32_t index, CoPlan *out)
{
    float leaves = 0.0f;
    for (uint32_t i = 0; i < range->count; i++) {
        CoRange one = {.first = range->first + i, .count = 1, .depth = range->depth + 1};
        memcpy(one.box.lo, s->prims[one.first].lo, sizeof one.box.lo);
        memcpy(one.box.hi, s->prims[one.first].hi, sizeof one.box.hi);
        grow(s, &one, out);
        leaves += out->cost[1];
    }
    float area = (float)(co_box_area(&range->box) * s->scale);
    for (uint32_t j = 1; j < CO_NODE_WIDTH; j++)
        out->cost[j] = leaves + (j < range->count ? area * NODE_COST + NODE_ROOM : 0.0f);
    if (s->is_out_of_memory)
        return;
    s->nodes[index].right = index + 1;
    s->nodes[index].plan = range->count << FLAT_SHIFT;
}

// Returns the index of the range's node, and its plan.
static uint32_t grow(CoSubtree *s, const CoRange *range, CoPlan *out)
{
    uint32_t index = (uint32_t)s->node_count;
    memset(out, 0, sizeof *out);
    s->is_out_of_memory = s->is_out_of_memory || !reserve_node(s);
    if (s->is_out_of_memory)
        return 0;
    s->nodes[s->node_count++] = (CoBinaryNode){.box = range->box};
    if (range->count <= s->rule->most &&
        s->rule->fits(s->rule->context, s->prims + range->first, range->count)) {
        write_pending(s, false);
        s->pending = *range;
        s->pending_node = index;
        co_plan_node(&s->nodes[index], NULL, s->scale, out);
        return index;
    }
    if (range->count <= s->rule->flat) {
        grow_flat(s, range, index, out);
        return index;
    }
    CoRange halves[2];
    CoPlan plans[2];
    co_split_range(s->prims, range, halves);
    for (int i = 0; i < 2 && s->rule->approach; i++)
        if (range->count > NEAR && halves[i].count <= NEAR)
            s->rule->approach(s->rule->context, s->prims + halves[i].first, halves[i].count);
    grow(s, &halves[0], &plans[0]);
    uint32_t right = grow(s, &halves[1], &plans[1]);
    if (s->is_out_of_memory)
        return 0;
    s->nodes[index].right = right;
    co_plan_node(&s->nodes[index], plans, s->scale, out);
    return index;
}

// Parents before children, in depth-first order.
static uint32_t write_node(const CoSubtree *s, uint32_t from, CoPiece *out)
{
    uint32_t index = (uint32_t)out->node_count++, children[CO_NODE_WIDTH];
    CoWideNode node;
    int count = co_plan_children(s->nodes, from, children);
    co_wide_node_clear(&node);
    for (int i = 0; i < count; i++) {
        const CoBinaryNode *child = &s->nodes[children[i]];
        co_wide_node_set(&node, i, &child->box,
                         child->right ? write_node(s, children[i], out) : child->leaf);
    }
    memcpy(out->bytes + out->leaf_bytes + index * sizeof node, &node, sizeof node);
    return index;
}

bool co_subtree_build(CoSubtree *s, const CoRange *range, bool has_node, CoPiece *out)
{
    CoPlan plan;
    *out = (CoPiece){.bytes = (unsigned char *)(s->prims + range->first)};
    s->first = range->first;
    s->leaves = out->bytes;
    s->node_count = s->leaf_bytes = s->held = s->pending.count = 0;
    void *nodes = s->nodes;
    s->is_out_of_memory =
        !reserve(&nodes, &s->node_capacity, range->count / PRIMS_OF_NODE, sizeof *s->nodes);
    s->nodes = nodes;
    grow(s, range, &plan);
    if (!s->is_out_of_memory)
        write_pending(s, true);
    if (s->is_out_of_memory)
        return false;
    bool is_node = has_node || s->nodes[0].right;
    size_t bytes = s->leaf_bytes + (is_node ? co_plan_count(s->nodes, 0) : 0) * sizeof(CoWideNode);
    if (s->leaves == s->apart || bytes > range->count * sizeof *s->prims) {
        out->bytes = co_alloc(TAG, bytes);
        if (!out->bytes)
            return false;
        out->is_apart = true;
        memcpy(out->bytes, s->leaves, s->leaf_bytes);
    }
    out->leaf_bytes = s->leaf_bytes;
    out->root = is_node ? write_node(s, 0, out) : s->nodes[0].leaf;
    return true;
}

void co_subtree_clear(CoSubtree *s)
{
    co_free(TAG, s->nodes, s->node_capacity * sizeof *s->nodes);
    co_free(TAG, s->apart, s->apart_capacity);
    s->nodes = NULL;
    s->apart = NULL;
    s->node_capacity = s->apart_capacity = 0;
}

void co_piece_leave_nodes(CoPiece *piece)
{
    size_t bytes = co_piece_bytes(piece);
    void *kept = piece->leaf_bytes ? piece->bytes : NULL;
    if (piece->is_apart && !kept)
        co_free(TAG, piece->bytes, bytes);
    else if (piece->is_apart)
        kept = co_realloc(TAG, piece->bytes, bytes, piece->leaf_bytes);
    if (piece->leaf_bytes && !kept)
        return;
    piece->bytes = kept;
    piece->node_count = 0;
}

void co_piece_clear(CoPiece *piece)
{
    if (piece->is_apart)
        co_free(TAG, piece->bytes, co_piece_bytes(piece));
    *piece = (CoPiece){0};
}
