// Colors of meshes and materials are Rec.709, whatever space the light is carried in.

#include "support/scenes.h"

#include <math.h>

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
    CohortLightDesc dome = cohort_light_default(COHORT_LIGHT_DOME);
    TEST_OK(cohort_scene_set_light(scene, cohort_scene_new_light(scene, &err), &dome, &err), &err);
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(colors_are_brought_into_the_rendering_space),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
