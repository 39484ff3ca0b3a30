// Which clips metadata makes a set, and what is said of that which does not.

#include "usda_loader/stage/usda_stage_fixture.h"

static void malformed_sets_are_named_and_left_out(void **state)
{
    (void)state;
    static const char *const said[][2] = {
        {"/NoPath|", "no absolute primPath"},
        {"/NoFiles|", "names no files"},
        {"/NoActive|", "which clip is active"},
        {"/BadIndex|", "has no file"},
        {"/NaNTime|", "not finite"},
        {"/Missing|", "none.usda"},
        {"/NoHash|", "no run of #"},
        {"/TooMany|", "too many clips"},
        {"/NoMatch|", "matches no file"},
        {"/NoStride|", "makes no sense"},
    };
    Reports reports = {0};
    CohortStage *stage = test_open("clip_faults.usda", &reports);
    for (size_t i = 0; i < sizeof said / sizeof *said; i++) {
        if (!test_was_reported(&reports, said[i][0], said[i][1]))
            print_error("%s %s\n", said[i][0], said[i][1]);
        assert_true(test_was_reported(&reports, said[i][0], said[i][1]));
    }
    // What the attribute says itself still stands.
    assert_true(cohort_prim_double(test_prim(stage, "/NoFiles"), "a", 1, 0) == 5);
    cohort_stage_destroy(stage);
}

static void sound_sets_are_silent_and_their_layers_counted(void **state)
{
    (void)state;
    Reports reports = {0};
    CohortStage *stage = test_open("clip_sets.usda", &reports);
    assert_int_equal(reports.count, 0);
    CohortStageInfo info;
    cohort_stage_info(stage, &info);
    assert_int_equal(info.layer_count, 6); // the root, one, two, the manifest, two parts
    cohort_stage_destroy(stage);
}

static void strict_opening_refuses_a_malformed_set(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortStageOptions options = {.strict = true};
    assert_null(cohort_stage_open(DATA "clip_faults.usda", &options, &err));
    assert_non_null(strstr(err.message, "clip"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(malformed_sets_are_named_and_left_out),
        cmocka_unit_test(sound_sets_are_silent_and_their_layers_counted),
        cmocka_unit_test(strict_opening_refuses_a_malformed_set),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
