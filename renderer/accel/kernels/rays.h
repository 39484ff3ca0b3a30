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
    // Of the nodes of meshes that stand in a group as they are, where others do not.
    float near_tight[3][CO_RAYS_ROOM], far_tight[3][CO_RAYS_ROOM];
    float pad[CO_RAYS_ROOM];                       // of the canonical slabs
    float placed_pad[CO_RAYS_ROOM];                // the same, of the mesh in place that is walked
    float entry[CO_RAYS_ROOM], exit[CO_RAYS_ROOM]; // of the instances' boxes on the way here
    float from[CO_RAYS_ROOM], to[CO_RAYS_ROOM];    // where hits may lie, as far as is known
    float shear_org[3][CO_RAYS_ROOM];              // what a triangle test takes, see triangle.h
    float shear_x[CO_RAYS_ROOM], shear_y[CO_RAYS_ROOM], shear_z[CO_RAYS_ROOM];
    uint8_t slot[CO_GROUP_RAYS];  // which ray of the group
    uint8_t outer[CO_GROUP_RAYS]; // its place among the rays it was taken from
    uint64_t negative[3];         // rays whose direction is, by axis
    uint64_t along[3];            // rays by major axis
    uint64_t huge; // rays for which a node's slabs may overflow: children are to be looked at
    uint64_t signed_zero; // in a group: rays that even the transform which is none may change
    uint64_t done;        // rays that need no more
    uint64_t nearer;      // rays whose `to` has changed since somebody asked
    uint32_t count;
    bool is_in_order; // each stands in its slot
    bool is_tight;    // slabs of nodes are padded for meshes that stand where they are
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
    for (uint32_t j = 0; j < rays->count; j += CO_WIDE_WIDTH) {
        CoWide org[3], dir[3];
        for (int k = 0; k < 3; k++) {
            org[k] = co_wide_load(rays->org[k] + j);
            dir[k] = co_wide_load(rays->dir[k] + j);
        }
        for (int r = 0; r < 3; r++) {
            CoWide m[4];
            for (int k = 0; k < 4; k++)
                m[k] = co_wide_set1(to_object->m[r][k]);
            CoWide p =
                co_wide_add(co_wide_add(co_wide_mul(m[0], org[0]), co_wide_mul(m[1], org[1])),
                            co_wide_mul(m[2], org[2]));
            CoWide d =
                co_wide_add(co_wide_add(co_wide_mul(m[0], dir[0]), co_wide_mul(m[1], dir[1])),
                            co_wide_mul(m[2], dir[2]));
            co_wide_store(rays->org[r] + j, co_wide_add(p, m[3]));
            co_wide_store(rays->dir[r] + j, d);
        }
    }
}

// Slabs of one axis, see ray_set_origin; `is_safe` tells where they do not overflow.
static inline void prepare_slabs(CoWide org, CoWide inv, CoWide shift, CoWideMask is_safe,
                                 float *near_c, float *far_c)
{
    const CoWide nan = co_wide_set1(__builtin_nanf(""));
    CoWide minus = co_wide_sub(co_wide_set1(0.0f), inv);
    shift = co_wide_copysign(shift, inv);
    CoWide near = co_wide_mul(co_wide_add(org, shift), minus);
    CoWide far = co_wide_mul(co_wide_sub(org, shift), minus);
    co_wide_store(near_c, co_wide_select(is_safe, near, nan));
    co_wide_store(far_c, co_wide_select(is_safe, far, nan));
}

// Constants of one axis, see ray_set_origin. pads: of nodes, and of those of meshes that stand as
// they are. Returns lanes whose nodes may overflow.
static inline uint32_t prepare_axis(Rays *rays, int k, uint32_t j, CoWide org, CoWide d,
                                    const CoWide pads[2], CoWide distance, bool is_group)
{
    CoWide size = co_wide_abs(org), inv = co_wide_div(co_wide_set1(1.0f), d);
    CoWide reach = co_wide_add(distance, size);
    CoWide rounding = co_wide_add(co_wide_mul(size, co_wide_set1(0x1p-23f)),
                                  co_wide_mul(reach, co_wide_set1(0x1p-21f)));
    CoWideMask is_safe = co_wide_lt(co_wide_mul(reach, co_wide_abs(inv)), co_wide_set1(0x1p125f));
    co_wide_store(rays->inv[k] + j, inv);
    prepare_slabs(org, inv, co_wide_add(pads[0], rounding), is_safe, rays->near_c[k] + j,
                  rays->far_c[k] + j);
    if (is_group)
        prepare_slabs(org, inv, co_wide_add(pads[1], rounding), is_safe, rays->near_tight[k] + j,
                      rays->far_tight[k] + j);
    rays->negative[k] |= (uint64_t)co_wide_bits(co_wide_lt(d, co_wide_set1(0.0f))) << j;
    return ~co_wide_bits(is_safe) & ((1u << CO_WIDE_WIDTH) - 1u);
}

// Slopes of the ray along its major axis and its origin, by what the triangle test calls x, y and
// z.
static inline void prepare_shear(Rays *rays, uint32_t j, const CoWide org[3], const CoWide dir[3])
{
    CoWide ax = co_wide_abs(dir[0]), ay = co_wide_abs(dir[1]), az = co_wide_abs(dir[2]);
    CoWideMask x_over_y = co_wide_lt(ay, ax), y_over_z = co_wide_lt(az, ay);
    CoWideMask x_first = co_wide_and(x_over_y, co_wide_lt(az, ax));
    uint32_t is_x = co_wide_bits(x_first);
    uint32_t is_y = co_wide_bits(y_over_z) & ~co_wide_bits(x_over_y);
    CoWide z = co_wide_select(y_over_z, dir[1], dir[2]);
    CoWide x = co_wide_select(y_over_z, dir[2], dir[0]);
    CoWide y = co_wide_select(y_over_z, dir[0], dir[1]);
    z = co_wide_select(x_first, dir[0], z);
    x = co_wide_select(x_first, dir[1], x);
    y = co_wide_select(x_first, dir[2], y);
    CoWide inv = co_wide_load(rays->inv[2] + j);
    inv = co_wide_select(y_over_z, co_wide_load(rays->inv[1] + j), inv);
    co_wide_store(rays->shear_z + j, co_wide_select(x_first, co_wide_load(rays->inv[0] + j), inv));
    for (int k = 0; k < 3; k++) {
        CoWide a = co_wide_select(y_over_z, org[(k + 2) % 3], org[k]);
        co_wide_store(rays->shear_org[k] + j, co_wide_select(x_first, org[(k + 1) % 3], a));
    }
    co_wide_store(rays->shear_x + j, co_wide_div(x, z));
    co_wide_store(rays->shear_y + j, co_wide_div(y, z));
    rays->along[0] |= (uint64_t)is_x << j;
    rays->along[1] |= (uint64_t)is_y << j;
}

// Lanes that are -0.
static inline uint32_t negative_zeros(CoWide a)
{
    const CoWide zero = co_wide_set1(0.0f);
    CoWide sign = co_wide_copysign(co_wide_set1(1.0f), a);
    return co_wide_bits(co_wide_lt(sign, zero)) & ~co_wide_bits(co_wide_ne(a, zero));
}

// As ray_prepare.
static inline void rays_prepare(Rays *rays, const CoBox *box, float relative)
{
    CoWide base = co_wide_set1(0x1p-20f + relative), from_org = co_wide_set1(relative);
    for (int k = 0; k < 3; k++)
        rays->negative[k] = rays->along[k] = 0;
    rays->huge = rays->done = rays->nearer = rays->signed_zero = 0;
    for (uint32_t j = 0; j < rays->count; j += CO_WIDE_WIDTH) {
        CoWide org[3], dir[3], distance = co_wide_set1(0.0f);
        CoWide largest_org = distance, largest_dir = distance;
        // What a transform made infinite or zero hits nothing.
        CoWideMask is_fit = co_wide_le(distance, distance);
        for (int k = 0; k < 3; k++) {
            org[k] = co_wide_load(rays->org[k] + j);
            dir[k] = co_wide_load(rays->dir[k] + j);
            distance = co_wide_max(co_wide_sub(org[k], co_wide_set1(box->lo[k])), distance);
            distance = co_wide_max(co_wide_sub(co_wide_set1(box->hi[k]), org[k]), distance);
            largest_org = co_wide_max(co_wide_abs(org[k]), largest_org);
            largest_dir = co_wide_max(co_wide_abs(dir[k]), largest_dir);
            is_fit = co_wide_and(is_fit, co_wide_lt(co_wide_abs(org[k]), co_wide_set1(3e38f)));
            is_fit = co_wide_and(is_fit,
                                 co_wide_lt(co_wide_abs(dir[k]), co_wide_set1(CO_DIRECTION_MOST)));
        }
        is_fit = co_wide_and(is_fit, co_wide_lt(co_wide_set1(CO_DIRECTION_LEAST), largest_dir));
        distance = co_wide_min(distance, co_wide_set1(3e38f));
        CoWide pad = co_wide_add(co_wide_mul(distance, base), co_wide_mul(largest_org, from_org));
        CoWide tiny = co_wide_mul(largest_dir, co_wide_set1(1e-18f));
        tiny = co_wide_max(tiny, co_wide_set1(CO_COMPONENT_LEAST));
        pad = co_wide_add(pad, co_wide_set1(CO_LEAST_SLACK));
        co_wide_store(rays->pad + j, pad);
        // Nodes round once more.
        const CoWide least = co_wide_set1(CO_LEAST_SLACK);
        CoWide tight = co_wide_add(co_wide_mul(distance, co_wide_set1(0x1p-20f)), least);
        const CoWide pads[2] = {co_wide_add(pad, least), co_wide_add(tight, least)};
        uint32_t huge = 0;
        for (int k = 0; k < 3; k++) {
            CoWideMask is_tiny = co_wide_lt(co_wide_abs(dir[k]), tiny);
            CoWide d = co_wide_select(is_tiny, co_wide_copysign(tiny, dir[k]), dir[k]);
            huge |= prepare_axis(rays, k, j, org[k], d, pads, distance, relative > 0.0f);
        }
        rays->huge |= (uint64_t)huge << j;
        for (int k = 0; k < 3; k++)
            rays->signed_zero |= (uint64_t)(negative_zeros(org[k]) | negative_zeros(dir[k])) << j;
        prepare_shear(rays, j, org, dir);
        CoWide unfit = co_wide_set1(-INFINITE);
        co_wide_store(rays->exit + j, co_wide_select(is_fit, co_wide_load(rays->exit + j), unfit));
        co_wide_store(rays->to + j, co_wide_select(is_fit, co_wide_load(rays->to + j), unfit));
    }
    rays->along[2] = ~(rays->along[0] | rays->along[1]);
}

// Of the canonical slabs of a mesh's triangles, as `padding` has it.
static inline CoWide rays_padding(const Rays *rays, uint32_t j, const CoBox *box)
{
    CoWide distance = co_wide_set1(0.0f);
    for (int k = 0; k < 3; k++) {
        CoWide org = co_wide_load(rays->org[k] + j);
        distance = co_wide_max(co_wide_sub(org, co_wide_set1(box->lo[k])), distance);
        distance = co_wide_max(co_wide_sub(co_wide_set1(box->hi[k]), org), distance);
    }
    distance = co_wide_min(distance, co_wide_set1(3e38f));
    return co_wide_add(co_wide_mul(distance, co_wide_set1(0x1p-20f)), co_wide_set1(CO_LEAST_SLACK));
}

static inline uint32_t rays_major(const Rays *rays, uint32_t j)
{
    // Without a branch, as no axis is likelier than another; it cannot be along two.
    return 2 - 2 * (uint32_t)(rays->along[0] >> j & 1u) - (uint32_t)(rays->along[1] >> j & 1u);
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
    out->padded_for = NULL;
    out->pad = out->placed_pad = rays->pad[j];
    out->entry = rays->entry[j];
    out->exit = rays->exit[j];
    out->from = rays->from[j];
    out->to = rays->to[j];
    out->shear_x = rays->shear_x[j];
    out->shear_y = rays->shear_y[j];
    out->major = rays_major(rays, j);
    for (uint32_t k = 0; k < 3; k++)
        out->near_row[k] = 2 * k + (uint32_t)(rays->negative[k] >> j & 1u);
    out->slot = rays->slot[j];
    out->is_huge = rays->huge >> j & 1u;
    out->is_fit = true; // else it would not have come here
}

// Of ray j what offering it a triangle takes, and nothing else.
static inline void rays_clamping(const Rays *rays, uint32_t j, bool is_placed, Ray *out)
{
    out->org = (CoFour){rays->org[0][j], rays->org[1][j], rays->org[2][j], 0.0f};
    out->inv = (CoFour){rays->inv[0][j], rays->inv[1][j], rays->inv[2][j], 0.0f};
    out->pad = is_placed ? rays->placed_pad[j] : rays->pad[j];
    out->entry = rays->entry[j];
    out->exit = rays->exit[j];
    out->to = rays->to[j];
    out->slot = rays->slot[j];
}

// Ray j as the triangle test needs it.
static inline void rays_shear(const Rays *rays, uint32_t j, Shear *out)
{
    uint32_t z = rays_major(rays, j), x = next_axis(z), y = next_axis(x);
    *out = (Shear){x,
                   y,
                   z,
                   {rays->shear_org[0][j], rays->shear_org[1][j], rays->shear_org[2][j]},
                   rays->shear_x[j],
                   rays->shear_y[j],
                   rays->shear_z[j],
                   rays->dir[z][j]};
}

// Where it ends now.
static inline void rays_settle(Rays *rays, uint32_t j, float best)
{
    rays->nearer |= (uint64_t)(best < rays->to[j]) << j;
    rays->to[j] = float_min(rays->to[j], best);
    if (best == -INFINITE)
        rays->done |= 1ull << j;
}

#endif
