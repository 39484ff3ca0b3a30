// Cameras as the adapter gives them: odd lenses are named and replaced, and what the renderer gets
// is always a window of the image's shape.

#include "stage_fixture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>

#include <cmocka.h>

static void render(const char *attributes, uint32_t width, uint32_t height)
{
    char body[512];
    snprintf(body, sizeof body, "def Camera 'C' { %s } def Mesh 'M' { $triangle }", attributes);
    open_stage(body);
    render_stage(width, height);
}

static void assert_window(double left, double right, double bottom, double top)
{
    const double expected[] = {left, right, bottom, top};
    for (int i = 0; i < 4; i++)
        if (!(fabs(fake.camera.window[i] - expected[i]) < 1e-9))
            fail_msg("window %d is %g, expected %g", i, fake.camera.window[i], expected[i]);
}

static void test_a_plain_camera(void **state)
{
    (void)state;
    render("float focalLength = 40; float horizontalAperture = 20; float verticalAperture = 10; "
           "float2 clippingRange = (2, 300)",
           40, 20);
    assert_window(-0.25, 0.25, -0.125, 0.125);
    assert_true(fake.camera.clip_near == 2.0 && fake.camera.clip_far == 300.0);
    assert_false(fake.camera.orthographic);
    assert_true(fake.camera.lens_radius == 0.0);
    const CohortReportEntry *entries;
    assert_int_equal(cohort_adapter_report(stage.adapter, &entries), 0);
}

static void test_offsets_and_orthographic(void **state)
{
    (void)state;
    render("token projection = 'orthographic'; float horizontalAperture = 20; "
           "float verticalAperture = 20; float horizontalApertureOffset = 5; "
           "float fStop = 1; float focusDistance = 3",
           10, 10);
    assert_true(fake.camera.orthographic);
    assert_window(-0.5, 1.5, -1.0, 1.0); // tenths of a unit
    assert_true(fake.camera.lens_radius == 0.0);
}

static void test_lenses(void **state)
{
    (void)state;
    render("float focalLength = 50; float fStop = 2.5; float focusDistance = 7", 10, 10);
    assert_true(fabs(fake.camera.lens_radius - 1.0) < 1e-9); // 5 units / (2 x 2.5)
    assert_true(fake.camera.focus_distance == 7.0);
}

static void test_a_focus_at_infinity_is_one(void **state)
{
    (void)state;
    render("float fStop = 2.5; float focusDistance = inf", 10, 10);
    assert_true(fake.camera.lens_radius > 0.0);
    assert_true(isfinite(fake.camera.focus_distance) && fake.camera.focus_distance > 1e12);
}

// Named, and replaced by UsdGeomCamera's defaults.
static void assert_replaced(const char *attribute, const char *name)
{
    char text[96];
    snprintf(text, sizeof text, "float %s", attribute);
    render(text, 41, 30);
    CohortCameraSource d = cohort_camera_source_default();
    const double width = d.horizontal_aperture / d.focal_length;
    if (!is_reported("/C", name))
        fail_msg("%s is not reported", attribute);
    assert_true(fabs(fake.camera.window[1] - fake.camera.window[0] - width) < 0.01);
    assert_true(fake.camera.window[3] > fake.camera.window[2]);
    close_stage(NULL);
}

static void test_lenses_that_are_none(void **state)
{
    (void)state;
    assert_replaced("focalLength = 0", "focalLength");
    assert_replaced("focalLength = -50", "focalLength");
    assert_replaced("focalLength = nan", "focalLength");
    assert_replaced("horizontalAperture = 0", "horizontalAperture");
    assert_replaced("horizontalAperture = inf", "horizontalAperture");
    assert_replaced("verticalAperture = -1", "verticalAperture");
    assert_replaced("verticalAperture = nan", "verticalAperture");
    assert_replaced("horizontalApertureOffset = nan", "horizontalApertureOffset");
    assert_replaced("verticalApertureOffset = -inf", "verticalApertureOffset");
}

// One line each: prim, attribute, and the default in its place; an open far end is none of them.
static void test_ranges_that_are_no_numbers(void **state)
{
    (void)state;
    static const struct {
        const char *range;
        double near, far;
        size_t reports;
    } cases[] = {{"(nan, 300)", 1.0, 300.0, 1},
                 {"(-inf, 300)", 1.0, 300.0, 1},
                 {"(2, nan)", 2.0, 1e6, 1},
                 {"(2, inf)", 2.0, HUGE_VAL, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[96];
        snprintf(text, sizeof text, "float2 clippingRange = %s", cases[i].range);
        render(text, 10, 10);
        assert_true(fake.camera.clip_near == cases[i].near && fake.camera.clip_far == cases[i].far);
        const CohortReportEntry *entries;
        assert_int_equal(cohort_adapter_report(stage.adapter, &entries), cases[i].reports);
        close_stage(NULL);
    }
}

static void assert_pinhole(const char *lens, const char *name)
{
    render(lens, 10, 10);
    assert_true(fake.camera.lens_radius == 0.0);
    if (!is_reported("/C", name))
        fail_msg("%s: %s is not reported", lens, name);
    close_stage(NULL);
}

static void test_no_depth_of_field(void **state)
{
    (void)state;
    assert_pinhole("float fStop = nan; float focusDistance = 3", "fStop");
    assert_pinhole("float fStop = -1; float focusDistance = 3", "fStop");
    assert_pinhole("float fStop = 2; float focusDistance = nan", "focusDistance");
    assert_pinhole("float fStop = 2; float focusDistance = -3", "focusDistance");
    assert_pinhole("float fStop = inf; float focusDistance = 3", "fStop");
}

static void test_odd_words_and_ranges(void **state)
{
    (void)state;
    static const char *const ranges[] = {"(10, 1)", "(5, 5)", "(nan, 3)", "(1, nan)"};
    for (size_t i = 0; i < sizeof ranges / sizeof *ranges; i++) {
        char text[96];
        snprintf(text, sizeof text, "float2 clippingRange = %s", ranges[i]);
        render(text, 10, 10);
        if (!is_reported("/C", "clippingRange"))
            fail_msg("%s is not reported", text);
        close_stage(NULL);
    }
    render("token projection = 'fisheye'", 10, 10);
    assert_false(fake.camera.orthographic);
    assert_true(is_reported("/C", "projection"));
}

// Only the camera that is rendered has to be one.
static void test_other_cameras_may_be_odd(void **state)
{
    (void)state;
    open_stage("def Camera 'C' {} def Camera 'Odd' { float focalLength = nan }");
    assert_false(is_reported("/Odd", "focalLength"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_a_plain_camera, close_stage),
        cmocka_unit_test_teardown(test_offsets_and_orthographic, close_stage),
        cmocka_unit_test_teardown(test_lenses, close_stage),
        cmocka_unit_test_teardown(test_a_focus_at_infinity_is_one, close_stage),
        cmocka_unit_test(test_lenses_that_are_none),
        cmocka_unit_test(test_ranges_that_are_no_numbers),
        cmocka_unit_test(test_no_depth_of_field),
        cmocka_unit_test_teardown(test_odd_words_and_ranges, close_stage),
        cmocka_unit_test_teardown(test_other_cameras_may_be_odd, close_stage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
