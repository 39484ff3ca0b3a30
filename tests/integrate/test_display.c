// Meshes without a material: displayColor, displayOpacity, and the colors of their placements.

#include "support/scenes.h"

static const float red[3] = {1, 0, 0}, green[3] = {0, 1, 0}, blue[3] = {0, 0, 1},
                   white[3] = {1, 1, 1};

// A quad with a color or none, and an opacity below 1 or none.
static uint32_t make_quad(CohortScene *scene, const float *color, float opacity, CohortError *err)
{
    CohortPrimvarDesc primvars[2];
    size_t count = 0;
    if (color)
        primvars[count++] = (CohortPrimvarDesc){
            .name = "displayColor", .components = 3, .values = color, .value_count = 1};
    if (opacity < 1.0f)
        primvars[count++] = (CohortPrimvarDesc){
            .name = "displayOpacity", .components = 1, .values = &opacity, .value_count = 1};
    CohortMeshDesc desc = test_square(NULL);
    desc.primvars = primvars;
    desc.primvar_count = count;
    return test_mesh(scene, &desc, err);
}

// What one place covers another with, to the last bit.
static CohortInstanceDesc place_quad(CohortScene *scene, const float *color, float opacity,
                                     CohortError *err)
{
    return test_place(make_quad(scene, color, opacity, err), 0, 0, 0, 1);
}

// The mean of what a camera at height 2 sees of the scene, but for the lights.
static void look(CohortScene *scene, const CohortInstanceDesc *places, size_t count,
                 CohortLightType type, float mean[4])
{
    CohortError err = {0};
    CohortLightDesc light = cohort_light_default(type);
    test_identity(light.transform);
    light.angle_degrees = 0.0f;
    light.intensity = type == COHORT_LIGHT_DISTANT ? 3.14159265f : 1.0f;
    TEST_OK(cohort_scene_set_light(scene, cohort_scene_new_light(scene, &err), &light, &err), &err);
    TEST_OK(cohort_scene_set_group(scene, 0, places, count, &err), &err);
    test_camera(scene, 0, 0, 2, 0.2, &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    CohortRenderSettings settings = {.width = 16,
                                     .height = 16,
                                     .spp = 64,
                                     .max_depth = 2,
                                     .filter = COHORT_FILTER_BOX,
                                     .hide_lights = true};
    float *pixels = test_render(scene, &settings, NULL, &err);
    memset(mean, 0, 4 * sizeof *mean);
    for (size_t i = 0; i < 4 * 256; i++)
        mean[i % 4] += pixels[i] / 256.0f;
    free(pixels);
    cohort_scene_destroy(scene);
}

static void opacity_lets_rays_through(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    CohortInstanceDesc place = test_place(make_quad(scene, red, 0.25f, &err), 0, 0, 0, 1);
    float mean[4];
    look(scene, &place, 1, COHORT_LIGHT_DOME, mean);
    assert_float_equal(mean[3], 0.25, 0.01);
    assert_float_equal(mean[0], 0.25, 0.01); // red 1 under a dome of 1
    assert_float_equal(mean[1], 0.0, 1e-6);
}

// Films that lie on a wall, and on each other, hide neither it nor each other.
static void what_lies_where_a_cutout_does_is_met(void **state)
{
    (void)state;
    CohortError err = {0};
    float mean[4];
    for (int order = 0; order < 2; order++) {
        CohortScene *scene = test_scene(&err);
        CohortInstanceDesc places[4] = {
            place_quad(scene, red, 0.25f, &err), place_quad(scene, green, 0.5f, &err),
            place_quad(scene, green, 0.5f, &err), place_quad(scene, blue, 1.0f, &err)};
        if (order) {
            CohortInstanceDesc first = places[0];
            places[0] = places[2];
            places[2] = first;
        }
        look(scene, places, 4, COHORT_LIGHT_DOME, mean);
        assert_float_equal(mean[0], (order ? 0.0625 : 0.25), 0.02);
        assert_float_equal(mean[1], (order ? 0.75 : 0.5625), 0.02);
        assert_float_equal(mean[2], 0.1875, 0.02);
        assert_float_equal(mean[3], 1.0, 1e-6);
    }
}

// A pane behind the camera stands between the floor and the sun.
static void shadows_are_as_thin(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    CohortInstanceDesc places[2] = {test_place(make_quad(scene, white, 1.0f, &err), 0, 0, 0, 4),
                                    test_place(make_quad(scene, blue, 0.25f, &err), 0, 0, 3, 4)};
    float mean[4];
    look(scene, places, 2, COHORT_LIGHT_DISTANT, mean);
    assert_float_equal(mean[0], 0.75, 1e-3);
}

// The color of a placement that has blue, seen on a mesh with red of its own or none.
static void placed(bool yields, bool has_own, float mean[4])
{
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    uint32_t quad = make_quad(scene, has_own ? red : NULL, 1.0f, &err);
    CohortInstanceDesc place = test_place(quad, 0, 0, 0, 1);
    place.display_color = blue;
    place.color_yields = yields;
    look(scene, &place, 1, COHORT_LIGHT_DOME, mean);
}

static void a_placements_color_may_yield(void **state)
{
    (void)state;
    float mean[4];
    placed(true, true, mean);
    assert_true(mean[0] > 0.9f && mean[2] == 0.0f);
    placed(true, false, mean);
    assert_true(mean[2] > 0.9f && mean[0] == 0.0f);
    placed(false, true, mean);
    assert_true(mean[2] > 0.9f && mean[0] == 0.0f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(opacity_lets_rays_through),
        cmocka_unit_test(what_lies_where_a_cutout_does_is_met),
        cmocka_unit_test(shadows_are_as_thin),
        cmocka_unit_test(a_placements_color_may_yield),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
