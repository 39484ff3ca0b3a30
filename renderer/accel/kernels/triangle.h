// The canonical hit of a ray with the triangles of a leaf.
//
// Source: Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection": the largest axis of the
// direction becomes z, points are sheared so that the ray runs along it, and three edge functions
// decide in 2D. Their signs are exact: a float product rounds monotonically, so a difference has
// the right sign or is 0, and where it is 0 it is taken again in double, in which products of
// floats are exact. Triangles that share an edge share its sheared points, so no ray passes between
// them. Both sides hit, hence the winding is left as it is.
//
// A distance is corrected by what the roundings on the way to it left out, so that it is good to
// 2 ulp of the triangle's largest coordinate for slivers too. What bounds it is known before:
// nothing but the choice among hits waits for the correction.

#ifndef CO_ACCEL_KERNELS_TRIANGLE_H
#define CO_ACCEL_KERNELS_TRIANGLE_H

#include "accel/kernels/one_ray.h"
#include "simd/residue.h"

// What a distance may be corrected by at most.
#define CO_CORRECTED_LEAST (1.0f - 0x1p-8f)
#define CO_CORRECTED_MOST (1.0f + 0x1p-8f)

// Edge functions are off by less than two units in the last place of the largest product in them,
// so the depth is by 8 times that over det of the triangle's extent in z. Where that is less than
// half of what may be corrected, depth times det is more than product times extent times this: all
// but slivers, and triangles that lie along the ray, as near to its origin as one that it has just
// left.
#define CO_DEPTH_IS_SURE 0x1p-11f

// A triangle is no sliver while its products are at most so many times det: what its depth is off
// by then is within what rays that leave it are moved by.
#define CO_NO_SLIVER 8.0f

// What is sheared is rounded by its distance from the ray's origin: corners of a ground of a
// million units by a tenth, however near the ray meets it. Where a triangle extends by more than
// this times the depth of its hit and every coordinate of the origin, the hit is placed by doubles
// instead.
#define CO_VAST 16.0f

// A ray as the triangle test needs it.
typedef struct Shear {
    uint32_t x, y, z; // axes; z is that of the largest direction component
    float org[3];     // along x, y, z
    float sx, sy, sz;
    float dir; // along z
} Shear;

static inline void shear_load(const Ray *ray, Shear *shear)
{
    const float *org = (const float *)&ray->org, *inv = (const float *)&ray->inv;
    const float *dir = (const float *)&ray->dir;
    uint32_t z = ray->major, x = next_axis(z), y = next_axis(x);
    shear->x = x;
    shear->y = y;
    shear->z = z;
    shear->org[0] = org[x];
    shear->org[1] = org[y];
    shear->org[2] = org[z];
    shear->sx = ray->shear_x;
    shear->sy = ray->shear_y;
    shear->sz = inv[z];
    shear->dir = dir[z];
}

enum {
    POINT_VECTORS = CO_LEAF_WIDTH / CO_WIDE_WIDTH,
    CO_FEW = 8 // triangles, and points
};

// A leaf's points along the ray, and the edge functions of its triangles.
typedef struct LeafHits {
    CoWide x[POINT_VECTORS], y[POINT_VECTORS], z[POINT_VECTORS];
    CoWide edge[3][POINT_VECTORS];
} LeafHits;

// A leaf whose points are given by what the test calls x, y and z.
static inline void shear_rows(const CoTriLeaf *leaf, const float *const points[3],
                              const Shear *shear, LeafHits *out)
{
    const CoWide org_x = co_wide_set1(shear->org[0]), org_y = co_wide_set1(shear->org[1]);
    const CoWide org_z = co_wide_set1(shear->org[2]);
    const CoWide sx = co_wide_set1(shear->sx), sy = co_wide_set1(shear->sy);
    // No branch on their number but where vectors are many.
    const uint32_t most = CO_WIDE_WIDTH < 8 ? leaf->point_count : CO_LEAF_WIDTH;
    for (uint32_t i = 0; i * CO_WIDE_WIDTH < most; i++) {
        CoWide z = co_wide_sub(co_wide_load(points[2] + i * CO_WIDE_WIDTH), org_z);
        CoWide x = co_wide_sub(co_wide_load(points[0] + i * CO_WIDE_WIDTH), org_x);
        CoWide y = co_wide_sub(co_wide_load(points[1] + i * CO_WIDE_WIDTH), org_y);
        out->x[i] = co_wide_sub(x, co_wide_mul(sx, z));
        out->y[i] = co_wide_sub(y, co_wide_mul(sy, z));
        out->z[i] = z;
    }
}

static inline void shear_points(const CoTriLeaf *leaf, const Shear *shear, LeafHits *out)
{
    const size_t row = (size_t)(leaf->points[1] - leaf->points[0]); // the same from 1 to 2
    const float *at = leaf->points[0];
    const float *const points[3] = {at + row * shear->x, at + row * shear->y, at + row * shear->z};
    shear_rows(leaf, points, shear, out);
}

// Edge functions of triangles i and up. Returns one bit per triangle whose line is pierced or may
// be.
static inline uint32_t pierce_vector(const CoTriLeaf *leaf, uint32_t i, LeafHits *hits)
{
    const CoWide zero = co_wide_set1(0.0f);
    CoWide x[3], y[3], edge[3];
    for (int c = 0; c < 3; c++) {
        const uint8_t *corner = leaf->corner + (size_t)c * leaf->row;
        x[c] = co_wide_lookup16(hits->x, corner, i);
        y[c] = co_wide_lookup16(hits->y, corner, i);
    }
    for (int c = 0; c < 3; c++) {
        int p = (c + 2) % 3, q = (c + 1) % 3;
        edge[c] = co_wide_sub(co_wide_mul(x[p], y[q]), co_wide_mul(y[p], x[q]));
        hits->edge[c][i / CO_WIDE_WIDTH] = edge[c];
    }
    CoWide least = co_wide_min(co_wide_min(edge[0], edge[1]), edge[2]);
    CoWide most = co_wide_max(co_wide_max(edge[0], edge[1]), edge[2]);
    CoWideMask mixed = co_wide_and(co_wide_lt(least, zero), co_wide_lt(zero, most));
    return ~co_wide_bits(mixed) & ((1u << CO_WIDE_WIDTH) - 1u);
}

// The same of all triangles, whose points are sheared. Wide vectors all at once, however many
// triangles there are: no branch is taken on what cannot be guessed.
static inline uint32_t pierce_triangles(const CoTriLeaf *leaf, uint32_t count, LeafHits *hits)
{
    const uint32_t most = CO_WIDE_WIDTH < 8 ? count : CO_LEAF_WIDTH;
    uint32_t pierced = 0;
    for (uint32_t i = 0; i < most; i += CO_WIDE_WIDTH)
        pierced |= pierce_vector(leaf, i, hits) << i;
    return pierced & ((2u << (count - 1)) - 1u);
}

// What most leaves of flat meshes are: two triangles, or a few.
static inline bool is_few(const CoTriLeaf *leaf)
{
    return leaf->count <= CO_FEW && leaf->point_count <= CO_FEW;
}

// shear_points and pierce_triangles of a leaf of few triangles, by lanes: wider vectors would be
// half empty.
static inline uint32_t pierce_few(const CoTriLeaf *leaf, uint32_t count, const Shear *shear,
                                  LeafHits *hits)
{
    const CoLane zero = co_lane_set1(0.0f);
    // Narrow lanes, which stop early, look up what stands behind the last corner too: any of 16.
    CoLane xs[CO_LEAF_WIDTH / CO_LANE_WIDTH] = {zero}, ys[CO_LEAF_WIDTH / CO_LANE_WIDTH] = {zero};
    const uint32_t points = CO_LANE_WIDTH < 8 ? leaf->point_count : CO_FEW;
    const uint32_t triangles = CO_LANE_WIDTH < 8 ? count : CO_FEW;
    for (uint32_t i = 0; i < points; i += CO_LANE_WIDTH) {
        CoLane z =
            co_lane_sub(co_lane_load(leaf->points[shear->z] + i), co_lane_set1(shear->org[2]));
        CoLane x =
            co_lane_sub(co_lane_load(leaf->points[shear->x] + i), co_lane_set1(shear->org[0]));
        CoLane y =
            co_lane_sub(co_lane_load(leaf->points[shear->y] + i), co_lane_set1(shear->org[1]));
        x = co_lane_sub(x, co_lane_mul(co_lane_set1(shear->sx), z));
        y = co_lane_sub(y, co_lane_mul(co_lane_set1(shear->sy), z));
        co_lane_store((float *)hits->x + i, xs[i / CO_LANE_WIDTH] = x);
        co_lane_store((float *)hits->y + i, ys[i / CO_LANE_WIDTH] = y);
        co_lane_store((float *)hits->z + i, z);
    }
    uint32_t pierced = 0;
    for (uint32_t i = 0; i < triangles; i += CO_LANE_WIDTH) {
        CoLane x[3], y[3], edge[3];
        for (int c = 0; c < 3; c++) {
            x[c] = co_lane_lookup8(xs, leaf->corner + (size_t)c * leaf->row, i);
            y[c] = co_lane_lookup8(ys, leaf->corner + (size_t)c * leaf->row, i);
        }
        for (int c = 0; c < 3; c++) {
            int p = (c + 2) % 3, q = (c + 1) % 3;
            edge[c] = co_lane_sub(co_lane_mul(x[p], y[q]), co_lane_mul(y[p], x[q]));
            co_lane_store((float *)hits->edge[c] + i, edge[c]);
        }
        CoLane least = co_lane_min(co_lane_min(edge[0], edge[1]), edge[2]);
        CoLane most = co_lane_max(co_lane_max(edge[0], edge[1]), edge[2]);
        CoLaneMask mixed = co_lane_and(co_lane_lt(least, zero), co_lane_lt(zero, most));
        pierced |= (~co_lane_bits(mixed) & ((1u << CO_LANE_WIDTH) - 1u)) << i;
    }
    return pierced & ((2u << (count - 1)) - 1u);
}

// Where a ray meets a triangle.
typedef struct Place {
    float t, u, v;
    float least, most; // that t may be, known before it is
} Place;

// A hit of one triangle in double, from its float sheared corners. False when it is missed or
// has no area along the ray. Inline: a call is rare, but what it spills is not.
static inline __attribute__((always_inline)) bool pierce_exactly(const float corner[3][3],
                                                                 float dir, Place *out)
{
    const float *x = corner[0], *y = corner[1], *z = corner[2];
    double edge[3];
    for (int c = 0; c < 3; c++) {
        int p = (c + 2) % 3, q = (c + 1) % 3;
        edge[c] = (double)x[p] * (double)y[q] - (double)y[p] * (double)x[q];
    }
    bool is_negative = edge[0] < 0.0 || edge[1] < 0.0 || edge[2] < 0.0;
    bool is_positive = edge[0] > 0.0 || edge[1] > 0.0 || edge[2] > 0.0;
    double det = edge[0] + edge[1] + edge[2];
    if ((is_negative && is_positive) || !(__builtin_fabs(det) > 0.0))
        return false;
    double sum = (edge[0] / det) * (double)z[0] + (edge[1] / det) * (double)z[1] +
                 (edge[2] / det) * (double)z[2];
    out->t = out->least = out->most = (float)(sum / (double)dir);
    out->u = (float)(edge[1] / det);
    out->v = (float)(edge[2] / det);
    return true;
}

// By edge, x[p] and x[q] of the corners that its function is a product of, see pierce_vector.
static inline CoFour edge_first(CoFour x)
{
    return __builtin_shufflevector(x, x, 2, 0, 1, 3);
}

static inline CoFour edge_second(CoFour x)
{
    return __builtin_shufflevector(x, x, 1, 2, 0, 3);
}

// The distance of a hit at depth `sum`, corrected: by how far the weighted corners are from there
// when the weights are taken with what their products were off by, and by what the product with sz
// and sz itself are off by. A step of Newton's, so it does not matter that inv is rounded; it makes
// weights of the products first, as these times a depth may be no floats.
static inline float correct_distance(CoFour x, CoFour y, CoFour z, float inv, float sum,
                                     const Shear *shear)
{
    const CoFour xp = edge_first(x), xq = edge_second(x), yp = edge_first(y), yq = edge_second(y);
    CoFour a = xp * yq, b = yp * xq;
    CoFour off = co_four_residue(xp, yq, a) - co_four_residue(yp, xq, b);
    CoFour part = (((a - b) + off) * co_four_set1(inv)) * (z - co_four_set1(sum));
    float left = part[0] + part[1] + part[2], t = sum * shear->sz;
    return t + (left - co_float_residue(t, shear->dir, sum)) * shear->sz;
}

// Asked of flat meshes: others are left at a distance that covers it (geometry/surface.c). By the
// corners as they are sheared, and the depth of the hit.
static inline bool is_vast(CoFour x, CoFour y, CoFour z, float depth, const Shear *shear)
{
    CoFour far = co_four_abs(x) + co_four_abs(y) + co_four_abs(z);
    float near = __builtin_fabsf(depth);
    for (int k = 0; k < 3; k++)
        near = float_max(near, __builtin_fabsf(shear->org[k]));
    return !co_four_below3(far, CO_VAST * near);
}

// Where a hit is, by the corners `at` themselves. Whether the triangle is met has been decided, by
// what its neighbors see too.
static inline __attribute__((always_inline)) void
place_vast(const CoTriLeaf *leaf, const Shear *shear, const uint32_t at[3], Place *out)
{
    double x[3], y[3], z[3], edge[3];
    for (int c = 0; c < 3; c++) {
        z[c] = (double)leaf->points[shear->z][at[c]] - (double)shear->org[2];
        x[c] = (double)leaf->points[shear->x][at[c]] - (double)shear->org[0];
        y[c] = (double)leaf->points[shear->y][at[c]] - (double)shear->org[1];
        x[c] -= (double)shear->sx * z[c];
        y[c] -= (double)shear->sy * z[c];
    }
    for (int c = 0; c < 3; c++) {
        int p = (c + 2) % 3, q = (c + 1) % 3;
        edge[c] = x[p] * y[q] - y[p] * x[q];
    }
    double det = edge[0] + edge[1] + edge[2], inv = 1.0 / det;
    double u = edge[1] * inv, v = edge[2] * inv;
    double t = (z[0] + u * (z[1] - z[0]) + v * (z[2] - z[0])) / (double)shear->dir;
    if (!(__builtin_fabs(t) < 1e38))
        return;
    out->t = out->least = out->most = (float)t;
    u = u < 0.0 ? 0.0 : u > 1.0 ? 1.0 : u;
    v = v < 0.0 ? 0.0 : v > 1.0 - u ? 1.0 - u : v;
    out->u = (float)u;
    out->v = (float)v;
}

// Whether a triangle is met where float does not tell, and where.
static inline __attribute__((always_inline)) bool
pierce_unsure(const CoTriLeaf *leaf, const Shear *shear, const uint32_t at[3],
              const float corner[3][3], const bool is_flat, Place *out)
{
    if (!pierce_exactly(corner, shear->dir, out))
        return false;
    CoFour axis[3];
    for (int k = 0; k < 3; k++)
        axis[k] = (CoFour){corner[k][0], corner[k][1], corner[k][2], 0.0f};
    if (is_flat && is_vast(axis[0], axis[1], axis[2], out->t * shear->dir, shear))
        place_vast(leaf, shear, at, out);
    return true;
}

static inline bool is_depth_sure(CoFour x, CoFour y, const float z[3], float sum, float det)
{
    CoFour a = edge_first(x) * edge_second(y);
    float extent = __builtin_fabsf(z[1] - z[0]) + __builtin_fabsf(z[2] - z[0]);
    float part = extent * CO_DEPTH_IS_SURE, depth = __builtin_fabsf(sum);
    float size = __builtin_fabsf(det);
    // The second product of an edge function is not farther from the first than det from 0.
    CoFour off = (co_four_abs(a) + size) * part;
    return co_four_below3(off, float_max(depth, part * CO_NO_SLIVER) * size);
}

// Where a triangle that may be pierced is. False when it is missed, or surely not in (from, to]:
// where float does not decide it is taken again in double. Few triangles of a leaf come here,
// mostly one: vectors do not pay.
static inline __attribute__((always_inline)) bool
place_hit(const CoTriLeaf *leaf, const Shear *shear, uint32_t i, const LeafHits *hits, float from,
          float to, const bool is_flat, Place *out)
{
    float edge[3];
    uint32_t at[3];
    CoFour four[3];
    const float *sheared[3] = {(const float *)hits->x, (const float *)hits->y,
                               (const float *)hits->z};
    for (uint32_t c = 0; c < 3; c++) {
        uint32_t point = co_leaf_corner(leaf, c, i);
        edge[c] = ((const float *)hits->edge[c])[i];
        at[c] = point;
    }
    for (int k = 0; k < 3; k++)
        four[k] =
            (CoFour){sheared[k][at[0]], sheared[k][at[1]], sheared[k][at[2]], sheared[k][at[0]]};
    float det = edge[0] + edge[1] + edge[2], size = __builtin_fabsf(det);
    float smallest = float_min(__builtin_fabsf(edge[0]), __builtin_fabsf(edge[1]));
    smallest = float_min(smallest, __builtin_fabsf(edge[2]));
    // From a corner on: the roundings of u and v are multiplied by the size of the triangle only.
    const float z[3] = {sheared[2][at[0]], sheared[2][at[1]], sheared[2][at[2]]}, inv = 1.0f / det;
    out->u = edge[1] * inv;
    out->v = edge[2] * inv;
    float sum = z[0] + (out->u * (z[1] - z[0]) + out->v * (z[2] - z[0]));
    bool is_sure = (size > 1e-30f) & (size < 1e30f) & (smallest > 0.0f) &
                   is_depth_sure(four[0], four[1], z, sum, det) &
                   !(is_flat && is_vast(four[0], four[1], four[2], sum, shear));
    if (!is_sure) {
        float corner[3][3];
        for (int k = 0; k < 3; k++)
            for (int c = 0; c < 3; c++)
                corner[k][c] = four[k][c];
        return pierce_unsure(leaf, shear, at, (const float(*)[3])corner, is_flat, out);
    }
    float less = sum * (shear->sz * CO_CORRECTED_LEAST);
    float more = sum * (shear->sz * CO_CORRECTED_MOST);
    out->least = float_min(less, more);
    out->most = float_max(less, more);
    if ((out->most <= from) | (out->least > to))
        return false;
    float t = correct_distance(four[0], four[1], four[2], inv, sum, shear);
    out->t = float_max(float_min(t, out->most), out->least);
    return true;
}

// Clamps t into the triangle's own box and the boxes of the instances on the way. False when the
// line is not in them at all.
static inline bool clamp_hit(const CoTriLeaf *leaf, const Ray *ray, uint32_t i, Place *at)
{
    CoFour corner[3];
    for (uint32_t c = 0; c < 3; c++) {
        uint32_t point = co_leaf_corner(leaf, c, i);
        corner[c] =
            (CoFour){leaf->points[0][point], leaf->points[1][point], leaf->points[2][point], 0.0f};
    }
    CoFour lo = co_four_min(co_four_min(corner[0], corner[1]), corner[2]);
    CoFour hi = co_four_max(co_four_max(corner[0], corner[1]), corner[2]);
    float from = ray->entry, to = ray->exit;
    if (!slab_box(ray, ray->pad, lo, hi, &from, &to))
        return false;
    at->t = float_max(float_min(at->t, to), from);
    at->most = float_max(float_min(at->most, to), from);
    return true;
}

#endif
