// Rays of a batch as a group, and what it found handed back. Part of traverse.c.

#ifndef CO_ACCEL_KERNELS_INTAKE_H
#define CO_ACCEL_KERNELS_INTAKE_H

// The power of two that brings the largest component of a direction into [1, 2), as far as it is
// one that a float holds, and its inverse. 0 for a direction that is zero or not finite.
static inline float direction_scale(float x, float y, float z, float *inverse)
{
    float largest = float_max(__builtin_fabsf(x), __builtin_fabsf(y));
    largest = float_max(__builtin_fabsf(z), largest);
    bool is_good = (__builtin_fabsf(x) < INFINITE) & (__builtin_fabsf(y) < INFINITE) &
                   (__builtin_fabsf(z) < INFINITE) & (largest != 0.0f);
    union {
        float f;
        uint32_t u;
    } up = {largest}, down;
    // Exponents 1 to 253 have an inverse that is a normal number; beyond them nothing overflows
    // yet.
    uint32_t exponent = up.u >> 23;
    exponent = exponent < 1 ? 1 : exponent;
    exponent = exponent > 253 ? 253 : exponent;
    up.u = exponent << 23;
    down.u = (254 - exponent) << 23;
    *inverse = is_good ? up.f : 0.0f;
    return is_good ? down.f : 0.0f;
}

// Rays of a batch as a group, and by how much their directions were scaled: distances inside are
// those along the scaled ones.
typedef struct Intake {
    float dir[3][CO_GROUP_RAYS];
    float tnear[CO_GROUP_RAYS], tfar[CO_GROUP_RAYS];
    float scale[CO_GROUP_RAYS]; // 0: invalid
} Intake;

// Most groups are full: then the length is known here.
static inline void read_field(const float *from, uint32_t count, float to[CO_GROUP_RAYS])
{
    if (count == CO_GROUP_RAYS) {
        __builtin_memcpy(to, from, CO_GROUP_RAYS * sizeof *to);
        return;
    }
    __builtin_memcpy(to, from, count * sizeof *to);
    __builtin_memset(to + count, 0, (CO_GROUP_RAYS - count) * sizeof *to);
}

// What of the group is not a ray is invalid.
static void read_batch(const CoRayBatch *batch, size_t begin, uint32_t count, Rays *rays,
                       Intake *in)
{
    const float *const org[3] = {batch->org_x, batch->org_y, batch->org_z};
    const float *const dir[3] = {batch->dir_x, batch->dir_y, batch->dir_z};
    for (int k = 0; k < 3; k++) {
        read_field(org[k] + begin, count, rays->org[k]);
        read_field(dir[k] + begin, count, in->dir[k]);
    }
    read_field(batch->tnear + begin, count, in->tnear);
    read_field(batch->tfar + begin, count, in->tfar);
}

// Without a branch: the compiler makes vectors of it.
static void scale_rays(Rays *rays, Intake *in, Group *group)
{
    for (uint32_t j = 0; j < CO_GROUP_RAYS; j++) {
        float x = in->dir[0][j], y = in->dir[1][j], z = in->dir[2][j], inverse;
        float s = direction_scale(x, y, z, &inverse), tnear = in->tnear[j], tfar = in->tfar[j];
        bool is_good = (__builtin_fabsf(rays->org[0][j]) < INFINITE) &
                       (__builtin_fabsf(rays->org[1][j]) < INFINITE) &
                       (__builtin_fabsf(rays->org[2][j]) < INFINITE) & (tnear == tnear) &
                       (tfar == tfar);
        s = is_good ? s : 0.0f;
        in->scale[j] = s;
        rays->dir[0][j] = x * s;
        rays->dir[1][j] = y * s;
        rays->dir[2][j] = z * s;
        rays->entry[j] = -INFINITE;
        rays->exit[j] = INFINITE;
        rays->from[j] = group->tnear[j] = float_max(tnear * inverse, -__FLT_MAX__);
        rays->to[j] = group->best_t[j] = tfar * inverse;
        rays->slot[j] = (uint8_t)j;
        group->best_u[j] = group->best_v[j] = 0.0f;
        group->best_path[j] = group->best_tri[j] = id_lane(0);
    }
}

// No hit, for the reason that t tells.
static void give_none(CoHitBatch *hits, size_t i, float t)
{
    hits->t[i] = t;
    hits->u[i] = 0.0f;
    hits->v[i] = 0.0f;
    hits->instance[i] = COHORT_INVALID_ID;
    hits->tri[i] = COHORT_INVALID_ID;
}

// As read_field: most groups are full.
static inline void give_field(const void *from, uint32_t count, void *to)
{
    if (count == CO_GROUP_RAYS)
        __builtin_memcpy(to, from, CO_GROUP_RAYS * sizeof(float));
    else
        __builtin_memcpy(to, from, count * sizeof(float));
}

static void give_hits(Group *group, const float scale[CO_GROUP_RAYS], CoHitBatch *hits,
                      size_t begin, uint32_t count)
{
    const CoWide zero = co_wide_set1(0.0f), most = co_wide_set1(__FLT_MAX__);
    const uint64_t seen = group->found & ~group->occlusion;
    for (uint32_t j = 0; j < CO_GROUP_RAYS; j += CO_WIDE_WIDTH) {
        CoWideMask found = co_wide_mask((uint32_t)(group->found >> j));
        CoWideMask mask = co_wide_mask((uint32_t)(seen >> j));
        CoWide t = co_wide_mul(co_wide_load(group->best_t + j), co_wide_load(scale + j));
        CoWide none = co_wide_select(found, zero, co_wide_set1(INFINITE));
        co_wide_store(group->best_t + j, co_wide_select(mask, co_wide_min(t, most), none));
        CoWide u = co_wide_load(group->best_u + j), v = co_wide_load(group->best_v + j);
        co_wide_store(group->best_u + j, co_wide_select(mask, u, zero));
        co_wide_store(group->best_v + j, co_wide_select(mask, v, zero));
    }
    for (uint64_t left = ~seen; left; left &= left - 1) {
        uint32_t slot = (uint32_t)__builtin_ctzll(left);
        group->best_path[slot] = group->best_tri[slot] = id_lane(COHORT_INVALID_ID);
    }
    give_field(group->best_t, count, hits->t + begin);
    give_field(group->best_u, count, hits->u + begin);
    give_field(group->best_v, count, hits->v + begin);
    give_field(group->best_path, count, hits->instance + begin);
    give_field(group->best_tri, count, hits->tri + begin);
}

static inline void open_group(Group *group, const CoAccelScene *scene, const uint8_t *flags,
                              CoTraverseStats *stats)
{
    group->scene = scene;
    group->flags = flags;
    group->stats = stats;
    group->after = NULL;
    group->found = 0;
    group->occlusion = 0;
    stats->groups++;
}

// Takes invalid rays out of the group: the last takes the place of each.
static void drop_invalid(Rays *rays, const float scale[CO_GROUP_RAYS])
{
    uint32_t invalid = 0;
    for (uint32_t j = 0; j < CO_GROUP_RAYS; j++)
        invalid += scale[j] == 0.0f;
    if (!invalid)
        return;
    for (uint32_t j = rays->count; j-- > 0;) {
        if (scale[j] != 0.0f)
            continue;
        uint32_t last = --rays->count;
        for (int k = 0; k < 3; k++) {
            rays->org[k][j] = rays->org[k][last];
            rays->dir[k][j] = rays->dir[k][last];
        }
        rays->from[j] = rays->from[last];
        rays->to[j] = rays->to[last];
        rays->slot[j] = rays->slot[last];
    }
}

// Asks for a group that comes next. Always inline: the compiler drops calls of functions that do no
// more.
static inline __attribute__((always_inline)) void prefetch_batch(const CoRayBatch *batch,
                                                                 size_t begin)
{
    const float *const fields[8] = {batch->org_x, batch->org_y, batch->org_z, batch->dir_x,
                                    batch->dir_y, batch->dir_z, batch->tnear, batch->tfar};
    for (int k = 0; k < 8; k++)
        for (uint32_t j = 0; j < CO_GROUP_RAYS; j += 16)
            __builtin_prefetch(fields[k] + begin + j);
}

// Asks for where its hits will stand, to write.
static inline __attribute__((always_inline)) void prefetch_hits(const CoHitBatch *hits,
                                                                size_t begin)
{
    const void *const fields[5] = {hits->t + begin, hits->u + begin, hits->v + begin,
                                   hits->instance + begin, hits->tri + begin};
    for (int k = 0; k < 5; k++)
        for (uint32_t j = 0; j < CO_GROUP_RAYS * sizeof(float); j += 64)
            __builtin_prefetch((const char *)fields[k] + j, 1);
}

#endif
