// Decoding a batch into field arrays: same values as the record decoder, inert padding, failures.

#include "base/memory.h"
#include "rays/ray_batch.h"
#include "rays/ray_kernels.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#define COUNT 20005u

static uint32_t words[COUNT * CO_RAY_WORDS_MAX];

static CoRayRecords make_records(uint32_t options)
{
    uint32_t stride = co_ray_words(options);
    static CoRayQueue queue;
    CoRayEncoded encoded;
    for (uint32_t i = 0; i < COUNT; i++) {
        float f = (float)i;
        CoRay ray = {.org = {f, -f, 0.5f * f}, .weight = {1, 1, 1}, .path = i, .tnear = f + 1.0f};
        ray.dir = co_normalize(co_vec3(1.0f, f / 100.0f - 30.0f, 3.0f));
        queue.count = 0;
        co_ray_queue_add(&queue, &ray, (CoRayKey){i, 0, 0});
        co_ray_kernels(NULL)->encode(&queue, options, &encoded);
        memcpy(words + i * stride, encoded.words[0], stride * sizeof *words);
    }
    CoRayRecords records = {.words = words, .count = COUNT, .stride = stride};
    return records;
}

static void check_place(const CoRayBatch *batch, size_t i, uint32_t record, uint32_t options)
{
    CoRay ray;
    co_ray_decode(words + record * co_ray_words(options), options, &ray);
    assert_true(batch->org_x[i] == ray.org.x && batch->org_y[i] == ray.org.y &&
                batch->org_z[i] == ray.org.z);
    assert_true(batch->dir_x[i] == ray.dir.x && batch->dir_y[i] == ray.dir.y &&
                batch->dir_z[i] == ray.dir.z);
    assert_true(batch->tnear[i] == ray.tnear && isinf(batch->tfar[i]));
    assert_int_equal(batch->record[i], record);
}

// In their own order and in another, in parts of any size, with every instruction set.
static void arrays_hold_what_the_records_say(void **state)
{
    (void)state;
    static const char *const isas[] = {"scalar", "sse42", "avx2", "avx512"};
    static uint32_t order[COUNT];
    for (uint32_t i = 0; i < COUNT; i++)
        order[i] = (uint32_t)((uint64_t)i * 7919 % COUNT);
    for (uint32_t k = 0; k < 16; k++) {
        const CoRayKernels *kernels = co_ray_kernels(isas[k / 4]);
        if (!kernels)
            continue;
        uint32_t options = k % 4;
        CoRayBatch batch = {.count = 0};
        CoRayRecords records = make_records(options);
        assert_true(co_ray_batch_reserve(&batch, COUNT, NULL));
        co_ray_batch_begin(&batch, COUNT);
        assert_int_equal(batch.count, COUNT);
        const size_t borders[] = {0, 1, 10, 26, 42, 1000, 1033, COUNT};
        for (int part = 0; part < 7; part++)
            kernels->decode(&records, part % 2 ? order : NULL, options, borders[part],
                            borders[part + 1], &batch);
        for (int part = 0; part < 7; part++)
            for (size_t i = borders[part]; i < borders[part + 1]; i++)
                check_place(&batch, i, part % 2 ? order[i] : (uint32_t)i, options);
        for (uint32_t i = COUNT; i < (COUNT + 63) / 64 * 64; i++)
            assert_true(batch.tnear[i] > batch.tfar[i] && batch.record[i] == UINT32_MAX);
        co_ray_batch_clear(&batch);
    }
    assert_int_equal(co_memory_live(CO_MEMORY_RAYS), 0);
}

static void room_is_kept_aligned_and_can_fail(void **state)
{
    (void)state;
    CoRayBatch batch = {.count = 0};
    CoHitBatch hits = {.count = 0};
    assert_true(co_ray_batch_reserve(&batch, 100, NULL));
    assert_int_equal(batch.capacity, 128);
    assert_int_equal((uintptr_t)batch.dir_y % 64, 0);
    const float *before = batch.org_x;
    assert_true(co_ray_batch_reserve(&batch, 128, NULL));
    assert_ptr_equal(batch.org_x, before);
    assert_true(co_hit_batch_reserve(&hits, 1, NULL));
    assert_int_equal(hits.capacity, 64);
    for (uint64_t n = 1; n <= 9; n++) {
        CohortError err = {0};
        co_memory_fail_after(n);
        assert_false(co_ray_batch_reserve(&batch, 1000, &err));
        co_memory_fail_after(0);
        assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
        assert_int_equal(batch.capacity, 0);
    }
    co_memory_fail_after(5);
    assert_false(co_hit_batch_reserve(&hits, 1000, NULL));
    co_memory_fail_after(0);
    assert_false(co_ray_batch_reserve(&batch, SIZE_MAX / 128, NULL));
    co_hit_batch_clear(&hits);
    co_ray_batch_clear(&batch);
    assert_int_equal(co_memory_live(CO_MEMORY_RAYS), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arrays_hold_what_the_records_say),
        cmocka_unit_test(room_is_kept_aligned_and_can_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
