// Adding textures: what cannot be one shows its fallback, with a warning that says why. Channels,
// sets of tiles and most failing allocations are in test_images and test_ptex_convert.

#include "png_support.h"
#include "support/faults.h"
#include "texture_support.h"

#include "texture/textures.h"

#include <math.h>

static const float *look(CoTextures *textures, uint32_t id, float s)
{
    static float out[1][4];
    CohortError err = {0};
    CoLookup lookup = {.texture = id, .s = s, .t = .5f};
    assert_true(
        co_textures_evaluate(textures, &lookup, 1, out, CO_LOOKUP_SORTED, NULL, NULL, NULL, &err));
    return out[0];
}

static void triangles_of_ptex_are_refused_by_name(void **state)
{
    (void)state;
    CohortError err = {0};
    Warnings warnings = {0};
    write_grid(in_folder("triangles.ptx"), 2, 3, CO_PTEX_U8, 3);
    FILE *file = fopen(in_folder("triangles.ptx"), "r+b");
    fseek(file, 8, SEEK_SET); // the mesh type
    fwrite("\0\0\0\0", 1, 4, file);
    fclose(file);
    CoTextures *textures = create_textures(&warnings, 0);
    CohortTextureDesc desc = {.path = in_folder("triangles.ptx"), .asset = "./t.ptx"};
    uint32_t id = co_textures_add(textures, &desc, &err);
    assert_int_equal(id, 0);
    assert_int_equal(err.code, COHORT_OK);
    assert_int_equal(warnings.count, 1);
    assert_non_null(strstr(warnings.text, "./t.ptx: triangle Ptex"));
    const float *got = look(textures, id, .5f);
    assert_true(got[0] == 1 && got[1] == 0 && got[2] == 1 && got[3] == 1);
    co_textures_destroy(textures);
}

static void tiles_with_other_channels_show_the_fallback(void **state)
{
    (void)state;
    CohortError err = {0};
    Warnings warnings = {0};
    const uint16_t pixel[] = {51, 102, 153, 204};
    write_png(in_folder("mixed.1001.png"), 1, 1, 3, 8, pixel);
    write_png(in_folder("mixed.1002.png"), 1, 1, 4, 8, pixel);
    write_png(in_folder("mixed.1003.png"), 1, 1, 3, 8, pixel);
    CoTextures *textures = create_textures(&warnings, 0);
    CohortTextureDesc desc = {.path = in_folder("mixed.<UDIM>.png"),
                              .color_space = COHORT_COLOR_RAW,
                              .fallback = {.25f, .5f, .75f, 1}};
    uint32_t id = co_textures_add(textures, &desc, &err);
    assert_int_equal(warnings.count, 1);
    assert_non_null(strstr(warnings.text, "mixed.1002.png has other channels"));
    assert_true(fabsf(look(textures, id, .5f)[0] - .2f) < 2e-6f);
    assert_true(fabsf(look(textures, id, 2.5f)[0] - .2f) < 2e-6f);
    assert_memory_equal(look(textures, id, 1.5f), desc.fallback, sizeof desc.fallback);
    co_textures_destroy(textures);
}

static void no_name_is_no_file(void **state)
{
    (void)state;
    CohortError err = {0};
    const char *const paths[] = {NULL, ""};
    for (int i = 0; i < 2; i++) {
        for (int is_ptex = 0; is_ptex < 2; is_ptex++) {
            Warnings warnings = {0};
            CoTextures *textures = create_textures(&warnings, 0);
            CohortTextureDesc desc = {.path = paths[i], .is_ptex = is_ptex, .fallback = {.5f}};
            uint32_t id = co_textures_add(textures, &desc, &err);
            assert_int_equal(warnings.count, 1);
            assert_non_null(strstr(warnings.text, "no file is named"));
            assert_true(look(textures, id, 0)[0] == (is_ptex ? 1 : .5f));
            co_textures_destroy(textures);
        }
    }
}

// One file, however it is named; as many textures as were added, ids in turn.
static void a_file_is_opened_once(void **state)
{
    (void)state;
    CohortError err = {0};
    Warnings warnings = {0};
    write_grid(in_folder("once.ptx"), 2, 3, CO_PTEX_U8, 3);
    assert_int_equal(symlink("once.ptx", in_folder("twice.ptx")), 0);
    CoTextures *textures = create_textures(&warnings, 0);
    for (uint32_t i = 0; i < 40; i++) {
        CohortTextureDesc desc = {.path = in_folder(i % 2 ? "once.ptx" : "twice.ptx"),
                                  .color_space = COHORT_COLOR_RAW};
        assert_int_equal(co_textures_add(textures, &desc, &err), i);
    }
    assert_int_equal(textures->file_count, 1);
    co_textures_destroy(textures);
}

// Images of lights, which are read whole.
static void whole_images_need_memory(void **state)
{
    (void)state;
    const uint16_t pixels[] = {51, 102, 153, 204};
    write_png(in_folder("whole.png"), 2, 2, 1, 8, pixels);
    CohortTextureDesc desc = {.path = in_folder("whole.png"), .color_space = COHORT_COLOR_RAW};
    Warnings warnings = {0};
    CoTextures *textures = create_textures(&warnings, 0);
    TestFaults faults = {0};
    while (test_faults_next(&faults)) {
        CohortError err = {0};
        float *rgba = NULL;
        uint32_t width = 0, height = 0;
        test_faults_begin(&faults);
        bool ok = co_image_read(textures, &desc, &rgba, &width, &height, &err);
        test_faults_end(&faults, ok, &err);
        assert_true(ok ? width == 2 && height == 2 : !rgba && !width && !height);
        if (ok)
            co_image_free(rgba, width, height);
    }
    assert_int_equal(faults.count, 2);
    assert_int_equal(warnings.count, 0);
    co_textures_destroy(textures);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(triangles_of_ptex_are_refused_by_name),
        cmocka_unit_test(tiles_with_other_channels_show_the_fallback),
        cmocka_unit_test(no_name_is_no_file),
        cmocka_unit_test(a_file_is_opened_once),
        cmocka_unit_test(whole_images_need_memory),
    };
    return cmocka_run_group_tests(tests, test_folder_make, test_folder_remove);
}
