// Statistics of a delegate in each of its states: every key is there, of its type, and true.

#include "index_fixture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

static CohortRenderPass *pass;
static CohortRenderPassState view;
static CohortAovBinding binding;

static int setup(void **state)
{
    if (setup_index(state) != 0)
        return 1;
    pass = cohort_render_pass_create(render_index, NULL);
    binding = (CohortAovBinding){
        "color", cohort_render_buffer_create(delegate, 2, 2, COHORT_FORMAT_FLOAT32_VEC4, NULL)};
    view = (CohortRenderPassState){.camera = "/camera", .bindings = &binding, .binding_count = 1};
    return !cohort_render_index_insert(render_index, COHORT_PRIM_CAMERA, "/camera", &host.scene,
                                       NULL, 0, NULL);
}

static CohortSettingValue stat_of(const char *key, CohortSettingType type)
{
    CohortStat stats[32];
    size_t count = cohort_delegate_stats(delegate, stats, 32);
    for (size_t i = 0; i < count && i < 32; i++)
        if (strcmp(stats[i].key, key) == 0) {
            assert_int_equal(stats[i].value.type, type);
            assert_non_null(stats[i].value.string);
            return stats[i].value;
        }
    fail_msg("there is no %s", key);
    return (CohortSettingValue){0};
}

static void assert_state(const char *annotation, double least, double most)
{
    double fraction = stat_of("fractionDone", COHORT_SETTING_DOUBLE).number;
    double percent = stat_of("percentDone", COHORT_SETTING_DOUBLE).number;
    assert_string_equal(stat_of("renderProgressAnnotation", COHORT_SETTING_STRING).string,
                        annotation);
    assert_true(fraction >= least && fraction <= most);
    assert_true(percent >= 100.0 * least && percent <= 100.0 * most);
    assert_true(stat_of("totalClockTime", COHORT_SETTING_DOUBLE).number >= 0.0);
}

static void test_every_key_is_there(void **state)
{
    (void)state;
    assert_string_equal(stat_of("rendererName", COHORT_SETTING_STRING).string, "Cohort");
    assert_string_equal(stat_of("rendererVersion", COHORT_SETTING_STRING).string, cohort_version());
    int64_t total = stat_of("totalMemory", COHORT_SETTING_INT).integer;
    assert_true(total > 0 && total < stat_of("peakMemory", COHORT_SETTING_INT).integer);
    assert_true(stat_of("loadClockTime", COHORT_SETTING_DOUBLE).number == 0.0);
    assert_int_equal(stat_of("numCompletedSamples", COHORT_SETTING_INT).integer, 0);
    assert_int_equal(stat_of("huskErrorStatus", COHORT_SETTING_INT).integer, 0);
    assert_state("no render", 0.0, 0.0);
    CohortStat stats[32];
    size_t count = cohort_delegate_stats(delegate, stats, 32);
    for (size_t i = 0; i < count; i++)
        for (size_t k = 0; k < i; k++)
            assert_string_not_equal(stats[i].key, stats[k].key);
}

static void test_each_state_says_its_name(void **state)
{
    (void)state;
    CohortRenderStats render;
    fake.round_nanoseconds = 2000000;
    fake.rounds_to_do = 1u << 30;
    assert_true(cohort_render_pass_execute(pass, &view, NULL));
    assert_state("rendering", 0.0, 0.5);
    assert_true(cohort_delegate_render_stats(delegate, &render));
    cohort_delegate_stop(delegate, true);
    assert_state("stopped", 0.0, 0.5);
    double load = stat_of("loadClockTime", COHORT_SETTING_DOUBLE).number;
    assert_true(load > 0.0 && load < 10.0);
    fake.round_nanoseconds = 0;
    fake.rounds_to_do = 4;
    assert_true(cohort_delegate_restart(delegate));
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_state("converged", 1.0, 1.0);
    assert_int_equal(stat_of("numCompletedSamples", COHORT_SETTING_INT).integer, 4);
    assert_true(cohort_delegate_render_stats(delegate, &render));
    assert_int_equal(render.rounds, 4);
    fake.fail_round = true;
    assert_true(cohort_delegate_restart(delegate));
    cohort_render_pass_wait(pass, 10.0);
    assert_state("failed", 0.0, 0.99);
    assert_int_equal(stat_of("huskErrorStatus", COHORT_SETTING_INT).integer,
                     COHORT_ERROR_FILE_WRITE);
    cohort_render_pass_destroy(pass);
    assert_state("no render", 0.0, 0.0);
    assert_false(cohort_delegate_render_stats(delegate, &render));
}

static void test_any_capacity_will_do(void **state)
{
    (void)state;
    size_t count = cohort_delegate_stats(delegate, NULL, 0);
    for (size_t capacity = 0; capacity < 20; capacity++) {
        CohortStat stats[20];
        memset(stats, 0x5a, sizeof stats);
        CohortStat untouched = stats[19];
        assert_int_equal(cohort_delegate_stats(delegate, stats, capacity), count);
        for (size_t i = capacity; i < 20; i++)
            assert_memory_equal(&stats[i], &untouched, sizeof untouched);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_every_key_is_there, setup, teardown_index),
        cmocka_unit_test_setup_teardown(test_each_state_says_its_name, setup, teardown_index),
        cmocka_unit_test_setup_teardown(test_any_capacity_will_do, setup, teardown_index),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
