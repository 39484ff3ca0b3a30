// Furnaces: scenes whose every pixel is known to be 1.

#include "support/scenes.h"

#include <math.h>

enum { SIZE = 32, BLOCK = 16 };

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

// Emission 0.3, albedo 0.7 everywhere: radiance 0.3 (1 + 0.7 + 0.49 + ...) = 1, less the tail beyond
// 64 segments, which is 0.7^64.
static void closed_room_is_one(void **state)
{
    (void)state;
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    uint32_t matte = test_matte(scene, 0.7f, 0.3f, &err);
    uint32_t box = test_quads(scene, test_box_points, 8, test_box_indices, 6, NULL, matte, &err);
    CohortInstanceDesc places[2] = {test_place(box, 0, 0, 0, 3.0), test_place(box, 0.5, -1, 0, 0.6)};
    TEST_OK(cohort_scene_set_group(scene, 0, places, 2, &err), &err);
    test_camera(scene, 0, 0, 2.9, 1.0, &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    CohortRenderSettings settings = {.width = SIZE, .height = SIZE, .spp = 512, .max_depth = 64,
                                     .filter = COHORT_FILTER_BOX, .batch = 1u << 16};
    CohortRenderStats stats;
    float *pixels = test_render(scene, &settings, &stats, &err);
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
    uint32_t box = test_quads(scene, test_box_points, 8, test_box_indices, 6, white,
                              COHORT_INVALID_ID, &err);
    CohortInstanceDesc places[2] = {test_place(corner, 0, 0, 0, 1.0), test_place(box, 0, 0.6, 0, 0.5)};
    TEST_OK(cohort_scene_set_group(scene, 0, places, 2, &err), &err);
    CohortLightDesc dome = cohort_light_default(COHORT_LIGHT_DOME);
    uint32_t light = cohort_scene_new_light(scene, &err);
    TEST_OK(cohort_scene_set_light(scene, light, &dome, &err), &err);
    test_camera(scene, 0, 1, 5, 0.5, &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    CohortRenderSettings settings = {.width = SIZE, .height = SIZE, .spp = 512, .max_depth = 64,
                                     .filter = COHORT_FILTER_BOX, .batch = 1u << 16};
    float *pixels = test_render(scene, &settings, NULL, &err);
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
    uint32_t box = test_quads(scene, test_box_points, 8, test_box_indices, 6, NULL,
                              COHORT_INVALID_ID, &err);
    CohortInstanceDesc place = test_place(box, 0, 0, 0, 0.5);
    TEST_OK(cohort_scene_set_group(scene, 0, &place, 1, &err), &err);
    CohortLightDesc dome = cohort_light_default(COHORT_LIGHT_DOME);
    uint32_t light = cohort_scene_new_light(scene, &err);
    TEST_OK(cohort_scene_set_light(scene, light, &dome, &err), &err);
    test_camera(scene, 0, 0, 5, 0.5, &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    CohortRenderSettings settings = {.width = SIZE, .height = SIZE, .spp = 4, .max_depth = 2,
                                     .filter = COHORT_FILTER_BOX, .batch = 1u << 16};
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_room_is_one),
        cmocka_unit_test(white_mesh_in_a_unit_dome_is_one),
        cmocka_unit_test(lights_seen_cover_their_pixels),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
