// Camera rays: where they start, what they pass through, and how far they go.

#include "support/scenes.h"

#include "integrate/render_data.h"

#include <math.h>

enum {
    WIDTH = 8,
    HEIGHT = 4,
    SAMPLES = 4,
    RAYS = WIDTH * HEIGHT * SAMPLES
};

// At (1, 2, 3), looking along -Z.
static CohortCameraDesc plain_camera(void)
{
    CohortCameraDesc desc = {.window = {-0.5, 0.5, -0.25, 0.25}, .clip_near = 0.5, .clip_far = 20};
    test_identity(desc.transform);
    for (int i = 0; i < 3; i++)
        desc.transform[3][i] = i + 1.0;
    return desc;
}

typedef struct Made {
    CohortScene *scene;
    CohortRender *render;
    CoRay rays[RAYS]; // by path
    CoVec3 eye;       // in the render frame
} Made;

// Makes all rays of a round by a camera.
static void make_rays(Made *made, const CohortCameraDesc *camera, CohortFilter filter)
{
    CohortError err = {0};
    CohortRenderSettings settings = {.width = WIDTH,
                                     .height = HEIGHT,
                                     .spp = SAMPLES,
                                     .batch = 256,
                                     .filter = filter,
                                     .threads = 2};
    made->scene = test_scene(&err);
    TEST_OK(cohort_scene_set_camera(made->scene, camera, &err), &err);
    TEST_OK(cohort_scene_commit(made->scene, NULL, &err), &err);
    made->render = cohort_render_create(made->scene, &settings, &err);
    assert_non_null(made->render);
    made->eye = made->scene->camera.origin;
    made->render->round_samples = SAMPLES;
    co_stage_camera(made->render, RAYS);
    assert_int_equal(made->render->camera_next, RAYS);
    TEST_OK(co_ray_bins_flush(made->render->bins, &err), &err);
    size_t count = 0;
    for (;;) {
        CoRayRecords records = {0};
        TEST_OK(co_ray_bins_pop(made->render->bins, &records, &err), &err);
        if (!records.count)
            TEST_OK(co_ray_bins_drain(made->render->bins, &records, &err), &err);
        if (!records.count)
            break;
        for (size_t i = 0; i < records.count; i++, count++) {
            CoRay ray;
            co_ray_decode(records.words + i * records.stride, made->render->ray_options, &ray);
            assert_true(ray.path < RAYS);
            made->rays[ray.path] = ray;
        }
        co_ray_bins_recycle(made->render->bins, &records);
    }
    assert_int_equal(count, RAYS);
}

static void clear(Made *made)
{
    cohort_render_destroy(made->render);
    cohort_scene_destroy(made->scene);
}

// Where the line of a ray meets the plane at a distance in front of the camera.
static CoVec3 at_distance(const Made *made, const CoRay *ray, float distance)
{
    CoVec3 from = co_sub(ray->org, made->eye);
    return co_madd(from, ray->dir, (-distance - from.z) / ray->dir.z);
}

// With a box filter each ray goes through its own pixel, rows from the top, samples side by side.
static void rays_go_through_their_pixels(void **state)
{
    (void)state;
    static Made made;
    CohortCameraDesc camera = plain_camera();
    make_rays(&made, &camera, COHORT_FILTER_BOX);
    for (uint32_t path = 0; path < RAYS; path++) {
        const CoRay *ray = &made.rays[path];
        uint32_t pixel = path / SAMPLES;
        CoVec3 p = at_distance(&made, ray, 1.0f);
        float x = (p.x + 0.5f) * WIDTH, y = (0.25f - p.y) * HEIGHT / 0.5f;
        assert_true(fabsf(x - (float)(pixel % WIDTH) - 0.5f) < 0.501f);
        assert_true(fabsf(y - (float)(pixel / WIDTH) - 0.5f) < 0.501f);
        assert_int_equal(ray->kind, CO_RAY_CAMERA);
        assert_int_equal(ray->depth, 1);
        assert_true(ray->weight.x == 1.0f && ray->weight.y == 1.0f && ray->weight.z == 1.0f);
        assert_true(ray->width == 0.0f);
        assert_true(fabsf(ray->spread * WIDTH - 1.0f) < 0.05f); // a pixel at distance 1
    }
    clear(&made);
}

// Rays start on the near plane, and the far one is where co_camera_far says.
static void rays_start_at_the_near_plane(void **state)
{
    (void)state;
    static Made made;
    CohortCameraDesc camera = plain_camera();
    make_rays(&made, &camera, COHORT_FILTER_BLACKMAN_HARRIS);
    const CoCamera *c = &made.scene->camera;
    for (uint32_t path = 0; path < RAYS; path++) {
        const CoRay *ray = &made.rays[path];
        assert_true(fabsf(co_camera_depth(c, ray->org) - 0.5f) < 1e-5f);
        CoVec3 end = co_madd(ray->org, ray->dir, co_camera_far(c, ray->dir));
        assert_true(fabsf(co_camera_depth(c, end) - 20.0f) < 1e-4f);
    }
    // Directions that never get there.
    assert_true(isinf(co_camera_far(c, co_vec3(0.0f, 0.0f, 1.0f))));
    assert_true(isinf(co_camera_far(c, co_vec3(1.0f, 0.0f, 0.0f))));
    assert_true(co_camera_depth(c, made.eye) == 0.0f);
    clear(&made);
}

// Through a lens rays start all over its disk and meet in the plane of focus.
static void lenses_focus(void **state)
{
    (void)state;
    static Made made;
    CohortCameraDesc camera = plain_camera();
    camera.lens_radius = 2.0;
    camera.focus_distance = 4.0;
    make_rays(&made, &camera, COHORT_FILTER_BOX);
    float widest = 0.0f;
    for (uint32_t path = 0; path < RAYS; path++) {
        CoVec3 lens = at_distance(&made, &made.rays[path], 0.0f);
        CoVec3 focus = at_distance(&made, &made.rays[path], 4.0f);
        uint32_t pixel = path / SAMPLES;
        float radius = co_length(lens);
        assert_true(radius <= 2.0f * 1.0001f);
        widest = fmaxf(widest, radius);
        // Within the ray's own pixel, which is 4 times as large there.
        float x = (focus.x / 4.0f + 0.5f) * WIDTH, y = (0.25f - focus.y / 4.0f) * HEIGHT / 0.5f;
        assert_true(fabsf(x - (float)(pixel % WIDTH) - 0.5f) < 0.501f);
        assert_true(fabsf(y - (float)(pixel / WIDTH) - 0.5f) < 0.501f);
    }
    assert_true(widest > 1.6f);
    clear(&made);
}

// Orthographic rays are parallel, as wide as a pixel, and have no lens.
static void orthographic_rays_are_parallel(void **state)
{
    (void)state;
    static Made made;
    CohortCameraDesc camera = plain_camera();
    camera.orthographic = true;
    camera.lens_radius = 0.1;
    camera.focus_distance = 4.0;
    make_rays(&made, &camera, COHORT_FILTER_BOX);
    for (uint32_t path = 0; path < RAYS; path++) {
        const CoRay *ray = &made.rays[path];
        uint32_t pixel = path / SAMPLES;
        assert_true(ray->dir.z == -1.0f);
        float x = (ray->org.x - made.eye.x + 0.5f) * WIDTH;
        assert_true(fabsf(x - (float)(pixel % WIDTH) - 0.5f) < 0.501f);
        assert_true(ray->spread == 0.0f);
        assert_true(fabsf(ray->width * WIDTH - 1.0f) < 0.05f);
    }
    clear(&made);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rays_go_through_their_pixels),
        cmocka_unit_test(rays_start_at_the_near_plane),
        cmocka_unit_test(lenses_focus),
        cmocka_unit_test(orthographic_rays_are_parallel),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
