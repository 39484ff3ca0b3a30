// The version, as programs compare it.

#include "cohort/base.h"

#include <stdio.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static void the_version_has_three_numbers(void **state)
{
    (void)state;
    unsigned major = 0, minor = 0, patch = 0;
    char rest = 0;
    assert_int_equal(sscanf(cohort_version(), "%u.%u.%u%c", &major, &minor, &patch, &rest), 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_version_has_three_numbers)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
