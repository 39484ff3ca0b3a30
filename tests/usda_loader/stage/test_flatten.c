// A flattened stage says, in one layer, what the composed one says. Also tests flat_value.c.

#include "stage/stage_data.h"
#include "support/faults.h"
#include "support/files.h"
#include "usda_loader/stage/memory_files.h"

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

// The root layer declares a type, the layer below has a value of another: what text of that type
// can say is written so, the rest takes its own type along.
static const MemoryFile typed[] = {
    {"/mem/typed.usda", "#usda 1.0\n(\n subLayers = [@./values.usda@]\n)\n"
                        "over \"A\"\n{\n double whole\n half small\n int real\n token word\n"
                        " string text\n float[] list\n int scalar\n float3 point\n quatf turn\n"
                        " double moving\n int rising\n double curve\n int bent\n float none\n}\n"},
    {"/mem/values.usda",
     "#usda 1.0\ndef \"A\"\n{\n int whole = 3\n double small = 0.5\n double real = 1.5\n"
     " string word = \"w\"\n token text = \"t\"\n int[] list = [1, 2]\n int[] scalar = [5]\n"
     " int3 point = (1, 2, 3)\n float4 turn = (1, 0, 0, 0)\n"
     " int moving.timeSamples = {\n 0: 1,\n 4: None,\n 8: 3,\n }\n"
     " double rising.timeSamples = {\n 0: 0.5,\n 8: 1.5,\n }\n"
     " double curve.spline = {\n 0: 1,\n 8: 2,\n }\n double bent.spline = {\n 0: 1,\n 8: 2,\n }\n"
     " double none = None\n}\n"},
};

static void values_of_another_type_are_kept(void **state)
{
    (void)state;
    MemoryFiles files = FILES(typed);
    CohortStage *stage = memory_stage(&files, NULL, NULL);
    CohortStage *flat = flatten(stage);
    const CohortPrim *a = test_prim(stage, "/A"), *b = test_prim(flat, "/A");
    assert_int_equal(cohort_prim_property_count(a), cohort_prim_property_count(b));
    for (size_t i = 0; i < cohort_prim_property_count(a); i++) {
        const char *name = cohort_prim_property_name(a, i);
        for (double time = -1; time < 10; time += 1) {
            double x[4] = {0}, y[4] = {0};
            bool is_number = cohort_prim_numbers(a, name, time, x, 4);
            assert_int_equal(cohort_prim_numbers(b, name, time, y, 4), is_number);
            for (int k = 0; k < 4; k++)
                if (!(x[k] == y[k]))
                    fail_msg("%s at %g: %g became %g", name, time, x[k], y[k]);
            assert_string_equal(cohort_prim_token(a, name, time, "none"),
                                cohort_prim_token(b, name, time, "none"));
        }
    }
    test_text(flat, "/A", "word", "w");
    assert_true(cohort_prim_double(b, "real", 0, 0) == 1.5);
    cohort_stage_destroy(flat);
    cohort_stage_destroy(stage);
}

static char *flat_text(const CohortStage *stage, CohortError *err)
{
    char path[] = "/tmp/cohort_flat_XXXXXX.usda";
    int fd = mkstemps(path, 5);
    assert_true(fd >= 0);
    close(fd);
    unlink(path);
    bool ok = cohort_stage_flatten(stage, path, err);
    size_t size;
    char *text = test_read_file(path, &size);
    assert_true(ok == (text != NULL)); // a file is whole or not there
    unlink(path);
    return text;
}

static void memory_short_is_an_error(void **state)
{
    (void)state;
    CohortError err = {0};
    MemoryFiles files = FILES(typed);
    CohortStage *stage = memory_stage(&files, NULL, NULL);
    char *whole = flat_text(stage, &err);
    assert_non_null(whole);
    cohort_stage_destroy(stage);
    size_t room = 0;
    for (bool is_done = false; !is_done; room += 16) {
        err = (CohortError){0};
        stage = memory_stage(&files, NULL, NULL);
        test_arena_leave(&stage->answers_arena, room);
        char *text = flat_text(stage, &err);
        is_done = text != NULL;
        assert_int_equal(err.code, text ? COHORT_OK : COHORT_ERROR_OUT_OF_MEMORY);
        if (text)
            assert_string_equal(text, whole);
        free(text);
        stage->answers_arena.limit = 0;
        text = flat_text(stage, NULL);
        assert_string_equal(text, whole);
        free(text);
        cohort_stage_destroy(stage);
    }
    assert_true(room > 100);
    stage = memory_stage(&files, NULL, NULL);
    free(flat_text(stage, NULL)); // all answers are there then
    TestFaults faults = {0};
    while (test_faults_next(&faults)) {
        err = (CohortError){0};
        test_faults_begin(&faults);
        char *text = flat_text(stage, &err);
        test_faults_end(&faults, text != NULL, &err);
        free(text);
    }
    assert_true(faults.count > 0);
    cohort_stage_destroy(stage);
    free(whole);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_is_lost),
        cmocka_unit_test(values_of_another_type_are_kept),
        cmocka_unit_test(instances_are_told_under_their_own_names),
        cmocka_unit_test(a_full_disk_is_an_error),
        cmocka_unit_test(memory_short_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
