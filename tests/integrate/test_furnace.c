// Furnaces: scenes whose every pixel is known to be 1.

#include "support/scenes.h"

#include <math.h>

enum {
    SIZE = 32,
    BLOCK = 16
};

static const CohortRenderSettings furnace = {.width = SIZE,
                                             .height = SIZE,
                                             .spp = 512,
                                             .max_depth = 64,
                                             .filter = COHORT_FILTER_BOX,
                                             .batch = 1u << 16};

static void check_blocks(const float *pixels, double expected, double tolerance)
{
    for (int by = 0; by < SIZE; by += BLOCK)
        for (int bx = 0; bx < SIZE; bx += BLOCK)
            for (int c = 0; c < 3; c++) {
                double sum = 0.0;
                for (int y = by; y < by + BLOCK; y++)
                    for (int x = bx; x < bx + BLOCK; x++)
                        sum += (double)pixels[4 * (y * SIZE + x) + c];
                double mean = sum / (BLOCK * BLOCK);
                if (fabs(mean - expected) > tolerance * expected)
                    fail_msg("block (%d, %d) channel %d: %.6f instead of %.6f", bx, by, c, mean,
                             expected);
            }
}

// Emission 0.3, albedo 0.7 everywhere: radiance 0.3 (1 + 0.7 + 0.49 + ...) = 1, less the tail
// beyond 64 segments, which is 0.7^64.
static void closed_room_is_one(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    uint32_t matte = test_matte(scene, 0.7f, 0.3f, &err);
    uint32_t box = test_quads(scene, test_box_points, 8, test_box_indices, 6, NULL, matte, &err);
    CohortInstanceDesc places[2] = {test_place(box, 0, 0, 0, 3.0),
                                    test_place(box, 0.5, -1, 0, 0.6)};
    TEST_OK(cohort_scene_set_group(scene, 0, places, 2, &err), &err);
    test_camera(scene, 0, 0, 2.9, 1.0, &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    CohortRenderStats stats;
    float *pixels = test_render(scene, &furnace, &stats, &err);
    check_blocks(pixels, 1.0, 0.002);
    assert_int_equal(stats.ends_invalid, 0);
    assert_int_equal(stats.ends_miss, 0);
    free(pixels);
    cohort_scene_destroy(scene);
}

// A concave mesh of albedo 1 in a dome of radiance 1 is invisible.
static void white_mesh_in_a_unit_dome_is_one(void **state)
{
    (void)state;
    static const float points[] = {-2, 0, 2, 2, 0, 2, 2, 0, -2, -2, 0, -2, -2, 2, -2, 2, 2, -2};
    static const int32_t indices[] = {0, 1, 2, 3, 3, 2, 5, 4};
    static const float white[3] = {1.0f, 1.0f, 1.0f};
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    uint32_t corner = test_quads(scene, points, 6, indices, 2, white, COHORT_INVALID_ID, &err);
    uint32_t box =
        test_quads(scene, test_box_points, 8, test_box_indices, 6, white, COHORT_INVALID_ID, &err);
    CohortInstanceDesc places[2] = {test_place(corner, 0, 0, 0, 1.0),
                                    test_place(box, 0, 0.6, 0, 0.5)};
    TEST_OK(cohort_scene_set_group(scene, 0, places, 2, &err), &err);
    test_dome(scene, &err);
    test_camera(scene, 0, 1, 5, 0.5, &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    float *pixels = test_render(scene, &furnace, NULL, &err);
    check_blocks(pixels, 1.0, 0.002);
    free(pixels);
    cohort_scene_destroy(scene);
}

// A visible dome covers every pixel; hidden, only the quad in the middle does.
static void lights_seen_cover_their_pixels(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    uint32_t box =
        test_quads(scene, test_box_points, 8, test_box_indices, 6, NULL, COHORT_INVALID_ID, &err);
    CohortInstanceDesc place = test_place(box, 0, 0, 0, 0.5);
    TEST_OK(cohort_scene_set_group(scene, 0, &place, 1, &err), &err);
    test_dome(scene, &err);
    test_camera(scene, 0, 0, 5, 0.5, &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    CohortRenderSettings settings = furnace;
    settings.spp = 4;
    settings.max_depth = 2;
    for (int hide = 0; hide < 2; hide++) {
        settings.hide_lights = hide != 0;
        float *pixels = test_render(scene, &settings, NULL, &err);
        for (int i = 0; i < SIZE * SIZE; i++)
            assert_true(hide || pixels[4 * i + 3] == 1.0f);
        assert_true(pixels[3] == (hide ? 0.0f : 1.0f));
        assert_true(pixels[4 * (SIZE / 2 * SIZE + SIZE / 2) + 3] == 1.0f);
        free(pixels);
    }
    cohort_scene_destroy(scene);
}

// Mean of a channel over a small image; with the lights hidden from the camera, alpha is the pane's
// own.
static double pane_mean(const CohortScene *scene, int channel, bool hide_lights, CohortError *err)
{
    CohortRenderSettings settings = {.width = 4,
                                     .height = 4,
                                     .spp = 1024,
                                     .max_depth = 4,
                                     .hide_lights = hide_lights,
                                     .batch = 1u << 14};
    float *pixels = test_render(scene, &settings, NULL, err);
    double sum = 0.0;
    for (int i = 0; i < 16; i++)
        sum += (double)pixels[4 * i + channel] / 16.0;
    free(pixels);
    return sum;
}

// A pane that lets part of the light straight through, in front of a dome of radiance 1: whatever
// its opacity, mode and angle it shows at most 1 (but for what GGX loses), and its alpha is its
// coverage.
static void panes_make_no_light(void **state)
{
    (void)state;
    static const float points[] = {-9, -9, 0, 9, -9, 0, 9, 9, 0, -9, 9, 0};
    static const int32_t indices[] = {0, 1, 2, 3};
    static const struct {
        float opacity, diffuse, tilt, least, alpha_least, alpha_most;
        bool presence;
    } cases[] = {{0.0f, 0.0f, 0.0f, 0.95f, 0.02f, 0.08f, false},
                 {0.0f, 0.0f, 1.4f, 0.9f, 0.1f, 0.9f, false},
                 {0.5f, 0.0f, 0.0f, 0.45f, 0.48f, 0.56f, false},
                 {0.5f, 1.0f, 0.0f, 0.95f, 0.48f, 0.56f, false},
                 {0.5f, 1.0f, 1.4f, 0.85f, 0.5f, 0.95f, false},
                 {0.5f, 1.0f, 0.0f, 0.95f, 0.48f, 0.52f, true}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        CohortError err = {0};
        CohortScene *scene = test_scene(&err);
        CohortMaterialDesc desc = cohort_material_default();
        for (int c = 0; c < 3; c++)
            desc.diffuse_color.value[c] = cases[i].diffuse;
        desc.opacity.value[0] = cases[i].opacity;
        desc.opacity_presence = cases[i].presence;
        desc.roughness.value[0] = 0.1f;
        uint32_t material = cohort_scene_new_material(scene, &err);
        TEST_OK(cohort_scene_set_material(scene, material, &desc, &err), &err);
        uint32_t pane = test_quads(scene, points, 4, indices, 1, NULL, material, &err);
        CohortInstanceDesc place = test_place(pane, 0, 0, 0, 1.0);
        double c = cos((double)cases[i].tilt), s = sin((double)cases[i].tilt);
        place.transform[0][0] = place.transform[2][2] = c;
        place.transform[0][2] = -s;
        place.transform[2][0] = s;
        TEST_OK(cohort_scene_set_group(scene, 0, &place, 1, &err), &err);
        test_dome(scene, &err);
        test_camera(scene, 0, 0, 5, 0.05, &err);
        TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
        double red = pane_mean(scene, 0, false, &err), alpha = pane_mean(scene, 3, true, &err);
        if (red > 1.02 || red < (double)cases[i].least || alpha < (double)cases[i].alpha_least ||
            alpha > (double)cases[i].alpha_most)
            fail_msg("pane %zu shows %f with alpha %f", i, red, alpha);
        cohort_scene_destroy(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_room_is_one),
        cmocka_unit_test(white_mesh_in_a_unit_dome_is_one),
        cmocka_unit_test(panes_make_no_light),
        cmocka_unit_test(lights_seen_cover_their_pixels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
