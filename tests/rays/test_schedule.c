// The schedule of a round: newest batch, camera rays, drain, done; and the sizes of rounds.

#include "base/memory.h"
#include "rays/schedule.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static void push(CoRayBins *bins, uint32_t count, uint32_t bin)
{
    const uint32_t words[CO_RAY_WORDS] = {bin};
    while (count-- > 0)
        co_ray_bins_push(bins, 0, words, bin);
}

static void batches_then_camera_then_leftovers_then_done(void **state)
{
    (void)state;
    CohortError err = {0};
    CoRayRecords records;
    CoRayBins *bins = co_ray_bins_create(256, CO_RAY_WORDS, 1, 0, NULL, &err);
    assert_int_equal(co_schedule_next(bins, true, &records, &err), CO_SCHEDULE_CAMERA);
    push(bins, 300, 0);
    push(bins, 290, 1);
    assert_int_equal(co_schedule_next(bins, true, &records, &err), CO_SCHEDULE_BATCH);
    assert_int_equal(records.count, 256);
    assert_int_equal(records.bin, 1);
    co_ray_bins_recycle(bins, &records);
    assert_int_equal(co_schedule_next(bins, true, &records, &err), CO_SCHEDULE_BATCH);
    co_ray_bins_recycle(bins, &records);
    assert_int_equal(co_schedule_next(bins, true, &records, &err), CO_SCHEDULE_CAMERA);
    assert_int_equal(co_schedule_next(bins, false, &records, &err), CO_SCHEDULE_BATCH);
    assert_int_equal(records.count, 44 + 34);
    co_ray_bins_recycle(bins, &records);
    push(bins, 1, 4); // a ray made by the last batch
    assert_int_equal(co_schedule_next(bins, false, &records, &err), CO_SCHEDULE_BATCH);
    assert_int_equal(records.count, 1);
    co_ray_bins_recycle(bins, &records);
    assert_int_equal(co_schedule_next(bins, false, &records, &err), CO_SCHEDULE_DONE);
    co_ray_bins_destroy(bins);
}

static void failures_end_the_round(void **state)
{
    (void)state;
    CohortError err = {0};
    CoRayRecords records;
    CoRayBins *bins = co_ray_bins_create(256, CO_RAY_WORDS, 1, 0, "/nonexistent", &err);
    push(bins, 3, 0);
    assert_int_equal(co_schedule_next(bins, false, &records, &err), CO_SCHEDULE_FAILED);
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
    co_ray_bins_destroy(bins);
}

static void rounds_double_up_to_ten_seconds(void **state)
{
    (void)state;
    uint64_t taken = 0, last = 0;
    const uint64_t expected[] = {1, 1, 2, 4, 8, 8, 8, 8};
    for (int i = 0; i < 8; i++) {
        last = co_schedule_round(taken, 1000, 100, last, 0.9 * (double)last);
        assert_int_equal(last, expected[i]);
        taken += last;
    }
    assert_int_equal(co_schedule_round(995, 1000, 100, 64, 0.1), 5);
    assert_int_equal(co_schedule_round(1000, 1000, 100, 64, 0.1), 0);
    assert_int_equal(co_schedule_round(512, 100000, (uint64_t)1 << 28, 64, 0.1), 16);
    assert_int_equal(co_schedule_round(512, 100000, (uint64_t)1 << 40, 64, 0.1), 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(batches_then_camera_then_leftovers_then_done),
        cmocka_unit_test(failures_end_the_round),
        cmocka_unit_test(rounds_double_up_to_ten_seconds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
