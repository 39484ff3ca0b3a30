// Rays of a group in the space of one object or group, ready for slab tests: the same as
// one_ray.h has for one ray, by the same arithmetic in lanes.

#ifndef CO_ACCEL_KERNELS_RAYS_H
#define CO_ACCEL_KERNELS_RAYS_H

#include "accel/kernels/triangle.h"

enum {
    CO_GROUP_RAYS = 64,
    CO_RAYS_ROOM = CO_GROUP_RAYS + 16 // whole vectors are stored behind the last ray
};

typedef struct Rays {
    _Alignas(64) float org[3][CO_RAYS_ROOM];
    float dir[3][CO_RAYS_ROOM];
    float inv[3][CO_RAYS_ROOM];                            // 1 / dir, finite and never 0
    float near_c[3][CO_RAYS_ROOM], far_c[3][CO_RAYS_ROOM]; // of a node's slabs
    float pad[CO_RAYS_ROOM];                               // of the canonical slabs
    float entry[CO_RAYS_ROOM], exit[CO_RAYS_ROOM];      // of the instances' boxes on the way here
    float from[CO_RAYS_ROOM], to[CO_RAYS_ROOM];         // where hits may lie, as far as is known
    float shear_x[CO_RAYS_ROOM], shear_y[CO_RAYS_ROOM]; // see triangle.h
    uint32_t major[CO_RAYS_ROOM];                       // axis of the largest direction component
    uint8_t slot[CO_GROUP_RAYS];                        // which ray of the group
    uint8_t outer[CO_GROUP_RAYS]; // its place among the rays it was taken from
    uint64_t negative[3];         // rays whose direction is, by axis
    uint64_t along[3];            // rays by major axis
    uint64_t huge; // rays for which a node's slabs may overflow: children are to be looked at
    uint64_t done; // rays that need no more
    uint32_t count;
} Rays;

// Repeats the last ray so that whole vectors can be worked on: one vector's worth behind it, which
// stored at once can be loaded at once.
static inline void rays_pad(Rays *rays)
{
    uint32_t last = rays->count - 1;
    if (rays->count % CO_WIDE_WIDTH == 0)
        return;
    for (int k = 0; k < 3; k++) {
        co_wide_store(rays->org[k] + last, co_wide_set1(rays->org[k][last]));
        co_wide_store(rays->dir[k] + last, co_wide_set1(rays->dir[k][last]));
    }
    co_wide_store(rays->exit + last, co_wide_set1(rays->exit[last]));
    co_wide_store(rays->to + last, co_wide_set1(rays->to[last]));
    co_wide_store(rays->from + last, co_wide_set1(rays->from[last]));
}

// Takes rays into an instance's space: org and dir, the latter not normalised, so that t is shared.
static inline void rays_transform(Rays *rays, const CoAffine *to_object)
{
    for (uint32_t j = 0; j < rays->count; j += CO_LANE_WIDTH) {
        CoLane org[3], dir[3];
        for (int k = 0; k < 3; k++) {
            org[k] = co_lane_load(rays->org[k] + j);
            dir[k] = co_lane_load(rays->dir[k] + j);
        }
        for (int r = 0; r < 3; r++) {
            CoLane m[4];
            for (int k = 0; k < 4; k++)
                m[k] = co_lane_set1(to_object->m[r][k]);
            CoLane p =
                co_lane_add(co_lane_add(co_lane_mul(m[0], org[0]), co_lane_mul(m[1], org[1])),
                            co_lane_mul(m[2], org[2]));
            CoLane d =
                co_lane_add(co_lane_add(co_lane_mul(m[0], dir[0]), co_lane_mul(m[1], dir[1])),
                            co_lane_mul(m[2], dir[2]));
            co_lane_store(rays->org[r] + j, co_lane_add(p, m[3]));
            co_lane_store(rays->dir[r] + j, d);
        }
    }
}

// Constants of one axis, see ray_prepare. Returns lanes whose nodes may overflow.
static inline uint32_t prepare_axis(Rays *rays, int k, uint32_t j, CoLane org, CoLane d, CoLane pad,
                                    CoLane distance)
{
    CoLane size = co_lane_abs(org), inv = co_lane_div(co_lane_set1(1.0f), d);
    CoLane shift = co_lane_add(pad, co_lane_mul(size, co_lane_set1(0x1p-23f)));
    CoLane reach = co_lane_add(distance, size);
    shift = co_lane_add(shift, co_lane_mul(reach, co_lane_set1(0x1p-21f)));
    shift = co_lane_copysign(shift, d);
    CoLane minus = co_lane_sub(co_lane_set1(0.0f), inv);
    CoLane near_c = co_lane_mul(co_lane_add(org, shift), minus);
    CoLane far_c = co_lane_mul(co_lane_sub(org, shift), minus);
    CoLaneMask is_safe = co_lane_lt(co_lane_mul(reach, co_lane_abs(inv)), co_lane_set1(0x1p125f));
    CoLane nan = co_lane_set1(__builtin_nanf(""));
    co_lane_store(rays->inv[k] + j, inv);
    co_lane_store(rays->near_c[k] + j, co_lane_select(is_safe, near_c, nan));
    co_lane_store(rays->far_c[k] + j, co_lane_select(is_safe, far_c, nan));
    rays->negative[k] |= (uint64_t)co_lane_bits(co_lane_lt(d, co_lane_set1(0.0f))) << j;
    return ~co_lane_bits(is_safe) & ((1u << CO_LANE_WIDTH) - 1u);
}

// Slopes of the ray along its major axis, by what the triangle test calls x and y.
static inline void prepare_shear(Rays *rays, uint32_t j, const CoLane dir[3])
{
    CoLane ax = co_lane_abs(dir[0]), ay = co_lane_abs(dir[1]), az = co_lane_abs(dir[2]);
    CoLaneMask x_over_y = co_lane_lt(ay, ax), y_over_z = co_lane_lt(az, ay);
    CoLaneMask x_first = co_lane_and(x_over_y, co_lane_lt(az, ax));
    uint32_t is_x = co_lane_bits(x_first);
    uint32_t is_y = co_lane_bits(y_over_z) & ~co_lane_bits(x_over_y);
    CoLane z = co_lane_select(y_over_z, dir[1], dir[2]);
    CoLane x = co_lane_select(y_over_z, dir[2], dir[0]);
    CoLane y = co_lane_select(y_over_z, dir[0], dir[1]);
    z = co_lane_select(x_first, dir[0], z);
    x = co_lane_select(x_first, dir[1], x);
    y = co_lane_select(x_first, dir[2], y);
    co_lane_store(rays->shear_x + j, co_lane_div(x, z));
    co_lane_store(rays->shear_y + j, co_lane_div(y, z));
    for (uint32_t i = 0; i < CO_LANE_WIDTH; i++)
        rays->major[j + i] = is_x >> i & 1u ? 0 : is_y >> i & 1u ? 1 : 2;
    rays->along[0] |= (uint64_t)is_x << j;
    rays->along[1] |= (uint64_t)is_y << j;
}

// As ray_prepare.
static inline void rays_prepare(Rays *rays, const CoBox *box, float relative)
{
    CoLane base = co_lane_set1(0x1p-20f + relative), from_org = co_lane_set1(relative);
    for (int k = 0; k < 3; k++)
        rays->negative[k] = rays->along[k] = 0;
    rays->huge = rays->done = 0;
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
        pad = co_lane_add(pad, co_lane_set1(CO_LEAST_SLACK));
        co_lane_store(rays->pad + j, pad);
        pad = co_lane_add(pad, co_lane_set1(CO_LEAST_SLACK)); // nodes round once more
        uint32_t huge = 0;
        for (int k = 0; k < 3; k++) {
            CoLaneMask is_tiny = co_lane_lt(co_lane_abs(dir[k]), tiny);
            CoLane d = co_lane_select(is_tiny, co_lane_copysign(tiny, dir[k]), dir[k]);
            huge |= prepare_axis(rays, k, j, org[k], d, pad, distance);
        }
        rays->huge |= (uint64_t)huge << j;
        prepare_shear(rays, j, dir);
        CoLane unfit = co_lane_set1(-INFINITE);
        co_lane_store(rays->exit + j, co_lane_select(is_fit, co_lane_load(rays->exit + j), unfit));
        co_lane_store(rays->to + j, co_lane_select(is_fit, co_lane_load(rays->to + j), unfit));
    }
    rays->along[2] = ~(rays->along[0] | rays->along[1]);
}

// Ray j on its own.
static inline void rays_single(const Rays *rays, uint32_t j, Ray *out)
{
#define THREE(field) ((CoFour){rays->field[0][j], rays->field[1][j], rays->field[2][j], 0.0f})
    out->org = THREE(org);
    out->dir = THREE(dir);
    out->inv = THREE(inv);
    out->near_c = THREE(near_c);
    out->far_c = THREE(far_c);
#undef THREE
    out->pad = rays->pad[j];
    out->entry = rays->entry[j];
    out->exit = rays->exit[j];
    out->from = rays->from[j];
    out->to = rays->to[j];
    out->shear_x = rays->shear_x[j];
    out->shear_y = rays->shear_y[j];
    out->major = rays->major[j];
    for (uint32_t k = 0; k < 3; k++)
        out->near_row[k] = 2 * k + (uint32_t)(rays->negative[k] >> j & 1u);
    out->slot = rays->slot[j];
    out->is_huge = rays->huge >> j & 1u;
}

// Ray j as the triangle test needs it.
static inline void rays_shear(const Rays *rays, uint32_t j, Shear *out)
{
    uint32_t z = rays->major[j], x = z == 2 ? 0 : z + 1, y = x == 2 ? 0 : x + 1;
    *out = (Shear){x, y, z, {rays->org[x][j], rays->org[y][j], rays->org[z][j]},
                   rays->shear_x[j], rays->shear_y[j], rays->inv[z][j]};
}

// What became of it.
static inline void rays_settle(Rays *rays, uint32_t j, float best)
{
    rays->to[j] = float_min(rays->to[j], best);
    if (best == -INFINITE)
        rays->done |= 1ull << j;
}

#endif
