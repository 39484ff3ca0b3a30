// The traversal with a plain triangle test in place of triangle.h's, to tell what exact edges and
// canonical distances cost; for rays one by one. PLAIN_MOELLER 1: Moeller, Trumbore 1997. 0: the
// same test without doubles where an edge function is 0. Neither clamps distances.

#include "plain_kernel.h"

#include "accel/kernels/triangle.h"

#define clamp_hit(leaf, ray, i, t) ((void)(leaf), true)

#if PLAIN_MOELLER

#define co_accel_traverse bench_moeller
#define pierce_triangles plain_pierce
#define shear_points(leaf, shear, count, hits) ((void)(shear))

static inline CoLane dot_lanes(const CoLane a[3], const CoLane b[3])
{
    return co_lane_add(co_lane_add(co_lane_mul(a[0], b[0]), co_lane_mul(a[1], b[1])),
                       co_lane_mul(a[2], b[2]));
}

static inline void cross_lanes(const CoLane a[3], const CoLane b[3], CoLane out[3])
{
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        out[k] = co_lane_sub(co_lane_mul(a[i], b[j]), co_lane_mul(a[j], b[i]));
    }
}

// In the order of axes of the shear, along (sx, sy, 1), whose distances are the ray's over sz.
static inline uint32_t plain_pierce(const CoTriLeaf *leaf, const Shear *shear, uint32_t count,
                                    LeafHits *out)
{
    const CoLane zero = co_lane_set1(0.0f), one = co_lane_set1(1.0f);
    const uint32_t axes[3] = {shear->x, shear->y, shear->z};
    const CoLane dir[3] = {co_lane_set1(shear->sx), co_lane_set1(shear->sy), one};
    uint32_t pierced = 0;
    out->unsure = 0;
    for (uint32_t i = 0; i < count; i += CO_LANE_WIDTH) {
        CoLane e1[3], e2[3], from[3], p[3], q[3];
        for (int k = 0; k < 3; k++) {
            CoLane at[3];
            for (int c = 0; c < 3; c++)
                at[c] = co_lane_lookup8(leaf->points[axes[k]] + leaf->base[c], leaf->corner[c] + i);
            e1[k] = co_lane_sub(at[1], at[0]);
            e2[k] = co_lane_sub(at[2], at[0]);
            from[k] = co_lane_sub(co_lane_set1(shear->org[k]), at[0]);
        }
        cross_lanes(dir, e2, p);
        cross_lanes(from, e1, q);
        CoLane inv = co_lane_div(one, dot_lanes(e1, p));
        CoLane u = co_lane_mul(dot_lanes(from, p), inv), v = co_lane_mul(dot_lanes(dir, q), inv);
        CoLaneMask in = co_lane_and(co_lane_le(zero, u), co_lane_le(zero, v));
        uint32_t bits = co_lane_bits(co_lane_and(in, co_lane_le(co_lane_add(u, v), one)));
        bits &= (1u << (count - i < CO_LEAF_WIDTH ? count - i : CO_LEAF_WIDTH)) - 1u;
        if (!bits)
            continue;
        CoLane t = co_lane_mul(dot_lanes(e2, q), inv);
        co_lane_store(out->t + i, co_lane_mul(t, co_lane_set1(shear->sz)));
        co_lane_store(out->u + i, u);
        co_lane_store(out->v + i, v);
        pierced |= bits << i;
    }
    return pierced;
}

#else

#define co_accel_traverse bench_inexact
#define pierce_lane(leaf, shear, i, hits) ((void)(shear), true)

#endif

#include "accel/kernels/traverse.c"
