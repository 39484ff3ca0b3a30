// Display-encoded Ptex files made linear: which are, averages of light, channels in their order.

#include "support/faults.h"
#include "texture_support.h"

#include "texture/ptex_convert.h"

#include <math.h>

static const float *look(CoTextures *textures, uint32_t id, uint32_t face, float width)
{
    static float out[1][4];
    CohortError err = {0};
    CoLookup lookup = {.texture = id, .face = face, .s = .5f, .t = .5f, .ds0 = width, .dt1 = width};
    assert_true(
        co_textures_evaluate(textures, &lookup, 1, out, CO_LOOKUP_SORTED, NULL, NULL, NULL, &err));
    return out[0];
}

static void display_encoded_files_are_averaged_in_linear_light(void **state)
{
    (void)state;
    write_grid(in_folder("codes.ptx"), 2, 5, CO_PTEX_U8, 3);
    CohortError err = {0};
    CoPtexFile *file = co_ptex_open(in_folder("codes.ptx"), &err);
    unsigned char *texels = texels_of(file, 2, 5, 5), *average = texels_of(file, 2, 0, 0);
    double linear = 0, authored = 0;
    for (int i = 0; i < 1024; i++)
        linear += (double)co_srgb_decode((float)texels[3 * i + 1] / 255) / 1024;
    authored = (double)co_srgb_decode((float)average[1] / 255);
    unsigned char *reduced = texels_of(file, 2, 2, 2);
    double level = 0;
    for (int i = 0; i < 16; i++)
        level += (double)co_srgb_decode((float)reduced[3 * i + 1] / 255) / 16;
    free(texels);
    free(average);
    free(reduced);
    co_ptex_close(file);
    for (int is_authored = 0; is_authored < 2; is_authored++) {
        CoTexturesOptions options = {.converted_folder = test_folder,
                                     .ptex_reductions_authored = is_authored};
        CoTextures *textures = co_textures_create(&options, &err);
        CohortTextureDesc desc = {.path = in_folder("codes.ptx"),
                                  .color_space = COHORT_COLOR_AUTO,
                                  .ptex_filter = COHORT_PTEX_BOX};
        uint32_t id = co_textures_add(textures, &desc, &err);
        bool is_triangle;
        assert_int_equal(co_texture_ptex_faces(textures, id, &is_triangle), 4);
        double got = (double)look(textures, id, 2, 1)[1];
        assert_true(fabs(got - (is_authored ? level : linear)) < 1e-5);
        co_textures_destroy(textures);
    }
    assert_true(fabs(authored - linear) > .02); // or the test would prove nothing
}

// One face of one color; its channels count 51, 102, 153, ...
static void write_channels(const char *path, uint32_t channels, int alpha)
{
    CohortError err = {0};
    CoPtexWriteDesc desc = {.face_count = 1,
                            .channels = channels,
                            .has_alpha = alpha >= 0,
                            .alpha = alpha >= 0 ? (uint32_t)alpha : 0};
    CoPtexFace info = {.ulog2 = 1, .vlog2 = 1, .adjfaces = {-1, -1, -1, -1}};
    unsigned char texels[4 * 8];
    for (uint32_t i = 0; i < 4 * channels; i++)
        texels[i] = (unsigned char)(51 * (i % channels % 5 + 1));
    CoPtexWriter *writer = co_ptex_writer_create(path, &desc, &err);
    assert_non_null(writer);
    assert_true(co_ptex_writer_face(writer, 0, &info, (const void *const[]){texels}, 1, &err));
    assert_true(co_ptex_writer_finish(writer, &err));
}

// What a lookup should say: colors are the channels that are not alpha, decoded where they are
// codes; alpha never is.
static void assert_channels(const float *got, uint32_t channels, int alpha, bool is_raw)
{
    float want[4] = {0, 0, 0, 1};
    uint32_t colors = 0;
    if (alpha < 0 && (channels == 2 || channels == 4))
        alpha = (int)channels - 1;
    for (uint32_t c = 0; c < channels && colors < 3; c++) {
        float code = (float)(c + 1) / 5;
        if ((int)c != alpha || channels == 1)
            want[colors++] = is_raw ? code : co_srgb_decode(code);
    }
    if (colors == 1)
        want[1] = want[2] = want[0];
    if (alpha >= 0 && channels > 1)
        want[3] = (float)(alpha + 1) / 5;
    for (int c = 0; c < 4; c++)
        if (fabsf(got[c] - want[c]) > 1e-6f)
            fail_msg("%u channels, alpha %d, %s: %g in place of %g", channels, alpha,
                     is_raw ? "raw" : "sRGB", (double)got[c], (double)want[c]);
}

static void alpha_is_no_color_wherever_it_stands(void **state)
{
    (void)state;
    Warnings warnings = {0};
    for (int is_raw = 0; is_raw < 2; is_raw++) {
        for (uint32_t channels = 1; channels <= 5; channels++) {
            for (int alpha = -1; alpha < (int)channels; alpha++) {
                CohortError err = {0};
                write_channels(in_folder("alpha.ptx"), channels, alpha);
                CoTextures *textures = create_textures(&warnings, 0);
                CohortTextureDesc desc = {.path = in_folder("alpha.ptx"),
                                          .color_space =
                                              is_raw ? COHORT_COLOR_RAW : COHORT_COLOR_SRGB};
                uint32_t id = co_textures_add(textures, &desc, &err);
                assert_channels(look(textures, id, 0, 0), channels, alpha, is_raw);
                co_textures_destroy(textures);
            }
        }
    }
    assert_int_equal(warnings.count, 0);
}

static void three_or_four_bytes_are_colors_unless_somebody_says_otherwise(void **state)
{
    (void)state;
    const CoTexturesOptions options = {0};
    for (uint32_t channels = 1; channels <= 5; channels++) {
        for (CoPtexType type = CO_PTEX_U8; type <= CO_PTEX_F32; type++) {
            CoPtexFile file = {.type = type, .channels = channels};
            CohortTextureDesc desc = {.color_space = COHORT_COLOR_AUTO};
            bool is_color = type == CO_PTEX_U8 && (channels == 3 || channels == 4);
            assert_int_equal(co_ptex_color(&options, &desc, &file).is_raw, !is_color);
            desc.color_space = COHORT_COLOR_SRGB;
            assert_false(co_ptex_color(&options, &desc, &file).is_raw);
            desc.color_space = COHORT_COLOR_RAW;
            assert_true(co_ptex_color(&options, &desc, &file).is_raw);
        }
    }
}

static const char *rule(void *cookie, const char *path)
{
    assert_string_equal(path, "paint.ptx");
    return cookie;
}

// As of images: rules come behind what is authored and before what the format suggests.
static void file_rules_speak_for_files_of_nobody(void **state)
{
    (void)state;
    const CoPtexFile bytes = {.type = CO_PTEX_U8, .channels = 3};
    const CoPtexFile floats = {.type = CO_PTEX_F32, .channels = 1};
    char film[] = "film", raw[] = "raw";
    CohortTextureDesc desc = {.path = "paint.ptx"};
    CoTexturesOptions options = {.space_of_file = rule, .cookie = film};
    assert_string_equal(co_ptex_color(&options, &desc, &bytes).space, "film");
    assert_string_equal(co_ptex_color(&options, &desc, &floats).space, "film");
    assert_false(co_ptex_color(&options, &desc, &floats).is_raw);
    desc.color_space = COHORT_COLOR_SRGB;
    assert_string_equal(co_ptex_color(&options, &desc, &floats).space, "sRGB");
    desc.color_space = COHORT_COLOR_RAW;
    assert_true(co_ptex_color(&options, &desc, &bytes).is_raw);
    desc.color_space = COHORT_COLOR_AUTO;
    options.cookie = raw;
    assert_true(co_ptex_color(&options, &desc, &bytes).is_raw);
    options.cookie = NULL;
    assert_string_equal(co_ptex_color(&options, &desc, &bytes).space, "sRGB");
    assert_true(co_ptex_color(&options, &desc, &floats).is_raw);
}

// Constant faces, faces of one texel and floats that are none.
static void odd_faces_are_converted(void **state)
{
    (void)state;
    CohortError err = {0};
    const CoTexturesOptions options = {.converted_folder = test_folder};
    const CoTextureColor color = {.space = "sRGB", .options = &options};
    CoPtexWriteDesc desc = {.face_count = 2, .channels = 3, .type = CO_PTEX_F32};
    CoPtexFace info = {.ulog2 = 2, .vlog2 = 0, .adjfaces = {-1, -1, -1, -1}};
    const float odd[12] = {NAN, INFINITY, -INFINITY, 1, 1, 1, -1, 0, 2, .5f, .5f, .5f};
    CoPtexWriter *writer = co_ptex_writer_create(in_folder("odd.ptx"), &desc, &err);
    assert_true(co_ptex_writer_face(writer, 1, &info, (const void *const[]){odd}, 1, &err));
    assert_true(co_ptex_writer_finish(writer, &err));
    CoPtexFile *file = co_ptex_open(in_folder("odd.ptx"), &err);
    char *path;
    assert_true(co_ptex_convert(&color, in_folder("odd.ptx"), file, &path, &err));
    CoPtexFile *made = co_ptex_open(path, &err);
    assert_non_null(made);
    assert_int_equal(made->type, CO_PTEX_F32);
    assert_true(made->faces[0].flags & CO_PTEX_CONSTANT);
    float *texels = texels_of(made, 1, 2, 0);
    for (int i = 0; i < 12; i++)
        assert_true(texels[i] == (i < 3 ? 0 : co_srgb_decode(odd[i])));
    free(texels);
    co_ptex_close(made);
    co_ptex_close(file);
    co_path_free(path);
}

// A file in tiles that is no less good for a lack of memory: no warning, no other color.
static void conversions_without_memory_are_no_damage(void **state)
{
    (void)state;
    write_grid(in_folder("many.ptx"), 1, 6, CO_PTEX_U8, 32);
    CohortTextureDesc desc = {.path = in_folder("many.ptx"), .color_space = COHORT_COLOR_SRGB};
    for (int is_authored = 0; is_authored < 2; is_authored++) {
        TestFaults faults = {0};
        while (test_faults_next(&faults)) {
            CohortError err = {0};
            Warnings warnings = {0};
            CoTexturesOptions options = {.converted_folder = converted_folder(),
                                         .ptex_reductions_authored = is_authored,
                                         .warn = keep_warning,
                                         .warn_cookie = &warnings};
            test_faults_begin(&faults);
            CoTextures *textures = co_textures_create(&options, &err);
            bool ok = textures && co_textures_add(textures, &desc, &err) != COHORT_INVALID_ID;
            test_faults_end(&faults, ok, &err);
            if (warnings.count)
                fail_msg("allocation %u: %s", (unsigned)faults.n, warnings.text);
            co_textures_destroy(textures);
            forget_converted();
        }
        assert_true(faults.count > 30);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(display_encoded_files_are_averaged_in_linear_light),
        cmocka_unit_test(alpha_is_no_color_wherever_it_stands),
        cmocka_unit_test(three_or_four_bytes_are_colors_unless_somebody_says_otherwise),
        cmocka_unit_test(file_rules_speak_for_files_of_nobody),
        cmocka_unit_test(odd_faces_are_converted),
        cmocka_unit_test(conversions_without_memory_are_no_damage),
    };
    return cmocka_run_group_tests(tests, test_folder_make, test_folder_remove);
}
