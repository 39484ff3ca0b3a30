// Large ranges: every step of a split in blocks of fixed size, which any thread may do.

#include "accel/split.h"

#include "base/memory.h"
#include "base/parallel.h"

enum {
    BLOCK = 4096,
    FEW = CO_SPLIT_LARGE / BLOCK // not worth waking a thread, nor the second look at each
};

struct CoWideSplit {
    CoBins *bins;        // one per worker but the first
    CoBox4 *boxes;       // one per worker
    uint32_t *left;      // of each block
    size_t *swaps_left;  // misplaced prims before each block, of those that belong left
    size_t *swaps_right; // and right
    size_t blocks;       // most
    uint32_t workers;
    // Of the split at hand.
    CoBuildPrim *prims;
    size_t count;
    const CoBinning *binning;
    CoBins *first; // worker's, on the stack: in a small build they would be 2% of the peak
    const CoSplit *split;
};

static size_t blocks_of(size_t count)
{
    return (count + BLOCK - 1) / BLOCK;
}

void co_wide_split_destroy(CoWideSplit *s)
{
    if (!s)
        return;
    co_free(CO_MEMORY_ACCEL, s->bins, (s->workers - 1) * sizeof *s->bins);
    co_free(CO_MEMORY_ACCEL, s->boxes, s->workers * sizeof *s->boxes);
    co_free(CO_MEMORY_ACCEL, s->left, s->blocks * sizeof *s->left);
    co_free(CO_MEMORY_ACCEL, s->swaps_left, (s->blocks + 1) * sizeof *s->swaps_left);
    co_free(CO_MEMORY_ACCEL, s->swaps_right, (s->blocks + 1) * sizeof *s->swaps_right);
    co_free(CO_MEMORY_ACCEL, s, sizeof *s);
}

CoWideSplit *co_wide_split_create(size_t most, uint32_t workers)
{
    CoWideSplit *s = co_alloc_zero(CO_MEMORY_ACCEL, sizeof *s);
    if (!s)
        return NULL;
    s->workers = workers;
    s->blocks = blocks_of(most);
    s->bins = co_alloc(CO_MEMORY_ACCEL, (s->workers - 1) * sizeof *s->bins);
    s->boxes = co_alloc(CO_MEMORY_ACCEL, s->workers * sizeof *s->boxes);
    s->left = co_alloc(CO_MEMORY_ACCEL, s->blocks * sizeof *s->left);
    s->swaps_left = co_alloc(CO_MEMORY_ACCEL, (s->blocks + 1) * sizeof *s->swaps_left);
    s->swaps_right = co_alloc(CO_MEMORY_ACCEL, (s->blocks + 1) * sizeof *s->swaps_right);
    if ((s->bins || workers == 1) && s->boxes && s->left && s->swaps_left && s->swaps_right)
        return s;
    co_wide_split_destroy(s);
    return NULL;
}

static size_t block_count(const CoWideSplit *s, size_t block)
{
    size_t begin = block * BLOCK;
    return s->count - begin < BLOCK ? s->count - begin : BLOCK;
}

static void for_blocks(CoWideSplit *s, size_t blocks, CoParallelFn *fn)
{
    if (s->workers == 1 || blocks <= FEW)
        fn(s, 0, blocks, 0);
    else
        co_parallel_for_parts(blocks, 1, fn, s);
}

static void centroid_blocks(void *context, size_t begin, size_t end, uint32_t worker)
{
    CoWideSplit *s = context;
    for (size_t b = begin; b < end; b++) {
        CoBox4 box = co_centroid_box(s->prims + b * BLOCK, block_count(s, b));
        co_box4_extend(&s->boxes[worker], &box);
    }
}

static void fill_blocks(void *context, size_t begin, size_t end, uint32_t worker)
{
    CoWideSplit *s = context;
    for (size_t b = begin; b < end; b++)
        co_bins_fill(worker ? &s->bins[worker - 1] : s->first, s->binning, s->prims + b * BLOCK,
                     block_count(s, b));
}

static void move_blocks(void *context, size_t begin, size_t end, uint32_t worker)
{
    CoWideSplit *s = context;
    (void)worker;
    for (size_t b = begin; b < end; b++) {
        CoBuildPrim *prims = s->prims + b * BLOCK;
        s->left[b] = (uint32_t)co_split_count(s->split, prims, block_count(s, b));
        co_split_move(s->split, prims, block_count(s, b), s->left[b]);
    }
}

// Once every block is split, what belongs left and lies right of the border, and the other way
// round, are as many; the k-th of the one changes places with the k-th of the other.
static size_t count_swaps(CoWideSplit *s)
{
    size_t border = s->split->left, blocks = blocks_of(s->count), left = 0, right = 0;
    for (size_t b = 0; b < blocks; b++) {
        size_t begin = b * BLOCK, middle = begin + s->left[b], end = begin + block_count(s, b);
        s->swaps_left[b] = left;
        s->swaps_right[b] = right;
        if (middle > border)
            left += middle - (begin > border ? begin : border);
        if (middle < border)
            right += (end < border ? end : border) - middle;
    }
    s->swaps_left[blocks] = left;
    s->swaps_right[blocks] = right;
    return left;
}

// The block that holds the k-th misplaced one: the last that starts at or before k.
static size_t find_block(const size_t *starts, size_t blocks, size_t k)
{
    size_t lo = 0, hi = blocks;
    while (hi - lo > 1) {
        size_t middle = lo + (hi - lo) / 2;
        if (starts[middle] <= k)
            lo = middle;
        else
            hi = middle;
    }
    return lo;
}

static void swap_blocks(void *context, size_t begin, size_t end, uint32_t worker)
{
    CoWideSplit *s = context;
    size_t border = s->split->left, blocks = blocks_of(s->count);
    size_t k = begin * BLOCK, most = s->swaps_left[blocks];
    size_t stop = end * BLOCK < most ? end * BLOCK : most;
    size_t a = find_block(s->swaps_left, blocks, k), b = find_block(s->swaps_right, blocks, k);
    (void)worker;
    for (; k < stop; k++) {
        while (s->swaps_left[a + 1] <= k)
            a++;
        while (s->swaps_right[b + 1] <= k)
            b++;
        size_t from = a * BLOCK < border ? border : a * BLOCK;
        CoBuildPrim *x = s->prims + from + (k - s->swaps_left[a]);
        CoBuildPrim *y = s->prims + b * BLOCK + s->left[b] + (k - s->swaps_right[b]);
        CoBuildPrim moved = *x;
        *x = *y;
        *y = moved;
    }
}

static void prim_box_blocks(void *context, size_t begin, size_t end, uint32_t worker)
{
    CoWideSplit *s = context;
    for (size_t b = begin; b < end; b++) {
        CoBox4 box = co_prim_box(s->prims + b * BLOCK, block_count(s, b));
        co_box4_extend(&s->boxes[worker], &box);
    }
}

// Union over all blocks of what `fn` finds in each.
static CoBox4 measure(CoWideSplit *s, CoParallelFn *fn)
{
    for (uint32_t i = 0; i < s->workers; i++)
        s->boxes[i] = co_box4_empty();
    for_blocks(s, blocks_of(s->count), fn);
    CoBox4 box = s->boxes[0];
    for (uint32_t i = 1; i < s->workers; i++)
        co_box4_extend(&box, &s->boxes[i]);
    return box;
}

CoBox co_wide_split_box(CoWideSplit *s, CoBuildPrim *prims, size_t count)
{
    s->prims = prims;
    s->count = count;
    CoBox4 all = measure(s, prim_box_blocks);
    CoBox box;
    co_box4_store(&box, &all);
    return box;
}

static void choose(CoWideSplit *s, const CoRange *range, CoSplit *split)
{
    CoBox4 centroids = measure(s, centroid_blocks);
    CoBinning binning = co_binning_over(&centroids, s->count);
    CoBins bins;
    s->binning = &binning;
    s->first = &bins;
    co_bins_clear(&bins, binning.used);
    for (uint32_t i = 0; i + 1 < s->workers; i++)
        co_bins_clear(&s->bins[i], binning.used);
    for_blocks(s, blocks_of(s->count), fill_blocks);
    for (uint32_t i = 0; i + 1 < s->workers; i++)
        co_bins_merge(&bins, &s->bins[i]);
    *split = co_split_choose(&bins, &binning, &range->box);
}

void co_wide_split_range(CoWideSplit *s, CoBuildPrim *prims, const CoRange *range,
                         CoRange halves[2])
{
    CoSplit split = {.axis = -1};
    if (range->count <= CO_SPLIT_LARGE) {
        co_split_range(prims, range, halves);
        return;
    }
    s->prims = prims + range->first;
    s->count = range->count;
    if (range->depth < CO_SPLIT_DEPTH)
        choose(s, range, &split);
    if (split.axis >= 0) {
        s->split = &split;
        for_blocks(s, blocks_of(s->count), move_blocks);
        for_blocks(s, blocks_of(count_swaps(s)), swap_blocks);
    }
    co_split_give(&split, s->prims, range, halves);
}
