// The AOVs: what each is, and that no other name is one.

#include "cohort/delegate.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static void test_rows_are_found_by_name_alone(void **state)
{
    (void)state;
    const CohortAovDescriptor *table;
    size_t count = cohort_aov_descriptors(&table);
    assert_int_equal(count, 9);
    for (size_t i = 0; i < count; i++) {
        CohortAovDescriptor found = cohort_aov_descriptor(table[i].name);
        assert_string_equal(found.name, table[i].name);
        assert_int_equal(found.aov, table[i].aov);
        assert_true(found.description[0]);
        for (size_t k = 0; k < i; k++)
            assert_int_not_equal(table[k].aov, table[i].aov);
    }
}

// As many floats or integers a pixel as the renderer gives.
static void test_formats_are_the_renderers(void **state)
{
    (void)state;
    const CohortAovDescriptor *table;
    size_t count = cohort_aov_descriptors(&table);
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(cohort_format_size(table[i].format),
                         4 * cohort_aov_components(table[i].aov));
        bool is_id =
            strcmp(table[i].name, "primId") == 0 || strcmp(table[i].name, "elementId") == 0;
        assert_int_equal(table[i].format == COHORT_FORMAT_INT32, is_id);
        assert_false(is_id && table[i].filtered); // half of an id is another one
    }
}

static void test_other_names_are_none(void **state)
{
    (void)state;
    static const char *const names[] = {"",       "colour", "Color",  "color ", "colo",
                                        "depth1", "Ci",     "primid", "\xff",   NULL};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        CohortAovDescriptor none = cohort_aov_descriptor(names[i]);
        assert_int_equal(none.format, COHORT_FORMAT_NONE);
        assert_string_equal(none.name, "");
    }
    assert_int_equal(cohort_format_size(COHORT_FORMAT_NONE), 0);
    assert_int_equal(cohort_format_size((CohortFormat)-1), 0);
    assert_int_equal(cohort_format_size((CohortFormat)99), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rows_are_found_by_name_alone),
        cmocka_unit_test(test_formats_are_the_renderers),
        cmocka_unit_test(test_other_names_are_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
