// Errors: the first wins, places are added, nothing overflows.

#include "base/error.h"

#include <string.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static bool check_three(int n, CohortError *err)
{
    CO_CHECK(n != 3, err, COHORT_ERROR_ARGUMENT, "%d is three", n);
    return true;
}

static const char *check_null(int n, CohortError *err)
{
    CO_CHECK_NULL(n != 3, err, COHORT_ERROR_LIMIT, "%d is three", n);
    return "fine";
}

static void the_first_failure_wins(void **state)
{
    (void)state;
    CohortError err = {0};
    assert_true(check_three(2, &err));
    assert_int_equal(err.code, COHORT_OK);
    assert_false(check_three(3, &err));
    assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
    assert_string_equal(err.message, "3 is three");
    assert_null(check_null(3, &err));
    assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
    assert_string_equal(check_null(2, &err), "fine");
    assert_false(check_three(3, NULL));
    co_error_place(NULL, "file", 1, 1, "/prim");
}

static void where_it_was_is_a_file_and_a_line(void **state)
{
    (void)state;
    CohortError err = {0};
    CO_FAIL(&err, COHORT_ERROR_INTERNAL, "here");
    assert_int_equal(strncmp(err.where, "test_error.c:", 13), 0);
    err = (CohortError){0};
    co_error_set(&err, "plain.c:1", COHORT_ERROR_INTERNAL, "there");
    assert_string_equal(err.where, "plain.c:1");
}

// What stood there before a failure, such as a place left by another, is gone.
static void leftovers_are_cleared(void **state)
{
    (void)state;
    CohortError err = {0};
    co_error_place(&err, "old.usda", 7, 9, "/Old");
    CO_FAIL(&err, COHORT_ERROR_SCENE, "new");
    assert_string_equal(err.file, "");
    assert_int_equal(err.line, 0);
    assert_string_equal(err.prim_path, "");
}

static void places_are_added_in_parts(void **state)
{
    (void)state;
    CohortError err = {0};
    CO_FAIL(&err, COHORT_ERROR_USDA_SYNTAX, "what is this");
    co_error_place(&err, "a.usda", 3, 0, NULL);
    co_error_place(&err, NULL, 0, 5, "/World");
    assert_string_equal(err.file, "a.usda");
    assert_int_equal(err.line, 3);
    assert_int_equal(err.column, 5);
    assert_string_equal(err.prim_path, "/World");
}

static void long_texts_are_cut(void **state)
{
    (void)state;
    char text[1000];
    memset(text, 'x', sizeof text - 1);
    text[sizeof text - 1] = '\0';
    CohortError err = {0};
    CO_FAIL(&err, COHORT_ERROR_LIMIT, "%s", text);
    co_error_place(&err, text, 1, 1, text);
    assert_int_equal(strlen(err.message), sizeof err.message - 1);
    assert_int_equal(strlen(err.file), sizeof err.file - 1);
    assert_int_equal(strlen(err.prim_path), sizeof err.prim_path - 1);
    assert_int_equal(err.code, COHORT_ERROR_LIMIT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_first_failure_wins),
        cmocka_unit_test(where_it_was_is_a_file_and_a_line),
        cmocka_unit_test(leftovers_are_cleared),
        cmocka_unit_test(places_are_added_in_parts),
        cmocka_unit_test(long_texts_are_cut),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
