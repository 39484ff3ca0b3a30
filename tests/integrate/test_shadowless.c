// Lights without shadows, and domes that the camera does not see.

#include "shed.h"

// Seen from between floor and roof; the light, if any, is above the roof.
static CohortScene *shed(bool has_roof, const CohortLightDesc *light)
{
    CohortError err = {0};
    CohortScene *scene = shed_create(has_roof, 0, light, &err);
    shed_commit(scene, 0.0, &err);
    return scene;
}

static void render_shed(bool has_roof, const CohortLightDesc *light, float out[SHED_VALUES])
{
    CohortError err = {0};
    CohortRenderSettings settings = {.spp = 16, .max_depth = 3};
    shed_render(shed(has_roof, light), &settings, out, &err);
}

// The roof reflects nothing, so without shadows it is as if it were not there, bit for bit: both
// ways of finding the light go through it.
static void light_without_shadows_goes_through(void **state)
{
    (void)state;
    static const CohortLightType types[] = {COHORT_LIGHT_RECT, COHORT_LIGHT_SPHERE,
                                            COHORT_LIGHT_DISTANT, COHORT_LIGHT_DOME};
    for (int i = 0; i < 4; i++) {
        CohortLightDesc light = cohort_light_default(types[i]);
        light.intensity = 1.0f;
        light.width = light.height = 4.0f;
        test_identity(light.transform);
        light.transform[3][2] = 3.0;
        float open[SHED_VALUES], shaded[SHED_VALUES], through[SHED_VALUES];
        render_shed(false, &light, open);
        render_shed(true, &light, shaded);
        light.no_shadow = true;
        render_shed(true, &light, through);
        assert_true(open[0] > 0.0f);
        assert_true(shaded[0] < 0.5f * open[0]); // a dome shines in from the sides
        assert_memory_equal(open, through, sizeof open);
    }
}

// Behind a cut-out a ray goes on, and must not collect the light again.
static void cutouts_do_not_collect_twice(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortLightDesc dome = cohort_light_default(COHORT_LIGHT_DOME);
    float means[2];
    for (int pass = 0; pass < 2; pass++) {
        dome.no_shadow = pass == 1;
        CohortScene *scene = shed(true, &dome);
        CohortMaterialDesc glass = cohort_material_default();
        glass.lambert = true;
        glass.opacity.value[0] = 0.0f;
        glass.opacity_threshold = 0.5f;
        uint32_t id = cohort_scene_new_material(scene, &err);
        TEST_OK(cohort_scene_set_material(scene, id, &glass, &err), &err);
        TEST_OK(cohort_scene_set_mesh_materials(scene, SHED_ROOF, id, NULL, 0, &err), &err);
        TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
        CohortRenderSettings settings = {.spp = 64, .max_depth = 2};
        float pixels[SHED_VALUES];
        shed_render(scene, &settings, pixels, &err);
        means[pass] = 0.0f;
        for (int i = 0; i < SHED_VALUES; i += 4)
            means[pass] += pixels[i] / (SHED_SIDE * SHED_SIDE);
    }
    assert_true(means[0] > 0.5f);
    assert_float_equal(means[0], means[1], 0.01);
}

static void hidden_domes_light_and_are_not_seen(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortLightDesc dome = cohort_light_default(COHORT_LIGHT_DOME);
    CohortScene *scene = shed(false, &dome);
    test_camera(scene, 0, 0, 0, 20.0, &err); // sees past the floor
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    CohortRenderSettings settings = {
        .width = SHED_SIDE, .height = SHED_SIDE, .spp = 4, .max_depth = 2};
    float *seen = test_render(scene, &settings, NULL, &err);
    settings.hide_domes = true;
    float *hidden = test_render(scene, &settings, NULL, &err);
    const int middle = 4 * (SHED_SIDE / 2 * SHED_SIDE + SHED_SIDE / 2);
    assert_true(seen[0] == 1.0f && seen[3] == 1.0f);
    assert_true(hidden[0] == 0.0f && hidden[3] == 0.0f);
    assert_true(hidden[middle] > 0.1f);
    free(seen);
    free(hidden);
    cohort_scene_destroy(scene);
}

// What is no edit of a light leaves the lights, and their images, alone, unless it moves the frame.
static void lights_are_built_when_they_change(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortLightDesc rect = cohort_light_default(COHORT_LIGHT_RECT);
    CohortScene *scene = shed(true, &rect);
    CohortSceneCounts counts;
    test_camera(scene, 0, 0, 0.5, 1.0, &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    cohort_scene_counts(scene, &counts);
    assert_int_equal(counts.light_builds, 1);
    rect.intensity = 2.0f;
    TEST_OK(cohort_scene_set_light(scene, 0, &rect, &err), &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    cohort_scene_counts(scene, &counts);
    assert_int_equal(counts.light_builds, 2);
    CohortInstanceDesc far = test_place(1, 1e4, 0, 0, 1);
    TEST_OK(cohort_scene_set_group(scene, 0, &far, 1, &err), &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    cohort_scene_counts(scene, &counts);
    assert_int_equal(counts.light_builds, 3);
    cohort_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_without_shadows_goes_through),
        cmocka_unit_test(cutouts_do_not_collect_twice),
        cmocka_unit_test(hidden_domes_light_and_are_not_seen),
        cmocka_unit_test(lights_are_built_when_they_change),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
