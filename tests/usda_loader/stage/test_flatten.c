// A flattened stage says, in one layer, what the composed one says. Also tests flat_value.c.

#include "usda_loader/stage/usda_stage_fixture.h"

#include <stdlib.h>
#include <unistd.h>

static void assert_same_prims(const CohortPrim *a, const CohortPrim *b)
{
    assert_string_equal(cohort_prim_name(a), cohort_prim_name(b));
    assert_string_equal(cohort_prim_type(a), cohort_prim_type(b));
    assert_int_equal(cohort_prim_property_count(a), cohort_prim_property_count(b));
    for (size_t i = 0; i < cohort_prim_property_count(a); i++) {
        const char *name = cohort_prim_property_name(a, i);
        assert_string_equal(name, cohort_prim_property_name(b, i));
        for (double time = -1; time < 22; time += 5.75) {
            CohortValue x = {0}, y = {0};
            assert_int_equal(cohort_prim_value(a, name, time, &x),
                             cohort_prim_value(b, name, time, &y));
            assert_int_equal(x.type, y.type);
            assert_int_equal(x.count, y.count);
        }
    }
    assert_int_equal(cohort_prim_child_count(a), cohort_prim_child_count(b));
    for (size_t i = 0; i < cohort_prim_child_count(a); i++)
        assert_same_prims(cohort_prim_child(a, i), cohort_prim_child(b, i));
}

static CohortStage *flatten(const CohortStage *stage)
{
    char path[] = "/tmp/cohort_flat_XXXXXX.usda";
    int fd = mkstemps(path, 5);
    assert_true(fd >= 0);
    close(fd);
    CohortError err = {0};
    assert_true(cohort_stage_flatten(stage, path, &err));
    CohortStageOptions options = {.strict = true};
    CohortStage *flat = cohort_stage_open(path, &options, &err);
    unlink(path);
    assert_non_null(flat);
    return flat;
}

static void nothing_is_lost(void **state)
{
    (void)state;
    static const char *const names[] = {"liverps.usda", "implied.usda",   "times.usda",
                                        "lists.usda",   "variants.usda",  "instances.usda",
                                        "assets.usda",  "relocates.usda", "xform.usda"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        CohortStage *stage = test_open(names[i], NULL);
        CohortStage *flat = flatten(stage);
        CohortStageInfo info;
        cohort_stage_info(flat, &info);
        assert_int_equal(info.layer_count, 1);
        assert_same_prims(cohort_stage_root(stage), cohort_stage_root(flat));
        cohort_stage_destroy(flat);
        cohort_stage_destroy(stage);
    }
}

static void instances_are_told_under_their_own_names(void **state)
{
    (void)state;
    CohortStage *stage = test_open("instances.usda", NULL);
    CohortStage *flat = flatten(stage);
    const char *const *paths;
    assert_int_equal(cohort_prim_targets(test_prim(flat, "/World/T2/Leaf"), "to", &paths), 1);
    assert_string_equal(paths[0], "/World/T2/Stem");
    assert_false(cohort_prim_is_instance(test_prim(flat, "/World/T2")));
    cohort_stage_destroy(flat);
    cohort_stage_destroy(stage);
}

static void a_full_disk_is_an_error(void **state)
{
    (void)state;
    CohortStage *stage = test_open("variants.usda", NULL);
    CohortError err = {0};
    assert_false(cohort_stage_flatten(stage, "/nonexistent/folder/out.usda", &err));
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
    cohort_stage_destroy(stage);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_is_lost),
        cmocka_unit_test(instances_are_told_under_their_own_names),
        cmocka_unit_test(a_full_disk_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
