// Settings: one table, typed values, no restart for nothing.

#include "delegate_fixture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

static void test_table_is_consistent(void **state)
{
    (void)state;
    const CohortSettingDescriptor *table;
    size_t count = cohort_setting_descriptors(&table);
    assert_true(count > 20);
    for (size_t i = 0; i < count; i++) {
        assert_non_null(table[i].key);
        assert_true(strlen(table[i].description) > 5);
        assert_int_equal(table[i].type, table[i].fallback.type);
        for (size_t k = 0; k < i; k++)
            assert_string_not_equal(table[i].key, table[k].key);
        CohortSettingValue value;
        assert_true(cohort_delegate_get(delegate, table[i].key, &value));
        assert_string_equal(value.string, table[i].fallback.string);
        assert_true(cohort_delegate_set(delegate, table[i].key, &table[i].fallback, NULL));
    }
    assert_int_equal(cohort_delegate_settings_version(delegate), 0);
}

static void test_equal_value_is_no_change(void **state)
{
    (void)state;
    assert_true(cohort_delegate_set_bool(delegate, "domeLightCameraVisibility", true, NULL));
    assert_true(cohort_delegate_set_int(delegate, "cohort:spp", 64, NULL));
    assert_true(cohort_delegate_set_double(delegate, "cohort:spp", 64.0, NULL));
    assert_true(cohort_delegate_set_string(delegate, "cohort:sort", "auto", NULL));
    assert_int_equal(cohort_delegate_settings_version(delegate), 0);
    assert_true(cohort_delegate_set_int(delegate, "cohort:spp", 65, NULL));
    assert_true(cohort_delegate_set_int(delegate, "cohort:spp", 65, NULL));
    assert_int_equal(cohort_delegate_settings_version(delegate), 1);
}

static void test_aliases_reach_the_renderer(void **state)
{
    (void)state;
    CohortRenderSettings settings;
    assert_true(cohort_delegate_set_int(delegate, "convergedSamplesPerPixel", 7, NULL));
    assert_true(cohort_delegate_set_int(delegate, "threadLimit", 3, NULL));
    assert_true(cohort_delegate_set_double(delegate, "convergedVariance", 0.0004, NULL));
    assert_true(cohort_delegate_set_string(delegate, "cohort:filter", "gaussian", NULL));
    assert_true(cohort_delegate_set_string(delegate, "cohort:sort", "both", NULL));
    assert_true(cohort_delegate_set_string(delegate, "cohort:sorter", "exact", NULL));
    cohort_delegate_render_settings(delegate, &settings);
    assert_int_equal(settings.spp, 7);
    assert_int_equal(settings.threads, 3);
    assert_true(fabs(settings.noise - 0.02) < 1e-12);
    assert_int_equal(settings.filter, COHORT_FILTER_GAUSSIAN);
    assert_int_equal(settings.sort, COHORT_SORT_BOTH);
    assert_int_equal(settings.sorter, COHORT_SORTER_EXACT);
    assert_null(settings.isa);
    assert_int_equal(settings.max_depth, 6);
    assert_true(cohort_delegate_set_double(delegate, "cohort:noise", 0.5, NULL));
    cohort_delegate_render_settings(delegate, &settings);
    assert_true(settings.noise == 0.5);
}

static void expect_refused(const char *key, CohortSettingValue value, const char *word)
{
    CohortError err = {0};
    assert_false(cohort_delegate_set(delegate, key, &value, &err));
    assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
    assert_non_null(strstr(err.message, word));
}

static void test_bad_values_are_named(void **state)
{
    (void)state;
    CohortSettingValue number = {.type = COHORT_SETTING_DOUBLE, .number = 1.5};
    CohortSettingValue huge = {.type = COHORT_SETTING_DOUBLE, .number = 1e300};
    CohortSettingValue nan_value = {.type = COHORT_SETTING_DOUBLE, .number = (double)NAN};
    CohortSettingValue text = {.type = COHORT_SETTING_STRING, .string = "sideways"};
    CohortSettingValue null_text = {.type = COHORT_SETTING_STRING};
    expect_refused("cohort:speed", number, "cohort:speed");
    expect_refused("cohort:spp", number, "whole number");
    expect_refused("cohort:spp", huge, "from 1");
    expect_refused("cohort:spp", nan_value, "from 1");
    expect_refused("cohort:spp", text, "number");
    expect_refused("cohort:sort", text, "auto|none");
    expect_refused("cohort:sort", number, "text");
    expect_refused("cohort:sort", null_text, "text");
    assert_int_equal(cohort_delegate_settings_version(delegate), 0);
    assert_false(cohort_delegate_get(delegate, "cohort:speed", &number));
}

static void test_switches_reach_the_renderer(void **state)
{
    (void)state;
    CohortRenderSettings settings;
    cohort_delegate_render_settings(delegate, &settings);
    assert_false(settings.hide_domes);
    assert_true(cohort_delegate_set_bool(delegate, "domeLightCameraVisibility", false, NULL));
    cohort_delegate_render_settings(delegate, &settings);
    assert_true(settings.hide_domes && !settings.hide_lights);
    const CohortReportEntry *entries;
    assert_int_equal(cohort_delegate_report(delegate, &entries), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_table_is_consistent, setup_delegate,
                                        teardown_delegate),
        cmocka_unit_test_setup_teardown(test_equal_value_is_no_change, setup_delegate,
                                        teardown_delegate),
        cmocka_unit_test_setup_teardown(test_aliases_reach_the_renderer, setup_delegate,
                                        teardown_delegate),
        cmocka_unit_test_setup_teardown(test_bad_values_are_named, setup_delegate,
                                        teardown_delegate),
        cmocka_unit_test_setup_teardown(test_switches_reach_the_renderer, setup_delegate,
                                        teardown_delegate),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
