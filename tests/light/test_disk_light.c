// Disks, and what all flat lights share: where a line meets the plane, and area as seen from a
// point.

#include "light_fixture.h"

static void a_line_meets_the_plane_at_the_lights_own_place(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_DISK);
    d.radius = 2.0f;
    test_place(&d, 1.0, 0.0, 5.0);
    CoLight light = light_of(&d);
    float t, a, b;
    assert_true(co_light_plane_meet(&light, co_vec3(1, 1, 0), co_vec3(0, 0, 1), &t, &a, &b));
    assert_true(t == 5.0f && a == 0.0f && b == 0.5f);
    assert_true(co_light_plane_height(&light, co_vec3(9, 9, 0)) == 5.0f);
    assert_true(co_light_plane_height(&light, co_vec3(9, 9, 6)) == -1.0f);
    assert_false(co_light_plane_meet(&light, co_vec3(0, 0, 0), co_vec3(0, 0, -1), &t, &a, &b));
    assert_false(co_light_plane_meet(&light, co_vec3(0, 0, 0), co_vec3(1, 0, 0), &t, &a, &b));
}

static void the_density_is_distance_squared_over_the_area_seen(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_DISK);
    d.radius = 0.5f;
    test_place(&d, 0.0, 0.0, 2.0);
    CoLight light = light_of(&d);
    double area = test_pi * 0.25;
    test_near((double)co_light_plane_pdf(&light, co_vec3(0, 0, 0), co_vec3(0, 0, 1)), 4.0 / area,
              1e-6);
    CoVec3 org = co_vec3(2, 0, 0), wi = co_normalize(co_vec3(-1, 0, 1));
    test_near((double)co_light_plane_pdf(&light, org, wi), 8.0 / (area * sqrt(0.5)), 1e-6);
    // From behind there is nothing.
    assert_true(co_light_plane_pdf(&light, co_vec3(0, 0, 4), co_vec3(0, 0, -1)) == 0.0f);
}

static void samples_fill_the_ellipse_evenly(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_DISK);
    test_stretch(&d, 3.0, 1.0, 1.0);
    test_place(&d, 0.0, 0.0, 1.0);
    CoLight light = light_of(&d);
    int inner = 0, left = 0;
    for (int i = 0; i < 64 * 64; i++) {
        CoVec3 wi;
        float t, a, b, u0 = ((float)(i % 64) + 0.5f) / 64, u1 = ((float)(i / 64) + 0.5f) / 64;
        assert_true(co_disk_light_sample(&light, co_vec3(0.3f, 0, 0), u0, u1, &wi));
        assert_true(co_light_plane_meet(&light, co_vec3(0.3f, 0, 0), wi, &t, &a, &b));
        assert_true(a * a + b * b <= 1.00001f);
        inner += a * a + b * b < 0.25f;
        left += a < 0.0f;
    }
    test_near(inner, 64 * 64 / 4.0, 0.02);
    test_near(left, 64 * 64 / 2.0, 0.02);
    CoVec3 wi;
    assert_false(co_disk_light_sample(&light, co_vec3(0, 0, 2), 0.5f, 0.5f, &wi));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_line_meets_the_plane_at_the_lights_own_place),
        cmocka_unit_test(the_density_is_distance_squared_over_the_area_seen),
        cmocka_unit_test(samples_fill_the_ellipse_evenly),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
