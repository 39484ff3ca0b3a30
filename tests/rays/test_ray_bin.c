// Ray bins: every record comes out exactly once, whatever the threads do; order, reuse, failures.

#include "base/hash.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "rays/ray_bin.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <cmocka.h>

// What memory files get: each test below that looks at `state` holds for all of these.
static uint64_t nothing = 0, a_little = 3 * 256 * 36, everything = UINT64_MAX;

static CoRayBins *make_bins(void **state, size_t capacity, CohortError *err)
{
    const uint64_t *budget = *state;
    return co_ray_bins_create(capacity, CO_RAY_WORDS, 1, *budget, NULL, err);
}

typedef struct Push {
    CoRayBins *bins;
    uint32_t stride;
    uint32_t base; // number of the first record
} Push;

// Record number n: every word follows from it.
static void fill_record(uint32_t *words, uint32_t stride, uint32_t n)
{
    words[0] = n;
    for (uint32_t i = 1; i < stride; i++)
        words[i] = co_hash32(n + i);
}

static uint32_t bin_of(uint32_t n)
{
    return co_hash32(n) % 8 < 3 ? 0 : co_hash32(n) % 6; // one bin fills faster
}

static void push_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Push *push = context;
    uint32_t words[CO_RAY_WORDS_MAX];
    for (size_t i = begin; i < end; i++) {
        uint32_t n = push->base + (uint32_t)i;
        fill_record(words, push->stride, n);
        co_ray_bins_push(push->bins, worker, words, bin_of(n));
    }
}

// Checks the records of a batch and ticks them off.
static void tick_off(const CoRayRecords *records, uint8_t *seen, size_t total)
{
    for (size_t i = 0; i < records->count; i++) {
        const uint32_t *words = records->words + i * records->stride;
        uint32_t expected[CO_RAY_WORDS_MAX], n = words[0];
        assert_true(n < total);
        fill_record(expected, records->stride, n);
        assert_memory_equal(words, expected, records->stride * sizeof(uint32_t));
        assert_true(records->bin == CO_RAY_BIN_MIXED || records->bin == bin_of(n));
        assert_int_equal(seen[n], 0);
        seen[n] = 1;
    }
}

static void take_all(CoRayBins *bins, uint8_t *seen, size_t total, size_t capacity)
{
    CohortError err = {0};
    CoRayRecords records;
    for (;;) {
        assert_true(co_ray_bins_pop(bins, &records, &err));
        if (records.count == 0)
            break;
        assert_int_equal(records.count, capacity);
        tick_off(&records, seen, total);
        co_ray_bins_recycle(bins, &records);
    }
    for (;;) {
        assert_true(co_ray_bins_drain(bins, &records, &err));
        if (records.count == 0)
            break;
        tick_off(&records, seen, total);
        co_ray_bins_recycle(bins, &records);
    }
    for (size_t i = 0; i < total; i++)
        assert_int_equal(seen[i], 1);
}

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

static void push_serial(CoRayBins *bins, uint32_t first, uint32_t count, uint32_t bin)
{
    uint32_t words[CO_RAY_WORDS_MAX];
    for (uint32_t n = first; n < first + count; n++) {
        fill_record(words, CO_RAY_WORDS, n);
        co_ray_bins_push(bins, 0, words, bin);
    }
}

static void newest_batch_first_and_files_are_reused(void **state)
{
    CohortError err = {0};
    CoRayBins *bins = make_bins(state, 256, &err);
    CoRayRecords first, second, none;
    push_serial(bins, 0, 256, 3);
    push_serial(bins, 256, 256, 1);
    push_serial(bins, 512, 256, 3);
    assert_true(co_ray_bins_flush(bins, &err));
    assert_int_equal(co_ray_bins_ready(bins), 3);
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

static void reset_forgets_the_round(void **state)
{
    CohortError err = {0};
    CoRayBins *bins = make_bins(state, 256, &err);
    CoRayRecords records;
    push_serial(bins, 0, 1000, 0);
    push_serial(bins, 1000, 10, 1);
    co_ray_bins_reset(bins);
    assert_true(co_ray_bins_flush(bins, &err));
    assert_int_equal(co_ray_bins_ready(bins) + co_ray_bins_left(bins), 0);
    push_serial(bins, 5000, 300, 2);
    assert_true(co_ray_bins_flush(bins, &err));
    assert_true(co_ray_bins_pop(bins, &records, &err));
    assert_int_equal(records.words[0], 5000);
    assert_int_equal(co_ray_bins_left(bins), 44);
    co_ray_bins_destroy(bins);
}

// Writes the scratch files back and asks the system to forget their pages. False where it can't.
static bool drop_scratch_pages(void)
{
    bool has_dropped = false;
    for (int fd = 3; fd < 256; fd++) {
        char link[64], target[256];
        snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
        ssize_t length = readlink(link, target, sizeof target - 1);
        if (length < 0)
            continue;
        target[length] = 0;
        struct statfs info;
        if (strstr(target, "cohort-scratch") && fstatfs(fd, &info) == 0 &&
            info.f_type != TMPFS_MAGIC && fdatasync(fd) == 0)
            has_dropped = posix_fadvise(fd, 0, 0, POSIX_FADV_DONTNEED) == 0;
    }
    return has_dropped;
}

static void batches_that_left_memory_are_read_back(void **state)
{
    (void)state;
    const size_t capacity = 50000; // 1.8 MB: more than one step of paging in
    CohortError err = {0};
    CoRayBins *bins = co_ray_bins_create(capacity, CO_RAY_WORDS, 1, 0, NULL, &err);
    CoRayRecords records;
    CoRayBinStats stats;
    push_serial(bins, 0, 2 * (uint32_t)capacity, 0);
    assert_true(co_ray_bins_flush(bins, &err));
    bool has_dropped = drop_scratch_pages();
    for (uint32_t batch = 2; batch-- > 0;) {
        assert_true(co_ray_bins_pop(bins, &records, &err));
        for (uint32_t i = 0; i < capacity; i++)
            assert_int_equal(records.words[i * CO_RAY_WORDS], batch * (uint32_t)capacity + i);
        co_ray_bins_recycle(bins, &records);
    }
    co_ray_bins_stats(bins, &stats);
    co_ray_bins_destroy(bins);
    if (!has_dropped)
        skip();
    assert_true(stats.bytes_read > 0 && stats.bytes_read <= 2 * capacity * 36 + 8192);
    assert_true(stats.wait_seconds > 0.0);
}

static void a_folder_that_cannot_be_used_is_an_error(void **state)
{
    (void)state;
    CohortError err = {0};
    CoRayBins *bins = co_ray_bins_create(256, CO_RAY_WORDS, 1, 0, "/nonexistent/folder", &err);
    assert_non_null(bins);
    push_serial(bins, 0, 100, 0);
    assert_false(co_ray_bins_flush(bins, &err));
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
    assert_non_null(strstr(err.message, "/nonexistent/folder"));
    co_ray_bins_destroy(bins);
    assert_null(co_ray_bins_create(255, CO_RAY_WORDS, 1, 0, NULL, NULL));
    assert_null(co_ray_bins_create(256, CO_RAY_WORDS_MAX + 1, 1, 0, NULL, NULL));
    assert_null(co_ray_bins_create(((size_t)1 << 26) + 1, CO_RAY_WORDS, 1, 0, NULL, NULL));
}

static void limit_file_size(rlim_t bytes)
{
    struct rlimit limit;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &limit), 0);
    limit.rlim_cur = bytes;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

// The limit on file sizes stands in for a disk that is full: same calls, same kind of failure.
static void a_full_disk_is_an_error_and_a_reset_gets_over_it(void **state)
{
    (void)state;
    CohortError err = {0};
    CoRayBins *bins = co_ray_bins_create(256, CO_RAY_WORDS, 1, 0, NULL, &err);
    CoRayRecords records;
    signal(SIGXFSZ, SIG_IGN);
    limit_file_size(4096);
    push_serial(bins, 0, 256, 0); // the file can't be made
    assert_false(co_ray_bins_flush(bins, &err));
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
    limit_file_size(RLIM_INFINITY);
    co_ray_bins_reset(bins);
    push_serial(bins, 0, 16, 0);
    limit_file_size(1000);
    push_serial(bins, 16, 200, 0); // a write ends short, the next one fails
    err = (CohortError){0};
    assert_false(co_ray_bins_flush(bins, &err));
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
    assert_non_null(strstr(err.message, "write"));
    limit_file_size(RLIM_INFINITY);
    co_ray_bins_reset(bins);
    err = (CohortError){0};
    push_serial(bins, 0, 256, 0);
    assert_true(co_ray_bins_flush(bins, &err));
    assert_true(co_ray_bins_pop(bins, &records, &err) && records.count == 256);
    co_ray_bins_destroy(bins);
}

static void what_memory_does_not_hold_is_on_disk(void **state)
{
    (void)state;
    CohortError err = {0};
    CoRayBins *bins = co_ray_bins_create(256, CO_RAY_WORDS, 1, 2 * 256 * 36 + 1, NULL, &err);
    CoRayRecords records;
    CoRayBinStats stats;
    push_serial(bins, 0, 5 * 256, 0);
    assert_true(co_ray_bins_flush(bins, &err));
    co_ray_bins_stats(bins, &stats);
    assert_int_equal(stats.files_in_memory, 2);
    assert_int_equal(stats.files_on_disk, 3);
    assert_int_equal(stats.bytes_written, 3 * 256 * 36);
    for (uint32_t batch = 5; batch-- > 0;) {
        assert_true(co_ray_bins_pop(bins, &records, &err));
        assert_int_equal(records.words[0], 256 * batch);
        co_ray_bins_recycle(bins, &records);
    }
    push_serial(bins, 0, 2 * 256, 0); // memory is used again first, wherever it is among the spares
    co_ray_bins_stats(bins, &stats);
    assert_int_equal(stats.bytes_written, 3 * 256 * 36);
    co_ray_bins_reset(bins);
    push_serial(bins, 0, 3 * 256, 0);
    co_ray_bins_stats(bins, &stats);
    assert_int_equal(stats.bytes_written, 4 * 256 * 36);
    co_ray_bins_destroy(bins);
}

static void a_full_disk_behind_memory_is_an_error(void **state)
{
    (void)state;
    CohortError err = {0};
    CoRayBins *bins = co_ray_bins_create(256, CO_RAY_WORDS, 1, 256 * 36, NULL, &err);
    signal(SIGXFSZ, SIG_IGN);
    limit_file_size(4096);
    push_serial(bins, 0, 256, 0);
    assert_true(co_ray_bins_flush(bins, &err));
    push_serial(bins, 256, 256, 0);
    bool is_good = co_ray_bins_flush(bins, &err);
    limit_file_size(RLIM_INFINITY);
    assert_false(is_good);
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
    co_ray_bins_destroy(bins);
}

static void refused_memory_means_disk(void **state)
{
    (void)state;
    CohortError err = {0};
    CoRayRecords records;
    CoRayBinStats stats;
    CoRayBins *bins = co_ray_bins_create(256, CO_RAY_WORDS, 1, UINT64_MAX, NULL, &err);
    co_memory_fail_after(2); // the first is what describes the file
    push_serial(bins, 0, 256, 0);
    co_memory_fail_after(0);
    assert_true(co_ray_bins_flush(bins, &err));
    assert_true(co_ray_bins_pop(bins, &records, &err) && records.count == 256);
    co_ray_bins_stats(bins, &stats);
    assert_int_equal(stats.files_on_disk, 1);
    assert_int_equal(stats.files_in_memory, 0);
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

static void a_budget_is_part_of_what_there_is(void **state)
{
    (void)state;
    uint64_t available = co_memory_available();
    if (!available)
        skip();
    assert_true(co_ray_bins_budget() > 0 && co_ray_bins_budget() < available);
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

#define WITH_BUDGETS(test) \
    cmocka_unit_test_prestate(test, &nothing), cmocka_unit_test_prestate(test, &a_little), \
        cmocka_unit_test_prestate(test, &everything)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_BUDGETS(no_record_is_lost_or_doubled),
        WITH_BUDGETS(newest_batch_first_and_files_are_reused),
        WITH_BUDGETS(leftovers_are_drained_together),
        WITH_BUDGETS(reset_forgets_the_round),
        cmocka_unit_test(batches_that_left_memory_are_read_back),
        cmocka_unit_test(a_folder_that_cannot_be_used_is_an_error),
        cmocka_unit_test(a_full_disk_is_an_error_and_a_reset_gets_over_it),
        cmocka_unit_test(what_memory_does_not_hold_is_on_disk),
        cmocka_unit_test(a_full_disk_behind_memory_is_an_error),
        cmocka_unit_test(refused_memory_means_disk),
        cmocka_unit_test(large_batches_come_out_whole),
        cmocka_unit_test(a_budget_is_part_of_what_there_is),
        WITH_BUDGETS(memory_failures_are_errors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
