#include "accel/subtree.h"

#include "base/memory.h"

#include <string.h>

// Costs of a walk relative to each other: testing a node's 8 boxes, testing a leaf's triangles.
#define NODE_COST 1.0f
#define LEAF_COST 1.2f
#define NODE_ROOM 1.0f // the memory of a node, see open.c

#define TAG CO_MEMORY_ACCEL

enum {
    NEAR = 24,  // ranges of this size are leaves soon
    AHEAD = 16, // ids, from what is written to what is asked for
    STEP = 256  // bytes by which records that lie apart grow at least
};

// What is known of a subtree on the way. Records wait in `held` for their place.
typedef struct Subtree {
    const CoSubtrees *in;
    CoPiece *out;
    size_t first, count, dead; // prims of the range, those of them that have become leaves
    size_t held_bytes;
    bool is_out_of_memory;
    unsigned char held[CO_RECORDS_HELD + sizeof(CoLeafShape)];
} Subtree;
_Static_assert(sizeof(CoLeafShape) >= sizeof(CoBinaryNode), "room for any record");

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

// The children of a node of leaves alone, each behind its ids.
static int list_flat(const void *records, uint32_t at, int flat, uint32_t *children)
{
    for (int i = flat; i-- > 0;) {
        at -= CO_BINARY_UNITS;
        children[i] = at;
        at -= co_binary_at(records, at)->left & ~CO_REF_LEAF;
    }
    return flat;
}

// Lists the subtrees that take at most j children's places, after `count` others.
static int list_children(const void *records, uint32_t from, int j, int count,
                         uint32_t children[CO_NODE_WIDTH])
{
    const CoBinaryNode *node = co_binary_at(records, from);
    bool is_leaf = co_binary_is_leaf(node);
    int flat = is_leaf ? 0 : (int)(node->plan >> FLAT_SHIFT);
    if (flat && j >= flat)
        return count + list_flat(records, from, flat, children + count);
    while (!is_leaf && j > 1 && share_of(node, j) == 0)
        j--;
    if (is_leaf || j == 1 || flat) {
        children[count] = from;
        return count + 1;
    }
    count = list_children(records, node->left, share_of(node, j), count, children);
    return list_children(records, from - CO_BINARY_UNITS, j - share_of(node, j), count, children);
}

int co_plan_children(const void *records, uint32_t from, uint32_t children[CO_NODE_WIDTH])
{
    return list_children(records, from, CO_NODE_WIDTH, 0, children);
}

size_t co_plan_count(const void *records, uint32_t from)
{
    uint32_t children[CO_NODE_WIDTH];
    int count = co_plan_children(records, from, children);
    size_t wide = 1;
    for (int i = 0; i < count; i++)
        if (!co_binary_is_leaf(co_binary_at(records, children[i])))
            wide += co_plan_count(records, children[i]);
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

// Room for so many bytes apart from the prims. At first as much as all prims take if they take what
// the dead ones do.
static bool reserve(Subtree *s, size_t bytes)
{
    CoPiece *piece = s->out;
    if (bytes <= piece->capacity)
        return true;
    size_t wanted = bytes + bytes / 8 + STEP, likely = bytes / s->dead * s->count;
    if (!piece->capacity && wanted < likely)
        wanted = likely;
    void *from = piece->capacity ? piece->bytes : NULL;
    unsigned char *moved = co_realloc(TAG, from, piece->capacity, wanted);
    if (!moved)
        return false;
    if (!from && piece->byte_count)
        memcpy(moved, piece->bytes, piece->byte_count);
    piece->bytes = moved;
    piece->capacity = wanted;
    return true;
}

// Gives back what it does not need, if the heap can.
static void fit(CoPiece *piece)
{
    if (piece->capacity == piece->byte_count)
        return;
    void *fitted = piece->byte_count
                       ? co_realloc(TAG, piece->bytes, piece->capacity, piece->byte_count)
                       : NULL;
    if (piece->byte_count == 0)
        co_free(TAG, piece->bytes, piece->capacity);
    else if (!fitted)
        return;
    piece->bytes = fitted;
    piece->capacity = piece->byte_count;
}

// Puts what is held to the other records: where prims are dead, as far as there is room, or apart,
// once more waits for that than `most` bytes.
static void settle(Subtree *s, size_t most)
{
    CoPiece *out = s->out;
    size_t room = s->dead * sizeof(CoBuildPrim) - out->byte_count;
    if (out->capacity || (s->held_bytes > room && s->held_bytes - room > most)) {
        s->is_out_of_memory = !reserve(s, out->byte_count + s->held_bytes);
        room = s->held_bytes;
    }
    if (s->is_out_of_memory)
        return;
    size_t bytes = s->held_bytes < room ? s->held_bytes : room;
    memcpy(out->bytes + out->byte_count, s->held, bytes);
    out->byte_count += bytes;
    s->held_bytes -= bytes;
    if (s->held_bytes)
        memmove(s->held, s->held + bytes, s->held_bytes);
}

// Mostly there is room for it where it stays. Inline, as sizes are known where it is called.
static inline void put(Subtree *s, const void *record, size_t bytes)
{
    CoPiece *out = s->out;
    if (s->is_out_of_memory)
        return;
    if (!s->held_bytes && !out->capacity &&
        out->byte_count + bytes <= s->dead * sizeof(CoBuildPrim)) {
        memcpy(out->bytes + out->byte_count, record, bytes);
        out->byte_count += bytes;
        return;
    }
    memcpy(s->held + s->held_bytes, record, bytes);
    s->held_bytes += bytes;
    settle(s, CO_RECORDS_HELD);
}

// Returns where it is.
static uint32_t put_node(Subtree *s, const CoBinaryNode *node)
{
    size_t at = (s->out->byte_count + s->held_bytes) / CO_LEAF_UNIT;
    put(s, node, sizeof *node);
    return (uint32_t)at;
}

static uint32_t put_leaf(Subtree *s, const CoRange *range, const CoLeafShape *shape, CoPlan *out)
{
    CoBinaryNode node = {.box = range->box, .left = CO_REF_LEAF};
    node.leaf = shape->ref + (uint32_t)(s->out->leaf_bytes / CO_LEAF_UNIT);
    s->out->leaf_bytes += shape->bytes;
    s->dead = range->first + range->count - s->first;
    if (shape->bytes) {
        uint32_t ids[CO_LEAF_WIDTH];
        memcpy(ids, shape->ids, sizeof ids);
        ids[0] |= CO_ID_FIRST;
        put(s, ids, shape->count * sizeof *ids);
        node.left |= shape->count;
    }
    co_plan_node(&node, NULL, s->in->scale, out);
    return put_node(s, &node);
}

static uint32_t grow(Subtree *s, const CoRange *range, CoPlan *out);

// A node of leaves alone. In a parent it takes one place, or one for each of them.
static uint32_t grow_flat(Subtree *s, const CoRange *range, CoPlan *out)
{
    CoBinaryNode node = {.box = range->box, .plan = range->count << FLAT_SHIFT};
    float leaves = 0.0f;
    for (uint32_t i = 0; i < range->count; i++) {
        CoRange one = {.first = range->first + i, .count = 1, .depth = range->depth + 1};
        memcpy(one.box.lo, s->in->prims[one.first].lo, sizeof one.box.lo);
        memcpy(one.box.hi, s->in->prims[one.first].hi, sizeof one.box.hi);
        uint32_t at = grow(s, &one, out);
        node.left = i == 0 ? at : node.left;
        leaves += out->cost[1];
    }
    float area = (float)(co_box_area(&range->box) * s->in->scale);
    for (uint32_t j = 1; j < CO_NODE_WIDTH; j++)
        out->cost[j] = leaves + (j < range->count ? area * NODE_COST + NODE_ROOM : 0.0f);
    return put_node(s, &node);
}

// Returns where the range's node is, and its plan.
static uint32_t grow(Subtree *s, const CoRange *range, CoPlan *out)
{
    const CoLeafRule *rule = s->in->rule;
    CoBuildPrim *prims = s->in->prims;
    CoLeafShape shape;
    memset(out, 0, sizeof *out);
    if (s->is_out_of_memory)
        return 0;
    if (range->count <= rule->most &&
        rule->fits(rule->context, prims + range->first, range->count, &shape))
        return put_leaf(s, range, &shape, out);
    if (range->count <= rule->flat)
        return grow_flat(s, range, out);
    CoRange halves[2];
    CoPlan plans[2];
    co_split_range(prims, range, halves);
    for (int i = 0; i < 2 && rule->approach; i++)
        if (range->count > NEAR && halves[i].count <= NEAR)
            rule->approach(rule->context, prims + halves[i].first, halves[i].count);
    CoBinaryNode node = {.box = range->box};
    node.left = grow(s, &halves[0], &plans[0]);
    grow(s, &halves[1], &plans[1]);
    co_plan_node(&node, plans, s->in->scale, out);
    return put_node(s, &node);
}

bool co_subtree_build(const CoSubtrees *in, const CoRange *range, bool has_node, CoPiece *out)
{
    CoPlan plan;
    Subtree s = {.in = in, .out = out, .first = range->first, .count = range->count};
    *out = (CoPiece){.bytes = (unsigned char *)(in->prims + range->first)};
    out->root = grow(&s, range, &plan);
    if (!s.is_out_of_memory)
        settle(&s, 0);
    if (s.is_out_of_memory) {
        co_piece_clear(out);
        return false;
    }
    if (out->capacity)
        fit(out);
    out->is_node = has_node || !co_binary_is_leaf(co_binary_at(out->bytes, out->root));
    out->node_count = out->is_node ? co_plan_count(out->bytes, out->root) : 0;
    return true;
}

// Where the next node and the next ids of a piece go.
typedef struct Writing {
    CoPiece *piece;
    CoWideNode *nodes;
    size_t node, id_bytes;
} Writing;

// Moves its ids to those of the leaves before it. What is left of the records is behind.
static uint32_t write_ref(Writing *w, const CoBinaryNode *leaf)
{
    uint32_t ref = leaf->leaf + (uint32_t)(w->piece->leaf_base / CO_LEAF_UNIT);
    size_t bytes = (leaf->left & ~CO_REF_LEAF) * sizeof(uint32_t);
    memmove(w->piece->bytes + w->id_bytes, (const unsigned char *)leaf - bytes, bytes);
    w->id_bytes += bytes;
    return ref;
}

// Parents before children, in depth-first order.
static uint32_t write_node(Writing *w, uint32_t from)
{
    uint32_t index = (uint32_t)w->node++, children[CO_NODE_WIDTH];
    CoWideNode *node = &w->nodes[index];
    int count = co_plan_children(w->piece->bytes, from, children);
    co_wide_node_clear(node);
    for (int i = 0; i < count; i++) {
        const CoBinaryNode *child = co_binary_at(w->piece->bytes, children[i]);
        const CoBox box = child->box;
        uint32_t ref = co_binary_is_leaf(child) ? write_ref(w, child) : write_node(w, children[i]);
        co_wide_node_set(node, i, &box, ref);
    }
    return index;
}

void co_piece_write_nodes(CoPiece *piece, CoWideNode *nodes)
{
    Writing w = {.piece = piece, .nodes = nodes, .node = piece->node_base};
    if (piece->is_node)
        piece->root = write_node(&w, piece->root);
    else
        piece->root = write_ref(&w, co_binary_at(piece->bytes, piece->root));
    piece->byte_count = w.id_bytes;
    if (piece->capacity)
        fit(piece);
}

void co_piece_write_leaves(const CoPiece *piece, const CoLeafRule *rule, unsigned char *leaves)
{
    const uint32_t *all = (const void *)piece->bytes;
    size_t count = piece->byte_count / sizeof *all;
    unsigned char *out = leaves + piece->leaf_base;
    for (size_t i = 0; i < count;) {
        uint32_t ids[CO_LEAF_WIDTH], n = 0;
        do {
            if (rule->expect && i + 2 * AHEAD < count)
                rule->expect(rule->context, all[i + AHEAD] & ~CO_ID_FIRST,
                             all[i + 2 * AHEAD] & ~CO_ID_FIRST);
            ids[n++] = all[i++] & ~CO_ID_FIRST;
        } while (i < count && !(all[i] & CO_ID_FIRST));
        out += rule->emit(rule->context, ids, n, out);
    }
}

void co_piece_clear(CoPiece *piece)
{
    if (piece->capacity)
        co_free(TAG, piece->bytes, piece->capacity);
    *piece = (CoPiece){0};
}
