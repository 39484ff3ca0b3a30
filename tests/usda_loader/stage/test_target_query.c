// Targets and connections in the stage's namespace.

#include "usda_loader/stage/usda_stage_fixture.h"

static void targets_follow_their_arc(void **state)
{
    (void)state;
    CohortStage *stage = test_open("liverps.usda", NULL);
    const CohortPrim *child = test_prim(stage, "/P/Child");
    const char *const *paths;
    assert_int_equal(cohort_prim_targets(child, "self", &paths), 1);
    assert_string_equal(paths[0], "/P/Child");
    assert_int_equal(cohort_prim_targets(child, "up", &paths), 1);
    assert_string_equal(paths[0], "/P");
    assert_int_equal(cohort_prim_targets(child, "outside", &paths), 0);
    assert_int_equal(cohort_prim_connections(child, "in", &paths), 1);
    assert_string_equal(paths[0], "/P.a3");
    assert_int_equal(cohort_prim_targets(child, "in", &paths), 0);
    assert_int_equal(cohort_prim_connections(child, "absent", &paths), 0);
    assert_true(cohort_prim_has_relationship(child, "self"));
    assert_false(cohort_prim_has_attribute(child, "self"));
    cohort_stage_destroy(stage);
}

static void list_ops_of_targets_compose(void **state)
{
    (void)state;
    CohortStage *stage = test_open("lists.usda", NULL);
    const char *const *paths, *const *again;
    const CohortPrim *prim = test_prim(stage, "/P");
    assert_int_equal(cohort_prim_targets(prim, "to", &paths), 3);
    assert_string_equal(paths[0], "/First");
    assert_string_equal(paths[1], "/A");
    assert_string_equal(paths[2], "/Z");
    assert_int_equal(cohort_prim_targets(prim, "to", &again), 3);
    assert_ptr_equal(paths, again);
    cohort_stage_destroy(stage);
}

static void prototypes_speak_of_the_first_instance(void **state)
{
    (void)state;
    CohortStage *stage = test_open("instances.usda", NULL);
    const char *const *paths;
    assert_int_equal(cohort_prim_targets(test_prim(stage, "/World/T2/Leaf"), "to", &paths), 1);
    assert_string_equal(paths[0], "/World/T1/Stem");
    cohort_stage_destroy(stage);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(targets_follow_their_arc),
        cmocka_unit_test(list_ops_of_targets_compose),
        cmocka_unit_test(prototypes_speak_of_the_first_instance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
