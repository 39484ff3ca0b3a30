// Opening: what is known of the whole stage, limits and failures. Also tests layer_stack.c and
// prim_query.c.

#include "usda_loader/stage/usda_stage_fixture.h"

static void the_root_layer_speaks_for_the_stage(void **state)
{
    (void)state;
    CohortStage *stage = test_open("times.usda", NULL);
    CohortStageInfo info;
    cohort_stage_info(stage, &info);
    assert_string_equal(info.default_prim, "");
    assert_string_equal(info.up_axis, "Y");
    assert_true(info.meters_per_unit == 0.01 && info.frames_per_second == 24);
    assert_true(info.has_time_range && info.start_time_code == 2 && info.end_time_code == 20);
    assert_int_equal(info.layer_count, 3);
    assert_int_equal(info.prim_count, 3);
    assert_non_null(strstr(cohort_stage_layer(stage, 0), "times.usda"));
    assert_null(cohort_stage_layer(stage, 3));
    double earliest;
    assert_true(cohort_stage_earliest_time(stage, &earliest));
    assert_true(earliest == 0);
    cohort_stage_destroy(stage);
    stage = test_open("xform.usda", NULL);
    assert_true(cohort_stage_earliest_time(stage, &earliest));
    cohort_stage_destroy(stage);
    stage = test_open("lists.usda", NULL);
    assert_false(cohort_stage_earliest_time(stage, &earliest));
    cohort_stage_destroy(stage);
}

static void the_hash_is_of_the_contents(void **state)
{
    (void)state;
    CohortStageInfo a, b, c;
    CohortStage *stage = test_open("times.usda", NULL);
    cohort_stage_info(stage, &a);
    cohort_stage_destroy(stage);
    stage = test_open("times.usda", NULL);
    cohort_stage_info(stage, &b);
    cohort_stage_destroy(stage);
    stage = test_open("lists.usda", NULL);
    cohort_stage_info(stage, &c);
    cohort_stage_destroy(stage);
    assert_true(a.hash == b.hash);
    assert_true(a.hash != c.hash);
}

static void failures_say_what_is_wrong(void **state)
{
    (void)state;
    CohortError err = {0};
    assert_null(cohort_stage_open(DATA "nowhere.usda", NULL, &err));
    assert_int_equal(err.code, COHORT_ERROR_FILE_NOT_FOUND);
    err = (CohortError){0};
    assert_null(cohort_stage_open(NULL, NULL, &err));
    assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
    assert_null(cohort_stage_open("", NULL, NULL));
    cohort_stage_destroy(NULL);
}

static void limits_hold(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortStageOptions options = {.max_prims = 2};
    assert_null(cohort_stage_open(DATA "times.usda", &options, &err));
    assert_int_equal(err.code, COHORT_ERROR_LIMIT);
    err = (CohortError){0};
    options = (CohortStageOptions){.max_layers = 2};
    assert_null(cohort_stage_open(DATA "times.usda", &options, &err));
    assert_int_equal(err.code, COHORT_ERROR_LIMIT);
    err = (CohortError){0};
    options = (CohortStageOptions){.max_layers = COHORT_NO_LIMIT, .max_prims = COHORT_NO_LIMIT};
    CohortStage *stage = cohort_stage_open(DATA "times.usda", &options, &err);
    assert_non_null(stage);
    cohort_stage_destroy(stage);
}

static void paths_find_prims(void **state)
{
    (void)state;
    CohortStage *stage = test_open("variants.usda", NULL);
    assert_ptr_equal(cohort_stage_prim(stage, "/"), cohort_stage_root(stage));
    assert_string_equal(cohort_prim_path(cohort_stage_root(stage)), "/");
    assert_string_equal(cohort_prim_path(test_prim(stage, "/Garage/Mine/Body")),
                        "/Garage/Mine/Body");
    static const char *const wrong[] = {"", "Car", "/Car/", "//Car", "/Ca", "/Car/Body/x", "/."};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_null(cohort_stage_prim(stage, wrong[i]));
    assert_null(cohort_stage_prim(stage, NULL));
    cohort_stage_destroy(stage);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_root_layer_speaks_for_the_stage),
        cmocka_unit_test(the_hash_is_of_the_contents),
        cmocka_unit_test(failures_say_what_is_wrong),
        cmocka_unit_test(limits_hold),
        cmocka_unit_test(paths_find_prims),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
