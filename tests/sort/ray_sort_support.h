// What the tests of the ray sort share: rays of a room, and a batch sorted with all that belongs to
// it.

#ifndef TEST_RAY_SORT_SUPPORT_H
#define TEST_RAY_SORT_SUPPORT_H

#include "base/hash.h"
#include "rays/ray_batch.h"
#include "rays/ray_queue.h"
#include "sort/ray_sort.h"
#include "support/rays.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static inline float uniform(uint32_t n, uint32_t what)
{
    return (float)(co_hash64((uint64_t)n << 8 | what) >> 40) * 0x1p-24f;
}

// Ray number n of a room with spheres in it: origins on surfaces, directions in the +x bin.
static inline CoRay scene_ray(uint32_t n)
{
    CoRay ray = {.depth = n};
    CoVec3 s;
    do {
        s = co_vec3(uniform(n, 0) - 0.5f, uniform(n, 1) - 0.5f, uniform(n, 2) - 0.5f);
        n += 0x10000000u;
    } while (co_dot(s, s) > 0.25f || co_dot(s, s) < 1e-4f);
    uint32_t sphere = co_hash32(ray.depth) % 20;
    CoVec3 center = {100.0f * uniform(sphere, 9), 40.0f * uniform(sphere, 10),
                     10.0f * uniform(sphere, 11)};
    ray.org = sphere < 5 ? co_vec3(100.0f * uniform(n, 3), 40.0f * uniform(n, 4), 0.0f)
                         : co_madd(center, co_normalize(s), 3.0f);
    uint32_t code[2];
    ray.dir = co_ray_snap_direction(
        co_normalize(co_vec3(1.0f, 2.0f * uniform(n, 5) - 1.0f, 2.0f * uniform(n, 6) - 1.0f)),
        code);
    return ray;
}

// Numbered by the distances, which sorting does not look at.
static inline void set_ray(CoRayBatch *batch, size_t i, const CoRay *ray, uint32_t record)
{
    ray_set(batch, i, ray->org, ray->dir);
    batch->tnear[i] = (float)record;
    batch->tfar[i] = (float)record + 1.0f;
    batch->record[i] = record;
}

// Position i holds ray (i * step) modulo count; step must be coprime to count.
static inline void fill_scene(CoRayBatch *batch, size_t count, size_t step)
{
    assert_true(co_ray_batch_reserve(batch, count, NULL));
    batch->count = count;
    for (size_t i = 0; i < count; i++) {
        uint32_t n = (uint32_t)(i * step % count);
        CoRay ray = scene_ray(n);
        set_ray(batch, i, &ray, n);
    }
}

// What sorting looks at; the rest of the records is left zero. Batches of one bin say so.
static inline void write_records(const CoRayBatch *b, uint32_t *words, CoRayRecords *out)
{
    *out = (CoRayRecords){.words = words, .count = b->count, .stride = CO_RAY_WORDS};
    out->bounds = co_ray_bounds_none();
    for (size_t i = 0; i < b->count; i++) {
        uint32_t *w = words + i * CO_RAY_WORDS, code[2];
        CoVec3 dir = co_vec3(b->dir_x[i], b->dir_y[i], b->dir_z[i]);
        co_ray_find_direction_code(dir, code);
        memcpy(&w[0], &b->org_x[i], sizeof *w);
        memcpy(&w[1], &b->org_y[i], sizeof *w);
        memcpy(&w[2], &b->org_z[i], sizeof *w);
        w[3] = code[0] ? code[0] - 1 : CO_DIRECTION_MAX;
        w[4] = code[1] ? code[1] - 1 : CO_DIRECTION_MAX;
        CoOct grid = {(int32_t)w[3] - CO_DIRECTION_MAX, (int32_t)w[4] - CO_DIRECTION_MAX};
        if (co_ray_bin(grid) != 0)
            out->bin = CO_RAY_BIN_MIXED;
    }
    co_ray_bounds_add(&out->bounds, words, b->count, CO_RAY_WORDS);
}

// Sorts the rays of a batch with everything that belongs to them.
static inline bool sort_batch(CoRayBatch *batch, CohortSorter which, CoSortScratch *scratch,
                              CohortError *err)
{
    size_t count = batch->count;
    uint32_t *words = calloc(count + 1, CO_RAY_WORDS * sizeof *words);
    uint32_t *order = malloc((count + 1) * sizeof *order), *held = malloc((count + 1) * 4);
    CoRayRecords records;
    write_records(batch, words, &records);
    order[count] = 77;
    bool is_good =
        co_sort_rays(&records, (CoRaySorter){which, co_ray_keys(NULL)}, scratch, order, err);
    assert_int_equal(order[count], 77);
#define REORDER(type, name) \
    for (size_t i = 0; i < count; i++) \
        memcpy(&held[i], &batch->name[i], 4); \
    for (size_t i = 0; i < count && is_good; i++) { \
        assert_true(order[i] < count); \
        memcpy(&batch->name[i], &held[order[i]], 4); \
    }
    CO_RAY_FIELDS(REORDER)
    free(words);
    free(order);
    free(held);
    return is_good;
}

#endif
