// Lights of any size: a normalized light gives the same irradiance however small it is, and no more
// noise.

#include "support/scenes.h"

#include <math.h>

enum {
    SIZE = 32,
    SAMPLES = 16
};

static const float albedo[3] = {0.8f, 0.4f, 0.05f};

typedef struct Statistics {
    double mean[3], deviation[3]; // deviation of a pixel, relative to the mean
} Statistics;

// A Lambertian plane seen from 0.5 above, through a window so narrow that all pixels see one point.
static Statistics lit_plane(const CohortLightDesc *light)
{
    static const float points[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    static const int32_t indices[] = {0, 1, 2, 3};
    CohortError err = {0};
    CohortScene *scene = test_scene(&err);
    CohortMaterialDesc matte = cohort_material_default();
    memcpy(matte.diffuse_color.value, albedo, sizeof albedo);
    matte.lambert = true;
    uint32_t material = cohort_scene_new_material(scene, &err);
    TEST_OK(cohort_scene_set_material(scene, material, &matte, &err), &err);
    uint32_t plane = test_quads(scene, points, 4, indices, 1, NULL, material, &err);
    CohortInstanceDesc place = test_place(plane, 0, 0, 0, 1.0);
    TEST_OK(cohort_scene_set_group(scene, 0, &place, 1, &err), &err);
    uint32_t id = cohort_scene_new_light(scene, &err);
    TEST_OK(cohort_scene_set_light(scene, id, light, &err), &err);
    test_camera(scene, 0, 0, 0.5, 1e-3, &err);
    TEST_OK(cohort_scene_commit(scene, NULL, &err), &err);
    CohortRenderSettings settings = {.width = SIZE,
                                     .height = SIZE,
                                     .spp = SAMPLES,
                                     .max_depth = 2,
                                     .filter = COHORT_FILTER_BOX,
                                     .batch = 1u << 16};
    CohortRenderStats stats;
    float *pixels = test_render(scene, &settings, &stats, &err);
    assert_int_equal(stats.rays_light, SIZE * SIZE * SAMPLES);
    assert_int_equal(stats.weight_underflows, 0);
    assert_int_equal(stats.film_saturations, 0);
    Statistics out;
    for (int c = 0; c < 3; c++) {
        double sum = 0.0, squares = 0.0, n = SIZE * SIZE;
        for (int i = 0; i < SIZE * SIZE; i++)
            sum += (double)pixels[4 * i + c];
        for (int i = 0; i < SIZE * SIZE; i++) {
            double off = (double)pixels[4 * i + c] * n / sum - 1.0;
            squares += off * off;
        }
        out.mean[c] = sum / n;
        out.deviation[c] = sqrt(squares / (n - 1.0));
    }
    free(pixels);
    cohort_scene_destroy(scene);
    return out;
}

// expected: irradiance over pi. The weight's mantissa is at least 256 for the largest channel, so
// that its rounding deviates by half a step of that; smaller channels have the same step.
static void check(const char *name, double size, const Statistics *s, double expected)
{
    for (int c = 0; c < 3; c++) {
        double truth = expected * (double)albedo[c];
        double step = (double)(albedo[0] / albedo[c]) / 256.0;
        if (fabs(s->mean[c] - truth) > 0.002 * truth)
            fail_msg("%s of size %g, channel %d: %.6f instead of %.6f", name, size, c, s->mean[c],
                     truth);
        if (s->deviation[c] > 0.6 * step / sqrt(SAMPLES))
            fail_msg("%s of size %g, channel %d: a relative deviation of %.6f", name, size, c,
                     s->deviation[c]);
    }
}

// Irradiance of a sphere of power 4 pi r^2 * radiance = 1 at distance 1: radiance * pi r^2 = 1/4.
static void spheres_of_any_radius_light_alike(void **state)
{
    (void)state;
    for (int power = -3; power >= -8; power--) {
        CohortLightDesc light = cohort_light_default(COHORT_LIGHT_SPHERE);
        light.normalize = true;
        light.intensity = 1.0f;
        light.radius = (float)pow(10.0, power);
        test_identity(light.transform);
        light.transform[3][2] = 1.0;
        Statistics s = lit_plane(&light);
        check("a sphere", (double)light.radius, &s, 0.25 / 3.14159265358979);
    }
}

// The irradiance of a normalized distant light is its intensity.
static void distant_lights_of_any_angle_light_alike(void **state)
{
    (void)state;
    static const float degrees[] = {0.3f, 0.03f, 0.003f, 0.0002f, 0.0f};
    for (int i = 0; i < 5; i++) {
        CohortLightDesc light = cohort_light_default(COHORT_LIGHT_DISTANT);
        light.normalize = true;
        light.intensity = 1.0f;
        light.angle_degrees = degrees[i];
        test_identity(light.transform);
        Statistics s = lit_plane(&light);
        check("a distant light", (double)degrees[i], &s, 1.0 / 3.14159265358979);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spheres_of_any_radius_light_alike),
        cmocka_unit_test(distant_lights_of_any_angle_light_alike),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
