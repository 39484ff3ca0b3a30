// The fast ray sort: one pass that finds cells and counts rays in plots of many, one that moves an
// item of eight bytes for each ray to its plot, and then, in cache, to its cell, and by direction
// within a run. Straight to cells, of which there are more than lines in a cache, takes longer,
// most of all where threads write to the same ones. Directions stand in the records as points of a
// grid: sorting needs no decoding.
#include "sort/ray_entry.h"

#include "base/parallel.h"
#include "sort/radix.h"
#include "sort/ray_keys.h"

#include <math.h>
#include <string.h>

enum {
    RUN_LEAST = 1024, // rays of a run, and of a batch of DENSE or more, whose places are closer
    RUN_DENSE = 2048,
    DENSE = 1 << 20,
    CELL_RAYS_BITS = 5, // log2 of the rays of a cell, were they spread evenly
    CELL_BITS_MAX = 18, // log2 of how many cells
    PLOT_BITS_MAX = 9,  // log2 of how many plots, which are cells in a row
    FINE_BITS = 6,      // that a place is known better than by its cell, at least
    DIRECTION_BITS_MAX = 2 * CO_KEY_MIXED_BITS + CO_KEY_FACE_BITS,
    DIGIT_BITS_MAX = 10, // of the sort within a large cell
    BLOCKS_MAX = 64,
    BLOCK_MIN = 16384,
    COUNT_PART = 1024, // items that are counted while they are in cache
    INDEX_BITS_MAX = 26
};

_Static_assert((CELL_BITS_MAX + FINE_BITS + 2) / 3 * 3 + DIRECTION_BITS_MAX + INDEX_BITS_MAX < 64,
               "an item has a bit left for what is invalid");

// Neighboring cells that hold at most a run of rays, or one cell that holds more.
typedef struct Segment {
    size_t begin, end;
    bool is_large;
} Segment;

typedef struct Curve {
    const CoRaySort *sort;
    uint64_t *items;  // as they come, then by cell
    uint64_t *plots;  // by plot
    uint32_t *counts; // [block][plot]; then where the block's next one goes
    uint32_t *ends;   // of cells
    Segment *segments;
    size_t segment_count, blocks, block_size;
    CoKeyGrid grid;
    uint32_t cell_bits; // the upper ones of a place
    uint32_t plot_bits; // the upper ones of a cell
    uint32_t run_most;  // rays
} Curve;

// --- cells --------------------------------------------------------------------------------------

static uint32_t cell_shift(const Curve *curve)
{
    const CoKeyGrid *grid = &curve->grid;
    return grid->index_bits + grid->direction_bits + grid->place_bits - curve->cell_bits;
}

static size_t cell_count(const Curve *curve) // and one for invalid rays
{
    return ((size_t)1 << curve->cell_bits) + 1;
}

static uint32_t fine_bits(const Curve *curve) // of a cell in its plot
{
    return curve->cell_bits - curve->plot_bits;
}

static size_t plot_count(const Curve *curve) // and one for invalid rays
{
    return ((size_t)1 << curve->plot_bits) + 1;
}

static size_t block_end(const Curve *curve, size_t block)
{
    size_t end = (block + 1) * curve->block_size, count = curve->sort->records->count;
    return end < count ? end : count;
}

static void count_blocks(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Curve *curve = context;
    uint32_t shift = cell_shift(curve) + fine_bits(curve);
    (void)worker;
    for (size_t block = begin; block < end; block++) {
        uint32_t *counts = curve->counts + block * plot_count(curve);
        memset(counts, 0, plot_count(curve) * sizeof *counts);
        size_t last = block_end(curve, block);
        for (size_t at = block * curve->block_size; at < last; at += COUNT_PART) {
            size_t stop = last - at < COUNT_PART ? last : at + COUNT_PART;
            curve->sort->keys(curve->sort->records, &curve->grid, at, stop, curve->items);
            for (size_t i = at; i < stop; i++)
                counts[curve->items[i] >> shift]++;
        }
    }
}

static void scan_plots(const Curve *curve)
{
    uint32_t sum = 0;
    for (size_t plot = 0; plot < plot_count(curve); plot++)
        for (size_t block = 0; block < curve->blocks; block++) {
            uint32_t *slot = &curve->counts[block * plot_count(curve) + plot], n = *slot;
            *slot = sum;
            sum += n;
        }
}

static void place_blocks(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Curve *curve = context;
    uint32_t shift = cell_shift(curve) + fine_bits(curve);
    (void)worker;
    for (size_t block = begin; block < end; block++) {
        uint32_t *next = curve->counts + block * plot_count(curve);
        for (size_t i = block * curve->block_size; i < block_end(curve, block); i++)
            curve->plots[next[curve->items[i] >> shift]++] = curve->items[i];
    }
}

// Where a plot ends is where its last block's next one would go.
static size_t plot_end(const Curve *curve, size_t plot)
{
    return curve->counts[(curve->blocks - 1) * plot_count(curve) + plot];
}

// The items of a plot by cell, in cache, and where the cells end.
static void divide_plots(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Curve *curve = context;
    uint32_t next[1 << (CELL_BITS_MAX - PLOT_BITS_MAX)], shift = cell_shift(curve);
    uint32_t cells = 1u << fine_bits(curve), mask = cells - 1;
    (void)worker;
    for (size_t plot = begin; plot < end; plot++) {
        size_t first = plot > 0 ? plot_end(curve, plot - 1) : 0, last = plot_end(curve, plot);
        uint32_t sum = (uint32_t)first, *ends = curve->ends + plot * cells;
        memset(next, 0, cells * sizeof *next);
        for (size_t i = first; i < last; i++)
            next[curve->plots[i] >> shift & mask]++;
        for (uint32_t cell = 0; cell < cells; cell++) {
            uint32_t n = next[cell];
            next[cell] = sum;
            sum += n;
            ends[cell] = sum;
        }
        for (size_t i = first; i < last; i++)
            curve->items[next[curve->plots[i] >> shift & mask]++] = curve->plots[i];
    }
}

static void add_segment(Curve *curve, size_t end)
{
    Segment *last = &curve->segments[curve->segment_count - 1];
    if (end <= last->end)
        return;
    curve->segments[curve->segment_count++] = (Segment){last->end, end, false};
}

// Segments end at multiples of 64, so that groups are full: the few rays before go with the next
// segment, which is a neighbor.
static void scan_cells(Curve *curve)
{
    uint32_t before = 0, begin = 0; // of the cell, of the segment
    curve->segments[0] = (Segment){0, 0, false};
    curve->segment_count = 1;
    for (size_t cell = 0; cell + 1 < cell_count(curve); before = curve->ends[cell++]) {
        uint32_t sum = curve->ends[cell];
        if (sum - begin <= curve->run_most)
            continue;
        // This cell does not fit the segment any more.
        begin = before / CO_SORT_GROUP * CO_SORT_GROUP;
        add_segment(curve, begin);
        if (sum - begin > curve->run_most + CO_SORT_GROUP) {
            begin = sum / CO_SORT_GROUP * CO_SORT_GROUP;
            add_segment(curve, begin);
            curve->segments[curve->segment_count - 1].is_large = true;
        }
    }
    add_segment(curve, curve->sort->valid);
}

// --- within segments ----------------------------------------------------------------------------

// By all of the key of the place, from the lowest digit up to the last bit that differs, between
// the segment's parts of both arrays. Returns the array that has the result.
static const uint64_t *sort_places(const Curve *curve, const Segment *segment)
{
    uint64_t *from = curve->items, *to = curve->plots, differs = 0;
    uint32_t shift = curve->grid.index_bits + curve->grid.direction_bits;
    uint32_t end = shift + curve->grid.place_bits;
    for (size_t i = segment->begin; i < segment->end; i++)
        differs |= from[i] ^ from[segment->begin];
    while (shift < end && differs >> shift != 0) {
        uint32_t bits = end - shift < DIGIT_BITS_MAX ? end - shift : DIGIT_BITS_MAX;
        uint32_t next[1 << DIGIT_BITS_MAX] = {0}, sum = (uint32_t)segment->begin;
        uint32_t mask = (1u << bits) - 1;
        for (size_t i = segment->begin; i < segment->end; i++)
            next[from[i] >> shift & mask]++;
        for (uint32_t digit = 0; digit <= mask; digit++) {
            uint32_t n = next[digit];
            next[digit] = sum;
            sum += n;
        }
        for (size_t i = segment->begin; i < segment->end; i++)
            to[next[from[i] >> shift & mask]++] = from[i];
        uint64_t *held = from;
        from = to;
        to = held;
        shift += bits;
    }
    return from;
}

// By direction.
static void sort_run(const Curve *curve, const uint64_t *items, size_t count, uint32_t *order)
{
    uint32_t next[1 << DIRECTION_BITS_MAX], sum = 0;
    uint32_t mask = (1u << curve->grid.direction_bits) - 1, shift = curve->grid.index_bits;
    uint64_t index_mask = ((uint64_t)1 << shift) - 1;
    memset(next, 0, (mask + 1) * sizeof *next);
    for (size_t i = 0; i < count; i++)
        next[items[i] >> shift & mask]++;
    for (uint32_t key = 0; key <= mask; key++) {
        uint32_t n = next[key];
        next[key] = sum;
        sum += n;
    }
    for (size_t i = 0; i < count; i++)
        order[next[items[i] >> shift & mask]++] = (uint32_t)(items[i] & index_mask);
}

static void finish_segments(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Curve *curve = context;
    bool has_directions = curve->grid.direction_bits > 0;
    (void)worker;
    for (size_t s = begin; s < end; s++) {
        const Segment *segment = &curve->segments[s];
        const uint64_t *items = curve->items;
        if (segment->is_large || !has_directions)
            items = sort_places(curve, segment);
        size_t most = segment->is_large ? curve->run_most : curve->run_most + CO_SORT_GROUP;
        for (size_t first = segment->begin; first < segment->end; first += most) {
            size_t left = segment->end - first;
            sort_run(curve, items + first, left < most ? left : most, curve->sort->order + first);
        }
    }
}

// --- all ----------------------------------------------------------------------------------------

static size_t aligned(size_t bytes)
{
    return (bytes + 63) & ~(size_t)63;
}

static size_t segments_most(size_t count) // of two neighbors, one at least has half a run
{
    return 4 * (count / RUN_LEAST) + 4;
}

static uint32_t cell_bits_of(size_t count)
{
    uint32_t bits = co_radix_bits((uint32_t)count);
    bits = bits > CELL_RAYS_BITS ? bits - CELL_RAYS_BITS : 0;
    return bits < CELL_BITS_MAX ? bits : CELL_BITS_MAX;
}

static size_t blocks_of(size_t count)
{
    size_t blocks = (count + BLOCK_MIN - 1) / BLOCK_MIN, workers = co_worker_count();
    size_t most = workers == 1 ? 1 : 8 * workers < BLOCKS_MAX ? 8 * workers : BLOCKS_MAX;
    return blocks < most ? blocks : most;
}

size_t co_curve_sort_bytes(size_t count)
{
    size_t cells = ((size_t)1 << cell_bits_of(count)) + 1;
    size_t plots = ((size_t)1 << PLOT_BITS_MAX) + 1;
    return 2 * aligned(count * sizeof(uint64_t)) + aligned(2 * cells * sizeof(uint32_t)) +
           aligned(blocks_of(count) * plots * sizeof(uint32_t)) +
           aligned(segments_most(count) * sizeof(Segment));
}

static void choose_keys(Curve *curve)
{
    const CoRaySort *sort = curve->sort;
    CoKeyGrid *grid = &curve->grid;
    bool is_mixed = sort->records->bin == CO_RAY_BIN_MIXED;
    curve->cell_bits = cell_bits_of(sort->records->count);
    curve->plot_bits = curve->cell_bits < PLOT_BITS_MAX ? curve->cell_bits : PLOT_BITS_MAX;
    curve->run_most = sort->records->count < DENSE ? RUN_LEAST : RUN_DENSE;
    *grid = (CoKeyGrid){.low = sort->low};
    grid->index_bits = co_radix_bits((uint32_t)sort->records->count - 1);
    grid->levels = (curve->cell_bits + FINE_BITS + 2) / 3;
    grid->place_bits = 3 * grid->levels;
    grid->axis_bits = is_mixed ? CO_KEY_MIXED_BITS : CO_KEY_DIRECTION_BITS;
    grid->direction_bits = 2 * grid->axis_bits + (is_mixed ? CO_KEY_FACE_BITS : 0);
    grid->scale = sort->extent > 0.0f ? (float)(1u << grid->levels) / sort->extent : 0.0f;
    if (grid->scale > 0.0f && isfinite(grid->scale))
        return;
    grid->scale = 0.0f; // one point, or all within a denormal of each other
    grid->axis_bits = CO_KEY_PINHOLE_BITS;
    grid->place_bits = 2 * grid->axis_bits + CO_KEY_FACE_BITS;
    grid->direction_bits = 0;
}

void co_curve_sort_rays(const CoRaySort *sort)
{
    size_t count = sort->records->count;
    Curve curve = {.sort = sort, .blocks = blocks_of(count)};
    choose_keys(&curve);
    char *memory = sort->memory;
    curve.items = (uint64_t *)(void *)memory;
    curve.plots = (uint64_t *)(void *)(memory += aligned(count * sizeof(uint64_t)));
    curve.counts = (uint32_t *)(void *)(memory += aligned(count * sizeof(uint64_t)));
    memory += aligned(curve.blocks * plot_count(&curve) * sizeof(uint32_t));
    curve.ends = (uint32_t *)(void *)memory;
    memory += aligned((plot_count(&curve) << fine_bits(&curve)) * sizeof(uint32_t));
    curve.segments = (Segment *)(void *)memory;
    curve.block_size = (count + curve.blocks - 1) / curve.blocks;
    co_parallel_for(curve.blocks, 1, count_blocks, &curve);
    scan_plots(&curve);
    co_parallel_for(curve.blocks, 1, place_blocks, &curve);
    co_parallel_for(plot_count(&curve), 1, divide_plots, &curve);
    scan_cells(&curve);
    co_parallel_for(curve.segment_count, 1, finish_segments, &curve);
    uint64_t mask = ((uint64_t)1 << curve.grid.index_bits) - 1;
    for (size_t i = sort->valid; i < count; i++)
        sort->order[i] = (uint32_t)(curve.items[i] & mask);
}
