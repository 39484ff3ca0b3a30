// The traversal with a plain triangle test in place of triangle.h's, to tell what exact edges and
// canonical distances cost; for rays one by one. PLAIN_MOELLER 1: Moeller, Trumbore 1997. 0: the
// same test without doubles where an edge function is 0. Neither clamps distances.

#include "plain_kernel.h"

#include "accel/kernels/triangle.h"

#define clamp_hit(leaf, ray, i, at) ((void)(leaf), true)
#define place_hit plain_place

#if PLAIN_MOELLER

#define co_accel_traverse bench_moeller
#define pierce_triangles plain_pierce
#define shear_points plain_points
#define shear_rows(leaf, points, shear, out) ((void)(points), plain_points(leaf, shear, out))

static inline CoWide dot_lanes(const CoWide a[3], const CoWide b[3])
{
    return co_wide_add(co_wide_add(co_wide_mul(a[0], b[0]), co_wide_mul(a[1], b[1])),
                       co_wide_mul(a[2], b[2]));
}

static inline void cross_lanes(const CoWide a[3], const CoWide b[3], CoWide out[3])
{
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        out[k] = co_wide_sub(co_wide_mul(a[i], b[j]), co_wide_mul(a[j], b[i]));
    }
}

// As seen from the ray's origin, in the order of axes of the shear; its slopes stand where hits
// will.
static inline void plain_points(const CoTriLeaf *leaf, const Shear *shear, LeafHits *out)
{
    const uint32_t axes[3] = {shear->x, shear->y, shear->z};
    CoWide *const to[3] = {out->x, out->y, out->z};
    for (uint32_t k = 0; k < 3; k++)
        for (uint32_t i = 0; i < POINT_VECTORS; i++)
            to[k][i] = co_wide_sub(co_wide_load(leaf->points[axes[k]] + i * CO_WIDE_WIDTH),
                                   co_wide_set1(shear->org[k]));
    out->edge[0][0] = co_wide_set1(shear->sx);
    out->edge[1][0] = co_wide_set1(shear->sy);
}

// Along (sx, sy, 1), whose distances are the ray's over sz; t, u, v take the place of edges.
static inline uint32_t plain_pierce(const CoTriLeaf *leaf, uint32_t count, LeafHits *out)
{
    const CoWide zero = co_wide_set1(0.0f), one = co_wide_set1(1.0f);
    const CoWide dir[3] = {out->edge[0][0], out->edge[1][0], one};
    const CoWide *const points[3] = {out->x, out->y, out->z};
    uint32_t pierced = 0;
    for (uint32_t i = 0; i < count; i += CO_WIDE_WIDTH) {
        CoWide e1[3], e2[3], from[3], p[3], q[3];
        for (int k = 0; k < 3; k++) {
            CoWide at[3];
            for (size_t c = 0; c < 3; c++)
                at[c] = co_wide_lookup16(points[k], leaf->corner + c * leaf->row, i);
            e1[k] = co_wide_sub(at[1], at[0]);
            e2[k] = co_wide_sub(at[2], at[0]);
            from[k] = co_wide_sub(zero, at[0]);
        }
        cross_lanes(dir, e2, p);
        cross_lanes(from, e1, q);
        CoWide inv = co_wide_div(one, dot_lanes(e1, p));
        CoWide u = co_wide_mul(dot_lanes(from, p), inv), v = co_wide_mul(dot_lanes(dir, q), inv);
        CoWideMask in = co_wide_and(co_wide_le(zero, u), co_wide_le(zero, v));
        uint32_t bits = co_wide_bits(co_wide_and(in, co_wide_le(co_wide_add(u, v), one)));
        out->edge[0][i / CO_WIDE_WIDTH] = co_wide_mul(dot_lanes(e2, q), inv);
        out->edge[1][i / CO_WIDE_WIDTH] = u;
        out->edge[2][i / CO_WIDE_WIDTH] = v;
        pierced |= bits << i;
    }
    return pierced & ((2u << (count - 1)) - 1u);
}

static inline bool plain_place(const CoTriLeaf *leaf, const Shear *shear, uint32_t i,
                               const LeafHits *hits, float from, float to, bool is_flat, Place *out)
{
    (void)is_flat;
    (void)leaf;
    out->t = out->most = ((const float *)hits->edge[0])[i] * shear->sz;
    out->u = ((const float *)hits->edge[1])[i];
    out->v = ((const float *)hits->edge[2])[i];
    return out->t > from && out->t <= to;
}

#else

#define co_accel_traverse bench_inexact

static inline bool plain_place(const CoTriLeaf *leaf, const Shear *shear, uint32_t i,
                               const LeafHits *hits, float from, float to, bool is_flat, Place *out)
{
    (void)is_flat;
    float edge[3], sum = 0.0f;
    for (int c = 0; c < 3; c++)
        edge[c] = ((const float *)hits->edge[c])[i];
    float inv = 1.0f / (edge[0] + edge[1] + edge[2]);
    for (uint32_t c = 0; c < 3; c++) {
        edge[c] *= inv;
        sum += edge[c] * ((const float *)hits->z)[co_leaf_corner(leaf, c, i)];
    }
    out->t = out->most = sum * shear->sz;
    out->u = edge[1];
    out->v = edge[2];
    return out->t > from && out->t <= to;
}

#endif

#include "accel/kernels/traverse.c"
