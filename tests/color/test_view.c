// Views: what people see, through the shipped config and others.

#include "cohort/image.h"

#include "shims/oiio.h"
#include "support/faults.h"
#include "support/files.h"

#include <math.h>

static int enter(void **state)
{
    unsetenv("OCIO");
    return test_folder_enter(state);
}

static CohortView *open_view(const char *config, const char *space, const char *display,
                             const char *name)
{
    CohortError err = {0};
    CohortView *view = cohort_view_create(config, space, display, name, &err);
    if (!view)
        fail_msg("%s: %s", config ? config : "shipped", err.message);
    return view;
}

static void show(const CohortView *view, const float in[3], float out[3])
{
    float pixel[4] = {in[0], in[1], in[2], 1.0f};
    assert_true(cohort_view_apply(view, pixel, 1, NULL, &(CohortError){0}));
    memcpy(out, pixel, 3 * sizeof *out);
}

static void the_default_is_the_srgb_curve(void **state)
{
    (void)state;
    CohortView *view = open_view(NULL, NULL, NULL, NULL);
    assert_string_equal(cohort_view_display_name(view), "sRGB - Display");
    assert_string_equal(cohort_view_view_name(view), "Un-tone-mapped");
    assert_true(cohort_view_config_name(view)[0] && cohort_view_config_cache_id(view)[0]);
    for (int i = 0; i <= 256; i++) {
        double x = (double)i / 256.0;
        double y = x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055;
        float in[3] = {(float)x, (float)(x * x), 0.5f}, out[3];
        show(view, in, out);
        if (fabs((double)out[0] - y) > 2e-5)
            fail_msg("%g shows as %.9g, expected %.9g", x, (double)out[0], y);
    }
    cohort_view_destroy(view);
}

static void gray_through_the_aces_view(void **state)
{
    (void)state;
    static const char *const spaces[] = {"lin_rec709_scene", "lin_ap1_scene", NULL};
    for (int i = 0; i < 3; i++) {
        CohortView *view = open_view(NULL, spaces[i], "sRGB - Display", "ACES 1.0 - SDR Video");
        float gray[3] = {0.18f, 0.18f, 0.18f}, out[3];
        show(view, gray, out);
        for (int c = 0; c < 3; c++)
            assert_float_equal(out[c], 0.356f, 0.002f);
        cohort_view_destroy(view);
    }
}

// Built-in spaces reach a config that does not know their names; white stays white, and a color
// looks the same whichever space it is given in.
static void a_built_in_rendering_space(void **state)
{
    (void)state;
    CohortView *view = open_view(NULL, "lin_ap1_scene", NULL, NULL);
    // Linear Rec.709 (0.8, 0.2, 0.05) in AP1 primaries, white adapted to D65.
    float white[3] = {1.0f, 1.0f, 1.0f}, out[3];
    show(view, white, out);
    for (int c = 0; c < 3; c++)
        assert_float_equal(out[c], 1.0f, 3e-4f);
    CohortView *rec709 = open_view(NULL, "lin_rec709_scene", NULL, NULL);
    const float in_709[3] = {0.8f, 0.2f, 0.05f};
    const float in_ap1[3] = {0.8f * 0.613097f + 0.2f * 0.339523f + 0.05f * 0.047379f,
                             0.8f * 0.070194f + 0.2f * 0.916354f + 0.05f * 0.013452f,
                             0.8f * 0.020616f + 0.2f * 0.109570f + 0.05f * 0.869815f};
    float a[3], b[3];
    show(view, in_ap1, a);
    show(rec709, in_709, b);
    for (int c = 0; c < 3; c++)
        assert_float_equal(a[c], b[c], 5e-4f);
    cohort_view_destroy(view);
    cohort_view_destroy(rec709);
}

static void alpha_is_left_alone(void **state)
{
    (void)state;
    CohortView *view = open_view(NULL, NULL, "sRGB - Display", "ACES 1.0 - SDR Video");
    const float alphas[] = {0.0f, -0.0f, 1.0f, 0.3f, -2.0f, 7.5f, 1e-40f, 1.0f / 3.0f};
    for (size_t i = 0; i < sizeof alphas / sizeof alphas[0]; i++) {
        float pixel[4] = {0.2f, 3.0f, -0.1f, alphas[i]};
        assert_true(cohort_view_apply(view, pixel, 1, NULL, &(CohortError){0}));
        assert_memory_equal(&pixel[3], &alphas[i], sizeof(float));
    }
    cohort_view_destroy(view);
}

static void what_is_no_number_is_replaced_and_counted(void **state)
{
    (void)state;
    CohortView *view = open_view(NULL, NULL, NULL, NULL);
    float pixels[12] = {NAN,  0.5f, INFINITY,  1.0f, 0.1f, 0.2f,
                        0.3f, 1.0f, -INFINITY, -NAN, 0.0f, 1.0f};
    uint64_t replaced = 99;
    assert_true(cohort_view_apply(view, pixels, 3, &replaced, &(CohortError){0}));
    assert_int_equal(replaced, 4);
    for (int i = 0; i < 12; i++)
        assert_true(pixels[i] == pixels[i]);
    assert_true(pixels[0] == 0.0f && pixels[2] > 1.0f);
    float fine[4] = {0.1f, 0.2f, 0.3f, 1.0f};
    assert_true(cohort_view_apply(view, fine, 1, &replaced, &(CohortError){0}));
    assert_int_equal(replaced, 0);
    assert_true(cohort_view_apply(view, NULL, 0, &replaced, &(CohortError){0}));
    cohort_view_destroy(view);
}

static void unknown_names_are_answered_with_known_ones(void **state)
{
    (void)state;
    CohortError display = {0}, view = {0}, space = {0}, config = {0};
    assert_null(cohort_view_create(NULL, NULL, "Projector", NULL, &display));
    assert_int_equal(display.code, COHORT_ERROR_ARGUMENT);
    assert_non_null(strstr(display.message, "Projector"));
    assert_non_null(strstr(display.message, "sRGB - Display"));
    assert_null(cohort_view_create(NULL, NULL, "sRGB - Display", "Sepia", &view));
    assert_int_equal(view.code, COHORT_ERROR_ARGUMENT);
    assert_non_null(strstr(view.message, "ACES 1.0 - SDR Video"));
    assert_null(cohort_view_create(NULL, "lin_mars_scene", NULL, NULL, &space));
    assert_non_null(strstr(space.message, "lin_mars_scene"));
    assert_null(cohort_view_create("none.ocio", NULL, NULL, NULL, &config));
    assert_int_equal(config.code, COHORT_ERROR_COLOR);
    assert_non_null(strstr(config.message, "none.ocio"));
}

static void the_environment_names_the_config(void **state)
{
    (void)state;
    setenv("OCIO", "none.ocio", 1);
    CohortError err = {0};
    assert_null(cohort_view_create(NULL, NULL, NULL, NULL, &err));
    assert_non_null(strstr(err.message, "none.ocio"));
    setenv("OCIO", COHORT_CONFIG, 1);
    CohortView *view = open_view(NULL, NULL, NULL, NULL);
    assert_string_equal(cohort_view_view_name(view), "ACES 1.0 - SDR Video");
    cohort_view_destroy(view);
    unsetenv("OCIO");
}

static void a_png_holds_what_the_view_shows(void **state)
{
    (void)state;
    CohortView *view = open_view(NULL, NULL, NULL, NULL);
    // Premultiplied: the last pixel is white, half covered.
    const float pixels[16] = {1.0f, 0.0f, 0.5f,  1.0f, 0.0f, 0.0f, 0.0f, 0.0f,
                              9.0f, NAN,  -1.0f, 1.0f, 0.5f, 0.5f, 0.5f, 0.5f};
    const int bytes[16] = {255, 0, 188, 255, 0, 0, 0, 0, 255, 0, 0, 255, 255, 255, 255, 128};
    CohortError err = {0};
    assert_true(cohort_png_write("view.png", 2, 2, pixels, view, &err));
    CoOiioInfo info;
    float back[16];
    assert_true(co_oiio_info("view.png", &info, &err));
    assert_int_equal(info.width, 2);
    assert_int_equal(info.height, 2);
    assert_int_equal(info.channels, 4);
    assert_true(info.is_8bit);
    assert_true(co_oiio_read("view.png", &info, back, &err));
    for (int i = 0; i < 16; i++)
        if ((int)lrintf(back[i] * 255.0f) != bytes[i])
            fail_msg("value %d is %g, expected %d", i, (double)(back[i] * 255.0f), bytes[i]);
    CohortError unwritten = {0}, taken = {0};
    assert_false(cohort_png_write("nofolder/a.png", 2, 2, pixels, view, &unwritten));
    assert_int_equal(unwritten.code, COHORT_ERROR_FILE_WRITE);
    assert_string_equal(unwritten.message,
                        "cannot write nofolder/a.png: No such file or directory");
    assert_int_equal(mkdir("taken.png", 0777), 0);
    assert_false(cohort_png_write("taken.png", 2, 2, pixels, view, &taken));
    assert_non_null(strstr(taken.message, "irectory"));
    cohort_view_destroy(view);
    assert_int_equal(system("ls | grep -q partial"), 256);
}

static void views_and_pictures_need_memory(void **state)
{
    (void)state;
    TestFaults faults = {0};
    while (test_faults_next(&faults)) {
        CohortError err = {0};
        test_faults_begin(&faults);
        CohortView *view = cohort_view_create(COHORT_CONFIG, NULL, NULL, NULL, &err);
        test_faults_end(&faults, view != NULL, &err);
        cohort_view_destroy(view);
    }
    assert_int_equal(faults.count, 2);
    CohortView *view = open_view(NULL, NULL, NULL, NULL);
    const float pixel[4] = {1.0f, 0.0f, 0.5f, 1.0f};
    for (faults = (TestFaults){0}; test_faults_next(&faults);) {
        CohortError err = {0};
        test_faults_begin(&faults);
        bool ok = cohort_png_write("short.png", 1, 1, pixel, view, &err);
        test_faults_end(&faults, ok, &err);
        assert_int_equal(access("short.png", F_OK), ok ? 0 : -1);
        unlink("short.png");
    }
    assert_int_equal(faults.count, 2);
    cohort_view_destroy(view);
    assert_int_equal(system("ls | grep -q partial"), 256);
}

static void every_good_config_has_a_default_view(void **state)
{
    (void)state;
    const char *configs = COHORT_SHARED_DIR "/color/configs/good";
    DIR *d = opendir(configs);
    if (!d)
        skip();
    int seen = 0;
    for (struct dirent *entry; (entry = readdir(d)) != NULL;) {
        char path[1024];
        snprintf(path, sizeof path, "%s/%s/config.ocio", configs, entry->d_name);
        if (entry->d_name[0] == '.' || access(path, R_OK))
            continue;
        CohortView *view = open_view(path, NULL, NULL, NULL);
        float gray[3] = {0.18f, 0.18f, 0.18f}, out[3];
        show(view, gray, out);
        assert_true(isfinite(out[0]) && cohort_view_view_name(view)[0]);
        cohort_view_destroy(view);
        seen++;
    }
    closedir(d);
    assert_true(seen >= 6);
}

// Two color spaces, each defined through the other.
static const char cyclic_config[] =
    "ocio_profile_version: 2.1\n"
    "roles:\n  scene_linear: base\n  default: base\n"
    "file_rules:\n  - !<Rule> {name: Default, colorspace: base}\n"
    "displays:\n  Monitor:\n    - !<View> {name: Plain, colorspace: a}\n"
    "colorspaces:\n"
    "  - !<ColorSpace>\n    name: base\n"
    "  - !<ColorSpace>\n    name: a\n"
    "    to_scene_reference: !<ColorSpaceTransform> {src: b, dst: base}\n"
    "  - !<ColorSpace>\n    name: b\n"
    "    to_scene_reference: !<ColorSpaceTransform> {src: a, dst: base}\n";

static void definitions_in_a_circle_are_refused(void **state)
{
    (void)state;
    test_write_text("cycle.ocio", cyclic_config);
    CohortError err = {0};
    assert_null(cohort_view_create("cycle.ocio", NULL, NULL, NULL, &err));
    assert_int_equal(err.code, COHORT_ERROR_COLOR);
    assert_non_null(strstr(err.message, "defined through itself"));
}

// A broken config is an error or a picture, never the end of the program.
static void broken_configs_are_survived(void **state)
{
    (void)state;
    const char *configs = COHORT_SHARED_DIR "/color/configs/broken";
    DIR *d = opendir(configs);
    if (!d)
        skip();
    for (struct dirent *entry; (entry = readdir(d)) != NULL;) {
        char path[1024];
        snprintf(path, sizeof path, "%s/%s/config.ocio", configs, entry->d_name);
        if (entry->d_name[0] == '.' || access(path, R_OK))
            continue;
        CohortError err = {0};
        CohortView *view = cohort_view_create(path, NULL, NULL, NULL, &err);
        assert_true((view != NULL) == (err.code == COHORT_OK));
        assert_true(view || err.message[0]);
        cohort_view_destroy(view);
    }
    closedir(d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_default_is_the_srgb_curve),
        cmocka_unit_test(gray_through_the_aces_view),
        cmocka_unit_test(a_built_in_rendering_space),
        cmocka_unit_test(alpha_is_left_alone),
        cmocka_unit_test(what_is_no_number_is_replaced_and_counted),
        cmocka_unit_test(unknown_names_are_answered_with_known_ones),
        cmocka_unit_test(the_environment_names_the_config),
        cmocka_unit_test(a_png_holds_what_the_view_shows),
        cmocka_unit_test(views_and_pictures_need_memory),
        cmocka_unit_test(every_good_config_has_a_default_view),
        cmocka_unit_test(definitions_in_a_circle_are_refused),
        cmocka_unit_test(broken_configs_are_survived),
    };
    return cmocka_run_group_tests(tests, enter, test_folder_leave);
}
