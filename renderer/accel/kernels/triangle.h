// The canonical hit of a ray with the triangles of a leaf.
//
// Source: Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection": the largest axis of the
// direction becomes z, points are sheared so that the ray runs along it, and three edge functions
// decide in 2D. Their signs are exact: a float product rounds monotonically, so a difference has
// the right sign or is 0, and where it is 0 it is taken again in double, in which products of
// floats are exact. Triangles that share an edge share its sheared points, so no ray passes between
// them. Both sides hit, hence the winding is left as it is.

#ifndef CO_ACCEL_KERNELS_TRIANGLE_H
#define CO_ACCEL_KERNELS_TRIANGLE_H

#include "accel/kernels/one_ray.h"

// A ray as the triangle test needs it.
typedef struct Shear {
    uint32_t x, y, z; // axes; z is that of the largest direction component
    float org[3];     // along x, y, z
    float sx, sy, sz;
} Shear;

static inline void shear_load(const Ray *ray, Shear *shear)
{
    const float *org = (const float *)&ray->org, *inv = (const float *)&ray->inv;
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
}

enum {
    POINT_VECTORS = CO_LEAF_WIDTH / CO_WIDE_WIDTH
};

// A leaf's points along the ray, and per triangle what the lanes found.
typedef struct LeafHits {
    CoWide x[POINT_VECTORS], y[POINT_VECTORS], z[POINT_VECTORS];
    float t[CO_LEAF_WIDTH], u[CO_LEAF_WIDTH], v[CO_LEAF_WIDTH];
    uint32_t unsure; // triangles for which float does not decide
} LeafHits;

static inline void shear_points(const CoTriLeaf *leaf, const Shear *shear, LeafHits *out)
{
    const size_t row = (size_t)(leaf->points[1] - leaf->points[0]); // the same from 1 to 2
    const float *points = leaf->points[0];
    const CoWide org_x = co_wide_set1(shear->org[0]), org_y = co_wide_set1(shear->org[1]);
    const CoWide org_z = co_wide_set1(shear->org[2]);
    const CoWide sx = co_wide_set1(shear->sx), sy = co_wide_set1(shear->sy);
    // No branch on their number but where vectors are many.
    const uint32_t most = CO_WIDE_WIDTH < 8 ? leaf->point_count : CO_LEAF_WIDTH;
    for (uint32_t i = 0; i * CO_WIDE_WIDTH < most; i++) {
        const float *at = points + i * CO_WIDE_WIDTH;
        CoWide z = co_wide_sub(co_wide_load(at + row * shear->z), org_z);
        CoWide x = co_wide_sub(co_wide_load(at + row * shear->x), org_x);
        CoWide y = co_wide_sub(co_wide_load(at + row * shear->y), org_y);
        out->x[i] = co_wide_sub(x, co_wide_mul(sx, z));
        out->y[i] = co_wide_sub(y, co_wide_mul(sy, z));
        out->z[i] = z;
    }
}

// Edge functions of a vector of triangles.
typedef struct LeafEdges {
    CoWide edge[3];
} LeafEdges;

// Those of triangles i and up. Returns one bit per triangle whose line is pierced or may be.
static inline uint32_t edges_of(const CoTriLeaf *leaf, uint32_t i, const LeafHits *points,
                                LeafEdges *out)
{
    const CoWide zero = co_wide_set1(0.0f);
    CoWide x[3], y[3];
    for (int c = 0; c < 3; c++) {
        const uint8_t *corner = leaf->corner + (size_t)c * leaf->row;
        x[c] = co_wide_lookup16(points->x, corner, i);
        y[c] = co_wide_lookup16(points->y, corner, i);
    }
    CoWide *edge = out->edge;
    for (int c = 0; c < 3; c++) {
        int p = (c + 2) % 3, q = (c + 1) % 3;
        edge[c] = co_wide_sub(co_wide_mul(x[p], y[q]), co_wide_mul(y[p], x[q]));
    }
    CoWide least = co_wide_min(co_wide_min(edge[0], edge[1]), edge[2]);
    CoWide most = co_wide_max(co_wide_max(edge[0], edge[1]), edge[2]);
    CoWideMask mixed = co_wide_and(co_wide_lt(least, zero), co_wide_lt(zero, most));
    return ~co_wide_bits(mixed) & ((1u << CO_WIDE_WIDTH) - 1u);
}

// t, u, v of triangles i and up. Returns those that are not unsure.
static inline uint32_t place_hits(const CoTriLeaf *leaf, uint32_t i, const Shear *shear,
                                  const LeafEdges *edges, LeafHits *out)
{
    const CoWide zero = co_wide_set1(0.0f), *edge = edges->edge;
    CoWide det = co_wide_add(co_wide_add(edge[0], edge[1]), edge[2]);
    CoWide size = co_wide_abs(det);
    CoWideMask sure =
        co_wide_and(co_wide_lt(co_wide_set1(1e-30f), size), co_wide_lt(size, co_wide_set1(1e30f)));
    for (int c = 0; c < 3; c++)
        sure = co_wide_and(sure, co_wide_ne(edge[c], zero));
    CoWide inv = co_wide_div(co_wide_set1(1.0f), det), t = zero, weight[3];
    for (int c = 0; c < 3; c++) {
        weight[c] = co_wide_mul(edge[c], inv);
        CoWide z = co_wide_lookup16(out->z, leaf->corner + (size_t)c * leaf->row, i);
        t = co_wide_add(t, co_wide_mul(weight[c], z));
    }
    co_wide_store(out->t + i, co_wide_mul(t, co_wide_set1(shear->sz)));
    co_wide_store(out->u + i, weight[1]);
    co_wide_store(out->v + i, weight[2]);
    return co_wide_bits(sure);
}

// Returns one bit per triangle whose line is pierced or may be; fills t, u, v for those not unsure.
// The points are sheared. Wide vectors all at once, however many triangles there are: no branch is
// taken on what cannot be guessed.
static inline uint32_t pierce_triangles(const CoTriLeaf *leaf, const Shear *shear, uint32_t count,
                                        LeafHits *out)
{
    LeafEdges edges[POINT_VECTORS];
    const uint32_t most = CO_WIDE_WIDTH < 8 ? count : CO_LEAF_WIDTH;
    uint32_t pierced = 0;
    for (uint32_t i = 0; i < most; i += CO_WIDE_WIDTH)
        pierced |= edges_of(leaf, i, out, &edges[i / CO_WIDE_WIDTH]) << i;
    pierced &= (2u << (count - 1)) - 1u;
    out->unsure = 0;
    if (!pierced)
        return 0;
    for (uint32_t i = 0; i < most; i += CO_WIDE_WIDTH) {
        uint32_t bits = pierced >> i & ((1u << CO_WIDE_WIDTH) - 1u);
        if (bits)
            out->unsure |= (bits & ~place_hits(leaf, i, shear, &edges[i / CO_WIDE_WIDTH], out))
                           << i;
    }
    return pierced;
}

// The same for one triangle in double, from its float sheared corners. False when it is missed or
// has no area along the ray.
static inline bool pierce_exactly(const float corner[3][3], float sz, float *t, float *u, float *v)
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
    *t = (float)(sum * (double)sz);
    *u = (float)(edge[1] / det);
    *v = (float)(edge[2] / det);
    return true;
}

static inline bool pierce_lane(const CoTriLeaf *leaf, const Shear *shear, uint32_t i,
                               LeafHits *hits)
{
    float corner[3][3];
    const float *x = (const float *)hits->x, *y = (const float *)hits->y;
    const float *z = (const float *)hits->z;
    for (uint32_t c = 0; c < 3; c++) {
        uint32_t point = co_leaf_corner(leaf, c, i);
        corner[0][c] = x[point];
        corner[1][c] = y[point];
        corner[2][c] = z[point];
    }
    return pierce_exactly((const float(*)[3])corner, shear->sz, &hits->t[i], &hits->u[i],
                          &hits->v[i]);
}

// Clamps t into the triangle's own box and the boxes of the instances on the way. False when the
// line is not in them at all.
static inline bool clamp_hit(const CoTriLeaf *leaf, const Ray *ray, uint32_t i, float *t)
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
    *t = float_max(float_min(*t, to), from);
    return true;
}

#endif
