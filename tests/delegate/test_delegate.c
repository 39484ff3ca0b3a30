// The delegate itself: made, asked and destroyed at any moment, with memory failing at each step;
// what it says of its settings, AOVs and statistics.

#include "cohort/delegate.h"

#include "base/memory.h"

#include <math.h>
#include <string.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static void failing_memory_makes_no_delegate(void **state)
{
    (void)state;
    size_t live = co_memory_live(CO_MEMORY_DELEGATE);
    bool is_made = false;
    uint64_t n = 0;
    while (!is_made && n < 200) {
        CohortError err = {0};
        co_memory_fail_after(++n);
        CohortDelegate *delegate = cohort_delegate_create(&err);
        co_memory_fail_after(0);
        is_made = delegate != NULL;
        assert_int_equal(err.code, is_made ? COHORT_OK : COHORT_ERROR_OUT_OF_MEMORY);
        cohort_delegate_destroy(delegate);
        assert_int_equal(co_memory_live(CO_MEMORY_DELEGATE), live);
    }
    assert_in_range(n, 3, 199);
    cohort_delegate_destroy(NULL);
}

static void settings_are_set_by_type(void **state)
{
    (void)state;
    CohortDelegate *delegate = cohort_delegate_create(NULL);
    CohortSettingValue value;
    CohortError err = {0};
    uint64_t version = cohort_delegate_settings_version(delegate);
    assert_true(cohort_delegate_set_int(delegate, "cohort:spp", 7, &err));
    assert_true(cohort_delegate_get(delegate, "convergedSamplesPerPixel", &value));
    assert_int_equal(value.integer, 7);
    assert_true(cohort_delegate_settings_version(delegate) != version);
    version = cohort_delegate_settings_version(delegate);
    assert_true(cohort_delegate_set_int(delegate, "cohort:spp", 7, &err)); // nothing new
    assert_int_equal(cohort_delegate_settings_version(delegate), version);
    assert_true(cohort_delegate_set_bool(delegate, "cohort:hideLights", true, &err));
    assert_true(cohort_delegate_set_double(delegate, "cohort:noise", 0.25, &err));
    assert_true(cohort_delegate_set_string(delegate, "cohort:sort", "rays", &err));
    assert_true(cohort_delegate_get(delegate, "cohort:sort", &value));
    assert_string_equal(value.string, "rays");
    assert_false(cohort_delegate_get(delegate, "cohort:nothing", &value));
    assert_false(cohort_delegate_get(delegate, NULL, &value));
    assert_int_equal(err.code, COHORT_OK);
    cohort_delegate_destroy(delegate);
}

static void wrong_settings_are_refused(void **state)
{
    (void)state;
    CohortDelegate *delegate = cohort_delegate_create(NULL);
    const int64_t bad[] = {0, -1, INT64_MIN, INT64_MAX};
    CohortSettingValue value;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        CohortError err = {0};
        assert_false(cohort_delegate_set_int(delegate, "cohort:spp", bad[i], &err));
        assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
        assert_non_null(strstr(err.message, "cohort:spp"));
    }
    const double worse[] = {-0.5, 1.5, (double)NAN, (double)INFINITY};
    for (size_t i = 0; i < sizeof worse / sizeof *worse; i++)
        assert_false(cohort_delegate_set_double(delegate, "cohort:noise", worse[i], NULL));
    assert_false(cohort_delegate_set_string(delegate, "cohort:sort", "sideways", NULL));
    assert_false(cohort_delegate_set_string(delegate, "cohort:sort", "ray", NULL));
    CohortError err = {0};
    assert_false(cohort_delegate_set_bool(delegate, "cohort:spq", true, &err));
    assert_non_null(strstr(err.message, "cohort:spq"));
    assert_false(cohort_delegate_set_bool(delegate, NULL, true, NULL));
    assert_true(cohort_delegate_get(delegate, "cohort:spp", &value));
    assert_int_equal(value.integer, 64);
    cohort_delegate_destroy(delegate);
}

// What the table says of itself can be set as it says.
static void defaults_can_be_set_again(void **state)
{
    (void)state;
    const CohortSettingDescriptor *table;
    CohortDelegate *delegate = cohort_delegate_create(NULL);
    uint64_t version = cohort_delegate_settings_version(delegate);
    size_t count = cohort_setting_descriptors(&table);
    assert_true(count > 20);
    for (size_t i = 0; i < count; i++) {
        CohortError err = {0};
        CohortSettingValue value;
        assert_true(table[i].key[0] && table[i].description[0]);
        assert_true(cohort_delegate_get(delegate, table[i].key, &value));
        assert_int_equal(value.type, table[i].type);
        assert_true(cohort_delegate_set(delegate, table[i].key, &table[i].fallback, &err));
        if (table[i].type == COHORT_SETTING_INT) {
            double number = (double)table[i].fallback.integer;
            assert_true(number >= table[i].least && number <= table[i].most);
        }
        for (size_t k = 0; k < i; k++)
            assert_string_not_equal(table[k].key, table[i].key);
    }
    assert_int_equal(cohort_delegate_settings_version(delegate), version);
    cohort_delegate_destroy(delegate);
}

static void aovs_are_found_by_name(void **state)
{
    (void)state;
    const CohortAovDescriptor *table;
    size_t count = cohort_aov_descriptors(&table);
    assert_true(count >= 9);
    for (size_t i = 0; i < count; i++) {
        CohortAovDescriptor found = cohort_aov_descriptor(table[i].name);
        assert_int_equal(found.aov, table[i].aov);
        assert_true(cohort_format_size(found.format) > 0);
    }
    assert_int_equal(cohort_format_size(COHORT_FORMAT_NONE), 0);
    assert_int_equal(cohort_format_size(COHORT_FORMAT_FLOAT32_VEC3), 12);
    assert_string_equal(cohort_aov_descriptor("Color").name, "");
    assert_string_equal(cohort_aov_descriptor("").name, "");
    assert_string_equal(cohort_aov_descriptor(NULL).name, "");
    assert_true(isinf(cohort_aov_descriptor("cameraDepth").clear[0]));
}

static void statistics_fit_where_they_are_put(void **state)
{
    (void)state;
    CohortDelegate *delegate = cohort_delegate_create(NULL);
    CohortStat stats[32];
    memset(stats, 0x55, sizeof stats);
    size_t count = cohort_delegate_stats(delegate, NULL, 0);
    assert_in_range(count, 5, 32);
    CohortStat guard = stats[3];
    assert_int_equal(cohort_delegate_stats(delegate, stats, 3), count);
    assert_memory_equal(&stats[3], &guard, sizeof guard);
    assert_int_equal(cohort_delegate_stats(delegate, stats, 32), count);
    bool has_annotation = false;
    for (size_t i = 0; i < count; i++) {
        if (strcmp(stats[i].key, "renderProgressAnnotation") == 0) {
            assert_string_equal(stats[i].value.string, "no render");
            has_annotation = true;
        }
        if (strcmp(stats[i].key, "fractionDone") == 0)
            assert_true(stats[i].value.number == 0.0);
    }
    assert_true(has_annotation);
    CohortRenderStats render;
    assert_false(cohort_delegate_render_stats(delegate, &render));
    cohort_delegate_destroy(delegate);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(failing_memory_makes_no_delegate),
        cmocka_unit_test(settings_are_set_by_type),
        cmocka_unit_test(wrong_settings_are_refused),
        cmocka_unit_test(defaults_can_be_set_again),
        cmocka_unit_test(aovs_are_found_by_name),
        cmocka_unit_test(statistics_fit_where_they_are_put),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
