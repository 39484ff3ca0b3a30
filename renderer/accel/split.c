#include "accel/split.h"

#include <float.h>

enum {
    STRAYS = 64 // looked at between swaps
};

static inline CoBox4 prim_box(const CoBuildPrim *prim)
{
    CoBox4 box = {co4_xyz(co4_load(prim->lo)), co4_xyz(co4_load(prim->hi))};
    return box;
}

// Half sums, so that centroids of the largest finite boxes are finite.
static inline Co4 centroid(const CoBox4 *box)
{
    const Co4 half = co4_set1(0.5f);
    return co4_add(co4_mul(half, box->lo), co4_mul(half, box->hi));
}

CoBox4 co_box4_empty(void)
{
    CoBox4 box = {co4_set1(INFINITY), co4_set1(-INFINITY)};
    return box;
}

void co_box4_extend(CoBox4 *box, const CoBox4 *by)
{
    box->lo = co4_min(box->lo, by->lo);
    box->hi = co4_max(box->hi, by->hi);
}

CoBox co_box4_store(CoBox4 from)
{
    float lo[4], hi[4];
    CoBox box;
    co4_store(lo, from.lo);
    co4_store(hi, from.hi);
    memcpy(box.lo, lo, sizeof box.lo);
    memcpy(box.hi, hi, sizeof box.hi);
    return box;
}

CoBox4 co_centroid_box(const CoBuildPrim *prims, size_t count)
{
    CoBox4 all = co_box4_empty();
    for (size_t i = 0; i < count; i++) {
        CoBox4 box = prim_box(&prims[i]);
        Co4 c = centroid(&box);
        all.lo = co4_min(all.lo, c);
        all.hi = co4_max(all.hi, c);
    }
    return all;
}

CoBox4 co_prim_box(const CoBuildPrim *prims, size_t count)
{
    CoBox4 all = co_box4_empty();
    for (size_t i = 0; i < count; i++) {
        CoBox4 box = prim_box(&prims[i]);
        co_box4_extend(&all, &box);
    }
    return all;
}

// Few things need few bins.
static uint32_t bin_count(size_t count)
{
    return count < 12 ? 4 : count < 32 ? 8 : count < 1024 ? 16 : CO_BIN_COUNT;
}

CoBinning co_binning_over(const CoBox4 *centroids, size_t count)
{
    CoBinning binning = {.used = bin_count(count)};
    CoBox box = co_box4_store(*centroids);
    for (int k = 0; k < 3; k++) {
        float extent = box.hi[k] - box.lo[k];
        float scale = (float)binning.used * (1.0f - 1e-6f) / extent;
        binning.origin[k] = box.lo[k];
        binning.scale[k] = extent > 0.0f && extent <= FLT_MAX && scale <= FLT_MAX ? scale : 0.0f;
    }
    return binning;
}

void co_bins_clear(CoBins *bins, uint32_t used)
{
    bins->used = used;
    for (int k = 0; k < 3; k++) {
        for (uint32_t b = 0; b < used; b++) {
            bins->box[k][b] = co_box4_empty();
            bins->count[k][b] = 0;
        }
    }
}

// What filling needs at every prim.
typedef struct Filling {
    Co4 origin, scale, last;
} Filling;

// NaN, from a difference that overflows and a scale of 0, is in bin 0.
static inline void fill_one(CoBins *bins, const Filling *filling, const CoBuildPrim *prim)
{
    CoBox4 box = prim_box(prim);
    Co4 x = co4_mul(co4_sub(centroid(&box), filling->origin), filling->scale);
    int32_t at[4];
    co4_truncate(co4_min(co4_max(x, co4_set1(0.0f)), filling->last), at);
    for (int k = 0; k < 3; k++) {
        co_box4_extend(&bins->box[k][at[k]], &box);
        bins->count[k][at[k]]++;
    }
}

// By turns from two halves: neighbors are often in one bin, and the second would wait for the
// first.
void co_bins_fill(CoBins *bins, const CoBinning *binning, const CoBuildPrim *prims, size_t count)
{
    const Filling filling = {co4_load(binning->origin), co4_load(binning->scale),
                             co4_set1((float)(binning->used - 1))};
    size_t half = count / 2;
    for (size_t i = 0; i < half; i++) {
        fill_one(bins, &filling, &prims[i]);
        fill_one(bins, &filling, &prims[half + i]);
    }
    if (count & 1)
        fill_one(bins, &filling, &prims[count - 1]);
}

// Minima, maxima and counts: the order of merging does not show.
void co_bins_merge(CoBins *into, const CoBins *from)
{
    for (int k = 0; k < 3; k++) {
        for (uint32_t b = 0; b < into->used; b++) {
            co_box4_extend(&into->box[k][b], &from->box[k][b]);
            into->count[k][b] += from->count[k][b];
        }
    }
}

// Areas of four boxes, in units of the scale, with which no finite box overflows.
static void areas_of_four(const CoBox4 boxes[4], Co4 scale, float out[4])
{
    const Co4 half = co4_set1(0.5f);
    Co4 d[4];
    for (int i = 0; i < 4; i++)
        d[i] = co4_mul(co4_sub(co4_mul(half, boxes[i].hi), co4_mul(half, boxes[i].lo)), scale);
    co4_transpose(d);
    Co4 sides = co4_add(co4_mul(d[0], d[1]), co4_mul(d[1], d[2]));
    co4_store(out, co4_add(sides, co4_mul(d[2], d[0])));
}

// For boxes within this one. Without fmaxf and fminf, which are calls.
static Co4 area_scale(const CoBox *box)
{
    float size = 0.0f;
    for (int k = 0; k < 3; k++) {
        float side = 0.5f * box->hi[k] - 0.5f * box->lo[k];
        size = side > size ? side : size;
    }
    float scale = 1.0f / size;
    return co4_set1(scale < FLT_MAX ? scale : FLT_MAX);
}

static void split_axis(const CoBins *bins, int axis, Co4 scale, CoSplit *best, uint32_t *best_bin)
{
    CoBox4 before[CO_BIN_COUNT], after[CO_BIN_COUNT]; // of bins 0 .. b; of bins b + 1 ..
    float before_area[CO_BIN_COUNT], after_area[CO_BIN_COUNT];
    uint32_t used = bins->used, left = 0, all = 0;
    CoBox4 box = co_box4_empty();
    for (uint32_t b = 0; b < used; b++) {
        co_box4_extend(&box, &bins->box[axis][b]);
        before[b] = box;
        all += bins->count[axis][b];
    }
    box = co_box4_empty();
    for (uint32_t b = used; b-- > 0;) {
        after[b] = box;
        co_box4_extend(&box, &bins->box[axis][b]);
    }
    for (uint32_t b = 0; b < used; b += 4) {
        areas_of_four(before + b, scale, before_area + b);
        areas_of_four(after + b, scale, after_area + b);
    }
    for (uint32_t b = 0; b + 1 < used; b++) {
        left += bins->count[axis][b];
        if (left == 0 || left == all)
            continue;
        float cost = before_area[b] * (float)left + after_area[b] * (float)(all - left);
        if (best->axis >= 0 && !(cost < best->cost))
            continue;
        best->axis = axis;
        best->cost = cost;
        best->left = left;
        *best_bin = b;
    }
}

CoSplit co_split_choose(const CoBins *bins, const CoBinning *binning, const CoBox *box)
{
    CoSplit best = {.axis = -1};
    uint32_t bin = 0;
    Co4 scale = area_scale(box);
    for (int k = 0; k < 3; k++)
        if (binning->scale[k] > 0.0f)
            split_axis(bins, k, scale, &best, &bin);
    if (best.axis < 0)
        return best;
    CoBox4 sides[2] = {co_box4_empty(), co_box4_empty()};
    for (uint32_t b = 0; b < bins->used; b++)
        co_box4_extend(&sides[b > bin], &bins->box[best.axis][b]);
    for (int i = 0; i < 2; i++)
        best.boxes[i] = co_box4_store(sides[i]);
    best.origin = binning->origin[best.axis];
    best.scale = binning->scale[best.axis];
    best.edge = (float)(bin + 1);
    return best;
}

// Of a split, in registers: what is written meanwhile might be the split otherwise.
typedef struct Plane {
    int axis;
    float origin, scale, edge;
} Plane;

static inline Plane plane_of(const CoSplit *split)
{
    Plane plane = {split->axis, split->origin, split->scale, split->edge};
    return plane;
}

static inline bool is_right(Plane plane, const CoBuildPrim *prim)
{
    float c = 0.5f * prim->lo[plane.axis] + 0.5f * prim->hi[plane.axis];
    return (c - plane.origin) * plane.scale >= plane.edge;
}

size_t co_split_count(const CoSplit *split, const CoBuildPrim *prims, size_t count)
{
    const Plane plane = plane_of(split);
    size_t right = 0;
    for (size_t i = 0; i < count; i++)
        right += is_right(plane, &prims[i]);
    return count - right;
}

// Those of one side that belong to the other, a few at a time.
typedef struct Strays {
    size_t at, end; // what is not searched yet
    CoBuildPrim *from;
    uint32_t count, taken;
    uint8_t place[STRAYS];
} Strays;

// Without a branch on the side, which nothing predicts.
static void find_strays(Strays *s, const CoSplit *split, CoBuildPrim *prims, bool stays_right)
{
    const Plane plane = plane_of(split);
    s->count = s->taken = 0;
    while (s->count == 0 && s->at < s->end) {
        uint32_t most = s->end - s->at < STRAYS ? (uint32_t)(s->end - s->at) : STRAYS, count = 0;
        const CoBuildPrim *from = s->from = prims + s->at;
        for (uint32_t i = 0; i < most; i++) {
            s->place[count] = (uint8_t)i;
            count += is_right(plane, &from[i]) != stays_right;
        }
        s->count = count;
        s->at += most;
    }
}

// There are as many on either side: the k-th of the one changes places with the k-th of the other.
void co_split_move(const CoSplit *split, CoBuildPrim *prims, size_t count, size_t left)
{
    Strays a = {.end = left}, b = {.at = left, .end = count};
    for (;;) {
        if (a.taken == a.count)
            find_strays(&a, split, prims, false);
        if (b.taken == b.count)
            find_strays(&b, split, prims, true);
        if (a.count == 0 || b.count == 0)
            return;
        while (a.taken < a.count && b.taken < b.count) {
            CoBuildPrim *x = &a.from[a.place[a.taken++]], *y = &b.from[b.place[b.taken++]];
            CoBuildPrim moved = *x;
            *x = *y;
            *y = moved;
        }
    }
}

static CoRange half_of(const CoRange *range, uint32_t first, uint32_t count, const CoBox *box)
{
    CoRange half = {range->first + first, count, range->depth + 1, *box};
    return half;
}

static void halve(const CoBuildPrim *prims, const CoRange *range, CoRange halves[2])
{
    uint32_t left = range->count / 2, right = range->count - left;
    CoBox4 boxes[2] = {co_prim_box(prims, left), co_prim_box(prims + left, right)};
    CoBox stored[2] = {co_box4_store(boxes[0]), co_box4_store(boxes[1])};
    halves[0] = half_of(range, 0, left, &stored[0]);
    halves[1] = half_of(range, left, right, &stored[1]);
}

void co_split_give(const CoSplit *split, const CoBuildPrim *prims, const CoRange *range,
                   CoRange halves[2])
{
    if (split->axis < 0) {
        halve(prims, range, halves);
        return;
    }
    halves[0] = half_of(range, 0, split->left, &split->boxes[0]);
    halves[1] = half_of(range, split->left, range->count - split->left, &split->boxes[1]);
}

void co_split_range(CoBuildPrim *prims, const CoRange *range, CoRange halves[2])
{
    CoSplit split = {.axis = -1};
    CoBuildPrim *mine = prims + range->first;
    if (range->depth < CO_SPLIT_DEPTH) {
        CoBox4 centroids = co_centroid_box(mine, range->count);
        CoBinning binning = co_binning_over(&centroids, range->count);
        CoBins bins;
        co_bins_clear(&bins, binning.used);
        co_bins_fill(&bins, &binning, mine, range->count);
        split = co_split_choose(&bins, &binning, &range->box);
        if (split.axis >= 0)
            co_split_move(&split, mine, range->count, split.left);
    }
    co_split_give(&split, mine, range, halves);
}
