// Colors of meshes and materials are Rec.709, whatever space the light is carried in.

#include "support/scenes.h"

#include "cohort/image.h"

#include <math.h>
#include <stdio.h>
#include <unistd.h>

// One lit pixel of a matte wall under a unit dome, which shows the albedo itself.
static void albedo_in(const char *space, const float color[3], bool by_material, float out[4])
{
    static const float points[] = {-9, -9, 0, 9, -9, 0, 9, 9, 0, -9, 9, 0};
    static const int32_t indices[] = {0, 1, 2, 3};
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    uint32_t material = COHORT_INVALID_ID;
    if (by_material) {
        CohortMaterialDesc desc = cohort_material_default();
        memcpy(desc.diffuse_color.value, color, 3 * sizeof(float));
        desc.lambert = true;
        material = cohort_scene_new_material(scene, &err);
        TEST_OK(cohort_scene_set_material(scene, material, &desc, &err), &err);
    }
    uint32_t wall = test_quads(scene, points, 4, indices, 1, color, material, &err);
    CohortInstanceDesc place = test_place(wall, 0, 0, 0, 1);
    TEST_OK(cohort_scene_set_group(scene, 0, &place, 1, &err), &err);
    test_dome(scene, &err);
    test_camera(scene, 0, 0, 2, 0.1, &err);
    CohortSceneOptions options = {.rendering_color_space = space};
    TEST_OK(cohort_scene_commit(scene, &options, &err), &err);
    CohortRenderSettings settings = {.width = 1, .height = 1, .spp = 256, .max_depth = 2};
    float *pixels = test_render(scene, &settings, NULL, &err);
    memcpy(out, pixels, 4 * sizeof *out);
    free(pixels);
    cohort_scene_destroy(scene);
}

static void colors_are_brought_into_the_rendering_space(void **state)
{
    (void)state;
    static const float red[3] = {0.8f, 0.1f, 0.05f};
    // Bradford-adapted Rec.709 -> AP1, the usual matrix.
    static const float ap1[9] = {0.6130974f, 0.3395231f, 0.0473795f, 0.0701937f, 0.9163539f,
                                 0.0134524f, 0.0206156f, 0.1095698f, 0.8698146f};
    for (int by_material = 0; by_material < 2; by_material++) {
        float plain[4], wide[4];
        albedo_in(NULL, red, by_material, plain);
        albedo_in("lin_ap1_scene", red, by_material, wide);
        for (int i = 0; i < 3; i++) {
            float expected =
                ap1[3 * i] * plain[0] + ap1[3 * i + 1] * plain[1] + ap1[3 * i + 2] * plain[2];
            assert_true(fabsf(plain[i] - red[i]) < 0.1f * red[i]);
            assert_true(fabsf(wide[i] - expected) < 1e-3f);
        }
    }
}

static const float rec709_xy[8] = {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f};
static const float ap1_xy[8] = {0.713f, 0.293f, 0.165f, 0.83f, 0.128f, 0.044f, 0.32168f, 0.33767f};
static const float odd_xy[8] = {0.6f, 0.3f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3f, 0.3f};

static void write_image(const char *path, const float color[3], const float *xy)
{
    CohortError err = {0};
    float pixels[8][3];
    for (int i = 0; i < 8; i++)
        memcpy(pixels[i], color, sizeof pixels[i]);
    CohortChannel channels[3] = {{"B", COHORT_CHANNEL_FLOAT, &pixels[0][2], sizeof pixels[0]},
                                 {"G", COHORT_CHANNEL_FLOAT, &pixels[0][1], sizeof pixels[0]},
                                 {"R", COHORT_CHANNEL_FLOAT, &pixels[0][0], sizeof pixels[0]}};
    CohortAttribute primaries = {"chromaticities", .type = COHORT_ATTRIBUTE_CHROMATICITIES};
    if (xy)
        memcpy(primaries.numbers, xy, 8 * sizeof(float));
    CohortExrDesc desc = {.width = 4,
                          .height = 2,
                          .channels = channels,
                          .channel_count = 3,
                          .attributes = &primaries,
                          .attribute_count = xy != NULL};
    TEST_OK(cohort_exr_write(path, &desc, &err), &err);
}

// A pixel of nothing but a dome with that image. Returns how many warnings there were.
static size_t dome_in(const char *space, const char *path, CohortColorSpace from,
                      const char *from_name, float out[4])
{
    CohortError err = {0};
    const CohortDiagnostic *said;
    CohortScene *scene = test_scene(&err);
    CohortLightDesc dome = cohort_light_default(COHORT_LIGHT_DOME);
    dome.texture_file = path;
    dome.texture_color_space = from;
    dome.texture_color_space_name = from_name;
    TEST_OK(cohort_scene_set_light(scene, cohort_scene_new_light(scene, &err), &dome, &err), &err);
    test_camera(scene, 0, 0, 2, 0.1, &err);
    CohortSceneOptions options = {.rendering_color_space = space};
    TEST_OK(cohort_scene_commit(scene, &options, &err), &err);
    size_t warnings = cohort_scene_warnings(scene, &said);
    CohortRenderSettings settings = {.width = 1, .height = 1, .spp = 4, .max_depth = 2};
    float *pixels = test_render(scene, &settings, NULL, &err);
    memcpy(out, pixels, 4 * sizeof *out);
    free(pixels);
    cohort_scene_destroy(scene);
    return warnings;
}

static void assert_color(const float got[4], const float want[3])
{
    for (int i = 0; i < 3; i++)
        assert_true(fabsf(got[i] - want[i]) <= 2e-3f * want[i]);
}

// An image of a light is a color. Where nobody says which, it is linear Rec.709 or what its
// chromaticities name, and never taken as it stands.
static void images_of_domes_are_brought_into_it_too(void **state)
{
    (void)state;
    static const float red[3] = {0.8f, 0.1f, 0.05f};
    static const float red_in_ap1[3] = {0.5268f, 0.1485f, 0.0709f};
    char path[64];
    snprintf(path, sizeof path, "/tmp/cohort-dome-%ld.exr", (long)getpid());
    float got[4];
    write_image(path, red, NULL);
    assert_int_equal(dome_in("lin_ap1_scene", path, COHORT_COLOR_AUTO, NULL, got), 0);
    assert_color(got, red_in_ap1);
    dome_in(NULL, path, COHORT_COLOR_AUTO, NULL, got);
    assert_color(got, red);
    dome_in("lin_ap1_scene", path, COHORT_COLOR_RAW, NULL, got);
    assert_color(got, red);
    dome_in("lin_ap1_scene", path, COHORT_COLOR_NAMED, "lin_ap1_scene", got);
    assert_color(got, red);
    write_image(path, red, rec709_xy);
    dome_in("lin_ap1_scene", path, COHORT_COLOR_AUTO, NULL, got);
    assert_color(got, red_in_ap1);
    write_image(path, red_in_ap1, ap1_xy);
    assert_int_equal(dome_in("lin_ap1_scene", path, COHORT_COLOR_AUTO, NULL, got), 0);
    assert_color(got, red_in_ap1);
    dome_in(NULL, path, COHORT_COLOR_AUTO, NULL, got);
    assert_color(got, red);
    write_image(path, red, odd_xy);
    assert_int_equal(dome_in("lin_ap1_scene", path, COHORT_COLOR_AUTO, NULL, got), 1);
    assert_color(got, red_in_ap1);
    unlink(path);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(colors_are_brought_into_the_rendering_space),
        cmocka_unit_test(images_of_domes_are_brought_into_it_too),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
