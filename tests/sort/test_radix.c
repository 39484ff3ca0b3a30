// The radix sort: against a plain stable sort, over counts, bit ranges and thread counts.

#include "base/hash.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "sort/radix.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static uint32_t sort_shift;
static uint64_t sort_mask;

static int compare(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a >> sort_shift & sort_mask;
    uint64_t y = *(const uint64_t *)b >> sort_shift & sort_mask;
    return x < y ? -1 : x > y;
}

// The low 20 bits number the items, so a stable sort has one right answer.
static void check(size_t count, uint32_t first, uint32_t bits, uint64_t varying)
{
    uint64_t *items = malloc((count + 1) * 8), *temp = malloc((count + 1) * 8);
    uint64_t *expected = malloc((count + 1) * 8);
    void *histograms = malloc(co_radix_histogram_bytes());
    for (size_t i = 0; i < count; i++)
        items[i] = (co_hash64(i) & varying & ~(uint64_t)0xfffff) | i;
    memcpy(expected, items, count * 8);
    sort_shift = first;
    sort_mask = bits < 64 ? ((uint64_t)1 << bits) - 1 : UINT64_MAX;
    if (count > 0) // glibc's qsort is a merge sort here, but stability is not promised: break ties
        qsort(expected, count, sizeof *expected, compare);
    for (size_t i = 1; i < count; i++) // restore the order of equal keys
        for (size_t j = i; j > 0 && compare(&expected[j - 1], &expected[j]) == 0 &&
                           (expected[j - 1] & 0xfffff) > (expected[j] & 0xfffff);
             j--) {
            uint64_t t = expected[j];
            expected[j] = expected[j - 1];
            expected[j - 1] = t;
        }
    uint64_t *sorted = co_radix_sort(items, temp, count, first, bits, histograms);
    assert_true(sorted == items || sorted == temp);
    assert_memory_equal(sorted, expected, count * 8);
    free(items);
    free(temp);
    free(expected);
    free(histograms);
}

static void sorts_stably_for_every_shape(void **state)
{
    (void)state;
    const size_t counts[] = {0, 1, 2, 3, 63, 1000, 16384, 16385, 100003};
    for (uint32_t threads = 1; threads <= 5; threads += 2)
        for (int c = 0; c < 9; c++) {
            co_worker_count_set(threads);
            check(counts[c], 20, 44, UINT64_MAX);
            check(counts[c], 20, 1, UINT64_MAX);
            check(counts[c], 27, 11, UINT64_MAX);
            check(counts[c], 20, 44, 0x00f0000ff0000000u); // digits that never differ
            check(counts[c], 20, 0, UINT64_MAX);
        }
    co_worker_count_set(0);
}

static void bits_are_counted(void **state)
{
    (void)state;
    assert_int_equal(co_radix_bits(0), 0);
    assert_int_equal(co_radix_bits(1), 1);
    assert_int_equal(co_radix_bits(255), 8);
    assert_int_equal(co_radix_bits(256), 9);
    assert_int_equal(co_radix_bits(UINT32_MAX), 32);
}

static void scratch_grows_and_can_fail(void **state)
{
    (void)state;
    CoSortScratch scratch = {NULL, 0};
    CohortError err = {0};
    void *first = co_sort_scratch_reserve(&scratch, 1000, &err);
    assert_non_null(first);
    assert_ptr_equal(co_sort_scratch_reserve(&scratch, 10, &err), first);
    co_memory_fail_after(1);
    assert_null(co_sort_scratch_reserve(&scratch, 2000, &err));
    co_memory_fail_after(0);
    assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
    assert_non_null(co_sort_scratch_reserve(&scratch, 2000, NULL));
    co_sort_scratch_clear(&scratch);
    assert_int_equal(co_memory_live(CO_MEMORY_RAYS), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sorts_stably_for_every_shape),
        cmocka_unit_test(bits_are_counted),
        cmocka_unit_test(scratch_grows_and_can_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
