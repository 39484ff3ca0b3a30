// Random numbers and batches of rays for tests of what is traced.

#ifndef TESTS_SUPPORT_RAYS_H
#define TESTS_SUPPORT_RAYS_H

#include "accel/accel.h"
#include "base/hash.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

typedef struct Random {
    uint64_t state;
} Random;

static inline uint32_t random_bits(Random *random)
{
    return (uint32_t)(co_hash64(random->state++) >> 32);
}

// In [lo, hi).
static inline float random_float(Random *random, float lo, float hi)
{
    return lo + (hi - lo) * ((float)(random_bits(random) >> 8) * 0x1p-24f);
}

static inline CoVec3 random_vec3(Random *random, float lo, float hi)
{
    CoVec3 v;
    v.x = random_float(random, lo, hi);
    v.y = random_float(random, lo, hi);
    v.z = random_float(random, lo, hi);
    return v;
}

static inline CoVec3 random_direction(Random *random)
{
    CoVec3 d;
    do
        d = random_vec3(random, -1, 1);
    while (!(co_dot(d, d) < 1.0f && co_dot(d, d) > 1e-3f));
    return co_normalize(d);
}

static inline CoRayBatch rays_alloc(size_t count)
{
    CoRayBatch rays = {.count = count, .capacity = (count + 63) & ~(size_t)63};
#define TEST_ALLOC(type, name) rays.name = aligned_alloc(64, rays.capacity * sizeof(type));
    CO_RAY_FIELDS(TEST_ALLOC)
#undef TEST_ALLOC
    for (size_t i = 0; i < rays.capacity; i++) {
        rays.tnear[i] = 0.0f;
        rays.tfar[i] = INFINITY;
        rays.record[i] = (uint32_t)i;
    }
    return rays;
}

static inline void rays_free(CoRayBatch *rays)
{
#define TEST_FREE(type, name) free(rays->name);
    CO_RAY_FIELDS(TEST_FREE)
#undef TEST_FREE
}

static inline CoHitBatch hits_alloc(size_t count)
{
    CoHitBatch hits = {.count = count, .capacity = (count + 63) & ~(size_t)63};
#define TEST_ALLOC(type, name) hits.name = aligned_alloc(64, hits.capacity * sizeof(type));
    CO_HIT_FIELDS(TEST_ALLOC)
#undef TEST_ALLOC
    return hits;
}

static inline void hits_free(CoHitBatch *hits)
{
#define TEST_FREE(type, name) free(hits->name);
    CO_HIT_FIELDS(TEST_FREE)
#undef TEST_FREE
}

static inline void ray_set(CoRayBatch *rays, size_t i, CoVec3 org, CoVec3 dir)
{
    rays->org_x[i] = org.x;
    rays->org_y[i] = org.y;
    rays->org_z[i] = org.z;
    rays->dir_x[i] = dir.x;
    rays->dir_y[i] = dir.y;
    rays->dir_z[i] = dir.z;
}

static inline CoVec3 ray_org(const CoRayBatch *rays, size_t i)
{
    return co_vec3(rays->org_x[i], rays->org_y[i], rays->org_z[i]);
}

static inline CoVec3 ray_dir(const CoRayBatch *rays, size_t i)
{
    return co_vec3(rays->dir_x[i], rays->dir_y[i], rays->dir_z[i]);
}

#endif
