// Rays of a group in the space of one object or group, ready for slab tests.
//
// Slabs are canonical and conservative. A plane's distance is (plane - org') * inv with org' moved
// against (near planes) or along (far planes) the direction by a padding that covers the rounding
// of the triangle test, of the instance transforms and of the slab arithmetic itself (see
// rays_prepare). Both roundings are monotone in the plane, so a box inside another never starts
// before it or ends after it: no tree can cull what the triangle's own box lets pass.

#ifndef CO_ACCEL_KERNELS_RAYS_H
#define CO_ACCEL_KERNELS_RAYS_H

#include "accel/node.h"
#include "simd/lane.h"

enum {
    CO_GROUP_RAYS = 64
};

// What a ray in object space may be off by, in group space, in units of its origin's largest
// coordinate and of the distance to the far side of the group: less than 40 roundings of 2^-24.
#define CO_TRANSFORM_SLACK 0x1p-18f

typedef struct Rays {
    float org[3][CO_GROUP_RAYS], dir[3][CO_GROUP_RAYS];
    float inv[3][CO_GROUP_RAYS]; // 1 / dir, finite and never 0
    float near_org[3][CO_GROUP_RAYS], far_org[3][CO_GROUP_RAYS];
    float entry[CO_GROUP_RAYS], exit[CO_GROUP_RAYS]; // of the instances' boxes on the way here
    uint8_t slot[CO_GROUP_RAYS];                     // which ray of the group
    uint32_t count;
} Rays;

// One ray's slab constants, one value in all lanes.
typedef struct Slab {
    CoLane inv[3], near_org[3], far_org[3];
    uint32_t near_row[3]; // rows of CoWideNode.planes; the far one is near_row ^ 1
} Slab;

static inline Slab slab_load(const Rays *rays, uint32_t j)
{
    Slab slab;
    for (uint32_t k = 0; k < 3; k++) {
        slab.inv[k] = co_lane_set1(rays->inv[k][j]);
        slab.near_org[k] = co_lane_set1(rays->near_org[k][j]);
        slab.far_org[k] = co_lane_set1(rays->far_org[k][j]);
        slab.near_row[k] = 2 * k + (rays->inv[k][j] < 0.0f);
    }
    return slab;
}

// Tests the 8 children of a node over [from, to]. Returns one bit per child that is entered and
// where.
static inline uint32_t slab_node(const CoWideNode *node, const Slab *slab, CoLane from, CoLane to,
                                 float entry[CO_NODE_WIDTH])
{
    uint32_t bits = 0;
    for (int i = 0; i < CO_NODE_WIDTH; i += CO_LANE_WIDTH) {
        CoLane near = from, far = to;
        for (int k = 0; k < 3; k++) {
            CoLane near_plane = co_lane_load(node->planes[slab->near_row[k]] + i);
            CoLane far_plane = co_lane_load(node->planes[slab->near_row[k] ^ 1u] + i);
            near_plane = co_lane_mul(co_lane_sub(near_plane, slab->near_org[k]), slab->inv[k]);
            far_plane = co_lane_mul(co_lane_sub(far_plane, slab->far_org[k]), slab->inv[k]);
            near = co_lane_max(near_plane, near);
            far = co_lane_min(far_plane, far);
        }
        co_lane_store(entry + i, near);
        bits |= co_lane_bits(co_lane_le(near, far)) << i;
    }
    return bits;
}

static inline float float_min(float a, float b)
{
    return a < b ? a : b;
}

static inline float float_max(float a, float b)
{
    return a > b ? a : b;
}

// Narrows [*from, *to] to a single box by the same arithmetic. False when nothing is left.
static inline bool slab_box(const Rays *rays, uint32_t j, const float lo[3], const float hi[3],
                            float *from, float *to)
{
    float near = *from, far = *to;
    for (int k = 0; k < 3; k++) {
        float inv = rays->inv[k][j];
        float near_plane = inv < 0.0f ? hi[k] : lo[k], far_plane = inv < 0.0f ? lo[k] : hi[k];
        near = float_max((near_plane - rays->near_org[k][j]) * inv, near);
        far = float_min((far_plane - rays->far_org[k][j]) * inv, far);
    }
    *from = near;
    *to = far;
    return near <= far;
}

// Repeats the last ray so that whole vectors can be worked on.
static inline void rays_pad(Rays *rays)
{
    for (uint32_t j = rays->count; j % CO_LANE_WIDTH != 0; j++) {
        for (int k = 0; k < 3; k++) {
            rays->org[k][j] = rays->org[k][j - 1];
            rays->dir[k][j] = rays->dir[k][j - 1];
        }
        rays->exit[j] = rays->exit[j - 1];
    }
}

// Takes rays into an instance's space: org and dir, the latter not normalised, so that t is shared.
static inline void rays_transform(Rays *rays, const CoAffine *to_object)
{
    CoLane m[3][4];
    for (int r = 0; r < 3; r++)
        for (int k = 0; k < 4; k++)
            m[r][k] = co_lane_set1(to_object->m[r][k]);
    for (uint32_t j = 0; j < rays->count; j += CO_LANE_WIDTH) {
        CoLane org[3], dir[3];
        for (int k = 0; k < 3; k++) {
            org[k] = co_lane_load(rays->org[k] + j);
            dir[k] = co_lane_load(rays->dir[k] + j);
        }
        for (int r = 0; r < 3; r++) {
            CoLane p =
                co_lane_add(co_lane_add(co_lane_mul(m[r][0], org[0]), co_lane_mul(m[r][1], org[1])),
                            co_lane_mul(m[r][2], org[2]));
            CoLane d =
                co_lane_add(co_lane_add(co_lane_mul(m[r][0], dir[0]), co_lane_mul(m[r][1], dir[1])),
                            co_lane_mul(m[r][2], dir[2]));
            co_lane_store(rays->org[r] + j, co_lane_add(p, m[r][3]));
            co_lane_store(rays->dir[r] + j, d);
        }
    }
}

// Derives the slab constants for what lies in `box`. The padding is, in units of the largest
// distance D from the origin to a plane of the box: 6 x 2^-24 for the shear (a point is off by 2 D
// + 4 D units), 3 for the slab's own three roundings, rounded up to 16; plus two units of the
// origin's coordinate, so that adding it is never lost. `relative` adds what the transforms of
// instances below may be off by, in units of D and of the origin. Directions below 1e-18 of the
// largest component are taken as that: the padding keeps planes far enough that such a ray still
// passes all boxes which it touches.
static inline void rays_prepare(Rays *rays, const CoBox *box, float relative)
{
    CoLane base = co_lane_set1(0x1p-20f + relative), from_org = co_lane_set1(relative);
    for (uint32_t j = 0; j < rays->count; j += CO_LANE_WIDTH) {
        CoLane org[3], dir[3], distance = co_lane_set1(0.0f);
        CoLane largest_org = distance, largest_dir = distance;
        // What a transform made infinite or zero hits nothing.
        CoLaneMask is_fit = co_lane_le(distance, distance);
        for (int k = 0; k < 3; k++) {
            org[k] = co_lane_load(rays->org[k] + j);
            dir[k] = co_lane_load(rays->dir[k] + j);
            distance = co_lane_max(co_lane_sub(org[k], co_lane_set1(box->lo[k])), distance);
            distance = co_lane_max(co_lane_sub(co_lane_set1(box->hi[k]), org[k]), distance);
            largest_org = co_lane_max(co_lane_abs(org[k]), largest_org);
            largest_dir = co_lane_max(co_lane_abs(dir[k]), largest_dir);
            is_fit = co_lane_and(is_fit, co_lane_lt(co_lane_abs(org[k]), co_lane_set1(3e38f)));
            is_fit = co_lane_and(is_fit, co_lane_lt(co_lane_abs(dir[k]), co_lane_set1(1e37f)));
        }
        is_fit = co_lane_and(is_fit, co_lane_lt(co_lane_set1(1e-18f), largest_dir));
        distance = co_lane_min(distance, co_lane_set1(3e38f));
        CoLane pad = co_lane_add(co_lane_mul(distance, base), co_lane_mul(largest_org, from_org));
        CoLane tiny = co_lane_mul(largest_dir, co_lane_set1(1e-18f));
        for (int k = 0; k < 3; k++) {
            CoLaneMask is_tiny = co_lane_lt(co_lane_abs(dir[k]), tiny);
            CoLane d = co_lane_select(is_tiny, co_lane_copysign(tiny, dir[k]), dir[k]);
            CoLane own = co_lane_mul(co_lane_abs(org[k]), co_lane_set1(0x1p-23f));
            CoLane shift = co_lane_copysign(co_lane_add(pad, own), dir[k]);
            co_lane_store(rays->inv[k] + j, co_lane_div(co_lane_set1(1.0f), d));
            co_lane_store(rays->near_org[k] + j, co_lane_add(org[k], shift));
            co_lane_store(rays->far_org[k] + j, co_lane_sub(org[k], shift));
        }
        CoLane exit = co_lane_load(rays->exit + j);
        exit = co_lane_select(is_fit, exit, co_lane_set1(-__builtin_inff()));
        co_lane_store(rays->exit + j, exit);
    }
}

#endif
