// Edits of arrays within time samples: they change whenever what they edit does.

#include "usda_loader/stage/memory_files.h"

static const MemoryFile layers[] = {
    {"/mem/root.usda",
     "#usda 1.0\n(\n subLayers = [@./sub.usda@ (offset = 10; scale = 2)]\n)\n"
     "def \"A\"\n{\n"
     " int[] e.timeSamples = { 1: edit [append 5], 4: [1, 2], 8: edit [write 9 to [0]] }\n"
     " int[] g.timeSamples = { 1: edit [append 5], 4: edit [append 6; append 7] }\n"
     " int[] h = edit [append 5]\n"
     " int[] plain.timeSamples = { 3: [1] }\n}\n"},
    {"/mem/sub.usda", "#usda 1.0\nover \"A\"\n{\n int[] e = [7, 8]\n"
                      " int[] e.timeSamples = { 0: [3, 4], 2: [5, 6, 7] }\n"
                      " int[] g = [1]\n int[] h = [2]\n int[] h.timeSamples = { 0: [1] }\n"
                      " int[] plain.timeSamples = { 9: [1] }\n}\n"},
};

static void expect_times(const CohortStage *stage, const char *name, const double *wanted,
                         size_t count)
{
    const double *times;
    assert_int_equal(cohort_prim_time_samples(test_prim(stage, "/A"), name, &times), count);
    for (size_t i = 0; i < count; i++)
        assert_true(times[i] == wanted[i]);
}

static void expect_array(const CohortStage *stage, const char *name, double time, const int *wanted,
                         size_t count)
{
    CohortValue value;
    assert_true(cohort_prim_value(test_prim(stage, "/A"), name, time, &value));
    assert_int_equal(value.count, count);
    assert_memory_equal(value.data, wanted, count * sizeof *wanted);
}

static void check(const CohortStage *stage)
{
    expect_times(stage, "e", (const double[]){1, 4, 8, 10, 14}, 5);
    expect_times(stage, "g", (const double[]){1, 4}, 2);
    expect_times(stage, "h", (const double[]){10}, 1);
    expect_times(stage, "plain", (const double[]){3}, 1);
    expect_array(stage, "e", 1, (const int[]){3, 4, 5}, 3);
    expect_array(stage, "e", 4, (const int[]){1, 2}, 2);
    expect_array(stage, "e", 10, (const int[]){9, 4}, 2);
    expect_array(stage, "e", 14, (const int[]){9, 6, 7}, 3);
    expect_array(stage, "e", COHORT_TIME_DEFAULT, (const int[]){7, 8}, 2);
    expect_array(stage, "g", 4, (const int[]){1, 6, 7}, 3);
    expect_array(stage, "h", 10, (const int[]){1, 5}, 2);
    expect_array(stage, "h", COHORT_TIME_DEFAULT, (const int[]){2, 5}, 2);
}

static void edits_change_with_what_they_edit(void **state)
{
    (void)state;
    MemoryFiles files = FILES(layers);
    CohortStage *stage = memory_stage(&files, NULL, NULL);
    check(stage);
    check(stage);
    cohort_stage_destroy(stage);
}

static void flattening_writes_them_out(void **state)
{
    (void)state;
    MemoryFiles files = FILES(layers);
    CohortStage *stage = memory_stage(&files, NULL, NULL);
    CohortError err = {0};
    assert_true(cohort_stage_flatten(stage, "edited_times_flat.usda", &err));
    cohort_stage_destroy(stage);
    stage = cohort_stage_open("edited_times_flat.usda", NULL, &err);
    assert_non_null(stage);
    check(stage);
    cohort_stage_destroy(stage);
    remove("edited_times_flat.usda");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(edits_change_with_what_they_edit),
        cmocka_unit_test(flattening_writes_them_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
