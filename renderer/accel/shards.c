#include "accel/shards.h"

#include "accel/cut.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "math/bits.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define TAG CO_MEMORY_ACCEL

// What a cut saves at least, in areas of an average box, a good part of a leaf's; and what all cuts
// save of the area of all boxes. Less does not pay, see docs/experiments.md.
#define LEAST_SAVED 3.0
#define WORTH 0.25

// The same where boxes lie across each other, so that leaves are larger than their triangles.
#define LEAST_SAVED_IF_CROWDED 0.25
#define WORTH_IF_CROWDED 0.125

// Shards beyond the first of each, by triangles: more only where it takes them to be worth it, as
// many triangles alike have their cuts in one step. From the third number on cuts are made as long
// as one saves a third of what those before it do on average.
#define BUDGET 0.3
#define BUDGET_MOST 0.4
#define BUDGET_FREE 0.1

enum {
    FEWEST = 64,   // triangles: fewer make a node or two
    CROWD = 25,    // pairs that meet, see is_crowded
    SAMPLE = 512,  // boxes that others are held against
    COUNTED = 512, // of a crowd, so many triangles tell what cuts would save,
    EIGHTH = 8,    // or one in so many
    DEEPEST = 24,  // cuts within each other
    TOLD = 1024,   // most blocks look at fewer cuts
    STEP_BITS = 3, // cuts are counted by what they save, in 8 steps to each power of two
    STEPS = 32 << STEP_BITS
};

typedef struct Block {
    size_t place;         // of its next shard
    uint32_t cuts[STEPS]; // each in the step of what it saves, if no cut it is within saves less
    uint64_t is_cut[CO_SHARDS_BLOCK / 64]; // triangles
    uint64_t is_made[TOLD / 64]; // each cut within another that was looked at, in that order,
    uint32_t told;               // the first so many of them
} Block;

typedef struct Shards {
    const CoMesh *mesh;
    CoBuildPrim *prims;
    size_t count, block_count; // of triangles
    Block *blocks;
    double worth;   // what all cuts save at least,
    double unit;    // what a cut of step 0 saves
    double limit;   // boxes of which no cut can save more are left alone
    int least;      // step of a cut that is made
    uint32_t every; // one triangle in so many is counted
} Shards;

// A triangle on its way.
typedef struct Cutter {
    const Shards *all;
    Block *block;
    uint32_t id;
    CoFour rounding;   // of a cut, by axis
    CoBuildPrim *next; // where a shard goes
    uint32_t told;     // of what the block knows
} Cutter;

static float box_area(const CoBuildPrim *prim)
{
    return co4_first(co_shards_area(co4_load(prim->lo), co4_load(prim->hi)));
}

// Of sides: xy, yz, zx.
static float sum_of(CoFour sides)
{
    return sides[0] + sides[1] + sides[2];
}

// No cut saves more: the halves together cover every side of the box, and half of the two that are
// cut. That is two thirds of the area at most.
static double most_saved(const CoShard *shard)
{
    CoFour sides = co_shard_sides(shard);
    return 0.5 * ((double)sum_of(sides) + (double)co_four_smallest3(sides, INFINITY));
}

// Exponent and first bits of a ratio; below 0 for less than a unit.
static int step_of(double saved, double unit)
{
    double ratio = saved / unit;
    if (!(ratio >= 1.0))
        return -1;
    uint64_t step = (co_double_bits(ratio) >> (52 - STEP_BITS)) - (1023u << STEP_BITS);
    return step < STEPS ? (int)step : STEPS - 1;
}

static double units_of(int step)
{
    double part = 1.0 + (double)(step & ((1 << STEP_BITS) - 1)) / (1 << STEP_BITS);
    return ldexp(part, step >> STEP_BITS);
}

static void put_shard(Cutter *c, const CoShard *shard)
{
    memcpy(c->next->lo, &shard->lo, sizeof c->next->lo);
    memcpy(c->next->hi, &shard->hi, sizeof c->next->hi);
    c->next->id = c->id;
}

static double saved_by(const CoShard *shard, const CoShard halves[2])
{
    return (double)sum_of(co_shard_sides(shard) - co_shard_sides(&halves[0]) -
                          co_shard_sides(&halves[1]));
}

static CoFour rounding_at(const Cutter *c, int depth)
{
    return c->rounding * co_four_set1((float)(depth + 1));
}

// The step of what a cut saves; -1 for less than a unit, or if there is none.
static int look_at(const Cutter *c, const CoShard *shard, int depth, CoShard halves[2])
{
    if (depth == DEEPEST || !(most_saved(shard) > c->all->limit) ||
        !co_cut_halve(shard, rounding_at(c, depth), halves))
        return -1;
    return step_of(saved_by(shard, halves), c->all->unit);
}

static void tell(Block *block, bool is_made)
{
    if (block->told == TOLD)
        return;
    block->is_made[block->told / 64] |= (uint64_t)is_made << block->told % 64;
    block->told++;
}

// Counts the cuts that save enough, none of them in a higher step than `most`. Returns whether the
// first does.
static bool count_down(Cutter *c, const CoShard *shard, int depth, int most)
{
    CoShard halves[2];
    int step = look_at(c, shard, depth, halves);
    bool is_made = step >= c->all->least;
    if (depth > 0)
        tell(c->block, is_made);
    if (!is_made)
        return false;
    step = step < most ? step : most;
    c->block->cuts[step]++;
    count_down(c, &halves[0], depth + 1, step);
    count_down(c, &halves[1], depth + 1, step);
    return true;
}

// Makes them. That the first does is known, of others most.
static void make_down(Cutter *c, const CoShard *shard, int depth)
{
    const Block *block = c->block;
    CoShard halves[2];
    bool is_known = depth == 0 || c->told < block->told, is_made = true;
    if (!is_known)
        is_made = look_at(c, shard, depth, halves) >= c->all->least;
    else if (depth > 0)
        is_made = block->is_made[c->told / 64] >> c->told % 64 & 1;
    c->told += is_known && depth > 0;
    if (!is_made) {
        put_shard(c, shard);
        return;
    }
    if (is_known)
        co_cut_halve(shard, rounding_at(c, depth), halves);
    make_down(c, &halves[0], depth + 1);
    c->next = c->all->prims + c->block->place++;
    make_down(c, &halves[1], depth + 1);
}

// A cut puts corners no farther off than 12 units of 2^-24 of the largest coordinate on their axis,
// so that those of shards come to lie beyond the corners they have by as much for each cut.
static CoFour rounding_of(const CoShard *whole)
{
    CoFour reach = co_four_max(co_four_abs(whole->lo), co_four_abs(whole->hi));
    return reach * co_four_set1(0x1p-20f) + co_four_set1(0x1p-140f);
}

static void start(Cutter *c, const CoBuildPrim *prim, CoShard *whole)
{
    co_cut_start(c->all->mesh, prim, whole);
    c->id = prim->id;
    c->rounding = rounding_of(whole);
}

// Four triangles of a block, of which the last may be there several times.
static void count_four(Cutter *cutter, const uint32_t ids[4], uint32_t count)
{
    const Shards *all = cutter->all;
    CoFour saved = co_cut_saving(all->mesh, ids);
    for (uint32_t i = 0; i < count; i++) {
        CoShard whole;
        uint32_t at = ids[i] % CO_SHARDS_BLOCK;
        if ((double)saved[i] < all->limit)
            continue;
        start(cutter, &all->prims[ids[i]], &whole);
        if (count_down(cutter, &whole, 0, STEPS - 1))
            cutter->block->is_cut[at / 64] |= (uint64_t)1 << at % 64;
    }
}

// Most are told by their area alone.
static uint32_t list_large(const Shards *all, size_t first, size_t stop, uint32_t *ids)
{
    const float least_area = (float)(1.5 * all->limit);
    uint32_t count = 0;
    for (size_t i = first; i < stop; i += all->every) {
        size_t one = all->every == 1 ? i : i + co_hash32((uint32_t)i) % all->every;
        one = one < stop ? one : i;
        ids[count] = (uint32_t)one;
        count += box_area(&all->prims[one]) > least_area;
    }
    return count;
}

static void count_cuts(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Shards *all = context;
    uint32_t ids[CO_SHARDS_BLOCK + 3];
    (void)worker;
    for (size_t b = begin; b < end; b++) {
        Cutter cutter = {.all = all, .block = &all->blocks[b]};
        uint32_t count =
            list_large(all, b * CO_SHARDS_BLOCK, co_shards_block_end(b, all->count), ids);
        for (uint32_t i = count; count && i < count + 3; i++)
            ids[i] = ids[count - 1];
        for (uint32_t i = 0; i < count; i += 4)
            count_four(&cutter, ids + i, count - i < 4 ? count - i : 4);
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
                CoShard whole;
                cutter.next = &all->prims[i];
                start(&cutter, &all->prims[i], &whole);
                make_down(&cutter, &whole, 0);
            }
        }
    }
}

// The least step from which on cuts are within the budget; STEPS when they do not save what they
// are worth.
static int choose_step(const Shards *all)
{
    double saved = 0.0, made = 0.0, triangles = (double)all->count;
    uint64_t cuts[STEPS] = {0};
    int step = STEPS;
    for (size_t b = 0; b < all->block_count; b++)
        for (int i = 0; i < STEPS; i++)
            cuts[i] += all->blocks[b].cuts[i];
    for (; step > 0; step--) {
        double each = units_of(step - 1) * all->unit, count = (double)(all->every * cuts[step - 1]);
        double by_then = saved + count * each;
        made += count;
        if (made > (saved < all->worth ? BUDGET_MOST : BUDGET) * triangles ||
            (made > BUDGET_FREE * triangles && each * made < by_then / 3.0))
            break;
        saved = by_then;
    }
    return saved >= all->worth ? step : STEPS;
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

static bool make_shards(Shards *all, CoPrimArray *prims, bool *are_shards)
{
    size_t grain = co_shards_grain(all->count);
    co_parallel_for_parts(all->block_count, grain, count_cuts, all);
    all->least = choose_step(all);
    if (all->least == STEPS)
        return true;
    all->every = 1; // places are to be exact
    all->limit = units_of(all->least) * all->unit;
    memset(all->blocks, 0, all->block_count * sizeof *all->blocks);
    co_parallel_for_parts(all->block_count, grain, count_cuts, all);
    if (!give_places(all, prims))
        return false;
    co_parallel_for_parts(all->block_count, grain, make_cuts, all);
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
    double average = area / (double)all.count;
    all.worth = WORTH * area;
    all.unit = LEAST_SAVED * average;
    if (is_crowded(prims, (float)(2.0 * all.unit))) {
        all.unit = LEAST_SAVED_IF_CROWDED * average;
        all.worth = WORTH_IF_CROWDED * area;
        all.every = all.count < EIGHTH * COUNTED ? (uint32_t)all.count / COUNTED : EIGHTH;
        all.every = all.every ? all.every : 1;
    } else if (largest < 1.5 * all.unit) { // no cut saves as much
        return true;
    }
    all.limit = all.unit;
    all.blocks = co_alloc_zero(TAG, all.block_count * sizeof *all.blocks);
    bool is_done = all.blocks && make_shards(&all, prims, are_shards);
    co_free(TAG, all.blocks, all.block_count * sizeof *all.blocks);
    return is_done;
}
