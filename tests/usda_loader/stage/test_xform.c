// Xform ops: every kind, their order, inverses and resets.

#include "usda_loader/stage/usda_stage_fixture.h"

static void move(const CohortStage *stage, const char *prim, double time, const double p[3],
                 double out[3])
{
    double m[4][4];
    assert_true(cohort_prim_local_transform(test_prim(stage, prim), time, m, NULL));
    for (int j = 0; j < 3; j++)
        out[j] = p[0] * m[0][j] + p[1] * m[1][j] + p[2] * m[2][j] + m[3][j];
}

static void assert_moves(const CohortStage *stage, const char *prim, const double from[3], double x,
                         double y, double z)
{
    double p[3];
    move(stage, prim, 0, from, p);
    assert_true(fabs(p[0] - x) < 1e-6 && fabs(p[1] - y) < 1e-6 && fabs(p[2] - z) < 1e-6);
}

static const double x_axis[3] = {1, 0, 0}, y_axis[3] = {0, 1, 0}, origin[3] = {0, 0, 0};

static void ops_do_what_they_say(void **state)
{
    (void)state;
    CohortStage *stage = test_open("xform.usda", NULL);
    assert_moves(stage, "/Euler", y_axis, 1, 0, 0);
    assert_moves(stage, "/Order", x_axis, 3, 2, 3); // scaled first
    assert_moves(stage, "/Pivot", x_axis, 1, 0, 0);
    assert_moves(stage, "/Pivot", origin, 1, -1, 0);
    assert_moves(stage, "/Orient", x_axis, 0, 1, 0);
    assert_moves(stage, "/Matrix", origin, 4, 5, 6);
    assert_moves(stage, "/Single", x_axis, 2, 3, 0);
    cohort_stage_destroy(stage);
}

static void resets_unlisted_and_singular_ops(void **state)
{
    (void)state;
    CohortStage *stage = test_open("xform.usda", NULL);
    double m[4][4];
    bool resets;
    assert_true(cohort_prim_local_transform(test_prim(stage, "/Orient"), 0, m, &resets));
    assert_true(resets);
    assert_true(cohort_prim_local_transform(test_prim(stage, "/Euler"), 0, m, &resets));
    assert_false(resets);
    assert_false(cohort_prim_local_transform(test_prim(stage, "/Unlisted"), 0, m, &resets));
    assert_true(m[3][0] == 0 && m[0][0] == 1);
    // The inverse of a flattening scale does not exist: the op is passed over.
    assert_moves(stage, "/Singular", x_axis, 1, 0, 0);
    cohort_stage_destroy(stage);
}

static void transforms_move_in_time(void **state)
{
    (void)state;
    CohortStage *stage = test_open("xform.usda", NULL);
    double p[3];
    move(stage, "/Moving", 2.5, origin, p);
    assert_true(p[0] == 2.5);
    cohort_stage_destroy(stage);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ops_do_what_they_say),
        cmocka_unit_test(resets_unlisted_and_singular_ops),
        cmocka_unit_test(transforms_move_in_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
