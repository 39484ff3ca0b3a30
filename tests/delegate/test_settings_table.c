// The settings table: every row keeps its own promises, at its ends and beyond them, for every type
// of value.

#include "delegate_fixture.h"
#include "index/settings.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static const CohortSettingDescriptor *table;

static int setup(void **state)
{
    assert_int_equal(cohort_setting_descriptors(&table), CO_SETTING_COUNT);
    return setup_delegate(state);
}

static CohortSettingValue value_of(const char *key)
{
    CohortSettingValue value = {0};
    assert_true(cohort_delegate_get(delegate, key, &value));
    return value;
}

static void assert_refused(const CohortSettingDescriptor *d, const CohortSettingValue *value)
{
    CohortError err = {0};
    uint64_t version = cohort_delegate_settings_version(delegate);
    if (cohort_delegate_set(delegate, d->key, value, &err))
        fail_msg("%s took what it must not", d->key);
    assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
    assert_non_null(strstr(err.message, d->key));
    assert_int_equal(cohort_delegate_settings_version(delegate), version);
}

static void test_every_name_is_one_setting(void **state)
{
    (void)state;
    for (CoSetting i = 0; i < CO_SETTING_COUNT; i++) {
        assert_int_equal(co_setting_find(table[i].key), i);
        if (table[i].alias)
            assert_int_equal(co_setting_find(table[i].alias), i);
        assert_true(table[i].description[0]);
        assert_int_equal(table[i].fallback.type, table[i].type);
    }
    static const char *const unknown[] = {"", "cohort:", "spp", "cohort:SPP", "cohort:spp ", NULL};
    for (size_t i = 0; i < sizeof unknown / sizeof *unknown; i++)
        assert_int_equal(co_setting_find(unknown[i]), CO_SETTING_COUNT);
}

static void test_ranges_hold_at_their_ends(void **state)
{
    (void)state;
    for (CoSetting i = 0; i < CO_SETTING_COUNT; i++) {
        const CohortSettingDescriptor *d = &table[i];
        if (d->type != COHORT_SETTING_INT && d->type != COHORT_SETTING_DOUBLE)
            continue;
        assert_true(d->least < d->most);
        assert_true(cohort_delegate_set_double(delegate, d->key, d->least, NULL));
        assert_true(cohort_delegate_set_double(delegate, d->key, d->most, NULL));
        const double beyond[] = {d->least - 1.0, d->most * 2.0 + 1.0, (double)NAN, (double)INFINITY,
                                 -(double)INFINITY};
        for (size_t k = 0; k < sizeof beyond / sizeof *beyond; k++)
            assert_refused(
                d, &(CohortSettingValue){.type = COHORT_SETTING_DOUBLE, .number = beyond[k]});
        assert_refused(d, &(CohortSettingValue){.type = COHORT_SETTING_INT, .integer = INT64_MIN});
        if (d->type == COHORT_SETTING_INT)
            assert_refused(d, &(CohortSettingValue){.type = COHORT_SETTING_DOUBLE, .number = 1.5});
    }
}

static void test_types_are_converted_where_nothing_is_lost(void **state)
{
    (void)state;
    for (CoSetting i = 0; i < CO_SETTING_COUNT; i++) {
        const CohortSettingDescriptor *d = &table[i];
        const CohortSettingValue text = {.type = COHORT_SETTING_STRING, .string = "1"};
        const CohortSettingValue none = {.type = COHORT_SETTING_STRING, .string = NULL};
        if (d->type == COHORT_SETTING_STRING) {
            assert_refused(d, &none);
            assert_refused(d, &(CohortSettingValue){.type = COHORT_SETTING_INT, .integer = 1});
            assert_refused(d, &(CohortSettingValue){.type = COHORT_SETTING_BOOL, .boolean = true});
            continue;
        }
        assert_refused(d, &text);
        assert_refused(d, &none);
        assert_true(cohort_delegate_set_bool(delegate, d->key, true, NULL)); // 1 is in all ranges
        CohortSettingValue value = value_of(d->key);
        assert_int_equal(value.type, d->type);
        assert_true(value.boolean || value.integer == 1 || value.number == 1.0);
        uint64_t version = cohort_delegate_settings_version(delegate);
        assert_true(cohort_delegate_set_int(delegate, d->key, 1, NULL));
        assert_true(cohort_delegate_set_double(delegate, d->key, 1.0, NULL));
        assert_int_equal(cohort_delegate_settings_version(delegate), version); // the same value
        if (d->type == COHORT_SETTING_BOOL) {
            assert_refused(d, &(CohortSettingValue){.type = COHORT_SETTING_INT, .integer = 2});
            assert_refused(d, &(CohortSettingValue){.type = COHORT_SETTING_DOUBLE, .number = 0.5});
        }
    }
}

// "a|b|c": each of them, and nothing that is only part of it.
static void test_choices_are_whole_words(void **state)
{
    (void)state;
    for (CoSetting i = 0; i < CO_SETTING_COUNT; i++) {
        const CohortSettingDescriptor *d = &table[i];
        if (!d->choices)
            continue;
        assert_refused(d,
                       &(CohortSettingValue){.type = COHORT_SETTING_STRING, .string = d->choices});
        assert_refused(d, &(CohortSettingValue){.type = COHORT_SETTING_STRING, .string = "|"});
        size_t count = 0;
        for (const char *at = d->choices; at; count++) {
            char word[64] = {0}, longer[80];
            const char *end = strchr(at, '|');
            memcpy(word, at, end ? (size_t)(end - at) : strlen(at));
            assert_true(cohort_delegate_set_string(delegate, d->key, word, NULL));
            assert_string_equal(value_of(d->key).string, word);
            snprintf(longer, sizeof longer, "%sx", word);
            assert_refused(d,
                           &(CohortSettingValue){.type = COHORT_SETTING_STRING, .string = longer});
            at = end ? end + 1 : NULL;
        }
        assert_true(count > 1);
    }
}

static void test_failing_memory_changes_nothing(void **state)
{
    (void)state;
    assert_true(cohort_delegate_set_string(delegate, "cohort:scratchFolder", "/before", NULL));
    uint64_t version = cohort_delegate_settings_version(delegate);
    CohortError err = {0};
    co_memory_fail_after(1);
    assert_false(cohort_delegate_set_string(delegate, "cohort:scratchFolder", "/after", &err));
    co_memory_fail_after(0);
    assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
    assert_string_equal(value_of("cohort:scratchFolder").string, "/before");
    assert_int_equal(cohort_delegate_settings_version(delegate), version);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_every_name_is_one_setting, setup, teardown_delegate),
        cmocka_unit_test_setup_teardown(test_ranges_hold_at_their_ends, setup, teardown_delegate),
        cmocka_unit_test_setup_teardown(test_types_are_converted_where_nothing_is_lost, setup,
                                        teardown_delegate),
        cmocka_unit_test_setup_teardown(test_choices_are_whole_words, setup, teardown_delegate),
        cmocka_unit_test_setup_teardown(test_failing_memory_changes_nothing, setup,
                                        teardown_delegate),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
