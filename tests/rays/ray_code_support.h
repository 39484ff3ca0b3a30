// What the tests of the ray record share: random numbers, one ray by itself.

#ifndef TEST_RAY_CODE_SUPPORT_H
#define TEST_RAY_CODE_SUPPORT_H

#include "base/hash.h"
#include "rays/ray_kernels.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

// Of a statistic: 10 million with COHORT_TEST_FULL in the environment.
static inline size_t samples(size_t fast)
{
    return getenv("COHORT_TEST_FULL") ? 10000000 : fast;
}

static inline double uniform(uint64_t *state)
{
    *state = co_hash64(*state);
    return (double)(*state >> 11) * 0x1p-53;
}

static inline CoVec3 random_direction(uint64_t *state)
{
    for (;;) {
        double x = 2 * uniform(state) - 1, y = 2 * uniform(state) - 1, z = 2 * uniform(state) - 1;
        double n = x * x + y * y + z * z;
        if (n > 1e-3 && n <= 1.0) {
            double inv = 1.0 / sqrt(n);
            return co_vec3((float)(x * inv), (float)(y * inv), (float)(z * inv));
        }
    }
}

static inline CoRay simple_ray(void)
{
    CoRay ray = {.org = {1, 2, 3}, .dir = {0, 0, 1}, .weight = {1, 1, 1}, .depth = 1};
    return ray;
}

// One ray by itself. The number of records it gets: 1, or 0 when its weight was rounded to nothing.
static inline uint32_t encode_with(const CoRayKernels *kernels, const CoRay *ray, uint32_t options,
                                   CoRayKey key, uint32_t *words, uint32_t *overflow)
{
    static CoRayQueue queue;
    CoRayEncoded encoded;
    queue.count = 0;
    assert_false(co_ray_queue_add(&queue, ray, key));
    kernels->encode(&queue, options, &encoded);
    if (encoded.is_kept)
        memcpy(words, encoded.words[0], co_ray_words(options) * sizeof *words);
    *overflow += encoded.has_overflown;
    return encoded.is_kept;
}

static inline uint32_t encode(const CoRay *ray, uint32_t *words)
{
    uint32_t overflow = 0;
    return encode_with(co_ray_kernels(NULL), ray, 0, (CoRayKey){1, 2, 3}, words, &overflow);
}

#endif
