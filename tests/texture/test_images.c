// Image textures: orientation, channels, wraps, color, mip levels, UDIM sets, broken files.
// Also tests oiio.cpp and oiio_module.c.

#include "png_support.h"
#include "support/faults.h"
#include "texture_support.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "shims/oiio.h"
#include "texture/converted.h"

#include <math.h>
#include <sys/stat.h>
#include <unistd.h>

static Warnings warnings;

static uint32_t add(CoTextures *textures, const char *path, CohortColorSpace space, CohortWrap wrap)
{
    CohortError err = {0};
    CohortTextureDesc desc = {.path = path,
                              .color_space = space,
                              .wrap_s = wrap,
                              .wrap_t = wrap,
                              .fallback = {.25f, .5f, .75f, 1}};
    uint32_t id = co_textures_add(textures, &desc, &err);
    assert_int_not_equal(id, COHORT_INVALID_ID);
    return id;
}

static const float *look(CoTextures *textures, uint32_t texture, float s, float t, float width)
{
    static float out[1][4];
    CohortError err = {0};
    CoLookup lookup = {.texture = texture, .s = s, .t = t, .ds0 = width, .dt1 = width};
    if (!co_textures_evaluate(textures, &lookup, 1, out, CO_LOOKUP_SORTED, NULL, NULL, NULL, &err))
        fail_msg("%s", err.message);
    return out[0];
}

static void assert_rgba(const float *got, float r, float g, float b, float a)
{
    const float want[4] = {r, g, b, a};
    for (int c = 0; c < 4; c++)
        if (!(fabsf(got[c] - want[c]) < 2e-6f))
            fail_msg("%g %g %g %g, expected %g %g %g %g", (double)got[0], (double)got[1],
                     (double)got[2], (double)got[3], (double)r, (double)g, (double)b, (double)a);
}

static void the_origin_is_lower_left(void **state)
{
    (void)state;
    const uint16_t pixels[] = {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255};
    write_png(in_folder("corners.png"), 2, 2, 3, 8, pixels);
    CoTextures *textures = create_textures(&warnings, 0);
    uint32_t id = add(textures, in_folder("corners.png"), COHORT_COLOR_RAW, COHORT_WRAP_CLAMP);
    assert_rgba(look(textures, id, .25f, .75f, 0), 1, 0, 0, 1); // first pixel: top left
    assert_rgba(look(textures, id, .75f, .75f, 0), 0, 1, 0, 1);
    assert_rgba(look(textures, id, .25f, .25f, 0), 0, 0, 1, 1);
    assert_rgba(look(textures, id, .75f, .25f, 0), 1, 1, 1, 1);
    assert_rgba(look(textures, id, .5f, .5f, 0), .5f, .5f, .5f, 1);
    CohortError err = {0};
    CohortTextureDesc desc = {.path = in_folder("corners.png"), .color_space = COHORT_COLOR_RAW};
    float *rows;
    uint32_t width, height;
    assert_true(co_image_read(textures, &desc, &rows, &width, &height, &err));
    assert_int_equal(width * 10 + height, 22);
    assert_rgba(rows, 1, 0, 0, 1); // from the top
    assert_rgba(rows + 12, 1, 1, 1, 1);
    co_image_free(rows, width, height);
    co_textures_destroy(textures);
}

static void channels_follow_the_rule(void **state)
{
    (void)state;
    const uint16_t pixel[] = {51, 102, 153, 204};
    CoTextures *textures = create_textures(&warnings, 0);
    for (uint32_t channels = 1; channels <= 4; channels++) {
        char name[16];
        snprintf(name, sizeof name, "c%u.png", channels);
        write_png(in_folder(name), 1, 1, channels, 8, pixel);
        uint32_t id = add(textures, in_folder(name), COHORT_COLOR_RAW, COHORT_WRAP_REPEAT);
        const float *got = look(textures, id, .3f, .6f, 0);
        if (channels <= 2)
            assert_rgba(got, .2f, .2f, .2f, channels == 1 ? 1 : .4f);
        else
            assert_rgba(got, .2f, .4f, .6f, channels == 3 ? 1 : .8f);
    }
    // Alpha is not multiplied in, not even where it is 0.
    const uint16_t clear[] = {255, 51, 0, 0};
    write_png(in_folder("clear.png"), 1, 1, 4, 8, clear);
    uint32_t id = add(textures, in_folder("clear.png"), COHORT_COLOR_RAW, COHORT_WRAP_REPEAT);
    assert_rgba(look(textures, id, 0, 0, 0), 1, .2f, 0, 0);
    co_textures_destroy(textures);
}

static void wraps_repeat_mirror_clamp_and_end(void **state)
{
    (void)state;
    uint16_t pixels[4 * 3];
    for (int x = 0; x < 4; x++)
        pixels[3 * x] = (uint16_t)(51 * (x + 1)), pixels[3 * x + 1] = pixels[3 * x + 2] = 255;
    write_png(in_folder("ramp.png"), 4, 1, 3, 8, pixels);
    CoTextures *textures = create_textures(&warnings, 0);
    uint32_t id[5];
    for (int wrap = 0; wrap < 5; wrap++)
        id[wrap] = add(textures, in_folder("ramp.png"), COHORT_COLOR_RAW, (CohortWrap)wrap);
    const float at = 1.125f; // the center of the texel after the last
    assert_rgba(look(textures, id[COHORT_WRAP_REPEAT], at, .5f, 0), .2f, 1, 1, 1);
    assert_rgba(look(textures, id[COHORT_WRAP_MIRROR], at, .5f, 0), .8f, 1, 1, 1);
    assert_rgba(look(textures, id[COHORT_WRAP_MIRROR], at + .25f, .5f, 0), .6f, 1, 1, 1);
    assert_rgba(look(textures, id[COHORT_WRAP_CLAMP], at, .5f, 0), .8f, 1, 1, 1);
    assert_rgba(look(textures, id[COHORT_WRAP_BLACK], at, .5f, 0), 0, 0, 0, 0);
    assert_rgba(look(textures, id[COHORT_WRAP_BLACK], 1, .5f, 0), .4f, .5f, .5f, .5f);
    assert_rgba(look(textures, id[COHORT_WRAP_USE_METADATA], at, .5f, 0), 0, 0, 0, 0);
    assert_rgba(look(textures, id[COHORT_WRAP_REPEAT], -.125f, 7.5f, 0), .8f, 1, 1, 1);
    assert_rgba(look(textures, id[COHORT_WRAP_MIRROR], -.125f, -3.5f, 0), .2f, 1, 1, 1);
    assert_rgba(look(textures, id[COHORT_WRAP_REPEAT], 1e9f, .5f, 0), .5f, 1, 1, 1);
    assert_rgba(look(textures, id[COHORT_WRAP_CLAMP], 1e20f, -1e20f, 0), .8f, 1, 1, 1);
    co_textures_destroy(textures);
}

static void srgb_is_decoded_by_its_formula(void **state)
{
    (void)state;
    uint16_t pixels[256 * 3];
    for (int i = 0; i < 256 * 3; i++)
        pixels[i] = (uint16_t)(i / 3);
    write_png(in_folder("codes.png"), 16, 16, 3, 8, pixels);
    CoTextures *textures = create_textures(&warnings, 0);
    uint32_t encoded = add(textures, in_folder("codes.png"), COHORT_COLOR_AUTO, COHORT_WRAP_CLAMP);
    uint32_t raw = add(textures, in_folder("codes.png"), COHORT_COLOR_RAW, COHORT_WRAP_CLAMP);
    for (int i = 0; i < 256; i++) {
        float s = ((float)(i % 16) + .5f) / 16, t = 1 - ((float)(i / 16) + .5f) / 16;
        double x = i / 255.0, linear = x <= .04045 ? x / 12.92 : pow((x + .055) / 1.055, 2.4);
        assert_true(fabs((double)look(textures, encoded, s, t, 0)[1] - linear) < 2e-7);
        assert_true(fabs((double)look(textures, raw, s, t, 0)[2] - x) < 2e-7);
    }
    // One channel of 8 bits and three of 16 are data unless somebody says otherwise.
    const uint16_t gray[] = {128, 32768, 32768};
    write_png(in_folder("gray.png"), 1, 1, 1, 8, gray);
    write_png(in_folder("deep.png"), 1, 1, 3, 16, (const uint16_t[]){32768, 0, 65535});
    uint32_t id = add(textures, in_folder("gray.png"), COHORT_COLOR_AUTO, COHORT_WRAP_CLAMP);
    assert_rgba(look(textures, id, .5f, .5f, 0), 128 / 255.f, 128 / 255.f, 128 / 255.f, 1);
    id = add(textures, in_folder("deep.png"), COHORT_COLOR_AUTO, COHORT_WRAP_CLAMP);
    assert_rgba(look(textures, id, .5f, .5f, 0), 32768 / 65535.f, 0, 1, 1);
    co_textures_destroy(textures);
}

static bool brighten(void *cookie, const char *space, float *pixels, size_t count, CohortError *err)
{
    (void)err;
    strcpy(cookie, space);
    for (size_t i = 0; i < count; i++)
        for (int c = 0; c < 3; c++)
            pixels[4 * i + (size_t)c] = pixels[4 * i + (size_t)c] * 2 + (float)c;
    return strcmp(space, "nowhere") != 0;
}

static void named_spaces_are_asked_for(void **state)
{
    (void)state;
    const uint16_t pixel[] = {51, 102, 153, 204};
    write_png(in_folder("named.png"), 1, 1, 4, 8, pixel);
    char asked[64] = "";
    CohortError err = {0};
    Warnings told = {0};
    CoTexturesOptions options = {.converted_folder = test_folder,
                                 .to_rendering = brighten,
                                 .cookie = asked,
                                 .warn = keep_warning,
                                 .warn_cookie = &told};
    CoTextures *textures = co_textures_create(&options, &err);
    CohortTextureDesc desc = {.path = in_folder("named.png"),
                              .color_space = COHORT_COLOR_NAMED,
                              .color_space_name = "somewhere",
                              .fallback = {.1f, .1f, .1f, 1}};
    uint32_t id = co_textures_add(textures, &desc, &err);
    assert_string_equal(asked, "somewhere");
    assert_rgba(look(textures, id, .5f, .5f, 0), .4f, 1.8f, 3.2f, .8f);
    desc.color_space_name = "nowhere";
    id = co_textures_add(textures, &desc, &err);
    assert_int_equal(told.count, 1);
    assert_rgba(look(textures, id, 0, 0, 0), .1f, .1f, .1f, 1);
    desc.color_space = COHORT_COLOR_SRGB;
    id = co_textures_add(textures, &desc, &err);
    assert_string_equal(asked, "sRGB");
    co_textures_destroy(textures);
}

static void footprints_see_averages_of_light(void **state)
{
    (void)state;
    enum {
        SIDE = 256
    };
    uint16_t *pixels = malloc(SIDE * SIDE * 3 * sizeof *pixels);
    double mean = 0;
    for (uint32_t i = 0; i < SIDE * SIDE * 3; i++)
        pixels[i] = (uint16_t)(256 * random_at(9, i));
    write_png(in_folder("noise.png"), SIDE, SIDE, 3, 8, pixels);
    for (uint32_t i = 0; i < SIDE * SIDE; i++)
        mean += (double)co_srgb_decode((float)pixels[3 * i] / 255) / (SIDE * SIDE);
    free(pixels);
    CoTextures *textures = create_textures(&warnings, 0);
    uint32_t id = add(textures, in_folder("noise.png"), COHORT_COLOR_SRGB, COHORT_WRAP_REPEAT);
    assert_true(fabs((double)look(textures, id, .3f, .8f, 1)[0] - mean) < 1e-5);
    assert_true(fabs((double)look(textures, id, .3f, .8f, 50)[0] - mean) < 1e-5);
    // Mean over the image of lookups of any width is the mean of the image.
    static CoLookup lookups[64 * 64];
    static float out[64 * 64][4];
    CohortError err = {0};
    for (int w = 1; w <= 40; w += 13) {
        for (int i = 0; i < 64 * 64; i++)
            lookups[i] = (CoLookup){id,
                                    0,
                                    ((float)(i % 64) + .5f) / 64,
                                    ((float)(i / 64) + .5f) / 64,
                                    (float)w / SIDE,
                                    0,
                                    0,
                                    3.0f / SIDE};
        assert_true(co_textures_evaluate(textures, lookups, 64 * 64, out, CO_LOOKUP_SORTED, NULL,
                                         NULL, NULL, &err));
        double sum = 0;
        for (int i = 0; i < 64 * 64; i++)
            sum += (double)out[i][0] / (64 * 64);
        assert_true(fabs(sum - mean) < .01 * mean);
    }
    co_textures_destroy(textures);
}

static void udim_tiles_lie_ten_in_a_row(void **state)
{
    (void)state;
    for (uint16_t i = 0; i < 3; i++) {
        const uint16_t pixel[] = {(uint16_t)(51 * (i + 1)), 0, 255};
        write_png(in_folder(i == 0   ? "u.1001.png"
                            : i == 1 ? "u.1002.png"
                                     : "u.1012.png"),
                  1, 1, 3, 8, pixel);
    }
    CoTextures *textures = create_textures(&warnings, 0);
    uint32_t id = add(textures, in_folder("u.<UDIM>.png"), COHORT_COLOR_RAW, COHORT_WRAP_REPEAT);
    assert_rgba(look(textures, id, .1f, .9f, 0), .2f, 0, 1, 1);
    assert_rgba(look(textures, id, 1.5f, .5f, 0), .4f, 0, 1, 1);
    assert_rgba(look(textures, id, 1.9f, 1.1f, 0), .6f, 0, 1, 1);
    assert_rgba(look(textures, id, 2.5f, .5f, 0), .25f, .5f, .75f, 1); // no such tile: fallback
    assert_rgba(look(textures, id, -.5f, .5f, 0), .25f, .5f, .75f, 1);
    assert_rgba(look(textures, id, 10.5f, .5f, 0), .25f, .5f, .75f, 1);
    int before = warnings.count;
    add(textures, in_folder("none.<UDIM>.png"), COHORT_COLOR_RAW, COHORT_WRAP_REPEAT);
    assert_int_equal(warnings.count, before + 1);
    co_textures_destroy(textures);
}

static void all_schedules_give_the_same_bits(void **state)
{
    (void)state;
    enum {
        COUNT = 6000
    };
    static CoLookup lookups[COUNT];
    static float out[COUNT][4], expected[COUNT][4];
    uint16_t *pixels = malloc(200 * 150 * 4 * sizeof *pixels);
    for (uint32_t i = 0; i < 200 * 150 * 4; i++)
        pixels[i] = (uint16_t)(256 * random_at(11, i));
    write_png(in_folder("odd.png"), 200, 150, 4, 8, pixels);
    write_png(in_folder("odd3.png"), 130, 65, 3, 8, pixels);
    free(pixels);
    for (uint32_t i = 0; i < COUNT; i++)
        lookups[i] = (CoLookup){i % 5,
                                0,
                                4 * random_at(12, i) - 2,
                                4 * random_at(13, i) - 2,
                                i % 3 ? .1f * random_at(14, i) : 0,
                                0,
                                0,
                                .3f * random_at(15, i)};
    bool is_first = true;
    for (int resident = 0; resident < 2; resident++) {
        for (uint32_t threads = 1; threads <= 2; threads++) {
            co_worker_count_set(threads);
            CoTextures *textures = create_textures(&warnings, resident ? 0 : 1000);
            for (int i = 0; i < 5; i++)
                add(textures, in_folder(i & 1 ? "odd.png" : "odd3.png"), COHORT_COLOR_SRGB,
                    (CohortWrap)i);
            for (int run = 0; run < 4; run++) {
                CohortError err = {0};
                CoLookupStats stats;
                size_t split = run < 2 ? COUNT : COUNT / 3;
                for (size_t at = 0; at < COUNT; at += split) {
                    assert_true(co_textures_evaluate(textures, lookups + at, split, out + at,
                                                     (CoLookupMode)(run & 1), NULL, NULL, &stats,
                                                     &err));
                    if ((run & 1) == 0)
                        assert_int_equal(stats.blocks_twice, 0);
                }
                if (is_first)
                    memcpy(expected, out, sizeof out);
                is_first = false;
                assert_memory_equal(expected, out, sizeof out);
            }
            co_textures_destroy(textures);
        }
    }
    co_worker_count_set(0);
    assert_int_equal(co_memory_live(CO_MEMORY_TEXTURE), 0);
}

static void broken_images_are_warnings(void **state)
{
    (void)state;
    static float texels[64 * 64 * 3];
    static unsigned char bytes[100000];
    for (uint32_t i = 0; i < 64 * 64 * 3; i++)
        texels[i] = random_at(16, i);
    CohortError err = {0};
    CoOiioInfo info = {.width = 64, .height = 64, .channels = 3};
    assert_true(co_oiio_write_mips(in_folder("whole.exr"), &info, texels, 64, &err));
    FILE *file = fopen(in_folder("whole.exr"), "rb");
    size_t size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    CoTextures *textures = create_textures(&warnings, 0);
    for (size_t cut = 0; cut < size; cut += size / 12) {
        file = fopen(in_folder("cut.exr"), "wb");
        fwrite(bytes, 1, cut, file);
        fclose(file);
        int before = warnings.count;
        uint32_t id = add(textures, in_folder("cut.exr"), COHORT_COLOR_RAW, COHORT_WRAP_CLAMP);
        const float *got = look(textures, id, .5f / 64, 1 - .5f / 64, 0);
        assert_true(warnings.count == before + 1 ? got[1] == .5f : got[1] == texels[1]);
        if (cut < 300)
            assert_int_equal(warnings.count, before + 1);
    }
    // A header that asks for 2^31 - 1 texels a side.
    write_png(in_folder("whole.png"), 1, 1, 3, 8, (const uint16_t[3]){0});
    file = fopen(in_folder("whole.png"), "rb");
    size = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    png_u32(bytes + 16, 0x7fffffff);
    png_u32(bytes + 20, 0x7fffffff);
    png_u32(bytes + 29, png_crc(0, bytes + 12, 17));
    file = fopen(in_folder("huge.png"), "wb");
    fwrite(bytes, 1, size, file);
    fclose(file);
    const char *bad[] = {in_folder("huge.png"), test_folder, "", "/dev/null"};
    for (int i = 0; i < 4; i++) {
        int before = warnings.count;
        uint32_t id = add(textures, bad[i], COHORT_COLOR_RAW, COHORT_WRAP_CLAMP);
        assert_int_equal(warnings.count, before + 1);
        assert_rgba(look(textures, id, 0, 0, 0), .25f, .5f, .75f, 1);
    }
    co_textures_destroy(textures);
}

// No writer ever comes.
static void pipes_and_devices_are_refused_at_once(void **state)
{
    (void)state;
    const char *path = in_folder("pipe.png");
    const char *const odd[] = {path, "/dev/zero", "/"};
    assert_int_equal(mkfifo(path, 0600), 0);
    alarm(60);
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        CohortError err = {0};
        CoOiioInfo info;
        assert_false(co_oiio_info(odd[i], &info, &err));
        assert_int_equal(err.code, COHORT_ERROR_TEXTURE);
        assert_string_equal(err.file, odd[i]);
    }
    alarm(0);
    unlink(path);
}

static void converted_files_are_found_again(void **state)
{
    (void)state;
    const uint16_t one[] = {51, 51, 51}, two[] = {102, 102, 102};
    const char *path = in_folder("again.png");
    for (int i = 0; i < 3; i++) {
        write_png(path, 1, 1, 3, 8, i == 1 ? two : one); // new content, then the old one
        CoTextures *textures = create_textures(&warnings, 0);
        uint32_t id = add(textures, path, COHORT_COLOR_RAW, COHORT_WRAP_CLAMP);
        assert_rgba(look(textures, id, 0, 0, 0), i == 1 ? .4f : .2f, i == 1 ? .4f : .2f,
                    i == 1 ? .4f : .2f, 1);
        co_textures_destroy(textures);
    }
    // A folder that cannot be made is a warning that names it.
    Warnings told = {0};
    CohortError err = {0};
    CoTexturesOptions options = {
        .converted_folder = path, .warn = keep_warning, .warn_cookie = &told};
    CoTextures *textures = co_textures_create(&options, &err);
    add(textures, path, COHORT_COLOR_RAW, COHORT_WRAP_CLAMP);
    assert_int_equal(told.count, 1);
    assert_non_null(strstr(told.text, "converted"));
    co_textures_destroy(textures);
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    co_worker_count_set(1);
    const uint16_t pixel[] = {51, 52, 53};
    write_png(in_folder("fresh.1001.png"), 1, 1, 3, 8, pixel);
    write_grid(in_folder("fresh.ptx"), 2, 3, CO_PTEX_U8, 3);
    const char *paths[] = {in_folder("fresh.<UDIM>.png"), in_folder("fresh.ptx")};
    for (int which = 0; which < 2; which++) {
        TestFaults faults = {0};
        while (test_faults_next(&faults)) {
            CohortError err = {0};
            Warnings told = {0};
            CoTexturesOptions options = {
                .converted_folder = converted_folder(), .warn = keep_warning, .warn_cookie = &told};
            CohortTextureDesc desc = {.path = paths[which], .color_space = COHORT_COLOR_SRGB};
            CoLookup lookup = {.s = .5f, .t = .5f};
            float out[1][4];
            test_faults_begin(&faults);
            CoTextures *textures = co_textures_create(&options, &err);
            bool ok = textures && co_textures_add(textures, &desc, &err) != COHORT_INVALID_ID &&
                      co_textures_evaluate(textures, &lookup, 1, out, CO_LOOKUP_SORTED, NULL, NULL,
                                           NULL, &err);
            test_faults_end(&faults, ok, &err);
            assert_int_equal(told.count, 0);
            co_textures_destroy(textures);
            forget_converted();
        }
        assert_true(faults.count > 20);
    }
    co_worker_count_set(0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_origin_is_lower_left),
        cmocka_unit_test(channels_follow_the_rule),
        cmocka_unit_test(wraps_repeat_mirror_clamp_and_end),
        cmocka_unit_test(srgb_is_decoded_by_its_formula),
        cmocka_unit_test(named_spaces_are_asked_for),
        cmocka_unit_test(footprints_see_averages_of_light),
        cmocka_unit_test(udim_tiles_lie_ten_in_a_row),
        cmocka_unit_test(all_schedules_give_the_same_bits),
        cmocka_unit_test(broken_images_are_warnings),
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(pipes_and_devices_are_refused_at_once),
        cmocka_unit_test(converted_files_are_found_again),
    };
    return cmocka_run_group_tests(tests, test_folder_make, test_folder_remove);
}
