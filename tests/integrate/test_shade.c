// What leaves a hit: emission, reflection in expected amounts, what goes through, and where it
// ends.

#include "support/scenes.h"

#include <math.h>

// One pixel, seen from (0, 0, 5); ends the scene.
static void look(CohortScene *scene, const CohortInstanceDesc *places, size_t count,
                 const CohortRenderSettings *settings, float out[4])
{
    CohortError err = {0};
    CohortRenderSettings one = *settings;
    one.width = one.height = 1;
    TEST_OK(cohort_scene_set_group(scene, 0, places, count, &err), &err);
    test_camera(scene, 0, 0, 5, 0.01, &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    float *pixels = test_render(scene, &one, NULL, &err);
    memcpy(out, pixels, 4 * sizeof *out);
    free(pixels);
    cohort_scene_destroy(scene);
}

static void assert_near(float got, double want, double tolerance)
{
    if (!(fabs((double)got - want) <= tolerance))
        fail_msg("%g, expected %g within %g", (double)got, want, tolerance);
}

static uint32_t add_material(CohortScene *scene, const CohortMaterialDesc *desc, CohortError *err)
{
    uint32_t id = cohort_scene_new_material(scene, err);
    TEST_OK(cohort_scene_set_material(scene, id, desc, err), err);
    return id;
}

static CohortMaterialDesc black_matte(void)
{
    CohortMaterialDesc desc = cohort_material_default();
    memset(desc.diffuse_color.value, 0, sizeof desc.diffuse_color.value);
    desc.lambert = true;
    return desc;
}

static void emission_is_shown_as_it_is(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    CohortInstanceDesc wall;
    test_wall(scene, &wall, 1, 0, test_matte(scene, 0.0f, 0.375f, &err), &err);
    float pixel[4];
    look(scene, &wall, 1, &(CohortRenderSettings){.spp = 3}, pixel);
    assert_true(pixel[0] == 0.375f && pixel[2] == 0.375f && pixel[3] == 1.0f);
}

// A matte wall under a dome sends back its albedo; the light is a second segment.
static void the_longest_path_is_kept(void **state)
{
    (void)state;
    for (uint32_t depth = 1; depth <= 2; depth++) {
        CohortError err = {0};
        CohortScene *scene = test_scene(&err);
        CohortLightDesc dome = cohort_light_default(COHORT_LIGHT_DOME);
        test_light(scene, &dome, &err);
        CohortInstanceDesc wall;
        test_wall(scene, &wall, 100, 0, test_matte(scene, 0.5f, 0.0f, &err), &err);
        float pixel[4];
        look(scene, &wall, 1, &(CohortRenderSettings){.spp = 1024, .max_depth = depth}, pixel);
        assert_near(pixel[1], depth == 1 ? 0.0 : 0.5, depth == 1 ? 0.0 : 0.01);
    }
}

// In a closed box that emits 0.2 and reflects 0.8, light sums to 1 - 0.8^segments; from the seventh
// on by roulette, which keeps the mean.
static void roulette_keeps_the_mean(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    uint32_t box = test_quads(scene, test_box_points, 8, test_box_indices, 6, NULL,
                              test_matte(scene, 0.8f, 0.2f, &err), &err);
    CohortInstanceDesc place = test_place(box, 0, 0, 0, 10);
    float pixel[4];
    look(scene, &place, 1, &(CohortRenderSettings){.spp = 4096, .max_depth = 40}, pixel);
    assert_near(pixel[0], 1.0 - pow(0.8, 40), 0.02);
}

static void a_mirror_shows_what_is_there(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    CohortMaterialDesc mirror = black_matte();
    mirror.lambert = false;
    mirror.use_specular_workflow = true;
    mirror.roughness.value[0] = 0.0f;
    for (int i = 0; i < 3; i++)
        mirror.specular_color.value[i] = 0.5f;
    CohortInstanceDesc walls[2];
    test_wall(scene, &walls[0], 1, 0, add_material(scene, &mirror, &err), &err);
    test_wall(scene, &walls[1], 50, 9, test_matte(scene, 0.0f, 2.0f, &err), &err); // behind the eye
    float pixel[4];
    look(scene, walls, 2, &(CohortRenderSettings){.spp = 64}, pixel);
    assert_near(pixel[0], 1.0, 0.02);
}

// Presence: that share of the samples sees the wall, the rest what is behind.
static void what_is_not_there_lets_through(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    CohortMaterialDesc half = black_matte();
    half.opacity.value[0] = 0.25f;
    half.opacity_presence = true;
    half.emissive_color.value[0] = 1.0f;
    CohortInstanceDesc walls[2];
    test_wall(scene, &walls[0], 1, 1, add_material(scene, &half, &err), &err);
    test_wall(scene, &walls[1], 1, 0, test_matte(scene, 0.0f, 0.5f, &err), &err);
    float pixel[4];
    look(scene, walls, 2, &(CohortRenderSettings){.spp = 4096}, pixel);
    assert_near(pixel[0], 0.25 * 1.0 + 0.75 * 0.5, 0.02);
    assert_near(pixel[1], 0.75 * 0.5, 0.02);
    assert_true(pixel[3] == 1.0f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(emission_is_shown_as_it_is),
        cmocka_unit_test(the_longest_path_is_kept),
        cmocka_unit_test(roulette_keeps_the_mean),
        cmocka_unit_test(a_mirror_shows_what_is_there),
        cmocka_unit_test(what_is_not_there_lets_through),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
