// Color spaces into the rendering space: USD's built-in ones, a config's, and the way between
// them. Also tests ocio.cpp.

#include "color/color.h"
#include "color/rgb_space.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static const char config_path[] = COHORT_CONFIG;

static int no_environment(void **state)
{
    (void)state;
    return unsetenv("OCIO");
}

static void without_config_rec709_is_the_space(void **state)
{
    (void)state;
    CohortError err = {0};
    CoColor *color = co_color_create(NULL, NULL, &err);
    assert_non_null(color);
    assert_string_equal(co_color_space_name(color), "lin_rec709_scene");
    float m[9], xy[8];
    co_color_rec709_matrix(color, m);
    for (int i = 0; i < 9; i++)
        assert_true(m[i] == (i % 4 == 0 ? 1.0f : 0.0f));
    co_color_chromaticities(color, xy);
    assert_float_equal(xy[0], 0.64f, 1e-6f);
    assert_float_equal(xy[7], 0.329f, 1e-6f);
    float pixel[4] = {0.5f, 0.02f, 1.0f, 0.25f};
    assert_true(co_color_to_rendering(color, "sRGB", pixel, 1, &err));
    assert_float_equal(pixel[0], powf((0.5f + 0.055f) / 1.055f, 2.4f), 2e-7f);
    assert_float_equal(pixel[1], 0.02f / 12.92f, 1e-8f);
    assert_float_equal(pixel[2], 1.0f, 1e-7f);
    assert_true(pixel[3] == 0.25f);
    co_color_destroy(color);
}

static void data_passes_unchanged(void **state)
{
    (void)state;
    CohortError err = {0};
    CoColor *color = co_color_create(NULL, "lin_ap1_scene", &err);
    float pixel[4] = {-0.5f, 3.0f, 0.1f, 0.5f};
    assert_true(co_color_to_rendering(color, "raw", pixel, 1, &err));
    assert_true(pixel[0] == -0.5f && pixel[1] == 3.0f && pixel[2] == 0.1f);
    co_color_destroy(color);
}

static void white_stays_white(void **state)
{
    (void)state;
    static const char *const names[] = {"lin_p3d65_scene", "lin_rec2020_scene",
                                        "lin_ap1_scene",   "lin_ap0_scene",
                                        "srgb_ap1_scene",  "g22_adobergb_scene"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        CohortError err = {0};
        CoColor *color = co_color_create(NULL, NULL, &err);
        float pixel[4] = {1.0f, 1.0f, 1.0f, 1.0f};
        assert_true(co_color_to_rendering(color, names[i], pixel, 1, &err));
        for (int c = 0; c < 3; c++)
            assert_float_equal(pixel[c], 1.0f, 2e-4f);
        co_color_destroy(color);
    }
}

static void a_config_gives_its_scene_linear(void **state)
{
    (void)state;
    CohortError err = {0};
    CoColor *color = co_color_create(config_path, NULL, &err);
    assert_non_null(color);
    assert_string_equal(co_color_space_name(color), "ACEScg");
    float xy[8], pixel[4] = {0.18f, 0.18f, 0.18f, 0.5f};
    co_color_chromaticities(color, xy);
    // AP1's primaries, seen from D65: red stays near, the white is D65's.
    assert_float_equal(xy[6], 0.3127f, 2e-4f);
    assert_float_equal(xy[7], 0.3290f, 2e-4f);
    assert_true(co_color_to_rendering(color, "lin_rec709_scene", pixel, 1, &err));
    for (int c = 0; c < 3; c++)
        assert_float_equal(pixel[c], 0.18f, 1e-4f);
    assert_true(pixel[3] == 0.5f);
    co_color_destroy(color);
}

// The same conversion by our own matrices and by the config must agree.
static void config_and_built_in_agree(void **state)
{
    (void)state;
    CohortError err = {0};
    CoColor *a = co_color_create(config_path, "ACEScg", &err);
    CoColor *b = co_color_create(NULL, "lin_ap1_scene", &err);
    float p[4] = {0.8f, 0.2f, 0.05f, 1.0f}, q[4] = {0.8f, 0.2f, 0.05f, 1.0f};
    assert_true(co_color_to_rendering(a, "sRGB", p, 1, &err));
    assert_true(co_color_to_rendering(b, "sRGB", q, 1, &err));
    for (int c = 0; c < 3; c++)
        assert_float_equal(p[c], q[c], 3e-4f);
    co_color_destroy(a);
    co_color_destroy(b);
}

static void built_in_space_beside_a_config(void **state)
{
    (void)state;
    CohortError err = {0};
    CoColor *color = co_color_create(config_path, "lin_rec709_scene", &err);
    assert_non_null(color);
    float pixel[4] = {0.3f, 0.2f, 0.1f, 1.0f};
    assert_true(co_color_to_rendering(color, "Linear Rec.709 (sRGB)", pixel, 1, &err));
    assert_float_equal(pixel[0], 0.3f, 2e-4f);
    assert_float_equal(pixel[1], 0.2f, 2e-4f);
    assert_float_equal(pixel[2], 0.1f, 2e-4f);
    co_color_destroy(color);
}

static void file_rules_speak_but_for_the_default(void **state)
{
    (void)state;
    static const char config[] =
        "ocio_profile_version: 2\nroles: {scene_linear: lin, default: raw}\nfile_rules:\n"
        "  - !<Rule> {name: camera, extension: exr, pattern: \"*_cam\", colorspace: film}\n"
        "  - !<Rule> {name: gone, extension: gone, pattern: \"*\", colorspace: raw}\n"
        "  - !<Rule> {name: Default, colorspace: default}\n"
        "displays: {d: [!<View> {name: v, colorspace: raw}]}\ncolorspaces:\n"
        "  - !<ColorSpace> {name: lin}\n"
        "  - !<ColorSpace> {name: raw, isdata: true}\n"
        "  - !<ColorSpace> {name: film, to_scene_reference: !<MatrixTransform> {matrix: "
        "[2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]}}\n";
    char path[] = "/tmp/cohort-rules-XXXXXX";
    int file = mkstemp(path);
    assert_true(write(file, config, sizeof config - 1) == sizeof config - 1);
    close(file);
    CohortError err = {0};
    CoColor *color = co_color_create(path, NULL, &err);
    unlink(path);
    if (!color)
        fail_msg("%s", err.message);
    const char *space = co_color_space_of_file(color, "/sky/dawn_cam.exr");
    assert_non_null(space);
    assert_string_equal(space, "film");
    float pixel[4] = {1.0f, 0.5f, 0.25f, 1.0f};
    assert_true(co_color_to_rendering(color, space, pixel, 1, &err));
    assert_float_equal(pixel[1], 1.0f, 1e-6f);
    assert_string_equal(co_color_space_of_file(color, "a.gone"), "raw");
    assert_null(co_color_space_of_file(color, "/sky/dawn.exr"));
    assert_null(co_color_space_of_file(color, ""));
    co_color_destroy(color);
    color = co_color_create(NULL, NULL, &err);
    assert_null(co_color_space_of_file(color, "/sky/dawn_cam.exr"));
    co_color_destroy(color);
}

static void what_does_not_exist_is_named(void **state)
{
    (void)state;
    CohortError err = {0};
    assert_null(co_color_create(NULL, "no such space", &err));
    assert_int_equal(err.code, COHORT_ERROR_COLOR);
    assert_non_null(strstr(err.message, "no such space"));
    CohortError missing = {0};
    assert_null(co_color_create("/nonexistent/config.ocio", NULL, &missing));
    assert_int_equal(missing.code, COHORT_ERROR_COLOR);
    CohortError unknown = {0};
    CoColor *color = co_color_create(NULL, NULL, NULL);
    float pixel[4] = {0};
    assert_false(co_color_to_rendering(color, "ACES - Wonderland", pixel, 1, &unknown));
    assert_non_null(strstr(unknown.message, "Wonderland"));
    co_color_destroy(color);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_config_rec709_is_the_space),
        cmocka_unit_test(data_passes_unchanged),
        cmocka_unit_test(white_stays_white),
        cmocka_unit_test(a_config_gives_its_scene_linear),
        cmocka_unit_test(config_and_built_in_agree),
        cmocka_unit_test(built_in_space_beside_a_config),
        cmocka_unit_test(file_rules_speak_but_for_the_default),
        cmocka_unit_test(what_does_not_exist_is_named),
    };
    return cmocka_run_group_tests(tests, no_environment, NULL);
}
