// Files of ray bins: in memory while there is some, else on disk; folders, limits and disks that
// fail.

#include "ray_bin_support.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <signal.h>
#include <stdio.h>
#include <sys/resource.h>
#include <sys/vfs.h>
#include <unistd.h>

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

static void a_budget_is_part_of_what_there_is(void **state)
{
    (void)state;
    uint64_t available = co_memory_available();
    if (!available)
        skip();
    assert_true(co_ray_bins_budget() > 0 && co_ray_bins_budget() < available);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(batches_that_left_memory_are_read_back),
        cmocka_unit_test(a_folder_that_cannot_be_used_is_an_error),
        cmocka_unit_test(a_full_disk_is_an_error_and_a_reset_gets_over_it),
        cmocka_unit_test(what_memory_does_not_hold_is_on_disk),
        cmocka_unit_test(a_full_disk_behind_memory_is_an_error),
        cmocka_unit_test(refused_memory_means_disk),
        cmocka_unit_test(a_budget_is_part_of_what_there_is),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
