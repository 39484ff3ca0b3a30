// Which color space an image is taken to be in, and what its converted form is.

#include "png_support.h"
#include "texture_support.h"

#include "base/memory.h"
#include "texture/image_convert.h"
#include "texture/image_file.h"

#include <math.h>

static const char *ruled; // what the rule of the test says of every file

static const char *rule(void *cookie, const char *path)
{
    (void)cookie, (void)path;
    return ruled;
}

static bool halve(void *cookie, const char *space, float *pixels, size_t count, CohortError *err)
{
    (void)cookie, (void)space, (void)err;
    for (size_t i = 0; i < 4 * count; i++)
        pixels[i] *= i % 4 == 3 ? 1 : .5f;
    return true;
}

static CoTexturesOptions options_with_rule(const char *space)
{
    ruled = space;
    return (CoTexturesOptions){
        .converted_folder = test_folder, .to_rendering = halve, .space_of_file = rule};
}

static CoOiioInfo info_of(const char *format, const char *says, uint32_t channels, bool is_8bit)
{
    CoOiioInfo info = {.width = 1, .height = 1, .channels = channels, .is_8bit = is_8bit};
    snprintf(info.format, sizeof info.format, "%s", format);
    snprintf(info.color_space, sizeof info.color_space, "%s", says);
    return info;
}

// The space of an image nobody has a word for but the file, a rule, or the rule of USD.
static const char *auto_space(const char *by_rule, const CoOiioInfo *info, bool of_light)
{
    static CoTexturesOptions options;
    options = options_with_rule(by_rule);
    CohortTextureDesc desc = {.path = "x"};
    bool unknown;
    CoTextureColor color = of_light ? co_light_image_color(&options, &desc, "x", info, &unknown)
                                    : co_image_color(&options, &desc, "x", info);
    return color.is_raw ? "raw" : color.space;
}

static void who_speaks_first_is_heard(void **state)
{
    (void)state;
    const CoOiioInfo bytes = info_of("targa", "", 3, true), gray = info_of("targa", "", 1, true);
    const CoOiioInfo photo = info_of("jpeg", "sRGB", 3, true);
    const CoOiioInfo floats = info_of("openexr", "Linear", 3, false);
    const CoOiioInfo srgb = info_of("tiff", "sRGB", 1, false);
    const CoOiioInfo linear = info_of("tiff", "linear", 4, true);
    assert_string_equal(auto_space(NULL, &bytes, false), "sRGB");
    assert_string_equal(auto_space(NULL, &gray, false), "raw");
    assert_string_equal(auto_space(NULL, &photo, false), "sRGB");
    assert_string_equal(auto_space(NULL, &floats, false), "raw");
    assert_string_equal(auto_space(NULL, &srgb, false), "sRGB");
    assert_string_equal(auto_space(NULL, &linear, false), "raw");
    // Files that say it themselves, then rules, then what the format suggests.
    assert_string_equal(auto_space("film", &bytes, false), "film");
    assert_string_equal(auto_space("film", &gray, false), "film");
    assert_string_equal(auto_space("film", &photo, false), "film");
    assert_string_equal(auto_space("film", &floats, false), "film");
    assert_string_equal(auto_space("film", &srgb, false), "sRGB");
    assert_string_equal(auto_space("film", &linear, false), "raw");
    assert_string_equal(auto_space("raw", &bytes, false), "raw");
}

// A 16-bit PNG is data to the rule of UsdPreviewSurface, unless it says what it is.
static bool png_is_raw(const char *chunk)
{
    const char *path = in_folder("chunks.png");
    unsigned char head[33] = {137, 'P', 'N', 'G', 13, 10, 26, 10, 0, 0, 0, 13, 'I', 'H', 'D', 'R'};
    unsigned char next[24] = {0, 0, 0, 12};
    memcpy(next + 4, chunk, strlen(chunk));
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(head, 1, sizeof head, file), sizeof head);
    assert_int_equal(fwrite(next, 1, sizeof next, file), sizeof next);
    fclose(file);
    CoTexturesOptions options = {0};
    CohortTextureDesc desc = {.color_space = COHORT_COLOR_AUTO};
    CoOiioInfo info = {.channels = 3, .format = "png", .color_space = "sRGB"};
    bool is_raw = co_image_color(&options, &desc, path, &info).is_raw;
    unlink(path);
    return is_raw;
}

static void deep_pngs_say_what_they_are(void **state)
{
    (void)state;
    assert_false(png_is_raw("sRGB"));
    assert_false(png_is_raw("iCCPsRGB IEC"));
    assert_true(png_is_raw("iCCPGreyscal"));
    assert_true(png_is_raw("iTXtsRGB"));
}

static void what_is_authored_overrules_all(void **state)
{
    (void)state;
    const CoOiioInfo info = info_of("tiff", "sRGB", 3, true);
    CoTexturesOptions options = options_with_rule("film");
    bool unknown;
    CohortTextureDesc desc = {.path = "x", .color_space = COHORT_COLOR_RAW};
    assert_true(co_image_color(&options, &desc, "x", &info).is_raw);
    assert_true(co_light_image_color(&options, &desc, "x", &info, &unknown).is_raw);
    desc.color_space = COHORT_COLOR_NAMED;
    desc.color_space_name = "lin_ap1_scene";
    assert_string_equal(co_image_color(&options, &desc, "x", &info).space, "lin_ap1_scene");
    desc.color_space = COHORT_COLOR_SRGB;
    assert_string_equal(co_image_color(&options, &desc, "x", &info).space, "sRGB");
    assert_false(unknown);
}

static void images_of_lights_are_colors(void **state)
{
    (void)state;
    CoOiioInfo floats = info_of("openexr", "Linear", 3, false);
    const CoOiioInfo bytes = info_of("targa", "", 3, true);
    assert_string_equal(auto_space(NULL, &bytes, true), "sRGB");
    assert_string_equal(auto_space(NULL, &floats, true), "lin_rec709_scene");
    assert_string_equal(auto_space("film", &floats, true), "film");
    assert_string_equal(auto_space("raw", &floats, true), "raw");
    // Adobe's to three digits.
    static const float adobe[8] = {.64f, .33f, .21f, .71f, .15f, .06f, .313f, .329f};
    memcpy(floats.chromaticities, adobe, sizeof adobe);
    floats.has_chromaticities = true;
    assert_string_equal(auto_space("film", &floats, true), "lin_adobergb_scene");
    assert_string_equal(auto_space(NULL, &floats, false), "raw");
    CoTexturesOptions options = options_with_rule(NULL);
    CohortTextureDesc desc = {.path = "x"};
    const float odd[] = {.7f, NAN, INFINITY};
    for (int i = 0; i < 3; i++) {
        bool unknown = false;
        floats.chromaticities[2] = odd[i];
        CoTextureColor color = co_light_image_color(&options, &desc, "x", &floats, &unknown);
        assert_string_equal(color.space, "lin_rec709_scene");
        assert_true(unknown);
    }
}

static void wraps_are_what_is_said_then_metadata_then_black(void **state)
{
    (void)state;
    assert_int_equal(co_image_wrap(COHORT_WRAP_CLAMP, "periodic"), COHORT_WRAP_CLAMP);
    assert_int_equal(co_image_wrap(COHORT_WRAP_USE_METADATA, "clamp"), COHORT_WRAP_CLAMP);
    assert_int_equal(co_image_wrap(COHORT_WRAP_USE_METADATA, "periodic"), COHORT_WRAP_REPEAT);
    assert_int_equal(co_image_wrap(COHORT_WRAP_USE_METADATA, "mirror"), COHORT_WRAP_MIRROR);
    assert_int_equal(co_image_wrap(COHORT_WRAP_USE_METADATA, "?"), COHORT_WRAP_BLACK);
    assert_int_equal(co_image_wrap(COHORT_WRAP_USE_METADATA, ""), COHORT_WRAP_BLACK);
}

// A converted form serves again as long as color and channels are those asked for.
static void a_converted_form_is_made_once_per_color(void **state)
{
    (void)state;
    const uint16_t pixel[] = {51, 102, 153};
    write_png(in_folder("once.png"), 1, 1, 3, 8, pixel);
    CoTexturesOptions options = options_with_rule(NULL);
    CohortTextureDesc desc = {.path = in_folder("once.png")};
    CohortError err = {0};
    CoOiioInfo info;
    char *first, *second, *raw;
    assert_true(co_oiio_info(desc.path, &info, &err));
    CoTextureColor color = co_image_color(&options, &desc, desc.path, &info);
    assert_true(co_image_convert(&color, desc.path, &info, &first, &err));
    assert_true(co_image_convert(&color, desc.path, &info, &second, &err));
    assert_string_equal(first, second);
    desc.color_space = COHORT_COLOR_RAW;
    color = co_image_color(&options, &desc, desc.path, &info);
    assert_true(co_image_convert(&color, desc.path, &info, &raw, &err));
    assert_string_not_equal(first, raw);
    CoImageFile *made = co_image_open(first, &err);
    assert_non_null(made);
    assert_int_equal(made->channels, 3);
    co_image_close(made);
    // What a crash left there is made anew.
    FILE *broken = fopen(raw, "w");
    fputs("no image", broken);
    fclose(broken);
    assert_null(co_image_open(raw, NULL));
    co_path_free(second);
    assert_true(co_image_convert(&color, desc.path, &info, &second, &err));
    made = co_image_open(raw, &err);
    assert_non_null(made);
    co_image_close(made);
    co_path_free(first);
    co_path_free(second);
    co_path_free(raw);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(who_speaks_first_is_heard),
        cmocka_unit_test(deep_pngs_say_what_they_are),
        cmocka_unit_test(what_is_authored_overrules_all),
        cmocka_unit_test(images_of_lights_are_colors),
        cmocka_unit_test(wraps_are_what_is_said_then_metadata_then_black),
        cmocka_unit_test(a_converted_form_is_made_once_per_color),
    };
    return cmocka_run_group_tests(tests, test_folder_make, test_folder_remove);
}
