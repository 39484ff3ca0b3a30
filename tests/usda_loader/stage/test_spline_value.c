// Curves over time: segments, tangents, loops and what lies beyond the ends. The figures are the
// reference's.

#include "usda_loader/stage/memory_files.h"

typedef struct Sample {
    double time, value; // NaN: none
} Sample;

static void expect(const char *type, const char *spline, const Sample *samples, size_t count)
{
    char text[1024];
    snprintf(text, sizeof text, "#usda 1.0\ndef \"A\"\n{\n %s a.spline = {\n%s\n }\n}\n", type,
             spline);
    MemoryFile list[] = {{"/mem/a.usda", text}};
    MemoryFiles files = {.items = list, .count = 1};
    CohortStage *stage = memory_stage(&files, NULL, NULL);
    assert_non_null(stage);
    const CohortPrim *prim = test_prim(stage, "/A");
    for (size_t i = 0; i < count; i++) {
        double wanted = samples[i].value;
        double got = cohort_prim_double(prim, "a", samples[i].time, (double)NAN);
        if (isnan(wanted) != isnan(got) || fabs(got - wanted) > 2e-5 * fmax(1, fabs(wanted))) {
            print_error("%s at %g: %g, expected %g\n", spline, samples[i].time, got, wanted);
            fail();
        }
    }
    cohort_stage_destroy(stage);
}

#define EXPECT(spline, ...) \
    do { \
        const Sample samples[] = {__VA_ARGS__}; \
        expect("double", spline, samples, sizeof samples / sizeof *samples); \
    } while (0)

#define NONE ((double)NAN)
#define KNOTS \
    "0: 1; post curve (0.3, 2),\n1: 3; pre (0.2, -1); post linear,\n" \
    "2: 2; post curve (0.5,1),\n3: 5; pre (0.5,3); post curve (0.5, 2)"

static void beyond_the_ends(void **state)
{
    (void)state;
    EXPECT(KNOTS, {-7, 1}, {0.25, 1.582}, {1.5, 2.5}, {2.5, 3.125}, {3, 5}, {8, 5});
    EXPECT("pre: none,\npost: none,\n" KNOTS, {-1, NONE}, {0, 1}, {2, 2}, {3, NONE}, {8, NONE});
    EXPECT("pre: linear,\npost: linear,\n" KNOTS, {-7, -13}, {3.7, 7.1}, {8, 20});
    EXPECT("pre: sloped (2),\npost: sloped (2),\n" KNOTS, {-7, -13}, {3.7, 6.4}, {8, 15});
    EXPECT("pre: loop repeat,\npost: loop repeat,\n" KNOTS, {-7, -10}, {-3.5, -4.875}, {3, 5},
           {3.7, 6.66611}, {8, 10});
    EXPECT("pre: loop reset,\npost: loop reset,\n" KNOTS, {-7, 2}, {-0.25, 4.15235}, {3, 1},
           {8, 2});
    EXPECT("pre: loop oscillate,\npost: loop oscillate,\n" KNOTS, {-7, 3}, {-0.25, 1.582}, {3, 5},
           {3.7, 2.47629}, {8, 2});
}

static void ends_without_a_slope_are_flat(void **state)
{
    (void)state;
    EXPECT("pre: linear,\npost: linear,\n0: 1; post held,\n3: 5; post held", {-7, 1}, {2.5, 1},
           {8, 5});
    EXPECT("pre: linear,\npost: linear,\n0: 1; pre (1, 3); post curve (1, 2)", {-7, 1}, {8, 1});
    EXPECT("pre: linear,\npost: linear,\n0: 2 & 1; post linear,\n3: 5 & 6; post linear", {-7, 2},
           {0, 1}, {1.5, 3}, {3, 6}, {8, 6});
    EXPECT("pre: loop repeat,\npost: loop repeat,\n0: 2 & 1; post linear,\n3: 5 & 6; post linear",
           {-7, -5.33333}, {-1, 0.66667}, {4, 7.33333}, {8, 13.66667});
    EXPECT("0: 1; post none,\n1: 3; post none,\n3: 2; post none", {-1, 1}, {0, NONE}, {2, NONE},
           {3, 2});
}

static void inner_loops_repeat_and_hide(void **state)
{
    (void)state;
    EXPECT("loop: (0, 2, 1, 1, 5),\n0: 1; post linear,\n1: 3; post linear,\n2: 7; post linear,\n"
           "6: 0; post linear",
           {-7, -4}, {-1, -2}, {-0.25, 0.25}, {1.5, 4.5}, {2, 6}, {3.7, 10.1}, {4, 11},
           {5.1, 4.95});
    EXPECT("loop: (0, 2, 1, 1, 5),\npre: linear,\npost: loop repeat,\n0: 1; post linear,\n"
           "1: 3; post held,\n3.5: 9; post linear",
           {-7, -14}, {-1, -2}, {1.5, 3}, {3.7, 8}, {4, 11}, {5.1, 13}, {8, 21});
    EXPECT("loop: (1, 2, 1, 1, 5),\n0: 1; post linear,\n3: 4; post linear", {1, 2}, {2.5, 3.5});
}

static void loops_without_rounds_are_none(void **state)
{
    (void)state;
#define LINES "0: 1; post linear,\n1: 3; post linear,\n2: 7; post linear,\n6: 0; post linear"
    EXPECT("loop: (0, 2, 0, 0, 5),\n" LINES, {1.5, 5}, {2, 7});
    EXPECT("loop: (0, 2, -1, 1, 5),\n" LINES, {-1, 1}, {1.5, 4.5}, {3, 8}, {4, 11});
    EXPECT("loop: (0, 2, 1, -1, 5),\n" LINES, {-3, -4}, {-0.5, -0.5}, {1.5, 4.5}, {4, 3});
}

static void loops_at_the_ends(void **state)
{
    (void)state;
    EXPECT("post: none,\nloop: (1, 2, 1, 1, 5),\n0: 1; post linear,\n1: 3; post linear", {0, NONE},
           {0.5, 0.5}, {1, NONE}, {1.5, 5.5}, {2.5, 10.5}, {3, NONE});
    EXPECT("pre: linear,\npost: linear,\nloop: (1, 2, 1, 1, 5),\n1: 3; post linear", {-1, -2},
           {0, -2}, {0.5, 0.5}, {1, 3}, {1.5, 5.5}, {2.5, 10.5}, {3, 13}, {4, 13});
    EXPECT("pre: linear,\npost: linear,\nloop: (1, 3, 1, 1, 5),\n1: 3; post linear,\n"
           "2: 4; post linear",
           {-2, -3}, {-1, -2}, {0.5, 1}, {1, 3}, {1.5, 3.5}, {2.5, 6}, {5, 13}, {6, 17});
    // A time that rounding brings to before the prototype is still at its start.
    EXPECT("loop: (2.6, 4.1, 3, 3, 0.8806),\n1.6: 3.083; post linear,\n2.6: 4.747; post held",
           {1.1, 3.8664}, {1.2, 3.8664});
}

static void loops_bounded_by_a_knot(void **state)
{
    (void)state;
    EXPECT("pre: loop repeat(2),\npost: loop repeat ( 2 ),\n" LINES, {-9, -27}, {-0.5, -1}, {2, 7},
           {6, 0}, {6.5, -0.875}, {11, -8.75});
    EXPECT("pre: loop reset(1),\npost: loop reset(1),\n" LINES, {-1.5, 2}, {6, 3}, {7, 7}, {11, 3});
    EXPECT("pre: loop oscillate(2),\npost: loop oscillate(2),\n" LINES, {-1.5, 5}, {-0.5, 2},
           {6.5, 0.875}, {12, 3.5});
    EXPECT("pre: loop repeat(0),\npost: loop repeat(6),\n" LINES, {-9, 1}, {1, 3}, {6, 0}, {12, 0});
    EXPECT("pre: loop repeat(3),\npost: loop repeat(3),\n" LINES, {-9, NONE}, {0, 1}, {2, 7},
           {6, NONE}, {12, NONE});
}

static void a_shape_holds_for_one_segment(void **state)
{
    (void)state;
    EXPECT("0: 1; post linear,\n1: 3; pre (1, 2),\n2: 5; post linear", {0.5, 2}, {1.5, 3});
}

static void handles_never_run_backwards(void **state)
{
    (void)state;
    EXPECT("0: 0; post curve (0.9, 1),\n1: 1; pre (0.9, 1); post curve (2, 3),\n"
           "2: 3; pre (0.1, 0); post curve (1.5, 0),\n3: 0; pre (3, 1)",
           {0.25, 0.25}, {0.5, 0.5}, {1.5, 2.43546}, {2.5, -0.19652});
    EXPECT("0: 0; post curve (1.2, 0.3),\n1: 1; pre (0.5, 0.2)", {0.25, 0.08824}, {0.75, 0.54491});
    EXPECT("hermite,\n0: 0; post curve (1),\n1: 1; pre (2); post curve (3),\n2: 3; pre (0)",
           {0.25, 0.20312}, {0.5, 0.375}, {1.5, 2.375});
    EXPECT("0: 1; post curve (0.5, 1.5, autoEase),\n"
           "1: 3; pre (0.5, 1.5, autoEase); post curve (0.2, 1, autoEase),\n3: 2; pre (0.1, 1)",
           {0.25, 1.3125}, {0.5, 2}, {1.5, 2.86663}, {2.5, 2.27181});
}

static void easing_is_flat_at_breaks(void **state)
{
    (void)state;
    EXPECT("0: 1; post linear,\n1: 3; pre (0.5, 1.5, autoEase); post curve (0.2, 1, autoEase),\n"
           "3: 4 & 5; pre (0.2, 1, autoEase); post curve (0.2, 1, autoEase),\n"
           "4: 6; pre (0.1, 1); post none (1, 1),\n"
           "5: 8; pre (1, 1, autoEase); post curve (1, 1, autoEase),\n6: 9; pre (0.1, 1)",
           {1.5, 3.546875}, {2.5, 3.973958}, {3.25, 5.115379}, {3.75, 5.669236}, {5.25, 8.115379},
           {5.5, 8.359786});
}

static void types_of_numbers(void **state)
{
    (void)state;
    const Sample line[] = {{0.5, 1.16667}}, half[] = {{0.25, 1.08301}};
    expect("float", "0: 1; post linear,\n3: 2; post linear", line, 1);
    expect("timecode", "0: 1; post linear,\n3: 2; post linear", line, 1);
    expect("half", "0: 1; post linear,\n3: 2; post linear", half, 1);
    // Knots are rounded to the type before anything is made of them.
    const Sample rounded[] = {{0, 0.099976}, {1, 0.300049}, {3, 0.700195}};
    expect("half", "0: 0.1; post linear,\n3: 0.7; post linear", rounded, 3);
    const Sample far[] = {{0.5, 0}};
    expect("float", "0: 16777217; post linear,\n1: -16777216; post linear", far, 1);
    const Sample curve[] = {{1, 1.5}, {2.5, 1.8125}};
    expect("half", "0: 1; post curve (0.5, 1.3),\n3: 2; pre (0.5, 0.7)", curve, 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(beyond_the_ends),
        cmocka_unit_test(ends_without_a_slope_are_flat),
        cmocka_unit_test(inner_loops_repeat_and_hide),
        cmocka_unit_test(loops_without_rounds_are_none),
        cmocka_unit_test(loops_at_the_ends),
        cmocka_unit_test(loops_bounded_by_a_knot),
        cmocka_unit_test(a_shape_holds_for_one_segment),
        cmocka_unit_test(handles_never_run_backwards),
        cmocka_unit_test(easing_is_flat_at_breaks),
        cmocka_unit_test(types_of_numbers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
