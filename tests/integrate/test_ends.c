// Ends of rays: shares of emission between both ways of finding it, and lights that cameras see.

#include "support/scenes.h"

#include "integrate/render_data.h"

#include <math.h>

typedef struct Lit {
    CohortScene *scene;
    CohortRender *render;
} Lit;

// A disk of radius 1 at the origin that shines along +Z, seen from (0, 0, 5); and more of it.
static Lit lit_by(const CohortLightDesc *light, const CohortRenderSettings *settings)
{
    CohortError err = {0};
    Lit lit = {.scene = test_scene(&err)};
    if (light) {
        uint32_t id = cohort_scene_new_light(lit.scene, &err);
        TEST_OK(cohort_scene_set_light(lit.scene, id, light, &err), &err);
    }
    test_camera(lit.scene, 0, 0, 5, 0.5, &err);
    TEST_OK(cohort_scene_commit(lit.scene, NULL, &err), &err);
    lit.render = cohort_render_create(lit.scene, settings, &err);
    assert_non_null(lit.render);
    return lit;
}

static void clear(Lit *lit)
{
    cohort_render_destroy(lit->render);
    cohort_scene_destroy(lit->scene);
}

static CohortLightDesc disk(void)
{
    CohortLightDesc light = cohort_light_default(COHORT_LIGHT_DISK);
    light.radius = 1.0f;
    light.transform[0][0] = light.transform[2][2] = -1.0; // from -Z to +Z
    return light;
}

static const CohortRenderSettings small = {.width = 4, .height = 4, .threads = 1, .batch = 256};

// Where no light sample competed, emission counts whole.
static void alone_it_counts_whole(void **state)
{
    (void)state;
    CohortLightDesc light = disk();
    Lit lit = lit_by(&light, &small);
    CoRay ray = {.org = lit.scene->camera.origin, .dir = {0, 0, -1}, .normal = {0, 0, -1}};
    ray.kind = CO_RAY_CAMERA;
    ray.pdf = 0.5f;
    assert_true(co_mis_emission(lit.render, &ray, 0) == 1.0f);
    ray.kind = CO_RAY_BSDF;
    const float pdfs[] = {0.0f, INFINITY, NAN}; // straight on, a mirror, nonsense
    for (int i = 0; i < 3; i++) {
        ray.pdf = pdfs[i];
        assert_true(co_mis_emission(lit.render, &ray, 0) == 1.0f);
    }
    clear(&lit);
}

// The balance heuristic: shares of both sides sum to one, with the counts of samples at the split.
static void shares_are_balanced(void **state)
{
    (void)state;
    CohortLightDesc light = disk();
    for (uint32_t many = 1; many <= 3; many += 2) {
        CohortRenderSettings settings = small;
        settings.first_hit_samples = many;
        settings.light_samples = 2 * many;
        Lit lit = lit_by(&light, &settings);
        CoRay ray = {.org = lit.scene->camera.origin, .dir = {0, 0, -1}, .normal = {0, 0, -1}};
        ray.kind = CO_RAY_BSDF;
        float p_light = co_light_pdf(lit.scene->lights, ray.org, ray.normal, 0, ray.dir);
        assert_true(p_light > 0.0f && isfinite(p_light));
        for (int i = 0; i < 5; i++) {
            ray.pdf = p_light * ldexpf(1.0f, 4 * i - 8);
            float share = co_mis_emission(lit.render, &ray, 0);
            assert_true(fabsf(share - ray.pdf / (ray.pdf + p_light)) < 1e-6f);
            ray.flags = CO_RAY_FROM_SPLIT;
            float a = (float)many * ray.pdf, b = 2.0f * (float)many * p_light;
            assert_true(fabsf(co_mis_emission(lit.render, &ray, 0) - a / (a + b)) < 1e-6f);
            ray.flags = 0;
        }
        clear(&lit);
    }
}

// The nearest light in front that gives anything; none where they are hidden, dark or turned away.
static void cameras_see_the_nearest_light(void **state)
{
    (void)state;
    for (int k = 0; k < 6; k++) {
        CohortLightDesc light = disk();
        CohortRenderSettings settings = small;
        settings.hide_lights = k == 1;
        if (k == 2)
            light.color[0] = light.color[1] = light.color[2] = 0.0f;
        if (k == 3)
            light.transform[2][2] = light.transform[0][0] = 1.0; // shines away
        if (k == 4)
            light.hidden = true;
        Lit lit = lit_by(k == 5 ? NULL : &light, &settings);
        CoVec3 eye = lit.scene->camera.origin, ahead = co_vec3(0.0f, 0.0f, -1.0f);
        float t = co_camera_light_distance(lit.render, eye, ahead, 0.0f);
        assert_true(k == 0 ? fabsf(t - 5.0f) < 1e-5f : isinf(t) && t > 0.0f);
        assert_true(isinf(co_camera_light_distance(lit.render, eye, ahead, 6.0f))); // from behind
        CoVec3 aside = co_normalize(co_vec3(1.0f, 0.0f, -1.0f));
        assert_true(isinf(co_camera_light_distance(lit.render, eye, aside, 0.0f)));
        clear(&lit);
    }
}

// Light behind all surfaces covers its pixels, unless it is hidden from the camera.
static void seen_lights_cover(void **state)
{
    (void)state;
    for (int k = 0; k < 3; k++) {
        CohortError err = {0};
        CohortLightDesc light = cohort_light_default(COHORT_LIGHT_DOME);
        CohortRenderSettings settings = small;
        settings.spp = 1;
        settings.hide_lights = k == 1;
        settings.hide_domes = k == 2;
        Lit lit = lit_by(&light, &settings);
        while (!cohort_render_is_done(lit.render))
            TEST_OK(cohort_render_round(lit.render, &err), &err);
        float pixels[4 * 16];
        assert_true(cohort_render_aov(lit.render, COHORT_AOV_COLOR, pixels));
        for (int i = 0; i < 64; i++)
            assert_true(fabsf(pixels[i] - (k == 0 ? 1.0f : 0.0f)) < 1e-6f);
        clear(&lit);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(alone_it_counts_whole),
        cmocka_unit_test(shares_are_balanced),
        cmocka_unit_test(cameras_see_the_nearest_light),
        cmocka_unit_test(seen_lights_cover),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
