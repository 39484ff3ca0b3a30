// Frame specs and placeholders.

#include "cli/frames.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static void assert_frames(const char *spec, const double *expected, size_t count)
{
    FrameList list = {0};
    char why[512];
    assert_true(frames_parse(spec, &list, why, sizeof why));
    assert_int_equal(list.count, count);
    for (size_t i = 0; i < count; i++)
        assert_true(list.times[i] == expected[i]);
    frames_clear(&list);
}

#define ASSERT_FRAMES(spec, ...) \
    assert_frames(spec, (const double[]){__VA_ARGS__}, \
                  sizeof((const double[]){__VA_ARGS__}) / sizeof(double))

static void specs(void **state)
{
    (void)state;
    ASSERT_FRAMES("7", 7);
    ASSERT_FRAMES("-7", -7);
    ASSERT_FRAMES("1.5", 1.5);
    ASSERT_FRAMES("1:5", 1, 2, 3, 4, 5);
    ASSERT_FRAMES("5:1", 5, 4, 3, 2, 1);
    ASSERT_FRAMES("1:9x2", 1, 3, 5, 7, 9);
    ASSERT_FRAMES("1:8x3", 1, 4, 7);
    ASSERT_FRAMES("1:2x0.5", 1, 1.5, 2);
    ASSERT_FRAMES("5:1x-2", 5, 3, 1);
    ASSERT_FRAMES("-4:0x2", -4, -2, 0);
    ASSERT_FRAMES("3:3", 3);
    ASSERT_FRAMES("1,3,2:4", 1, 3, 2, 3, 4);
}

static void the_end_is_reached_in_spite_of_rounding(void **state)
{
    (void)state;
    FrameList list = {0};
    char why[512];
    assert_true(frames_parse("0:1x0.1", &list, why, sizeof why));
    assert_int_equal(list.count, 11);
    assert_int_equal(list.precision, 1);
    frames_clear(&list);
}

static void bad_specs(void **state)
{
    (void)state;
    static const char *const specs[] = {
        "",    ",",   "1,",    "1:",   ":1",   "a",     "1:5x0", "5:1x1",     "1:5x-1", "1:5x",
        "nan", "inf", "1:inf", "0x10", "1 :5", "1:1e9", "1--2",  "1:2000000", "1:5x1e", "1.2.3"};
    for (size_t i = 0; i < sizeof specs / sizeof specs[0]; i++) {
        FrameList list = {0};
        char why[512] = "";
        if (frames_parse(specs[i], &list, why, sizeof why))
            fail_msg("\"%s\" was taken for a frame spec", specs[i]);
        assert_non_null(strstr(why, "frame spec"));
        assert_null(list.times);
    }
}

static void assert_path(const char *pattern, const char *spec, size_t frame, const char *expected)
{
    FrameList list = {0};
    char why[512] = "", path[256] = "";
    assert_true(frames_parse(spec, &list, why, sizeof why));
    bool ok = frames_path(pattern, &list, frame, path, sizeof path, why, sizeof why);
    if (ok != (expected != NULL) || (ok && strcmp(path, expected)))
        fail_msg("%s at %s: \"%s\" %s", pattern, spec, path, why);
    assert_true(ok || why[0]);
    frames_clear(&list);
}

static void placeholders(void **state)
{
    (void)state;
    assert_path("a.####.exr", "1:12", 11, "a.0012.exr");
    assert_path("a#.exr", "1:12", 11, "a12.exr");
    assert_path("##/a.exr", "7", 0, "07/a.exr");
    assert_path("a.###.###.exr", "1:2x0.5", 1, "a.001.500.exr");
    assert_path("a.###.#.exr", "1:2x0.5", 2, "a.002.0.exr");
    assert_path("a.####.exr", "-3:3", 0, "a.-003.exr");
    assert_path("a.####.exr", "123456", 0, "a.123456.exr");
    assert_path("one.exr", "7", 0, "one.exr");
    // What would write one file twice, or lose digits, is refused.
    assert_path("a.exr", "1:2", 0, NULL);
    assert_path("a.##.b.##.exr", "1:2", 0, NULL);
    assert_path("a.###.exr", "1:2x0.5", 0, NULL);
    assert_path("a.###.#.exr", "1:2x0.25", 0, NULL);
}

static void placeholder_needs_frames(void **state)
{
    (void)state;
    char why[512] = "", path[64];
    assert_false(frames_path("a.###.exr", NULL, 0, path, sizeof path, why, sizeof why));
    assert_non_null(strstr(why, "--frames"));
    assert_true(frames_path("a.exr", NULL, 0, path, sizeof path, why, sizeof why));
    assert_string_equal(path, "a.exr");
}

static void long_names_are_refused(void **state)
{
    (void)state;
    char why[512] = "", path[8];
    assert_false(frames_path("a-long-name.exr", NULL, 0, path, sizeof path, why, sizeof why));
    assert_non_null(strstr(why, "too long"));
    FrameList list = {0};
    assert_true(frames_parse("7", &list, why, sizeof why));
    assert_false(frames_path("name.####.exr", &list, 0, path, sizeof path, why, sizeof why));
    assert_non_null(strstr(why, "too long"));
    frames_clear(&list);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(specs),
        cmocka_unit_test(the_end_is_reached_in_spite_of_rounding),
        cmocka_unit_test(bad_specs),
        cmocka_unit_test(placeholders),
        cmocka_unit_test(placeholder_needs_frames),
        cmocka_unit_test(long_names_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
