// The scratch memory of one pull.

#include "index/index.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>

#include <cmocka.h>

static void test_arrays_are_zeroed_and_aligned(void **state)
{
    (void)state;
    CohortPull pull = {.arena = {.tag = CO_MEMORY_DELEGATE}};
    for (size_t count = 1; count < 2000; count = 3 * count + 1) {
        unsigned char *bytes = cohort_pull_array(&pull, count, 7);
        assert_non_null(bytes);
        assert_int_equal((uintptr_t)bytes % 16, 0);
        for (size_t i = 0; i < 7 * count; i++) {
            assert_int_equal(bytes[i], 0);
            bytes[i] = 0xff; // the next one must not see it
        }
    }
    co_arena_clear(&pull.arena);
    assert_int_equal(co_memory_live(CO_MEMORY_DELEGATE), 0);
}

static void test_products_that_overflow_are_refused(void **state)
{
    (void)state;
    CohortPull pull = {.arena = {.tag = CO_MEMORY_DELEGATE}};
    assert_null(cohort_pull_array(&pull, SIZE_MAX, 2));
    assert_null(cohort_pull_array(&pull, SIZE_MAX / 4 + 2, 4));
    assert_null(cohort_pull_array(&pull, 1, SIZE_MAX));
    assert_true(pull.is_short);
    pull.is_short = false;
    co_memory_fail_after(1);
    assert_null(cohort_pull_array(&pull, 1000, 1000));
    co_memory_fail_after(0);
    assert_non_null(cohort_pull_array(&pull, 1000, 1000));
    assert_true(pull.is_short); // whatever came after
    co_arena_clear(&pull.arena);
    assert_int_equal(co_memory_live(CO_MEMORY_DELEGATE), 0);
}

// No element is no failure: hosts ask for as many as there are.
static void test_nothing_is_something(void **state)
{
    (void)state;
    CohortPull pull = {.arena = {.tag = CO_MEMORY_DELEGATE}};
    assert_non_null(cohort_pull_array(&pull, 0, 8));
    assert_non_null(cohort_pull_array(&pull, 8, 0));
    assert_false(pull.is_short);
    co_arena_clear(&pull.arena);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_arrays_are_zeroed_and_aligned),
        cmocka_unit_test(test_products_that_overflow_are_refused),
        cmocka_unit_test(test_nothing_is_something),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
