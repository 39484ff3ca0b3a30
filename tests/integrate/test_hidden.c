// What is hidden from some rays: a roof that casts no shadow, and one that the camera looks
// through.

#include "support/scenes.h"

enum {
    SIDE = 8,
    VALUES = SIDE * SIDE * 4,
    NO_ROOF = 1
};

// A white floor under a black roof, seen from height z, lit from height `light`.
static void render_shed(uint32_t hidden_from, double z, double light_z, float out[VALUES])
{
    static const float floor_points[] = {-9, -9, -2, 9, -9, -2, 9, 9, -2, -9, 9, -2};
    static const float roof_points[] = {-9, -9, 1, 9, -9, 1, 9, 9, 1, -9, 9, 1};
    static const int32_t indices[] = {0, 1, 2, 3};
    static const float white[3] = {0.8f, 0.8f, 0.8f}, black[3] = {0, 0, 0};
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    CohortInstanceDesc places[2] = {
        test_place(test_quads(scene, floor_points, 4, indices, 1, white, COHORT_INVALID_ID, &err),
                   0, 0, 0, 1),
        test_place(test_quads(scene, roof_points, 4, indices, 1, black, COHORT_INVALID_ID, &err), 0,
                   0, 0, 1)};
    places[1].hidden_from = hidden_from;
    TEST_OK(cohort_scene_set_group(scene, 0, places, hidden_from == NO_ROOF ? 1 : 2, &err), &err);
    CohortLightDesc light = cohort_light_default(COHORT_LIGHT_RECT);
    light.width = light.height = 4.0f;
    test_identity(light.transform);
    light.transform[3][2] = light_z;
    TEST_OK(cohort_scene_set_light(scene, cohort_scene_new_light(scene, &err), &light, &err), &err);
    test_camera(scene, 0, 0, z, 0.5, &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    CohortRenderSettings settings = {
        .width = SIDE, .height = SIDE, .spp = 16, .max_depth = 3, .hide_lights = true};
    float *pixels = test_render(scene, &settings, NULL, &err);
    memcpy(out, pixels, VALUES * sizeof *out);
    free(pixels);
    cohort_scene_destroy(scene);
}

static void what_no_light_ray_meets_casts_no_shadow(void **state)
{
    (void)state;
    float open[VALUES], shaded[VALUES], through[VALUES], seen[VALUES];
    render_shed(NO_ROOF, 0.0, 3.0, open);
    render_shed(0, 0.0, 3.0, shaded);
    render_shed(COHORT_HIDDEN_FROM_SHADOW | COHORT_HIDDEN_FROM_INDIRECT, 0.0, 3.0, through);
    assert_true(open[0] > 0.0f && shaded[0] == 0.0f);
    assert_memory_equal(open, through, sizeof open);
    // From above it is still there.
    render_shed(COHORT_HIDDEN_FROM_SHADOW | COHORT_HIDDEN_FROM_INDIRECT, 2.0, 0.0, seen);
    assert_true(seen[0] == 0.0f && seen[3] == 1.0f);
}

static void the_camera_looks_through(void **state)
{
    (void)state;
    float open[VALUES], blocked[VALUES], through[VALUES], shaded[VALUES];
    render_shed(NO_ROOF, 2.0, 0.0, open);
    render_shed(0, 2.0, 0.0, blocked);
    render_shed(COHORT_HIDDEN_FROM_CAMERA, 2.0, 0.0, through);
    assert_true(open[0] > 0.0f && blocked[0] == 0.0f);
    assert_memory_equal(open, through, sizeof open); // a black roof takes what the sky would have
    render_shed(COHORT_HIDDEN_FROM_CAMERA, 2.0, 3.0, shaded);
    assert_true(shaded[0] == 0.0f); // and casts its shadow
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_no_light_ray_meets_casts_no_shadow),
        cmocka_unit_test(the_camera_looks_through),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
