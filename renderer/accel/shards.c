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
    CORNERS = 3 + DEEPEST,
    STEP_BITS = 3, // cuts are counted by what they save, in 8 steps to each power of two
    STEPS = 32 << STEP_BITS
};

// What is left of a triangle in a box.
typedef struct Shard {
    CoBox box;
    int count;
    double corners[CORNERS][3];
} Shard;

typedef struct Block {
    size_t place;         // of its next shard
    uint32_t cuts[STEPS]; // each in the step of what it saves, if no cut it is within saves less
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
    CoBuildPrim *next; // where a shard goes, or NULL: cuts are counted
} Cutter;

static float box_area(const CoBuildPrim *prim)
{
    return co4_first(co_shards_area(co4_load(prim->lo), co4_load(prim->hi)));
}

static Shard whole_triangle(const CoMesh *mesh, const CoBuildPrim *prim)
{
    Shard shard = {.count = 3};
    uint32_t tri[3];
    co_mesh_triangle(mesh, prim->id, tri);
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++)
            shard.corners[c][k] = (double)mesh->points[3 * (size_t)tri[c] + (size_t)k];
    memcpy(shard.box.lo, prim->lo, sizeof prim->lo);
    memcpy(shard.box.hi, prim->hi, sizeof prim->hi);
    return shard;
}

static int longest_axis(const CoBox *box)
{
    float d[3];
    for (int k = 0; k < 3; k++)
        d[k] = box->hi[k] - box->lo[k];
    int yz = d[2] > d[1] ? 2 : 1;
    return d[yz] > d[0] ? yz : 0;
}

// Of the corners, wider by more than they are rounded by, but within what it was. What doubles lose
// in all cuts is less than a millionth of that.
static void narrow_box(Shard *shard)
{
    for (int k = 0; k < 3; k++) {
        double least = shard->corners[0][k], most = least;
        for (int i = 1; i < shard->count; i++) {
            double x = shard->corners[i][k];
            least = x < least ? x : least;
            most = x > most ? x : most;
        }
        float lo = (float)least, hi = (float)most;
        lo -= fabsf(lo) * 0x1p-22f + FLT_TRUE_MIN;
        hi += fabsf(hi) * 0x1p-22f + FLT_TRUE_MIN;
        shard->box.lo[k] = lo > shard->box.lo[k] ? lo : shard->box.lo[k];
        shard->box.hi[k] = hi < shard->box.hi[k] ? hi : shard->box.hi[k];
    }
}

static void add_corner(Shard *shard, const double p[3])
{
    memcpy(shard->corners[shard->count++], p, sizeof shard->corners[0]);
}

// Corners in the plane belong to both halves.
static void cut_corners(const Shard *shard, int axis, double plane, Shard halves[2])
{
    const double *from = shard->corners[shard->count - 1];
    double before = from[axis] - plane;
    for (int i = 0; i < shard->count; i++) {
        const double *to = shard->corners[i];
        double after = to[axis] - plane;
        if ((before < 0.0 && after > 0.0) || (before > 0.0 && after < 0.0)) {
            double crossing[3], w = before / (before - after);
            for (int k = 0; k < 3; k++)
                crossing[k] = from[k] + (to[k] - from[k]) * w;
            crossing[axis] = plane;
            add_corner(&halves[0], crossing);
            add_corner(&halves[1], crossing);
        }
        if (after <= 0.0)
            add_corner(&halves[0], to);
        if (after >= 0.0)
            add_corner(&halves[1], to);
        from = to;
        before = after;
    }
}

// Through the middle of the longest side. False when floats have none.
static bool cut(const Shard *shard, Shard halves[2])
{
    int axis = longest_axis(&shard->box);
    float middle = 0.5f * shard->box.lo[axis] + 0.5f * shard->box.hi[axis];
    if (!(shard->box.lo[axis] < middle && middle < shard->box.hi[axis]))
        return false;
    halves[0].count = halves[1].count = 0;
    halves[0].box = halves[1].box = shard->box;
    halves[0].box.hi[axis] = halves[1].box.lo[axis] = middle;
    cut_corners(shard, axis, (double)middle, halves);
    if (!halves[0].count || !halves[1].count)
        return false;
    narrow_box(&halves[0]);
    narrow_box(&halves[1]);
    return true;
}

// No cut saves more: the halves together cover every side of the box but the one that is cut. That
// is two thirds of the area at most.
static double most_saved(const CoBox *box)
{
    int axis = longest_axis(box), y = (axis + 1) % 3, z = (axis + 2) % 3;
    double d[3];
    for (int k = 0; k < 3; k++)
        d[k] = (double)box->hi[k] - (double)box->lo[k];
    return 0.5 * d[axis] * (d[y] + d[z]) + d[y] * d[z];
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

static void put_shard(Cutter *c, const CoBox *box)
{
    memcpy(c->next->lo, box->lo, sizeof box->lo);
    memcpy(c->next->hi, box->hi, sizeof box->hi);
    c->next->id = c->id;
}

// Makes or counts the cuts that save enough, none of them in a higher step than `most`.
static void cut_down(Cutter *c, const Shard *shard, int depth, int most)
{
    const Shards *all = c->all;
    Shard halves[2];
    int step = -1;
    if (depth < DEEPEST && most_saved(&shard->box) > all->limit && cut(shard, halves))
        step = step_of(co_box_area(&shard->box) - co_box_area(&halves[0].box) -
                           co_box_area(&halves[1].box),
                       all->unit);
    if (step < all->least) {
        if (c->next)
            put_shard(c, &shard->box);
        return;
    }
    step = step < most ? step : most;
    if (!c->next)
        c->block->cuts[step]++;
    cut_down(c, &halves[0], depth + 1, step);
    if (c->next)
        c->next = all->prims + c->block->place++;
    cut_down(c, &halves[1], depth + 1, step);
}

static void cut_blocks(const Shards *all, size_t begin, size_t end, bool is_counted)
{
    // Most are told by their area alone.
    const float least_area = (float)(1.5 * all->limit);
    for (size_t b = begin; b < end; b++) {
        Cutter cutter = {.all = all, .block = &all->blocks[b]};
        size_t stop = co_shards_block_end(b, all->count);
        for (size_t i = b * CO_SHARDS_BLOCK; i < stop; i++) {
            CoBuildPrim *prim = &all->prims[i];
            if (!is_counted)
                co_shards_whole(all->mesh, (uint32_t)i, prim);
            if (!(box_area(prim) > least_area) ||
                (all->every > 1 && co_hash32((uint32_t)i) % all->every != 0))
                continue;
            Shard whole = whole_triangle(all->mesh, prim);
            cutter.id = prim->id;
            cutter.next = is_counted ? NULL : prim;
            cut_down(&cutter, &whole, 0, STEPS - 1);
        }
    }
}

static void count_cuts(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    cut_blocks(context, begin, end, true);
}

static void make_cuts(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    cut_blocks(context, begin, end, false);
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
// box meets: 7 to 15 in a closed surface, 30 among splinters 30 times as long as wide, hundreds among
// turned ones. Large boxes are not asked, which are cut in any case.
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
    co_parallel_for(all->block_count, 1, count_cuts, all);
    all->least = choose_step(all, worth);
    if (all->least == STEPS)
        return true;
    if (all->every > 1) { // places are to be exact
        all->every = 1;
        all->limit = units_of(all->least) * all->unit;
        memset(all->blocks, 0, all->block_count * sizeof *all->blocks);
        co_parallel_for(all->block_count, 1, count_cuts, all);
    }
    if (!give_places(all, prims))
        return false;
    co_parallel_for(all->block_count, 1, make_cuts, all);
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
