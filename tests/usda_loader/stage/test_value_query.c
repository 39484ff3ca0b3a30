// Values over time: samples, interpolation, blocks, offsets and rates. Also tests
// edited_value.c and property_query.c.

#include "usda_loader/stage/usda_stage_fixture.h"

static double number(const CohortStage *stage, const char *prim, const char *name, double time)
{
    return cohort_prim_double(test_prim(stage, prim), name, time, -1);
}

static void floating_values_are_interpolated(void **state)
{
    (void)state;
    CohortStage *stage = test_open("times.usda", NULL);
    assert_true(number(stage, "/V", "x", 4) == 2);
    assert_true(number(stage, "/V", "x", -5) == 0); // held before
    assert_true(number(stage, "/V", "x", 10) == 5);
    assert_true(number(stage, "/V", "x", 15) == 5);  // held up to a block
    assert_true(number(stage, "/V", "x", 20) == -1); // blocked from then on
    assert_true(number(stage, "/V", "x", COHORT_TIME_DEFAULT) == -1);
    double h[3];
    assert_true(cohort_prim_numbers(test_prim(stage, "/V"), "h", 5, h, 3));
    assert_true(h[0] == 0.5 && h[1] == 1 && h[2] == 2);
    cohort_stage_destroy(stage);
}

static void the_rest_is_held(void **state)
{
    (void)state;
    CohortStage *stage = test_open("times.usda", NULL);
    const CohortPrim *v = test_prim(stage, "/V");
    assert_true(number(stage, "/V", "count", 9) == 1);
    assert_string_equal(cohort_prim_token(v, "word", 9.9, ""), "a");
    assert_string_equal(cohort_prim_token(v, "word", 10, ""), "b");
    CohortValue value;
    assert_true(cohort_prim_value(v, "same", 5, &value));
    assert_int_equal(value.count, 2);
    assert_true(((const float *)value.data)[0] == 0.5f && ((const float *)value.data)[1] == 15);
    assert_true(cohort_prim_value(v, "grows", 5, &value)); // lengths differ
    assert_int_equal(value.count, 1);
    assert_true(((const float *)value.data)[0] == 0);
    cohort_stage_destroy(stage);
}

static void quaternions_turn_at_constant_speed(void **state)
{
    (void)state;
    CohortStage *stage = test_open("times.usda", NULL);
    const float *q;
    CohortValue value;
    assert_true(cohort_prim_value(test_prim(stage, "/V"), "turn", 2.5, &value));
    q = value.data; // (x, y, z, w): an eighth turn of a half turn about z
    assert_true(fabsf(q[2] - 0.38268343f) < 1e-6f && fabsf(q[3] - 0.92387953f) < 1e-6f);
    assert_true(q[0] == 0 && q[1] == 0);
    cohort_stage_destroy(stage);
}

static void samples_beat_the_default_at_a_time(void **state)
{
    (void)state;
    CohortStage *stage = test_open("times.usda", NULL);
    assert_true(number(stage, "/V", "both", COHORT_TIME_DEFAULT) == 7);
    assert_true(number(stage, "/V", "both", 0) == 8);
    CohortValue value;
    assert_false(cohort_prim_value(test_prim(stage, "/V"), "blocked", 0, &value));
    assert_true(cohort_prim_has_attribute(test_prim(stage, "/V"), "blocked"));
    // A stronger layer's default, though blocked, hides a weaker layer's samples.
    assert_false(cohort_prim_value(test_prim(stage, "/S"), "hidden", 0, &value));
    const double *times;
    assert_int_equal(cohort_prim_time_samples(test_prim(stage, "/S"), "hidden", &times), 0);
    assert_false(cohort_prim_value(test_prim(stage, "/V"), "absent", 0, &value));
    cohort_stage_destroy(stage);
}

static void layers_keep_their_own_time(void **state)
{
    (void)state;
    CohortStage *stage = test_open("times.usda", NULL);
    const double *times;
    assert_int_equal(cohort_prim_time_samples(test_prim(stage, "/S"), "x", &times), 2);
    assert_true(times[0] == 10 && times[1] == 20);
    assert_true(number(stage, "/S", "x", 15) == 25);
    assert_true(number(stage, "/S", "mark", COHORT_TIME_DEFAULT) == 16); // 3 * 2 + 10
    // 48 time codes of the referenced layer are 24 of the stage, after an offset of 100.
    assert_int_equal(cohort_prim_time_samples(test_prim(stage, "/R"), "x", &times), 2);
    assert_true(times[0] == 100 && times[1] == 124);
    assert_true(number(stage, "/R", "x", 112) == 0.5);
    cohort_stage_destroy(stage);
}

static void curves_are_evaluated(void **state)
{
    (void)state;
    CohortStage *stage = test_open("times.usda", NULL);
    assert_true(number(stage, "/V", "curve", 5) == 10);
    assert_true(number(stage, "/V", "curve", 15) == 20);
    assert_true(number(stage, "/V", "curve", 25) == 5);
    assert_true(number(stage, "/V", "curve", -3) == 0);
    cohort_stage_destroy(stage);
}

static void assert_ints(const CohortStage *stage, const char *name, const int *expected,
                        size_t count)
{
    CohortValue value;
    assert_true(cohort_prim_value(test_prim(stage, "/A"), name, COHORT_TIME_DEFAULT, &value));
    assert_int_equal(value.type, COHORT_TYPE_INT);
    assert_int_equal(value.count, count);
    for (size_t i = 0; i < count; i++)
        assert_int_equal(((const int32_t *)value.data)[i], expected[i]);
}

static void edits_change_the_weaker_array(void **state)
{
    (void)state;
    CohortStage *stage = test_open("edits.usda", NULL);
    assert_ints(stage, "e", (const int[]){5, 0, 9, 3, 4, 5}, 6);
    assert_ints(stage, "sized", (const int[]){1, 7, 7}, 3);
    assert_ints(stage, "alone", (const int[]){1}, 1);
    assert_true(number(stage, "/A", "ab", 1) == 3);
    cohort_stage_destroy(stage);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(floating_values_are_interpolated),
        cmocka_unit_test(the_rest_is_held),
        cmocka_unit_test(quaternions_turn_at_constant_speed),
        cmocka_unit_test(samples_beat_the_default_at_a_time),
        cmocka_unit_test(layers_keep_their_own_time),
        cmocka_unit_test(curves_are_evaluated),
        cmocka_unit_test(edits_change_the_weaker_array),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
