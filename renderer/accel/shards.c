#include "accel/shards.h"

#include "base/hash.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "simd/four.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define TAG CO_MEMORY_ACCEL

// What a cut saves at least, in areas of an average box, a good part of a leaf's; and what all cuts
// save of the area of all boxes. Less does not pay, see docs/benchmarks.md.
#define LEAST_SAVED 3.0
#define WORTH 0.25

// The same where boxes lie across each other, so that leaves are larger than their triangles.
#define LEAST_SAVED_IF_CROWDED 0.25
#define WORTH_IF_CROWDED 0.125

// Shards beyond the first of each, by triangles.
#define BUDGET 0.3

enum {
    FEWEST = 64,   // triangles: fewer make a node or two
    CROWD = 25,    // pairs that meet, see is_crowded
    SAMPLE = 512,  // boxes that others are held against
    COUNTED = 8,   // of a crowd, one triangle of so many tells what cuts would save
    DEEPEST = 24,  // cuts within each other
    CORNERS = 32,  // of what is left of a triangle, mostly 9 at most
    STEP_BITS = 3, // cuts are counted by what they save, in 8 steps to each power of two
    STEPS = 32 << STEP_BITS
};

// What is left of a triangle in a box.
typedef struct Shard {
    CoFour lo, hi;
    int count;
    CoFour corners[CORNERS];
} Shard;

typedef struct Block {
    size_t place;         // of its next shard
    uint32_t cuts[STEPS]; // each in the step of what it saves, if no cut it is within saves less
    uint64_t is_cut[CO_SHARDS_BLOCK / 64]; // triangles
} Block;

typedef struct Shards {
    const CoMesh *mesh;
    CoBuildPrim *prims;
    size_t count, block_count; // of triangles
    Block *blocks;
    double unit;    // what a cut of step 0 saves
    double limit;   // boxes of which no cut can save more are left alone
    int least;      // step of a cut that is made
    uint32_t every; // triangle of so many is counted
} Shards;

// A triangle on its way.
typedef struct Cutter {
    const Shards *all;
    Block *block;
    uint32_t id;
    CoFour rounding;   // of a cut, by axis
    CoBuildPrim *next; // where a shard goes, or NULL: cuts are counted
    bool is_cut;       // once at least
} Cutter;

static float box_area(const CoBuildPrim *prim)
{
    return co4_first(co_shards_area(co4_load(prim->lo), co4_load(prim->hi)));
}

static CoFour four_of(const float p[3])
{
    return (CoFour){p[0], p[1], p[2], 0.0f};
}

static void whole_triangle(const CoMesh *mesh, const CoBuildPrim *prim, Shard *out)
{
    uint32_t tri[3];
    co_mesh_triangle(mesh, prim->id, tri);
    for (int c = 0; c < 3; c++)
        out->corners[c] = four_of(mesh->points + 3 * (size_t)tri[c]);
    out->count = 3;
    out->lo = four_of(prim->lo);
    out->hi = four_of(prim->hi);
}

// Of sides: xy, yz, zx.
static float sum_of(CoFour sides)
{
    return sides[0] + sides[1] + sides[2];
}

static CoFour sides_of(const Shard *shard)
{
    CoFour size = shard->hi - shard->lo;
    return size * __builtin_shufflevector(size, size, 1, 2, 0, 3);
}

// Of the corners, wider by what these are off by, but within what it was.
static void narrow_box(Shard *shard, CoFour rounding)
{
    CoFour lo = shard->corners[0], hi = lo;
    for (int i = 1; i < shard->count; i++) {
        lo = co_four_min(shard->corners[i], lo);
        hi = co_four_max(shard->corners[i], hi);
    }
    shard->lo = co_four_max(lo - rounding, shard->lo);
    shard->hi = co_four_min(hi + rounding, shard->hi);
}

// Corners in the plane belong to both halves. Inline, as the axis is known where it is called.
static inline __attribute__((always_inline)) void cut_corners(const Shard *shard, int axis,
                                                              float plane, Shard halves[2])
{
    int left = 0, right = 0;
    CoFour from = shard->corners[shard->count - 1];
    float before = from[axis] - plane;
    halves[0].lo = halves[1].lo = shard->lo;
    halves[0].hi = halves[1].hi = shard->hi;
    halves[0].hi[axis] = halves[1].lo[axis] = plane;
    for (int i = 0; i < shard->count; i++) {
        CoFour to = shard->corners[i];
        float after = to[axis] - plane;
        if ((before < 0.0f && after > 0.0f) || (before > 0.0f && after < 0.0f)) {
            CoFour crossing = from + (to - from) * co_four_set1(before / (before - after));
            crossing[axis] = plane;
            halves[0].corners[left++] = crossing;
            halves[1].corners[right++] = crossing;
        }
        halves[0].corners[left] = to;
        halves[1].corners[right] = to;
        left += after <= 0.0f;
        right += after >= 0.0f;
        from = to;
        before = after;
    }
    halves[0].count = left;
    halves[1].count = right;
}

// Through the middle of the longest side. False when floats have none, or rounding has bent the
// outline so often that a corner more on each edge is too many.
static bool cut(const Shard *shard, CoFour rounding, Shard halves[2])
{
    CoFour lo = shard->lo, hi = shard->hi, middle = 0.5f * lo + 0.5f * hi, size = hi - lo;
    CoFourBits is_between = (lo < middle) & (middle < hi);
    int axis = size[2] > size[1] ? 2 : 1;
    axis = size[axis] > size[0] ? axis : 0;
    if (!is_between[axis] || 2 * shard->count >= CORNERS)
        return false;
    if (axis == 0)
        cut_corners(shard, 0, middle[0], halves);
    else if (axis == 1)
        cut_corners(shard, 1, middle[1], halves);
    else
        cut_corners(shard, 2, middle[2], halves);
    if (halves[0].count == 0 || halves[1].count == 0)
        return false;
    narrow_box(&halves[0], rounding);
    narrow_box(&halves[1], rounding);
    return true;
}

// No cut saves more: the halves together cover every side of the box, and half of the two that are
// cut. That is two thirds of the area at most.
static double most_saved(const Shard *shard)
{
    CoFour sides = sides_of(shard);
    return 0.5 * ((double)sum_of(sides) + (double)co_four_smallest3(sides, INFINITY));
}

// Exponent and first bits of a ratio; below 0 for less than a unit.
static int step_of(double saved, double unit)
{
    double ratio = saved / unit;
    uint64_t bits;
    if (!(ratio >= 1.0))
        return -1;
    memcpy(&bits, &ratio, sizeof bits);
    uint64_t step = (bits >> (52 - STEP_BITS)) - (1023u << STEP_BITS);
    return step < STEPS ? (int)step : STEPS - 1;
}

static double units_of(int step)
{
    double part = 1.0 + (double)(step & ((1 << STEP_BITS) - 1)) / (1 << STEP_BITS);
    return ldexp(part, step >> STEP_BITS);
}

static void put_shard(Cutter *c, const Shard *shard)
{
    memcpy(c->next->lo, &shard->lo, sizeof c->next->lo);
    memcpy(c->next->hi, &shard->hi, sizeof c->next->hi);
    c->next->id = c->id;
}

static double saved_by(const Shard *shard, const Shard halves[2])
{
    return (double)sum_of(sides_of(shard) - sides_of(&halves[0]) - sides_of(&halves[1]));
}

// Makes or counts the cuts that save enough, none of them in a higher step than `most`.
static void cut_down(Cutter *c, const Shard *shard, int depth, int most)
{
    const Shards *all = c->all;
    CoFour rounding = c->rounding * co_four_set1((float)(depth + 1));
    Shard halves[2];
    int step = -1;
    if (depth < DEEPEST && most_saved(shard) > all->limit && cut(shard, rounding, halves))
        step = step_of(saved_by(shard, halves), all->unit);
    if (step < all->least) {
        if (c->next)
            put_shard(c, shard);
        return;
    }
    step = step < most ? step : most;
    c->is_cut = true;
    if (!c->next)
        c->block->cuts[step]++;
    cut_down(c, &halves[0], depth + 1, step);
    if (c->next)
        c->next = all->prims + c->block->place++;
    cut_down(c, &halves[1], depth + 1, step);
}

// A cut puts corners no farther off than 12 units of 2^-24 of the largest coordinate on their axis,
// so that those of shards come to lie beyond the corners they have by as much for each cut.
static CoFour rounding_of(const Shard *whole)
{
    CoFour reach = co_four_max(co_four_abs(whole->lo), co_four_abs(whole->hi));
    return reach * co_four_set1(0x1p-20f) + co_four_set1(0x1p-140f);
}

static void cut_triangle(Cutter *c, const CoBuildPrim *prim)
{
    Shard whole;
    whole_triangle(c->all->mesh, prim, &whole);
    c->id = prim->id;
    c->rounding = rounding_of(&whole);
    cut_down(c, &whole, 0, STEPS - 1);
}

static void count_cuts(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Shards *all = context;
    // Most are told by their area alone.
    const float least_area = (float)(1.5 * all->limit);
    (void)worker;
    for (size_t b = begin; b < end; b++) {
        Cutter cutter = {.all = all, .block = &all->blocks[b]};
        size_t first = b * CO_SHARDS_BLOCK, stop = co_shards_block_end(b, all->count);
        for (size_t i = first; i < stop; i++) {
            if (!(box_area(&all->prims[i]) > least_area) ||
                (all->every > 1 && co_hash32((uint32_t)i) % all->every != 0))
                continue;
            cutter.is_cut = false;
            cut_triangle(&cutter, &all->prims[i]);
            cutter.block->is_cut[(i - first) / 64] |= (uint64_t)cutter.is_cut << i % 64;
        }
    }
}

static void make_cuts(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Shards *all = context;
    (void)worker;
    for (size_t b = begin; b < end; b++) {
        Cutter cutter = {.all = all, .block = &all->blocks[b]};
        size_t first = b * CO_SHARDS_BLOCK, stop = co_shards_block_end(b, all->count);
        for (size_t i = first; i < stop; i++) {
            co_shards_whole(all->mesh, (uint32_t)i, &all->prims[i]);
            if (cutter.block->is_cut[(i - first) / 64] >> i % 64 & 1) {
                cutter.next = &all->prims[i];
                cut_triangle(&cutter, &all->prims[i]);
            }
        }
    }
}

// The least step from which on cuts are within the budget; STEPS when they save less than `worth`.
static int choose_step(const Shards *all, double worth)
{
    double saved = 0.0, room = BUDGET * (double)all->count;
    int step = STEPS;
    for (; step > 0; step--) {
        uint64_t count = 0;
        for (size_t b = 0; b < all->block_count; b++)
            count += (uint64_t)all->every * all->blocks[b].cuts[step - 1];
        if ((double)count > room)
            break;
        room -= (double)count;
        saved += (double)count * units_of(step - 1) * all->unit;
    }
    return saved >= worth ? step : STEPS;
}

// Some boxes, four by four.
typedef struct BoxSample {
    CoFour lo[3][SAMPLE / 4], hi[3][SAMPLE / 4];
    size_t count; // of fours
} BoxSample;

static const CoBuildPrim *any_prim(const CoPrimArray *prims, size_t n)
{
    return &prims->prims[(co_hash64(n) >> 32) * prims->count >> 32];
}

static uint64_t count_met(const BoxSample *sample, const CoBuildPrim *prim)
{
    CoFour lo[3], hi[3];
    CoFourBits met = {0, 0, 0, 0};
    for (int k = 0; k < 3; k++) {
        lo[k] = co_four_set1(prim->lo[k]);
        hi[k] = co_four_set1(prim->hi[k]);
    }
    for (size_t i = 0; i < sample->count; i++) {
        CoFourBits is_met = (sample->lo[0][i] <= hi[0]) & (sample->hi[0][i] >= lo[0]);
        is_met &= (sample->lo[1][i] <= hi[1]) & (sample->hi[1][i] >= lo[1]);
        met -= is_met & (sample->lo[2][i] <= hi[2]) & (sample->hi[2][i] >= lo[2]);
    }
    return (uint64_t)met[0] + (uint64_t)met[1] + (uint64_t)met[2] + (uint64_t)met[3];
}

// Of half as many random pairs as there are boxes, how many meet? That is half of how many others a
// box meets: 7 to 15 in a closed surface, 30 among splinters 30 times as long as wide, hundreds
// among turned ones. Large boxes are not asked, which are cut in any case.
static bool is_crowded(const CoPrimArray *prims, float largest)
{
    BoxSample sample;
    size_t pairs = prims->count / 2, side = (size_t)sqrt((double)pairs);
    uint64_t met = 0;
    side = (side < SAMPLE ? side : SAMPLE) & ~(size_t)3;
    for (size_t i = 0; i < side; i++) {
        const CoBuildPrim *prim = any_prim(prims, i);
        for (int k = 0; k < 3; k++) {
            sample.lo[k][i / 4][i % 4] = prim->lo[k];
            sample.hi[k][i / 4][i % 4] = prim->hi[k];
        }
    }
    sample.count = side / 4;
    for (size_t i = 0; i < pairs / side; i++) {
        const CoBuildPrim *prim = any_prim(prims, side + i);
        if (box_area(prim) <= largest)
            met += count_met(&sample, prim);
    }
    return met >= CROWD;
}

// The old prims make room for the new ones: a build never holds much more than its result.
static bool give_places(Shards *all, CoPrimArray *prims)
{
    size_t count = all->count;
    for (size_t b = 0; b < all->block_count; b++) {
        all->blocks[b].place = count;
        for (int step = all->least; step < STEPS; step++)
            count += all->blocks[b].cuts[step];
    }
    co_prims_free(prims);
    prims->prims = all->prims = co_alloc(TAG, count * sizeof *prims->prims);
    if (!prims->prims)
        return false;
    prims->count = prims->capacity = count;
    return true;
}

static bool make_shards(Shards *all, double worth, CoPrimArray *prims, bool *are_shards)
{
    size_t grain = co_shards_grain(all->count);
    co_parallel_for(all->block_count, grain, count_cuts, all);
    all->least = choose_step(all, worth);
    if (all->least == STEPS)
        return true;
    if (all->every > 1) { // places are to be exact
        all->every = 1;
        all->limit = units_of(all->least) * all->unit;
        memset(all->blocks, 0, all->block_count * sizeof *all->blocks);
        co_parallel_for(all->block_count, grain, count_cuts, all);
    }
    if (!give_places(all, prims))
        return false;
    co_parallel_for(all->block_count, grain, make_cuts, all);
    *are_shards = true;
    return true;
}

bool co_shards_make(const CoMesh *mesh, const CoBoxAreas *areas, CoPrimArray *prims,
                    bool *are_shards)
{
    Shards all = {.mesh = mesh, .prims = prims->prims, .count = prims->count, .every = 1};
    double area = 0.0, largest = 0.0;
    *are_shards = false;
    all.block_count = co_shards_blocks(all.count);
    for (size_t b = 0; b < all.block_count; b++) {
        area += (double)areas[b].sum;
        largest = fmax(largest, (double)areas[b].largest);
    }
    // Areas that are too large or too small for floats are nothing to go by.
    if (all.count < FEWEST || !(area > 0.0 && area < (double)FLT_MAX))
        return true;
    double average = area / (double)all.count, worth = WORTH * area;
    all.unit = LEAST_SAVED * average;
    if (is_crowded(prims, (float)(2.0 * all.unit))) {
        all.unit = LEAST_SAVED_IF_CROWDED * average;
        worth = WORTH_IF_CROWDED * area;
        all.every = COUNTED;
    } else if (largest < 1.5 * all.unit) { // no cut saves as much
        return true;
    }
    all.limit = all.unit;
    all.blocks = co_alloc_zero(TAG, all.block_count * sizeof *all.blocks);
    bool is_done = all.blocks && make_shards(&all, worth, prims, are_shards);
    co_free(TAG, all.blocks, all.block_count * sizeof *all.blocks);
    return is_done;
}
