// What comes out of ray bins: the newest batch, then what is left over all of them.

#include "ray_bin_support.h"

static void newest_batch_first_and_files_are_reused(void **state)
{
    CohortError err = {0};
    CoRayBins *bins = make_bins(state, 256, &err);
    CoRayRecords first, second, none;
    push_serial(bins, 0, 256, 3);
    push_serial(bins, 256, 256, 1);
    push_serial(bins, 512, 256, 3);
    assert_true(co_ray_bins_flush(bins, &err));
    assert_int_equal(co_ray_bins_left(bins), 0);
    assert_true(co_ray_bins_pop(bins, &first, &err));
    assert_int_equal(first.words[0], 512);
    assert_int_equal(first.bin, 3);
    assert_true(co_ray_bins_pop(bins, &second, &err));
    assert_int_equal(second.words[0], 256);
    co_ray_bins_recycle(bins, &second);
    push_serial(bins, 768, 256, 5); // while a batch is in work
    assert_int_equal(first.words[0], 512);
    co_ray_bins_recycle(bins, &first);
    for (uint32_t round = 0; round < 20; round++) {
        push_serial(bins, 1000, 256, 2);
        assert_true(co_ray_bins_pop(bins, &first, &err));
        assert_int_equal(first.words[0], 1000);
        co_ray_bins_recycle(bins, &first);
    }
    CoRayBinStats stats;
    co_ray_bins_stats(bins, &stats);
    assert_int_equal(stats.files_in_memory + stats.files_on_disk, 3);
    assert_int_equal(stats.ready_depth_peak, 3);
    assert_int_equal(stats.batches[2], 20);
    assert_true(co_ray_bins_pop(bins, &first, &err) && first.words[0] == 768);
    assert_true(co_ray_bins_pop(bins, &second, &err) && second.words[0] == 0);
    assert_true(co_ray_bins_pop(bins, &none, &err) && none.count == 0);
    co_ray_bins_destroy(bins); // with batches still out
}

static void leftovers_are_drained_together(void **state)
{
    CohortError err = {0};
    CoRayBins *bins = make_bins(state, 256, &err);
    CoRayRecords records;
    for (uint32_t b = 0; b < 6; b++)
        push_serial(bins, b * 40, 40, b);
    assert_true(co_ray_bins_flush(bins, &err));
    assert_int_equal(co_ray_bins_left(bins), 240);
    assert_true(co_ray_bins_drain(bins, &records, &err));
    assert_int_equal(records.count, 240);
    assert_int_equal(records.bin, CO_RAY_BIN_MIXED);
    bool seen[240] = {false};
    for (uint32_t i = 0; i < 240; i++) {
        uint32_t n = records.words[i * CO_RAY_WORDS];
        assert_true(n < 240 && !seen[n]);
        seen[n] = true;
    }
    uint32_t first = records.words[0];
    push_serial(bins, 1000, 100, 0); // more than a batch over all bins: the fullest goes first
    push_serial(bins, 2000, 150, 4);
    push_serial(bins, 3000, 120, 5);
    assert_int_equal(records.words[0], first); // the drained batch is still in work
    co_ray_bins_recycle(bins, &records);
    assert_true(co_ray_bins_flush(bins, &err));
    assert_true(co_ray_bins_drain(bins, &records, &err));
    assert_int_equal(records.count, 150);
    assert_int_equal(records.words[0], 2000);
    co_ray_bins_recycle(bins, &records);
    assert_true(co_ray_bins_drain(bins, &records, &err));
    assert_int_equal(records.count, 220);
    assert_true(co_ray_bins_drain(bins, &records, &err));
    assert_int_equal(records.count, 0);
    co_ray_bins_destroy(bins);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_BUDGETS(newest_batch_first_and_files_are_reused),
        WITH_BUDGETS(leftovers_are_drained_together),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
