#include "accel/cut.h"

#include <math.h>
#include <string.h>

static CoFour four_of(const float p[3])
{
    return (CoFour){p[0], p[1], p[2], 0.0f};
}

void co_cut_start(const CoMesh *mesh, const CoBuildPrim *prim, CoShard *out)
{
    uint32_t tri[3];
    co_mesh_triangle(mesh, prim->id, tri);
    for (int c = 0; c < 3; c++)
        out->corners[c] = four_of(mesh->points + 3 * (size_t)tri[c]);
    out->count = 3;
    out->lo = four_of(prim->lo);
    out->hi = four_of(prim->hi);
}

// A half as it grows.
typedef struct Half {
    CoFour lo, hi;
    CoShard *out;
    int count;
} Half;

// Where `is_in` says no, it is overwritten by the next. Nothing predicts which are in.
static inline void add_corner(Half *half, CoFour corner, bool is_in)
{
    CoFourBits all = {-(int32_t)is_in, -(int32_t)is_in, -(int32_t)is_in, -(int32_t)is_in};
    half->lo = co_four_min(co_four_select(all, corner, co_four_set1(INFINITY)), half->lo);
    half->hi = co_four_max(co_four_select(all, corner, co_four_set1(-INFINITY)), half->hi);
    half->out->corners[half->count] = corner;
    half->count += is_in;
}

static inline void finish(Half *half, CoFour lo, CoFour hi, CoFour rounding)
{
    half->out->lo = co_four_max(half->lo - rounding, lo);
    half->out->hi = co_four_min(half->hi + rounding, hi);
    half->out->count = half->count;
}

// Corners in the plane belong to both halves. Inline, as the axis is known where it is called.
static inline __attribute__((always_inline)) bool halve(const CoShard *shard, int axis, float plane,
                                                        CoFour rounding, CoShard halves[2])
{
    Half left = {co_four_set1(INFINITY), co_four_set1(-INFINITY), &halves[0], 0}, right = left;
    CoFour from = shard->corners[shard->count - 1];
    float before = from[axis] - plane;
    right.out = &halves[1];
    for (int i = 0; i < shard->count; i++) {
        CoFour to = shard->corners[i];
        float after = to[axis] - plane;
        bool crosses = (before < 0.0f) & (after > 0.0f);
        crosses |= (before > 0.0f) & (after < 0.0f);
        CoFour crossing = from + (to - from) * co_four_set1(before / (before - after));
        crossing[axis] = plane;
        add_corner(&left, crossing, crosses);
        add_corner(&right, crossing, crosses);
        add_corner(&left, to, after <= 0.0f);
        add_corner(&right, to, after >= 0.0f);
        from = to;
        before = after;
    }
    CoFour middle = shard->hi;
    middle[axis] = plane;
    finish(&left, shard->lo, middle, rounding);
    middle = shard->lo;
    middle[axis] = plane;
    finish(&right, middle, shard->hi, rounding);
    return left.count > 0 && right.count > 0;
}

bool co_cut_halve(const CoShard *shard, CoFour rounding, CoShard halves[2])
{
    CoFour lo = shard->lo, hi = shard->hi, middle = 0.5f * lo + 0.5f * hi, size = hi - lo;
    CoFourBits is_between = (lo < middle) & (middle < hi);
    int axis = size[2] > size[1] ? 2 : 1;
    axis = size[axis] > size[0] ? axis : 0;
    if (!is_between[axis] || 2 * shard->count >= CO_CUT_CORNERS)
        return false;
    if (axis == 0)
        return halve(shard, 0, middle[0], rounding, halves);
    if (axis == 1)
        return halve(shard, 1, middle[1], rounding, halves);
    return halve(shard, 2, middle[2], rounding, halves);
}

// One coordinate of the corners of four triangles.
typedef struct Triple {
    CoFour of[3];
} Triple;

static Triple choose(CoFourBits m, const Triple *a, const Triple *b)
{
    Triple r;
    for (int c = 0; c < 3; c++)
        r.of[c] = co_four_select(m, a->of[c], b->of[c]);
    return r;
}

static CoFour least(const Triple *a)
{
    return co_four_min(co_four_min(a->of[0], a->of[1]), a->of[2]);
}

static CoFour most(const Triple *a)
{
    return co_four_max(co_four_max(a->of[0], a->of[1]), a->of[2]);
}

static CoFour extent(const Triple *a)
{
    return most(a) - least(a);
}

// Rows become columns.
static void load_four(const CoMesh *mesh, const uint32_t ids[4], Triple out[3])
{
    uint32_t tris[4][3];
    for (int i = 0; i < 4; i++)
        co_mesh_triangle(mesh, ids[i], tris[i]);
    for (int c = 0; c < 3; c++) {
        CoFour p[4];
        for (int i = 0; i < 4; i++)
            p[i] = four_of(mesh->points + 3 * (size_t)tris[i][c]);
        CoFour near = __builtin_shufflevector(p[0], p[1], 0, 4, 1, 5);
        CoFour far = __builtin_shufflevector(p[2], p[3], 0, 4, 1, 5);
        out[0].of[c] = __builtin_shufflevector(near, far, 0, 1, 4, 5);
        out[1].of[c] = __builtin_shufflevector(near, far, 2, 3, 6, 7);
        near = __builtin_shufflevector(p[0], p[1], 2, 6, 3, 7);
        far = __builtin_shufflevector(p[2], p[3], 2, 6, 3, 7);
        out[2].of[c] = __builtin_shufflevector(near, far, 0, 1, 4, 5);
    }
}

// A triangle in the plane's two sides: one corner alone, first, and two.
typedef struct Sides {
    CoFourBits is_second, is_third; // it is this one that is alone; else the first
    CoFour at[2];                   // where the plane cuts the edges to the other two, from 0 to 1
} Sides;

static Triple alone_first(const Triple *a, const Sides *sides)
{
    CoFour second = co_four_select(sides->is_second, a->of[1], a->of[0]);
    return (Triple){{co_four_select(sides->is_third, a->of[2], second),
                     co_four_select(sides->is_second, a->of[0], a->of[1]),
                     co_four_select(sides->is_third, a->of[0], a->of[2])}};
}

// How far the two halves reach across the cut.
static void widths(const Triple *a, const Sides *sides, CoFour out[2])
{
    Triple by = alone_first(a, sides);
    CoFour alone = by.of[0];
    CoFour p = alone + (by.of[1] - alone) * sides->at[0];
    CoFour q = alone + (by.of[2] - alone) * sides->at[1];
    CoFour lo = co_four_min(p, q), hi = co_four_max(p, q);
    out[0] = co_four_max(alone, hi) - co_four_min(alone, lo);
    out[1] = co_four_max(co_four_max(by.of[1], by.of[2]), hi) -
             co_four_min(co_four_min(by.of[1], by.of[2]), lo);
}

CoFour co_cut_saving(const CoMesh *mesh, const uint32_t ids[4])
{
    Triple axes[3];
    load_four(mesh, ids, axes);
    CoFour size[3] = {extent(&axes[0]), extent(&axes[1]), extent(&axes[2])};
    CoFourBits is_z = size[2] > size[1];
    CoFourBits is_x = co_four_max(size[2], size[1]) <= size[0];
    Triple longest = choose(is_z, &axes[2], &axes[1]), y = choose(is_z, &axes[1], &axes[2]);
    Triple x = choose(is_x, &longest, &axes[0]);
    longest = choose(is_x, &axes[0], &longest);
    CoFour plane = 0.5f * least(&longest) + 0.5f * most(&longest);
    for (int c = 0; c < 3; c++)
        longest.of[c] -= plane;
    CoFourBits below[3] = {longest.of[0] < 0.0f, longest.of[1] < 0.0f, longest.of[2] < 0.0f};
    Sides sides = {.is_second = below[1] ^ below[0], .is_third = below[2] ^ below[0]};
    CoFourBits is_first = sides.is_second & sides.is_third;
    sides.is_second &= ~is_first;
    sides.is_third &= ~is_first;
    Triple by = alone_first(&longest, &sides);
    sides.at[0] = by.of[0] / (by.of[0] - by.of[1]);
    sides.at[1] = by.of[0] / (by.of[0] - by.of[2]);
    CoFour wide[2], high[2], half = 0.5f * extent(&longest);
    widths(&x, &sides, wide);
    widths(&y, &sides, high);
    CoFour whole = size[0] * size[1] + size[1] * size[2] + size[2] * size[0];
    CoFour cut = half * (wide[0] + high[0] + wide[1] + high[1]);
    return whole - cut - wide[0] * high[0] - wide[1] * high[1];
}
