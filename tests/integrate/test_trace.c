// How far rays reach: camera rays to the far plane or a lamp, light rays to their light.

#include "support/scenes.h"

#include <math.h>

// One pixel, seen from (0, 0, 5) up to clip_far.
static void look(CohortScene *scene, const CohortInstanceDesc *places, size_t count, double near,
                 double far, float out[4])
{
    CohortError err = {0};
    CohortCameraDesc camera = {
        .window = {-0.01, 0.01, -0.01, 0.01}, .clip_near = near, .clip_far = far};
    test_identity(camera.transform);
    camera.transform[3][2] = 5.0;
    TEST_OK(cohort_scene_set_group(scene, 0, places, count, &err), &err);
    TEST_OK(cohort_scene_set_camera(scene, &camera, &err), &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    CohortRenderSettings settings = {.width = 1, .height = 1, .spp = 64, .max_depth = 2};
    float *pixels = test_render(scene, &settings, NULL, &err);
    memcpy(out, pixels, 4 * sizeof *out);
    free(pixels);
    cohort_scene_destroy(scene);
}

static void clip_planes_end_camera_rays(void **state)
{
    (void)state;
    static const struct {
        double near, far;
        float want;
    } planes[] = {{0.1, 100, 1}, {0.1, 4.9, 0}, {0.1, 5.1, 1}, {4.9, 100, 1}, {5.1, 100, 0}};
    for (size_t i = 0; i < sizeof planes / sizeof *planes; i++) {
        CohortError err = {0};
        CohortScene *scene = test_scene(&err);
        CohortInstanceDesc wall;
        float pixel[4];
        test_wall(scene, &wall, 1, 0, test_matte(scene, 0.0f, 1.0f, &err), &err);
        look(scene, &wall, 1, planes[i].near, planes[i].far, pixel);
        assert_true(pixel[0] == planes[i].want && pixel[3] == planes[i].want);
    }
}

// A lamp that faces the camera is what it sees; one that faces away is not there for it.
static void a_lamp_in_the_picture_hides_the_wall(void **state)
{
    (void)state;
    for (int away = 0; away < 2; away++) {
        CohortError err = {0};
        CohortScene *scene = test_scene(&err);
        CohortLightDesc lamp = cohort_light_default(COHORT_LIGHT_RECT);
        lamp.width = lamp.height = 1.0f;
        lamp.intensity = 3.0f;
        lamp.transform[3][2] = 2.0;
        if (!away)
            lamp.transform[0][0] = lamp.transform[2][2] = -1.0;
        test_light(scene, &lamp, &err);
        CohortInstanceDesc wall;
        float pixel[4];
        test_wall(scene, &wall, 1, 0, test_matte(scene, 0.0f, 1.0f, &err), &err);
        look(scene, &wall, 1, 0.1, 100, pixel);
        assert_true(pixel[0] == (away ? 1.0f : 3.0f));
    }
}

// A wall beyond the lamp keeps no light from another; one before it all.
static void light_rays_end_at_their_lamp(void **state)
{
    (void)state;
    for (int k = 0; k < 3; k++) {
        CohortError err = {0};
        CohortScene *scene = test_scene(&err);
        CohortLightDesc lamp = cohort_light_default(COHORT_LIGHT_SPHERE);
        lamp.radius = 0.01f;
        lamp.normalize = true;
        lamp.transform[3][0] = 3.0;
        lamp.transform[3][2] = 3.0;
        test_light(scene, &lamp, &err);
        CohortInstanceDesc walls[2];
        uint32_t matte = test_matte(scene, 1.0f, 0.0f, &err);
        test_wall(scene, &walls[0], 1, 0, matte, &err);
        test_wall(scene, &walls[1], 0.5, 0, matte, &err);
        double along = k == 1 ? 1.5 : 4.5; // before and beyond it
        walls[1].transform[3][0] = walls[1].transform[3][2] = along;
        float pixel[4];
        look(scene, walls, k == 0 ? 1 : 2, 0.1, 100, pixel);
        // Radiance 1 / (4 pi r^2) over pi r^2 / d^2, times the cosine over pi.
        double want = 0.25 / 18.0 * sqrt(0.5) / 3.14159265;
        if (k == 1)
            assert_true(pixel[0] == 0.0f);
        else
            assert_true(fabs((double)pixel[0] - want) < 0.01 * want);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clip_planes_end_camera_rays),
        cmocka_unit_test(a_lamp_in_the_picture_hides_the_wall),
        cmocka_unit_test(light_rays_end_at_their_lamp),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
