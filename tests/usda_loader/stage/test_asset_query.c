// Asset paths: from the layer that says them.

#include "usda_loader/stage/usda_stage_fixture.h"

static const CohortAsset *asset(const CohortStage *stage, const char *name)
{
    const CohortAsset *out = NULL;
    assert_int_equal(cohort_prim_assets(test_prim(stage, "/A"), name, COHORT_TIME_DEFAULT, &out),
                     1);
    return out;
}

static bool ends_with(const char *text, const char *end)
{
    size_t n = strlen(text), m = strlen(end);
    return n >= m && !strcmp(text + n - m, end);
}

static void paths_are_anchored_and_resolved(void **state)
{
    (void)state;
    Reports reports = {0};
    CohortStage *stage = test_open("assets.usda", &reports);
    assert_string_equal(asset(stage, "here")->authored, "./assets.usda");
    assert_true(ends_with(asset(stage, "here")->resolved, "/compose/assets.usda"));
    assert_true(ends_with(asset(stage, "search")->resolved, "/compose/textures/note.txt"));
    assert_string_equal(asset(stage, "missing")->resolved, "");
    assert_true(ends_with(asset(stage, "missing")->anchored, "/compose/nothing/all.png"));
    // The reference's own path is an expression, and so is one attribute.
    assert_true(ends_with(asset(stage, "from_ref")->resolved, "/compose/textures/note.txt"));
    assert_string_equal(asset(stage, "named")->authored, "./textures/tile.txt");
    assert_true(ends_with(asset(stage, "named")->resolved, "/textures/tile.txt"));
    assert_int_equal(reports.count, 0);
    cohort_stage_destroy(stage);
}

static void tiles_stay_a_pattern(void **state)
{
    (void)state;
    CohortStage *stage = test_open("assets.usda", NULL);
    assert_true(ends_with(asset(stage, "tiles")->resolved, "/textures/cloth.<UDIM>.txt"));
    assert_string_equal(asset(stage, "no_tiles")->resolved, "");
    assert_true(ends_with(asset(stage, "no_tiles")->anchored, "/textures/wood.<UDIM>.txt"));
    cohort_stage_destroy(stage);
}

static void arrays_give_one_each(void **state)
{
    (void)state;
    CohortStage *stage = test_open("assets.usda", NULL);
    const CohortAsset *out;
    const CohortPrim *prim = test_prim(stage, "/A");
    assert_int_equal(cohort_prim_assets(prim, "several", 0, &out), 2);
    assert_string_equal(out[1].anchored, "");
    assert_string_equal(out[1].resolved, "");
    assert_int_equal(cohort_prim_assets(prim, "absent", 0, &out), 0);
    cohort_stage_destroy(stage);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(paths_are_anchored_and_resolved),
        cmocka_unit_test(tiles_stay_a_pattern),
        cmocka_unit_test(arrays_give_one_each),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
