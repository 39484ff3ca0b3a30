// Samples over clips. Every expected number is what the reference answers for the same stage.

#include "usda_loader/stage/usda_stage_fixture.h"

typedef struct Expected {
    double time, value; // value -1: none
} Expected;

static void check(const char *prim, const char *name, const Expected *expected, size_t count)
{
    CohortStage *stage = test_open("clip_sets.usda", NULL);
    for (size_t i = 0; i < count; i++) {
        double got = cohort_prim_double(test_prim(stage, prim), name, expected[i].time, -1);
        if (!(fabs(got - expected[i].value) < 1e-9))
            print_error("%s.%s at %g: %.17g\n", prim, name, expected[i].time, got);
        assert_true(fabs(got - expected[i].value) < 1e-9);
    }
    cohort_stage_destroy(stage);
}
#define CHECK(prim, name, ...) \
    check(prim, name, (const Expected[]){__VA_ARGS__}, \
          sizeof((const Expected[]){__VA_ARGS__}) / sizeof(Expected))

static void samples_of_all_clips_make_one_list(void **state)
{
    (void)state;
    CohortStage *stage = test_open("clip_sets.usda", NULL);
    const double *times;
    static const double expected[] = {0, 5, 10, 11, 12};
    assert_int_equal(cohort_prim_time_samples(test_prim(stage, "/Late"), "a", &times), 5);
    for (size_t i = 0; i < 5; i++)
        assert_true(times[i] == expected[i]);
    assert_int_equal(cohort_prim_time_samples(test_prim(stage, "/Jump"), "a", &times), 5);
    assert_true(times[2] < 10 && times[2] > 9.99999999 && times[3] == 10);
    cohort_stage_destroy(stage);
    CHECK("/Plain", "a", {-5, 10}, {2.5, 12.5}, {7, 57}, {10, 120}, {25, 122});
    CHECK("/Late", "a", {9, 19}, {12, 122});
    CHECK("/Late/K", "a", {2.5, 3.5}, {5, 6}, {11, -1}); // below the prim that has the clips
}

static void clip_times_are_mapped(void **state)
{
    (void)state;
    CHECK("/Jump", "a", {0, 10}, {7, 17}, {10, 110}, {15, 115}, {20, 120});
    CHECK("/Offset", "a", {100, 10}, {102.5, 15}, {105, 110}, {110, 120});
    CHECK("/Back", "a", {2.5, 15}, {4, 18}, {5, 16}, {7, 12}, {20, 10});
}

static void a_clip_without_samples_says_what_the_manifest_says(void **state)
{
    (void)state;
    CHECK("/Plain", "e", {0, 1}, {2.5, 25.5}, {10, 99});
    CHECK("/Plain", "d", {0, -1}, {10, -1}); // defaults in clips do not count
    CHECK("/Plain/K", "a", {9, 1}, {10, -1});
    CHECK("/Filled/K", "a", {9, 1}, {10, 1});
    CohortStage *stage = test_open("clip_sets.usda", NULL);
    const CohortPrim *plain = test_prim(stage, "/Plain");
    assert_string_equal(cohort_prim_token(plain, "s", 4, "none"), "x");
    assert_string_equal(cohort_prim_token(plain, "s", 9, "none"), "y");
    assert_string_equal(cohort_prim_token(plain, "s", 10, "none"), "none");
    cohort_stage_destroy(stage);
}

static void clips_are_weaker_than_their_layer_and_stronger_than_references(void **state)
{
    (void)state;
    CHECK("/Local", "a", {5, 3});
    CHECK("/Local", "e", {5, 8});
    CHECK("/Referring", "a", {5, 15}, {10, 120});
    CHECK("/Referring", "e", {0, 1}, {(double)NAN, 4});
    CHECK("/Two", "a", {5, 115});
    CHECK("/Ordered", "a", {5, 15});
}

static void templates_find_their_files(void **state)
{
    (void)state;
    CHECK("/Template", "a", {1, 11}, {2, 112}, {2.5, 112});
    CHECK("/Shifted", "a", {0.75, 10.75}, {2, 12}, {2.25, 112.25});
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_of_all_clips_make_one_list),
        cmocka_unit_test(clip_times_are_mapped),
        cmocka_unit_test(a_clip_without_samples_says_what_the_manifest_says),
        cmocka_unit_test(clips_are_weaker_than_their_layer_and_stronger_than_references),
        cmocka_unit_test(templates_find_their_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
