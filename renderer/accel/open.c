#include "accel/open.h"

#include "base/memory.h"
#include "base/parallel.h"

#define TAG CO_MEMORY_ACCEL

// Of leaves that are full, by which the memory of a node is as dear as being met by every ray: a
// quarter of what a node costs on average, as rays meet some 15 nodes and 4 leaves make one. Of
// groups, whose leaves are one thing each, far less: what stands there takes more than nodes above.
#define MEMORY_WORTH 12.0
#define GROUP_MEMORY_WORTH 0.1

enum {
    WIDE_SHARE = 4, // ranges above this part of each thread's are split by all of them
    NARROW = 32768, // or, of so few things, which gain little by that, above three halves of it
    SUBTREE_SHARE = 128, // a subtree is at most this part of the whole,
    SUBTREE_MIN = 1024,  // within these bounds
    SUBTREE_MAX = 16384,
    SUBTREE_ALONE = 4096 // so few things are one subtree
};

static bool reserve(void **array, size_t *capacity, size_t count, size_t element)
{
    if (count < *capacity)
        return true;
    size_t more = 2 * *capacity + 1;
    void *moved = co_realloc(TAG, *array, *capacity * element, more * element);
    if (!moved)
        return false;
    *array = moved;
    *capacity = more;
    return true;
}

static bool add_range(CoOpening *o, const CoRange *range)
{
    void *ranges = o->ranges;
    bool is_done = reserve(&ranges, &o->range_capacity, o->range_count, sizeof *o->ranges);
    o->ranges = ranges;
    if (is_done)
        o->ranges[o->range_count++] = *range;
    return is_done;
}

static bool add_binary(CoOpening *o, const CoBinaryNode *node)
{
    void *binary = o->binary;
    bool is_done = reserve(&binary, &o->binary_capacity, o->binary_count, sizeof *o->binary);
    o->binary = binary;
    if (is_done)
        o->binary[o->binary_count++] = *node;
    return is_done;
}

// Splits a range until what is left has at most `limit` prims.
static bool open_range(CoOpening *o, CoWideSplit *split, CoBuildPrim *prims, const CoRange *range,
                       size_t limit)
{
    CoBinaryNode node = {.box = range->box, .left = CO_REF_LEAF};
    if (range->count <= limit) {
        node.leaf = (uint32_t)o->range_count;
        return add_range(o, range) && add_binary(o, &node);
    }
    CoRange halves[2];
    co_wide_split_range(split, prims, range, halves);
    if (!open_range(o, split, prims, &halves[0], limit))
        return false;
    node.left = co_opening_root(o);
    return open_range(o, split, prims, &halves[1], limit) && add_binary(o, &node);
}

// The second step: each range of the first opened on its own.
typedef struct Deeper {
    const CoPrimArray *prims;
    const CoOpening *outer;
    CoOpening *inner; // one per range of the outer
    size_t limit;
    _Atomic bool is_out_of_memory;
} Deeper;

static void open_deeper(void *context, size_t begin, size_t end, uint32_t worker)
{
    Deeper *d = context;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        const CoRange *range = &d->outer->ranges[i];
        bool is_large = range->count > CO_SPLIT_LARGE;
        CoWideSplit *split = is_large ? co_wide_split_create(range->count, 1) : NULL;
        if ((is_large && !split) ||
            !open_range(&d->inner[i], split, d->prims->prims, range, d->limit))
            d->is_out_of_memory = true;
        co_wide_split_destroy(split);
    }
}

// The tree of one inner opening takes the place of a leaf of the outer.
static bool put_inner(CoOpening *out, const CoOpening *inner)
{
    uint32_t base = (uint32_t)out->binary_count * CO_BINARY_UNITS;
    uint32_t ranges = (uint32_t)out->range_count;
    for (size_t i = 0; i < inner->range_count; i++)
        if (!add_range(out, &inner->ranges[i]))
            return false;
    for (size_t i = 0; i < inner->binary_count; i++) {
        CoBinaryNode node = inner->binary[i];
        if (co_binary_is_leaf(&node))
            node.leaf += ranges;
        else
            node.left += base;
        if (!add_binary(out, &node))
            return false;
    }
    return true;
}

// Walks the outer tree, which is small.
static bool join(CoOpening *out, const CoOpening *outer, const CoOpening *inner, uint32_t from)
{
    CoBinaryNode node = *co_binary_at(outer->binary, from);
    if (co_binary_is_leaf(&node))
        return put_inner(out, &inner[node.leaf]);
    if (!join(out, outer, inner, node.left))
        return false;
    node.left = co_opening_root(out);
    return join(out, outer, inner, from - CO_BINARY_UNITS) && add_binary(out, &node);
}

static bool deepen(const CoPrimArray *prims, const CoOpening *outer, CoOpening *out)
{
    size_t bytes = outer->range_count * sizeof(CoOpening);
    Deeper deeper = {.prims = prims, .outer = outer, .limit = out->largest};
    deeper.inner = co_alloc_zero(TAG, bytes);
    if (!deeper.inner)
        return false;
    co_parallel_for_parts(outer->range_count, 1, open_deeper, &deeper);
    bool is_done =
        !deeper.is_out_of_memory && join(out, outer, deeper.inner, co_opening_root(outer));
    for (size_t i = 0; i < outer->range_count; i++)
        co_opening_clear(&deeper.inner[i]);
    co_free(TAG, deeper.inner, bytes);
    return is_done;
}

// Children before parents.
static void plan(CoOpening *o, size_t index, CoPlan *out)
{
    CoBinaryNode *node = &o->binary[index];
    CoPlan halves[2];
    bool is_leaf = co_binary_is_leaf(node);
    if (!is_leaf) {
        plan(o, node->left / CO_BINARY_UNITS, &halves[0]);
        plan(o, index - 1, &halves[1]);
    }
    co_plan_node(node, is_leaf ? NULL : halves, o->scale, out);
}

static bool open_wide(const CoPrimArray *prims, uint32_t threads, CoOpening *out)
{
    CoOpening outer = {0};
    CoRange all = {.count = (uint32_t)prims->count};
    size_t share = prims->count / threads;
    size_t limit = prims->count < NARROW ? share + share / 2 : share / WIDE_SHARE;
    CoWideSplit *split = co_wide_split_create(prims->count, threads);
    bool is_done = split != NULL;
    if (split) {
        all.box = out->box = co_wide_split_box(split, prims->prims, prims->count);
        is_done = threads == 1 ? open_range(out, split, prims->prims, &all, out->largest)
                               : open_range(&outer, split, prims->prims, &all,
                                            limit > out->largest ? limit : out->largest);
    }
    co_wide_split_destroy(split);
    is_done = is_done && (threads == 1 || deepen(prims, &outer, out));
    co_opening_clear(&outer);
    return is_done;
}

bool co_opening_make(const CoPrimArray *prims, size_t leaf, uint32_t threads, CoOpening *out)
{
    size_t share = prims->count / SUBTREE_SHARE;
    *out = (CoOpening){.largest = share};
    if (share < SUBTREE_MIN || share > SUBTREE_MAX)
        out->largest = share < SUBTREE_MIN ? SUBTREE_MIN : SUBTREE_MAX;
    bool is_done;
    if (prims->count > SUBTREE_ALONE) {
        is_done = open_wide(prims, threads, out);
    } else {
        CoRange all = {.count = (uint32_t)prims->count};
        CoBox4 box = co_prim_box(prims->prims, prims->count);
        co_box4_store(&out->box, &box);
        all.box = out->box;
        out->largest = prims->count;
        is_done = open_range(out, NULL, prims->prims, &all, out->largest);
    }
    if (!is_done)
        return false;
    CoPlan root;
    double area = co_box_area(&out->box);
    double worth = leaf > 1 ? MEMORY_WORTH * (double)leaf : GROUP_MEMORY_WORTH;
    double weight = (double)prims->count / worth;
    out->scale = area > 0.0 ? weight / area : 0.0;
    plan(out, out->binary_count - 1, &root);
    return true;
}

void co_opening_clear(CoOpening *o)
{
    co_free(TAG, o->ranges, o->range_capacity * sizeof *o->ranges);
    co_free(TAG, o->binary, o->binary_capacity * sizeof *o->binary);
    *o = (CoOpening){0};
}
