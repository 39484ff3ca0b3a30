// What to render: options before the render settings prim before the stage, and what is no setting.

#include "stage_fixture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static CohortResolvedSettings settings(void)
{
    CohortResolvedSettings out;
    cohort_adapter_settings(stage.adapter, &out);
    return out;
}

// ---- The settings prim -------------------------------------------------------------------------

static void test_settings_and_camera(void **state)
{
    (void)state;
    open_stage("(renderSettingsPrimPath = '/Set')\n"
               "def Camera 'Other' {}"
               "def Camera 'Cam' { float horizontalAperture = 20; float verticalAperture = 10;"
               "  float focalLength = 40; float fStop = 2; float focusDistance = 5;"
               "  float2 clippingRange = (0.5, 100); float horizontalApertureOffset = 2;"
               "  double shutter:close = 0.5 }"
               "def RenderSettings 'Set' { rel camera = </Cam>;"
               "  uniform int2 resolution = (200, 100);"
               "  uniform token renderingColorSpace = 'lin_rec709_scene';"
               "  uniform float4 dataWindowNDC = (0, 0, 0.5, 1); rel products = </Set/P>;"
               "  def RenderProduct 'P' { token productName = 'out.exr';"
               "    rel orderedVars = [</Set/C>, </Set/L>, </Set/N>] }"
               "  def RenderVar 'C' { uniform string sourceName = 'color' }"
               "  def RenderVar 'L' { uniform string sourceName = 'C<RD>[<L.>]' }"
               "}"
               "def Mesh 'M' { $triangle }");
    CohortResolvedSettings s = settings();
    assert_string_equal(s.camera, "/Cam");
    assert_int_equal(s.width, 200);
    assert_int_equal(s.height, 100);
    assert_string_equal(s.product_name, "out.exr");
    assert_true(is_reported("/Set", "dataWindowNDC"));
    assert_true(is_reported("/Set/L", "sourceName"));
    assert_false(is_reported("/Set/C", "sourceName"));
    assert_true(is_reported("/Set/P", "orderedVars"));
    CohortSettingValue space;
    assert_true(cohort_delegate_get(stage.delegate, "cohort:renderingColorSpace", &space));
    assert_string_equal(space.string, "lin_rec709_scene");
    render_stage(200, 100);
    assert_true(is_reported("/Cam", "shutter:close"));
    assert_true(fabs(fake.camera.window[0] - (2.0 - 10.0) / 40.0) < 1e-7);
    assert_true(fabs(fake.camera.window[1] - (2.0 + 10.0) / 40.0) < 1e-7);
    assert_true(fabs(fake.camera.window[3] - 5.0 / 40.0) < 1e-7);
    assert_true(fabs(fake.camera.lens_radius - 1.0) < 1e-7); // 0.1 * 40 / (2 * 2)
    assert_true(fake.camera.focus_distance == 5.0 && fake.camera.clip_near == 0.5);
    render_stage(100, 100); // square: expandAperture grows the height
    assert_true(fabs(fake.camera.window[3] - 10.0 / 40.0) < 1e-7);
}

// The first product overrides the settings; further ones are named.
static void test_products_override_settings(void **state)
{
    (void)state;
    open_stage("(renderSettingsPrimPath = '/Set')\n"
               "def Camera 'A' {} def Camera 'B' {}"
               "def RenderSettings 'Set' { rel camera = </A>; rel products = [</Set/P>, </Set/Q>];"
               "  uniform int2 resolution = (200, 100); uniform float pixelAspectRatio = 2;"
               "  uniform token aspectRatioConformPolicy = 'cropAperture';"
               "  uniform token[] materialBindingPurposes = ['full', 'preview'];"
               "  uniform bool disableDepthOfField = 1;"
               "  def RenderProduct 'P' { rel camera = </B>; uniform int2 resolution = (30, 60) }"
               "  def RenderProduct 'Q' { uniform int2 resolution = (1, 1) }"
               "}");
    CohortResolvedSettings s = settings();
    assert_string_equal(s.camera, "/B");
    assert_int_equal(s.width, 30);
    assert_int_equal(s.height, 60);
    assert_int_equal(s.conform, COHORT_CONFORM_CROP_APERTURE);
    assert_true(s.pixel_aspect_ratio == 2.0 && s.disable_depth_of_field);
    assert_true(is_reported("/Set", "products"));
    assert_true(is_reported("/Set", "materialBindingPurposes"));
}

// Purposes that are none count for nothing; without any the defaults do.
static void test_included_purposes(void **state)
{
    (void)state;
    static const struct {
        const char *purposes;
        bool has_default, has_proxy;
    } cases[] = {{"['proxy']", false, true},
                 {"['default', 'proxy']", true, true},
                 {"['nonsense']", true, false},
                 {"[]", true, false}};
    for (size_t i = 0; i < 4; i++) {
        char body[512];
        snprintf(body, sizeof body,
                 "(renderSettingsPrimPath = '/Set')\n"
                 "def RenderSettings 'Set' { uniform token[] includedPurposes = %s }"
                 "def Mesh 'D' { $triangle }"
                 "def Mesh 'P' { $triangle uniform token purpose = 'proxy' }",
                 cases[i].purposes);
        open_stage(body);
        assert_int_equal(fake_mesh("/D") != NULL, cases[i].has_default);
        assert_int_equal(fake_mesh("/P") != NULL, cases[i].has_proxy);
        if (i < 3)
            close_stage(NULL);
    }
}

// A path to nothing is an error when it was asked for, and a word when the stage names it.
static void test_settings_that_are_none(void **state)
{
    (void)state;
    static const char body[] = "(renderSettingsPrimPath = '/Nowhere')\n"
                               "def Camera 'A' {}"
                               "def RenderSettings 'Odd' { rel camera = </Nobody>;"
                               "  rel products = </Nothing>;"
                               "  uniform token aspectRatioConformPolicy = 'stretch';"
                               "  uniform token[] includedPurposes = ['default', 'preview'];"
                               "  uniform float pixelAspectRatio = nan;"
                               "  uniform int2 resolution = (0, -5) }";
    open_stage(body);
    assert_true(is_reported("", "renderSettingsPrimPath"));
    assert_string_equal(settings().settings_path, "");
    close_stage(NULL);
    CohortAdapterOptions options = {.render_settings = "/Odd"};
    open_stage_with(body, &options);
    assert_string_equal(settings().camera, "/A");
    assert_int_equal(settings().width, 1280);
    assert_int_equal(settings().conform, COHORT_CONFORM_EXPAND_APERTURE);
    assert_true(is_reported("/Odd", "camera"));
    assert_true(is_reported("/Odd", "products"));
    assert_true(is_reported("/Odd", "aspectRatioConformPolicy"));
    assert_true(is_reported("/Odd", "resolution"));
    assert_true(is_reported("/Odd", "pixelAspectRatio"));
    assert_true(is_reported("/Odd", "includedPurposes"));
    assert_true(settings().pixel_aspect_ratio == 1.0);
    close_stage(NULL);
    options.render_settings = "/A";
    CohortError err = {0};
    assert_false(try_stage(body, &options, &err));
    assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
}

// ---- Camera and size ---------------------------------------------------------------------------

static void test_asked_camera_and_size(void **state)
{
    (void)state;
    CohortAdapterOptions options = {.camera = "B", .height = 50};
    open_stage_with("def Camera 'A' {}"
                    "def Xform 'X' { def Camera 'B' { float horizontalAperture = 20;"
                    "  float verticalAperture = 10 } }",
                    &options);
    assert_string_equal(settings().camera, "/X/B");
    assert_int_equal(settings().width, 100);
    assert_string_equal(cohort_adapter_camera(stage.adapter, 0), "/A");
    assert_null(cohort_adapter_camera(stage.adapter, 2));
}

static void test_main_cam_before_the_first(void **state)
{
    (void)state;
    open_stage("def Camera 'A' {} def Xform 'X' { def Camera 'main_cam' {} }");
    assert_string_equal(settings().camera, "/X/main_cam");
}

static void test_unknown_camera_is_an_error(void **state)
{
    (void)state;
    CohortAdapterOptions options = {.camera = "C"};
    CohortError err = {0};
    assert_false(try_stage("def Camera 'A' {}", &options, &err));
    assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
    assert_non_null(strstr(err.message, "\"C\""));
}

// One side follows the other by the aspect, within 1 and 65536 whatever that is.
static void test_sides(void **state)
{
    (void)state;
    static const struct {
        const char *horizontal;
        uint32_t width, height, want_width, want_height;
    } cases[] = {{"20", 0, 0, 1280, 640},
                 {"1e9", 100, 0, 100, 1},
                 {"1e9", 0, 100, 65536, 100},
                 {"1e-9", 100, 0, 100, 65536},
                 {"0", 1529, 0, 1529, 1116}}; // of UsdGeomCamera's default aperture
    for (size_t i = 0; i < 5; i++) {
        char body[128];
        snprintf(body, sizeof body,
                 "def Camera 'C' { float horizontalAperture = %s; float verticalAperture = 10 }",
                 cases[i].horizontal);
        CohortAdapterOptions options = {.width = cases[i].width, .height = cases[i].height};
        open_stage_with(body, &options);
        assert_int_equal(settings().width, cases[i].want_width);
        assert_int_equal(settings().height, cases[i].want_height);
        if (i < 4)
            close_stage(NULL);
    }
}

// A film of another stage, time, camera or light is refused by this number.
static void test_stage_hash(void **state)
{
    (void)state;
    static const char body[] = "def Camera 'A' {} def Camera 'B' {}";
    const CohortAdapterOptions options[] = {{.width = 7},
                                            {.camera = "B"},
                                            {.headlight = true},
                                            {.env = "sky"},
                                            {.time_choice = COHORT_TIME_AT, .time = 3.0},
                                            {.purposes = COHORT_PURPOSE_PROXY}};
    uint64_t hashes[6];
    for (int i = 0; i < 6; i++) {
        open_stage_with(body, &options[i]);
        hashes[i] = settings().stage_hash;
        for (int k = 0; k < i; k++)
            assert_true(hashes[k] != hashes[i]);
        if (i < 5)
            close_stage(NULL);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_settings_and_camera, close_stage),
        cmocka_unit_test_teardown(test_products_override_settings, close_stage),
        cmocka_unit_test_teardown(test_included_purposes, close_stage),
        cmocka_unit_test_teardown(test_settings_that_are_none, close_stage),
        cmocka_unit_test_teardown(test_asked_camera_and_size, close_stage),
        cmocka_unit_test_teardown(test_main_cam_before_the_first, close_stage),
        cmocka_unit_test_teardown(test_unknown_camera_is_an_error, close_stage),
        cmocka_unit_test_teardown(test_sides, close_stage),
        cmocka_unit_test_teardown(test_stage_hash, close_stage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
