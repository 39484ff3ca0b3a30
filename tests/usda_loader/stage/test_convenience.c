// Values with a fallback: any plain number as double, any text, and what is neither.

#include "usda_loader/stage/memory_files.h"

static const MemoryFile files[] = {
    {"/mem/values.usda",
     "#usda 1.0\ndef \"V\"\n{\n"
     " bool yes = 1\n bool no = 0\n uchar byte = 255\n int i = -2147483648\n"
     " uint u = 4294967295\n int64 i64 = -9223372036854775808\n"
     " uint64 u64 = 18446744073709551615\n half h = 0.5\n float f = 1.5\n double d = -1e300\n"
     " timecode t = 24\n double inf = inf\n double blocked = None\n"
     " quatf q = (1, 2, 3, 4)\n matrix2d m = ((1, 2), (3, 4))\n float3[] points = [(1, 2, 3), (4, "
     "5, 6)]\n"
     " double[] empty = []\n"
     " string s = \"text\"\n token k = \"name\"\n asset a = @file.usda@\n token[] some = [\"a\", "
     "\"b\"]\n"
     " token[] none = []\n"
     " double moving.timeSamples = {\n 0: 0,\n 10: 5,\n }\n}\n"},
};

static CohortStage *open_values(void)
{
    MemoryFiles memory = FILES(files);
    Reports reports = {0};
    CohortStage *stage = memory_stage(&memory, NULL, &reports);
    if (!stage || reports.count)
        fail_msg("%s", reports.text[0]);
    return stage;
}

static void numbers_are_doubles(void **state)
{
    (void)state;
    CohortStage *stage = open_values();
    const CohortPrim *v = test_prim(stage, "/V");
    static const struct {
        const char *name;
        double expected;
    } numbers[] = {{"yes", 1},        {"no", 0},        {"byte", 255},   {"i", -0x1p31},
                   {"u", 0x1p32 - 1}, {"i64", -0x1p63}, {"u64", 0x1p64}, {"h", 0.5},
                   {"f", 1.5},        {"d", -1e300},    {"t", 24},       {"inf", (double)INFINITY}};
    for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++) {
        double got = cohort_prim_double(v, numbers[k].name, COHORT_TIME_DEFAULT, -7);
        if (!(got == numbers[k].expected))
            fail_msg("%s: %g", numbers[k].name, got);
        assert_int_equal(cohort_prim_bool(v, numbers[k].name, 0, false), got != 0);
    }
    assert_true(cohort_prim_double(v, "moving", 5, -7) == 2.5);
    assert_true(cohort_prim_double(v, "moving", COHORT_TIME_DEFAULT, -7) == -7);
    cohort_stage_destroy(stage);
}

static void tuples_and_arrays_are_copied_as_far_as_they_go(void **state)
{
    (void)state;
    CohortStage *stage = open_values();
    const CohortPrim *v = test_prim(stage, "/V");
    double out[8] = {0, 0, 0, 0, 0, 0, 0, 9};
    assert_true(cohort_prim_numbers(v, "m", 0, out, 8));
    assert_true(out[0] == 1 && out[1] == 2 && out[2] == 3 && out[3] == 4);
    assert_true(out[4] == 0 && out[7] == 9); // there are four
    assert_true(cohort_prim_numbers(v, "q", 0, out, 4));
    assert_true(out[0] == 2 && out[1] == 3 && out[2] == 4 && out[3] == 1); // the real part is last
    assert_true(cohort_prim_numbers(v, "points", 0, out, 5));
    assert_true(out[3] == 4 && out[4] == 5 && out[5] == 0);
    out[0] = 9;
    assert_true(cohort_prim_numbers(v, "m", 0, out, 0));
    assert_true(out[0] == 9);
    cohort_stage_destroy(stage);
}

static void what_is_not_there_is_the_fallback(void **state)
{
    (void)state;
    CohortStage *stage = open_values();
    const CohortPrim *v = test_prim(stage, "/V");
    static const char *const none[] = {"nothing", "", "blocked", "s", "k", "a", "some", "empty"};
    for (size_t k = 0; k < sizeof none / sizeof *none; k++) {
        double out = 9;
        assert_false(cohort_prim_numbers(v, none[k], 0, &out, 1));
        assert_true(out == 9);
        assert_true(cohort_prim_double(v, none[k], 0, 3) == 3);
        assert_true(cohort_prim_bool(v, none[k], 0, true));
        assert_false(cohort_prim_bool(v, none[k], 0, false));
    }
    static const char *const no_text[] = {"nothing", "", "blocked", "i", "m", "none", "moving"};
    for (size_t k = 0; k < sizeof no_text / sizeof *no_text; k++) {
        assert_string_equal(cohort_prim_token(v, no_text[k], 0, "fallback"), "fallback");
        assert_null(cohort_prim_token(v, no_text[k], 0, NULL));
    }
    cohort_stage_destroy(stage);
}

static void text_is_a_string_token_or_asset(void **state)
{
    (void)state;
    CohortStage *stage = open_values();
    test_text(stage, "/V", "s", "text");
    test_text(stage, "/V", "k", "name");
    test_text(stage, "/V", "a", "file.usda");
    test_text(stage, "/V", "some", "a"); // the first
    cohort_stage_destroy(stage);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_doubles),
        cmocka_unit_test(tuples_and_arrays_are_copied_as_far_as_they_go),
        cmocka_unit_test(what_is_not_there_is_the_fallback),
        cmocka_unit_test(text_is_a_string_token_or_asset),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
