// A stage that is opened again says what has become different. Also tests equal.c.

#include "support/files.h"
#include "usda_loader/stage/memory_files.h"

static const char before[] =
    "#usda 1.0\n(\n subLayers = [@./sub.usda@]\n)\n"
    "def \"A\"\n{\n double x = 1\n def \"B\"\n {\n }\n def \"C\"\n {\n }\n}\n"
    "def \"I1\" (instanceable = true\n inherits = </A>)\n{\n}\n"
    "def \"I2\" (instanceable = true\n inherits = </A>)\n{\n}\n";
static const char sub[] = "#usda 1.0\nover \"A\"\n{\n float[] y = [1, 2]\n}\n";

static CohortStage *reload(const CohortStage *stage, MemoryFile *file, const char *text)
{
    file->text = text;
    CohortError err = {0};
    CohortStage *again = cohort_stage_reload(stage, &err);
    assert_non_null(again);
    return again;
}

static void expect(const CohortStage *stage, size_t i, const char *path, bool is_structural)
{
    CohortChange change;
    assert_true(cohort_stage_change(stage, i, &change));
    assert_string_equal(change.path, path);
    assert_int_equal(change.is_structural, is_structural);
}

static void changes_are_told_by_prim(void **state)
{
    (void)state;
    MemoryFile list[] = {{"/mem/root.usda", before}, {"/mem/sub.usda", sub}};
    MemoryFiles files = {.items = list, .count = 2};
    CohortStage *stage = memory_stage(&files, NULL, NULL);
    assert_int_equal(cohort_stage_change_count(stage), 0);
    CohortStage *same = reload(stage, &list[1],
                               "#usda 1.0\n# said otherwise\nover \"A\"\n{\n"
                               " float[] y = [1, 2]\n}\n");
    assert_int_equal(cohort_stage_change_count(same), 0);
    CohortStage *values =
        reload(same, &list[1], "#usda 1.0\nover \"A\"\n{\n float[] y = [1, 3]\n}\n");
    assert_int_equal(cohort_stage_change_count(values), 3);
    expect(values, 0, "/A", false);
    expect(values, 1, "/I1", false);
    expect(values, 2, "/I2", false);
    CohortStage *children = reload(values, &list[0],
                                   "#usda 1.0\n(\n subLayers = [@./sub.usda@]\n)\n"
                                   "def \"A\"\n{\n double x = 1\n def \"B\"\n {\n  int i\n }\n}\n"
                                   "def \"New\"\n{\n}\n");
    assert_true(cohort_stage_change_count(children) >= 5);
    expect(children, 0, "/", true);
    expect(children, 1, "/I1", true);
    expect(children, 2, "/I2", true);
    expect(children, 3, "/A", true);
    expect(children, 4, "/A/C", true);
    expect(children, 5, "/A/B", false);
    expect(children, 6, "/New", true);
    assert_false(cohort_stage_change(children, 7, &(CohortChange){0}));
    CohortError err = {0};
    list[0].text = "no layer";
    assert_null(cohort_stage_reload(children, &err));
    assert_int_not_equal(err.code, COHORT_OK);
    CohortStage *all[] = {stage, same, values, children};
    for (size_t i = 0; i < 4; i++)
        cohort_stage_destroy(all[i]);
}

static void files_that_stay_are_shared(void **state)
{
    (void)state;
    const char *root = in_folder("root.usda"), *under = in_folder("sub.usda");
    test_write_text(root, before);
    test_write_text(under, sub);
    CohortError err = {0};
    CohortStage *stage = cohort_stage_open(root, NULL, &err);
    assert_non_null(stage);
    CohortValue then, now;
    assert_true(cohort_prim_value(test_prim(stage, "/A"), "y", COHORT_TIME_DEFAULT, &then));
    test_write_text(root, "#usda 1.0\n(\n subLayers = [@./sub.usda@]\n)\ndef \"A\"\n{\n}\n");
    CohortStage *again = cohort_stage_reload(stage, &err);
    assert_non_null(again);
    assert_true(cohort_prim_value(test_prim(again, "/A"), "y", COHORT_TIME_DEFAULT, &now));
    assert_ptr_equal(then.data, now.data);
    cohort_stage_destroy(stage);
    assert_true(((const float *)now.data)[1] == 2);
    cohort_stage_destroy(again);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(changes_are_told_by_prim),
        cmocka_unit_test(files_that_stay_are_shared),
    };
    return cmocka_run_group_tests(tests, test_folder_make, test_folder_remove);
}
