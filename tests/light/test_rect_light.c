// Rects: even over the solid angle where they look large, over the area where they do not.

#include "light_fixture.h"

// A side of a cube, seen from its middle, is a sixth of all directions.
static void a_side_of_a_cube_is_a_sixth(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_RECT);
    d.width = d.height = 2.0f;
    test_place(&d, 0.0, 0.0, 1.0);
    CoLight light = light_of(&d);
    const CoVec3 o = co_vec3(0, 0, 0);
    test_near((double)co_rect_light_pdf(&light, o, co_vec3(0, 0, 1)), 6.0 / (4.0 * test_pi), 1e-6);
    // A quarter of it, from the middle of another cube's edge ... and the half from its plane.
    double whole = 0.0;
    for (int q = 0; q < 4; q++) {
        CohortLightDesc part = test_light(COHORT_LIGHT_RECT);
        test_place(&part, q & 1 ? 0.5 : -0.5, q & 2 ? 0.5 : -0.5, 1.0);
        CoLight quarter = light_of(&part);
        whole += 1.0 / (double)co_rect_light_pdf(&quarter, o, co_vec3(0, 0, 1));
    }
    test_near(whole, 4.0 * test_pi / 6.0, 1e-6);
}

static void samples_stay_inside_with_their_density(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_RECT);
    d.width = 3.0f;
    test_place(&d, 0.4, 0.2, 2.0);
    CoLight light = light_of(&d);
    const CoVec3 org = co_vec3(-0.7f, 0.1f, 0);
    double sum = 0.0;
    for (int i = 0; i < 64 * 64; i++) {
        CoVec3 wi;
        float t, a, b, density = 0.0f;
        float u0 = ((float)(i % 64) + 0.5f) / 64, u1 = ((float)(i / 64) + 0.5f) / 64;
        assert_true(co_rect_light_sample(&light, org, u0, u1, &wi, &density));
        assert_true(co_light_plane_meet(&light, org, wi, &t, &a, &b));
        assert_true(fabsf(a) <= 1.00001f && fabsf(b) <= 1.00001f);
        assert_true(density == co_rect_light_pdf(&light, org, wi));
        // The area, from solid angle: dA = t^2 / cos dw.
        sum += (double)(t * t / wi.z / density) / (64 * 64);
    }
    test_near(sum, 3.0, 1e-3);
}

static void small_and_sheared_ones_go_by_area(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_RECT);
    test_place(&d, 0.0, 0.0, 20.0);
    CoLight light = light_of(&d);
    float density = 0.0f;
    CoVec3 wi;
    assert_true(co_rect_light_sample(&light, co_vec3(0, 0, 0), 0.5f, 0.5f, &wi, &density));
    assert_true(density == 0.0f); // it depends on wi
    test_near((double)co_rect_light_pdf(&light, co_vec3(0, 0, 0), wi), 400.0, 1e-6);
    test_place(&d, 0.0, 0.0, 1.0);
    d.transform[1][0] = 0.5;
    light = light_of(&d);
    assert_false(light.is_right_angled);
    test_near((double)co_rect_light_pdf(&light, co_vec3(0, 0, 0), co_vec3(0, 0, 1)), 1.0, 1e-6);
    assert_false(co_rect_light_sample(&light, co_vec3(0, 0, 2), 0.5f, 0.5f, &wi, &density));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_side_of_a_cube_is_a_sixth),
        cmocka_unit_test(samples_stay_inside_with_their_density),
        cmocka_unit_test(small_and_sheared_ones_go_by_area),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
