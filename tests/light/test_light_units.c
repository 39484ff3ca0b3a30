// A light meter: irradiance of each light against the analytic value, UsdLux units, color
// temperature, shaping, images, and lights that cannot shine.

#include "light_fixture.h"
#include "support/faults.h"

static double meter(CohortLightDesc d, CoVec3 org)
{
    CoLights *lights = test_lights(&d, NULL, 1);
    double e = (double)test_irradiance(lights, org, co_vec3(0, 0, 1), 128).x;
    co_lights_destroy(lights);
    return e;
}

static void irradiance_of_area_lights_is_the_closed_form(void **state)
{
    (void)state;
    CohortLightDesc rect = test_light(COHORT_LIGHT_RECT);
    rect.width = 3.0f;
    test_place(&rect, 0, 0, 2);
    double x = 1.5 / 2.0, y = 0.5 / 2.0, rx = sqrt(1.0 + x * x), ry = sqrt(1.0 + y * y);
    double e = 2.0 * (x / rx * atan(y / rx) + y / ry * atan(x / ry));
    test_near(meter(rect, co_vec3(0, 0, 0)), e, 1e-4);

    CohortLightDesc disk = test_light(COHORT_LIGHT_DISK);
    test_place(&disk, 0, 0, 2);
    test_near(meter(disk, co_vec3(0, 0, 0)), test_pi * 0.25 / 4.25, 1e-4);

    CohortLightDesc sphere = test_light(COHORT_LIGHT_SPHERE);
    test_place(&sphere, 0, 0, 2);
    test_near(meter(sphere, co_vec3(0, 0, 0)), test_pi * 0.25 / 4.0, 1e-4);
    test_near(meter(sphere, co_vec3(0, 0, 1.9f)), 0.0, 1e-3);
}

static void irradiance_of_distant_lights_follows_the_schema(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_DISTANT);
    CoVec3 org = co_vec3(3, 2, 1);
    d.intensity = 50000.0f;
    test_near(meter(d, org), 3.3602, 3e-5);
    d.normalize = true;
    test_near(meter(d, org), 50000.0, 1e-4);
    d.angle_degrees = 0.0f;
    test_near(meter(d, org), 50000.0, 1e-6);
    d.normalize = false;
    test_near(meter(d, org), 50000.0, 1e-6);
    d.intensity = 1.0f;
    d.angle_degrees = 60.0f;
    test_near(meter(d, org), test_pi * 0.25, 1e-4);
    d.angle_degrees = 300.0f; // the horizon cuts what is beyond 90 degrees
    test_near(meter(d, org), test_pi, 2e-3);
    d.normalize = true;
    test_near(meter(d, org), 1.0 / (2.0 - 0.25), 2e-3);
    d.angle_degrees = 1000.0f;
    test_near(meter(d, org), 0.5, 2e-3);
}

static void irradiance_of_a_dome_is_pi_times_its_radiance(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_DOME);
    d.normalize = true; // domes ignore it
    test_near(meter(d, co_vec3(0, 0, 0)), test_pi, 5e-3);
}

static void normalized_lights_keep_their_power_at_any_size(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_SPHERE);
    d.normalize = true;
    test_place(&d, 0, 0, 10);
    double e = meter(d, co_vec3(0, 0, 0));
    test_near(e, 0.25 / 100.0, 1e-4);
    test_stretch(&d, 4.0, 4.0, 4.0);
    test_near(meter(d, co_vec3(0, 0, 0)), e, 1e-3);

    d = test_light(COHORT_LIGHT_RECT);
    d.normalize = true;
    d.width = 2.0f;
    test_stretch(&d, 0.01, 0.03, 1.0);
    test_place(&d, 0, 0, 10);
    test_near(meter(d, co_vec3(0, 0, 0)), 1.0 / 100.0, 1e-4);
}

static void an_ellipsoid_is_normalized_by_its_area(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_SPHERE);
    d.normalize = true;
    d.radius = 1.0f;
    test_stretch(&d, 2.0, 2.0, 0.5);
    CoLights *lights = test_lights(&d, NULL, 1);
    // Oblate spheroid, a = 2, c = 1/2: 2 pi a^2 + pi c^2 / e log((1 + e) / (1 - e)).
    double ecc = sqrt(1.0 - 0.0625);
    double area = 8.0 * test_pi + 0.25 * test_pi / ecc * log((1.0 + ecc) / (1.0 - ecc));
    test_near((double)co_lights_max_radiance(lights), 1.0 / area, 1e-4);
    co_lights_destroy(lights);
}

static void exposure_color_and_multiplier_scale(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_DISK);
    d.intensity = 3.0f;
    d.exposure = -2.0f;
    d.color[1] = 0.5f;
    d.diffuse = 0.25f;
    CoLights *lights = test_lights(&d, NULL, 1);
    CoVec3 org = co_vec3(0, 0, -1), dir = co_vec3(0, 0, 1), radiance;
    TestHits hits = test_collect(lights, org, dir);
    assert_true(hits.last.radiance.x == 0.75f && hits.last.radiance.y == 0.375f);
    assert_true(hits.last.diffuse == 0.25f);
    co_light_ray_end(lights, org, dir, 0, &radiance);
    assert_true(radiance.x == 0.75f * 0.25f);
    assert_true(co_lights_max_radiance(lights) == 0.75f);
    co_lights_destroy(lights);
}

static void temperature_passes_through_the_rendering_matrix(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_DISK);
    const float swap[9] = {0, 0, 1, 0, 1, 0, 1, 0, 0};
    d.enable_color_temperature = true;
    d.color_temperature = 3200.0f;
    CoLights *lights = co_lights_create(&d, NULL, 1, zero_frame, swap, 1.0f, NULL);
    TestHits hits = test_collect(lights, co_vec3(0, 0, -1), co_vec3(0, 0, 1));
    assert_true(fabsf(hits.last.radiance.z - 1.6799f) < 3e-3f);
    assert_true(fabsf(hits.last.radiance.x - 0.3256f) < 3e-3f);
    co_lights_destroy(lights);
}

static float seen_at(const CohortLightDesc *d, double degrees_off)
{
    CoLights *lights = test_lights(d, NULL, 1);
    double a = degrees_off * test_pi / 180.0;
    CoVec3 out = co_vec3((float)sin(a), 0.0f, (float)-cos(a));
    TestHits hits = test_collect(lights, co_scale(out, 5.0f), co_neg(out));
    co_lights_destroy(lights);
    return hits.count > 0 ? hits.last.radiance.x : 0.0f;
}

static void shaping_follows_the_schema(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_SPHERE);
    assert_true(seen_at(&d, 0) == 1.0f && seen_at(&d, 170) == 1.0f);
    d.shaping_cone_angle_degrees = 40.0f;
    assert_true(seen_at(&d, 39) == 1.0f && seen_at(&d, 41) == 0.0f);
    d.shaping_cone_softness = 0.5f;
    assert_true(seen_at(&d, 19) == 1.0f && seen_at(&d, 41) == 0.0f);
    test_near((double)seen_at(&d, 30), 0.5, 1e-4);
    d.shaping_cone_angle_degrees = 90.0f;
    d.shaping_cone_softness = 0.0f;
    d.shaping_focus = 4.0f;
    d.shaping_focus_tint[0] = 0.2f;
    double f = pow(cos(30.0 * test_pi / 180.0), 4.0);
    test_near((double)seen_at(&d, 30), 0.2 + 0.8 * f, 1e-5);
    test_near((double)seen_at(&d, 150), 0.2 + 0.8 * f, 1e-5); // backwards the same
    d.shaping_focus = -1.0f;
    assert_true(seen_at(&d, 30) == 1.0f);
}

static void a_rect_shows_its_image_upright(void **state)
{
    (void)state;
    float pixels[4 * 4] = {1, 0, 0, 1, 2, 0, 0, 1, 3, 0, 0, 1, 4, 0, 0, 1};
    CoLightImage image = {pixels, 2, 2};
    CohortLightDesc d = test_light(COHORT_LIGHT_RECT);
    CoLights *lights = test_lights(&d, &image, 1);
    CoVec3 dir = co_vec3(0, 0, 1);
    assert_true(test_collect(lights, co_vec3(0.45f, 0.45f, -1), dir).last.radiance.x == 1.0f);
    assert_true(test_collect(lights, co_vec3(-0.45f, 0.45f, -1), dir).last.radiance.x == 2.0f);
    assert_true(test_collect(lights, co_vec3(0.45f, -0.45f, -1), dir).last.radiance.x == 3.0f);
    assert_true(test_collect(lights, co_vec3(0, 0, -1), dir).last.radiance.x == 2.5f);
    assert_true(co_lights_max_radiance(lights) == 4.0f);
    co_lights_destroy(lights);
}

static float dome_at(const CoLights *lights, float x, float y, float z)
{
    return test_collect(lights, co_vec3(7, 8, 9), co_normalize(co_vec3(x, y, z))).last.radiance.x;
}

static void a_dome_maps_its_image_as_usd_does(void **state)
{
    (void)state;
    enum {
        W = 64,
        H = 32
    };
    static float pixels[W * H * 4];
    for (int i = 0; i < W * H; i++) {
        pixels[i * 4] = (float)(i % W) + 1.0f;
        pixels[i * 4 + 1] = (float)(i / W) + 1.0f;
    }
    CoLightImage image = {pixels, W, H};
    CohortLightDesc d = test_light(COHORT_LIGHT_DOME);
    test_place(&d, 5, 5, 5); // translation does not count
    CoLights *lights = test_lights(&d, &image, 1);
    assert_true(fabsf(dome_at(lights, 0, 0, 1) - 32.5f) < 1e-3f); // longitude 0: the middle
    assert_true(fabsf(dome_at(lights, 1, 0, 0) - 16.5f) < 1e-3f); // +pi/2: left of it
    assert_true(fabsf(dome_at(lights, -1, 0, 0) - 48.5f) < 1e-3f);
    assert_true(fabsf(dome_at(lights, 0, 0, -1) - 32.5f) < 1e-3f); // the seam: columns wrap
    CoVec3 up = test_collect(lights, co_vec3(0, 0, 0), co_vec3(0, 1, 0)).last.radiance;
    CoVec3 down = test_collect(lights, co_vec3(0, 0, 0), co_vec3(0, -1, 0)).last.radiance;
    assert_true(up.y == 1.0f && down.y == (float)H);
    co_lights_destroy(lights);
    test_turn(&d, 1, 90.0); // +Z goes to +X
    test_stretch(&d, 2.0, 3.0, 4.0);
    lights = test_lights(&d, &image, 1);
    assert_true(fabsf(dome_at(lights, 1, 0, 0) - 32.5f) < 1e-3f);
    co_lights_destroy(lights);
}

static void a_dome_survives_any_texel(void **state)
{
    (void)state;
    float pixels[4 * 4 * 2] = {0};
    pixels[0] = NAN;
    pixels[4] = INFINITY;
    pixels[8] = -5.0f;
    pixels[12] = 2.0f;
    CoLightImage image = {pixels, 4, 2};
    CohortLightDesc d = test_light(COHORT_LIGHT_DOME);
    CoLights *lights = test_lights(&d, &image, 1);
    assert_true(co_lights_max_radiance(lights) == 2.0f);
    double sum = (double)test_irradiance(lights, co_vec3(0, 0, 0), co_vec3(0, 1, 0), 64).x;
    assert_true(isfinite(sum) && sum > 0.0);
    co_lights_destroy(lights);
    memset(pixels, 0, sizeof pixels);
    lights = test_lights(&d, &image, 1);
    assert_int_equal(co_lights_count(lights), 0); // all black
    co_lights_destroy(lights);
    CoLightImage single = {pixels, 1, 1};
    pixels[0] = 1.0f;
    lights = test_lights(&d, &single, 1);
    test_near((double)test_irradiance(lights, co_vec3(0, 0, 0), co_vec3(0, 1, 0), 128).x, test_pi,
              2e-3);
    co_lights_destroy(lights);
}

static void a_large_dome_keeps_its_total(void **state)
{
    (void)state;
    enum {
        W = 4200,
        H = 1100
    };
    float *pixels = test_calloc((size_t)W * H * 4, sizeof *pixels);
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++)
            pixels[(y * W + x) * 4] = 0.5f + 0.5f * (float)((x / 100 + y / 100) % 2);
    CoLightImage image = {pixels, W, H};
    CohortLightDesc d = test_light(COHORT_LIGHT_DOME);
    CoLights *lights = test_lights(&d, &image, 1);
    CoVec3 n = co_vec3(0.3f, 0.9f, 0.1f);
    double by_samples = (double)test_irradiance(lights, co_vec3(0, 0, 0), co_normalize(n), 256).x;
    test_near(by_samples, 0.75 * test_pi, 0.03);
    co_lights_destroy(lights);
    test_free(pixels);
}

static void what_cannot_shine_is_dark_and_named(void **state)
{
    (void)state;
    CohortLightDesc d[9];
    for (int i = 0; i < 9; i++)
        d[i] = test_light(COHORT_LIGHT_RECT);
    d[0].width = 0.0f;
    d[1].height = NAN;
    d[2].transform[3][1] = (double)INFINITY;
    d[3].intensity = INFINITY;
    test_stretch(&d[4], 0.0, 1.0, 1.0);
    d[5].type = COHORT_LIGHT_SPHERE;
    test_stretch(&d[5], 1.0, 1.0, 0.0);
    d[6].type = COHORT_LIGHT_DOME;
    test_stretch(&d[6], 1.0, 0.0, 1.0);
    d[7].type = COHORT_LIGHT_DISTANT;
    test_stretch(&d[7], 1.0, 1.0, 0.0);
    d[8].type = COHORT_LIGHT_DISK;
    d[8].radius = -1.0f;
    for (int i = 0; i < 9; i++)
        assert_non_null(co_light_problem(&d[i]));
    CoLights *lights = test_lights(d, NULL, 9);
    assert_int_equal(co_lights_count(lights), 0);
    CoLightSample s;
    CoVec3 radiance;
    assert_false(
        co_light_sample(lights, co_vec3(0, 0, -1), co_vec3(0, 0, 1), 0.5f, 0.5f, 0.5f, &s));
    for (uint32_t i = 0; i < 11; i++) {
        assert_true(
            co_light_pdf(lights, co_vec3(0, 0, -1), co_vec3(0, 0, 1), i, co_vec3(0, 0, 1)) == 0);
        co_light_ray_end(lights, co_vec3(0, 0, -1), co_vec3(0, 0, 1), i, &radiance);
        assert_true(co_max3(radiance) == 0.0f);
    }
    assert_int_equal(test_collect(lights, co_vec3(0, 0, -1), co_vec3(0, 0, 1)).count, 0);
    co_lights_destroy(lights);

    CohortLightDesc dim = test_light(COHORT_LIGHT_RECT);
    assert_null(co_light_problem(&dim));
    dim.intensity = -1.0f;
    assert_non_null(co_light_problem(&dim));
    dim.intensity = 1.0f;
    dim.specular = 0.5f;
    assert_non_null(co_light_problem(&dim));
    dim.diffuse = NAN;
    assert_non_null(co_light_problem(&dim));
    CohortLightDesc odd = test_light(COHORT_LIGHT_RECT), white = odd;
    odd.enable_color_temperature = white.enable_color_temperature = true;
    odd.color_temperature = odd.shaping_cone_softness = odd.shaping_focus = NAN;
    odd.shaping_cone_angle_degrees = NAN;
    assert_non_null(strstr(co_light_problem(&odd), "no number"));
    const CohortLightDesc both[] = {odd, white};
    CoVec3 shown[2];
    lights = test_lights(both, NULL, 2);
    for (uint32_t i = 0; i < 2; i++)
        shown[i] = co_light_ray_radiance(lights, co_vec3(0.1f, 0, -1), co_vec3(0, 0, 1), i);
    assert_true(shown[0].x > 0.0f);
    assert_memory_equal(&shown[0], &shown[1], sizeof shown[0]);
    co_lights_destroy(lights);
    CohortLightDesc sun = test_light(COHORT_LIGHT_DISTANT);
    sun.shaping_cone_angle_degrees = 30.0f;
    assert_non_null(co_light_problem(&sun));
    dim.hidden = true;
    lights = test_lights(&dim, NULL, 1);
    assert_int_equal(co_lights_count(lights), 0);
    co_lights_destroy(lights);
    co_lights_destroy(NULL);
}

static void no_memory_is_an_error(void **state)
{
    (void)state;
    float pixels[4 * 2] = {1, 1, 1, 1, 2, 2, 2, 2};
    CoLightImage image = {pixels, 2, 1};
    CohortLightDesc d = test_light(COHORT_LIGHT_DOME);
    TestFaults faults = {0};
    while (test_faults_next(&faults)) {
        CohortError err = {0};
        test_faults_begin(&faults);
        CoLights *lights = co_lights_create(&d, &image, 1, zero_frame, identity_rgb, 1.0f, &err);
        test_faults_end(&faults, lights != NULL, &err);
        co_lights_destroy(lights);
    }
    assert_int_equal(faults.count, 5);
}

static void no_lights_are_lights_too(void **state)
{
    (void)state;
    CoLights *lights = test_lights(NULL, NULL, 0);
    CoLightSample s;
    assert_false(co_light_sample(lights, co_vec3(0, 0, 0), co_vec3(0, 0, 1), 0, 0, 0, &s));
    assert_int_equal(co_lights_count(lights), 0);
    assert_true(co_lights_max_radiance(lights) == 0.0f);
    co_lights_destroy(lights);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(irradiance_of_area_lights_is_the_closed_form),
        cmocka_unit_test(irradiance_of_distant_lights_follows_the_schema),
        cmocka_unit_test(irradiance_of_a_dome_is_pi_times_its_radiance),
        cmocka_unit_test(normalized_lights_keep_their_power_at_any_size),
        cmocka_unit_test(an_ellipsoid_is_normalized_by_its_area),
        cmocka_unit_test(exposure_color_and_multiplier_scale),
        cmocka_unit_test(temperature_passes_through_the_rendering_matrix),
        cmocka_unit_test(shaping_follows_the_schema),
        cmocka_unit_test(a_rect_shows_its_image_upright),
        cmocka_unit_test(a_dome_maps_its_image_as_usd_does),
        cmocka_unit_test(a_dome_survives_any_texel),
        cmocka_unit_test(a_large_dome_keeps_its_total),
        cmocka_unit_test(what_cannot_shine_is_dark_and_named),
        cmocka_unit_test(no_memory_is_an_error),
        cmocka_unit_test(no_lights_are_lights_too),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
