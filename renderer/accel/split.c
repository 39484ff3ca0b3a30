#include "accel/split.h"

#include <float.h>

enum {
    STRAYS = 64, // looked at between swaps
    FEW = 63     // bits
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

void co_box4_store(CoBox *out, const CoBox4 *from)
{
    co4_store3(out->lo, from->lo);
    co4_store3(out->hi, from->hi);
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
    const Co4 zero = co4_set1(0.0f), most = co4_set1(INFINITY);
    Co4 extent = co4_sub(centroids->hi, centroids->lo);
    Co4 scale = co4_div(co4_set1((float)binning.used * (1.0f - 1e-6f)), extent);
    scale = co4_where_less(scale, most, scale, zero);
    scale = co4_where_less(extent, most, scale, zero);
    co4_store(binning.origin, centroids->lo);
    co4_store(binning.scale, co4_where_less(zero, extent, scale, zero));
    return binning;
}

void co_bins_clear(CoBins *bins, uint32_t used)
{
    bins->used = used;
    for (int k = 0; k < 3; k++) {
        for (uint32_t b = 0; b < used; b++) {
            bins->of[k][b].box = co_box4_empty();
            bins->of[k][b].count[0] = 0;
        }
    }
}

// What filling needs at every prim.
typedef struct Filling {
    Co4 origin, scale, last;
} Filling;

// NaN, from a difference that overflows and a scale of 0, is in bin 0.
static inline void fill_one(CoBins *bins, const Filling *filling, const CoBuildPrim *prim,
                            int32_t at[4])
{
    CoBox4 box = prim_box(prim);
    Co4 x = co4_mul(co4_sub(centroid(&box), filling->origin), filling->scale);
    co4_truncate(co4_min(co4_max(x, co4_set1(0.0f)), filling->last), at);
    for (int k = 0; k < 3; k++) {
        CoBin *bin = &bins->of[k][(uint32_t)at[k]];
        co_box4_extend(&bin->box, &box);
        bin->count[0]++;
    }
}

// By turns from two halves: neighbors are often in one bin, and the second would wait for the
// first.
void co_bins_fill(CoBins *bins, const CoBinning *binning, const CoBuildPrim *prims, size_t count)
{
    const Filling filling = {co4_load(binning->origin), co4_load(binning->scale),
                             co4_set1((float)(binning->used - 1))};
    size_t half = count / 2;
    int32_t at[4];
    for (size_t i = 0; i < half; i++) {
        fill_one(bins, &filling, &prims[i], at);
        fill_one(bins, &filling, &prims[half + i], at);
    }
    if (count & 1)
        fill_one(bins, &filling, &prims[count - 1], at);
}

// The same of few, and says in which bins they are.
static void fill_few(CoBins *bins, const CoBinning *binning, const CoBuildPrim *prims, size_t count,
                     int32_t at[FEW][4])
{
    const Filling filling = {co4_load(binning->origin), co4_load(binning->scale),
                             co4_set1((float)(binning->used - 1))};
    size_t half = count / 2;
    for (size_t i = 0; i < half; i++) {
        fill_one(bins, &filling, &prims[i], at[i]);
        fill_one(bins, &filling, &prims[half + i], at[half + i]);
    }
    if (count & 1)
        fill_one(bins, &filling, &prims[count - 1], at[count - 1]);
}

// Minima, maxima and counts: the order of merging does not show.
void co_bins_merge(CoBins *into, const CoBins *from)
{
    for (int k = 0; k < 3; k++) {
        for (uint32_t b = 0; b < into->used; b++) {
            co_box4_extend(&into->of[k][b].box, &from->of[k][b].box);
            into->of[k][b].count[0] += from->of[k][b].count[0];
        }
    }
}

// Areas of four boxes, in units of the scale, with which no finite box overflows.
static inline Co4 areas_of_four(const CoBox4 boxes[4], Co4 scale)
{
    const Co4 half = co4_set1(0.5f);
    Co4 d[4];
    for (int i = 0; i < 4; i++)
        d[i] = co4_mul(co4_sub(co4_mul(half, boxes[i].hi), co4_mul(half, boxes[i].lo)), scale);
    co4_transpose(d);
    Co4 sides = co4_add(co4_mul(d[0], d[1]), co4_mul(d[1], d[2]));
    return co4_add(sides, co4_mul(d[2], d[0]));
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

// The cheapest splits: of every fourth bin the first of them.
typedef struct Cheapest {
    Co4 cost, place; // bin + CO_BIN_COUNT axis
} Cheapest;

// Without a branch on what is cheaper, which nothing predicts. Splits with nothing on one side cost
// infinitely much.
static void split_axis(const CoBins *bins, int axis, Co4 scale, Cheapest *best)
{
    static const float steps[4] = {0.0f, 1.0f, 2.0f, 3.0f};
    const CoBin *mine = bins->of[axis];
    const Co4 none = co4_set1(INFINITY), zero = co4_set1(0.0f);
    const uint32_t used = bins->used;
    float left[CO_BIN_COUNT];
    Co4 right_areas[CO_BIN_COUNT / 4];
    CoBox4 four[4], box = co_box4_empty();
    uint32_t all = 0;
    for (uint32_t b = 0; b < used; b++) {
        all += mine[b].count[0];
        left[b] = (float)all;
    }
    for (uint32_t b = used; b > 0; b -= 4) {
        for (uint32_t i = 4; i-- > 0;) {
            four[i] = box;
            co_box4_extend(&box, &mine[b - 4 + i].box);
        }
        right_areas[b / 4 - 1] = areas_of_four(four, scale);
    }
    box = co_box4_empty();
    for (uint32_t b = 0; b < used; b += 4) {
        for (uint32_t i = 0; i < 4; i++) {
            co_box4_extend(&box, &mine[b + i].box);
            four[i] = box;
        }
        Co4 l = co4_load(left + b), r = co4_sub(co4_set1((float)all), l);
        Co4 cost = co4_add(co4_mul(areas_of_four(four, scale), l), co4_mul(right_areas[b / 4], r));
        Co4 first = co4_set1((float)((uint32_t)axis * CO_BIN_COUNT + b));
        cost = co4_where_less(zero, l, co4_where_less(zero, r, cost, none), none);
        best->place =
            co4_where_less(cost, best->cost, co4_add(first, co4_load(steps)), best->place);
        best->cost = co4_min(cost, best->cost);
    }
}

// The cheapest of four, of those as cheap the first.
static uint32_t cheapest_place(const Cheapest *from, float *cost)
{
    float costs[4], places[4];
    co4_store(costs, from->cost);
    co4_store(places, from->place);
    int best = 0;
    for (int i = 1; i < 4; i++) {
        bool is_first = costs[i] == costs[best] && places[i] < places[best];
        best = costs[i] < costs[best] || is_first ? i : best;
    }
    *cost = costs[best];
    return (uint32_t)places[best];
}

CoSplit co_split_choose(const CoBins *bins, const CoBinning *binning, const CoBox *box)
{
    CoSplit best = {.axis = -1};
    Cheapest cheapest = {co4_set1(INFINITY), co4_set1(0.0f)};
    Co4 scale = area_scale(box);
    for (int k = 0; k < 3; k++)
        if (binning->scale[k] > 0.0f)
            split_axis(bins, k, scale, &cheapest);
    uint32_t place = cheapest_place(&cheapest, &best.cost), bin = place % CO_BIN_COUNT;
    if (!(best.cost < INFINITY))
        return best;
    best.axis = (int)(place / CO_BIN_COUNT);
    CoBox4 left = co_box4_empty(), right = left;
    for (uint32_t b = 0; b <= bin; b++) {
        co_box4_extend(&left, &bins->of[best.axis][b].box);
        best.left += bins->of[best.axis][b].count[0];
    }
    for (uint32_t b = bin + 1; b < bins->used; b++)
        co_box4_extend(&right, &bins->of[best.axis][b].box);
    best.boxes[0] = left;
    best.boxes[1] = right;
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

void co_split_give(const CoSplit *split, const CoBuildPrim *prims, const CoRange *range,
                   CoRange halves[2])
{
    bool is_found = split->axis >= 0;
    uint32_t left = is_found ? split->left : range->count / 2, right = range->count - left;
    CoBox4 boxes[2] = {split->boxes[0], split->boxes[1]};
    if (!is_found) {
        boxes[0] = co_prim_box(prims, left);
        boxes[1] = co_prim_box(prims + left, right);
    }
    for (uint32_t i = 0; i < 2; i++) {
        halves[i].first = range->first + (i ? left : 0);
        halves[i].count = i ? right : left;
        halves[i].depth = range->depth + 1;
        co_box4_store(&halves[i].box, &boxes[i]);
    }
}

static void swap(CoBuildPrim *x, CoBuildPrim *y)
{
    CoBuildPrim moved = *x;
    *x = *y;
    *y = moved;
}

// As co_split_move().
static void move_few(const CoSplit *split, CoBuildPrim *prims, size_t count, int32_t at[FEW][4])
{
    const int32_t last = (int32_t)split->edge - 1;
    uint64_t right = 0, front = ((uint64_t)1 << split->left) - 1;
    for (size_t i = 0; i < count; i++)
        right |= (uint64_t)(at[i][split->axis] > last) << i;
    uint64_t a = right & front, b = ~right & ~front;
    for (; a; a &= a - 1, b &= b - 1)
        swap(&prims[__builtin_ctzll(a)], &prims[__builtin_ctzll(b)]);
}

static void split_few(CoBuildPrim *prims, const CoRange *range, CoRange halves[2])
{
    int32_t at[FEW][4];
    CoBins bins;
    CoBox4 centroids = co_centroid_box(prims, range->count);
    CoBinning binning = co_binning_over(&centroids, range->count);
    co_bins_clear(&bins, binning.used);
    fill_few(&bins, &binning, prims, range->count, at);
    CoSplit split = co_split_choose(&bins, &binning, &range->box);
    if (split.axis >= 0)
        move_few(&split, prims, range->count, at);
    co_split_give(&split, prims, range, halves);
}

void co_split_range(CoBuildPrim *prims, const CoRange *range, CoRange halves[2])
{
    CoSplit split = {.axis = -1};
    CoBuildPrim *mine = prims + range->first;
    if (range->count <= FEW && range->depth < CO_SPLIT_DEPTH) {
        split_few(mine, range, halves);
        return;
    }
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
