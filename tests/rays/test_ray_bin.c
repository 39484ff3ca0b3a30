// Ray bins: every record comes out exactly once, whatever the threads do; rounds, failures.

#include "ray_bin_support.h"

// What went to disk, by how many files there are of each kind.
static void check_stats(const CoRayBins *bins, uint64_t budget, size_t total, size_t file_bytes)
{
    CoRayBinStats stats;
    co_ray_bins_stats(bins, &stats);
    uint64_t committed = 0, most = budget / file_bytes;
    for (int b = 0; b < 6; b++)
        committed += stats.committed[b];
    assert_int_equal(committed, total);
    assert_true(stats.files_in_memory <= most);
    assert_true(stats.files_on_disk == 0 || stats.files_in_memory == most);
    assert_true((stats.bytes_written > 0) == (stats.files_on_disk > 0));
}

static void no_record_is_lost_or_doubled(void **state)
{
    const uint64_t *budget = *state;
    const size_t most = 200000, capacities[] = {256, 257, 1000, 20000, 1 << 18};
    uint8_t *seen = malloc(most);
    for (uint32_t threads = 1; threads <= 8; threads += threads == 1 ? 2 : 5)
        for (int c = 0; c < 5; c++) {
            size_t total = capacities[c] * 50 + 17 < most ? capacities[c] * 50 + 17 : most;
            memset(seen, 0, total);
            co_worker_count_set(threads);
            uint32_t stride = CO_RAY_WORDS + (uint32_t)c % 3;
            CoRayBins *bins =
                co_ray_bins_create(capacities[c], stride, threads, *budget, NULL, NULL);
            assert_non_null(bins);
            Push push = {bins, stride, 0};
            co_parallel_for(total, 100, push_range, &push);
            assert_true(co_ray_bins_flush(bins, NULL));
            take_all(bins, seen, total, capacities[c]);
            check_stats(bins, *budget, total, capacities[c] * stride * 4);
            co_ray_bins_destroy(bins);
        }
    free(seen);
    co_worker_count_set(0);
    assert_int_equal(co_memory_live(CO_MEMORY_RAYS), 0);
}

static void reset_forgets_the_round(void **state)
{
    CohortError err = {0};
    CoRayBins *bins = make_bins(state, 256, &err);
    CoRayRecords records;
    push_serial(bins, 0, 1000, 0);
    push_serial(bins, 1000, 10, 1);
    co_ray_bins_reset(bins);
    assert_true(co_ray_bins_flush(bins, &err));
    assert_true(co_ray_bins_pop(bins, &records, &err));
    assert_int_equal(records.count + co_ray_bins_left(bins), 0);
    push_serial(bins, 5000, 300, 2);
    assert_true(co_ray_bins_flush(bins, &err));
    assert_true(co_ray_bins_pop(bins, &records, &err));
    assert_int_equal(records.words[0], 5000);
    assert_int_equal(co_ray_bins_left(bins), 44);
    co_ray_bins_destroy(bins);
}

// Large enough to go around the caches; and a part of the other bins behind the fullest.
static void large_batches_come_out_whole(void **state)
{
    (void)state;
    const size_t capacity = 1 << 18, total = capacity + capacity / 2;
    CohortError err = {0};
    uint8_t *seen = calloc(total, 1);
    co_worker_count_set(3);
    for (uint32_t stride = CO_RAY_WORDS; stride <= CO_RAY_WORDS_MAX; stride++) {
        CoRayBins *bins = co_ray_bins_create(capacity, stride, 3, UINT64_MAX, NULL, &err);
        Push push = {bins, stride, 0};
        memset(seen, 0, total);
        co_parallel_for(total, 999, push_range, &push);
        assert_true(co_ray_bins_flush(bins, &err));
        take_all(bins, seen, total, capacity);
        co_ray_bins_destroy(bins);
    }
    co_worker_count_set(0);
    free(seen);
}

static void memory_failures_are_errors(void **state)
{
    const uint64_t *budget = *state;
    for (uint64_t n = 1; n <= 7; n++) {
        CohortError err = {0};
        CoRayRecords records = {.count = 0};
        co_memory_fail_after(n);
        CoRayBins *bins = co_ray_bins_create(256, CO_RAY_WORDS, 2, *budget, NULL, &err);
        bool is_good = bins != NULL;
        if (bins) {
            push_serial(bins, 0, 20, 0);
            is_good = co_ray_bins_flush(bins, &err) && co_ray_bins_drain(bins, &records, &err);
        }
        co_memory_fail_after(0);
        assert_false(is_good);
        assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
        co_ray_bins_destroy(bins);
        assert_int_equal(co_memory_live(CO_MEMORY_RAYS), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_BUDGETS(no_record_is_lost_or_doubled),
        WITH_BUDGETS(reset_forgets_the_round),
        cmocka_unit_test(large_batches_come_out_whole),
        WITH_BUDGETS(memory_failures_are_errors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
