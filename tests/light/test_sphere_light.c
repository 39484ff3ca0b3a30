// Spheres: the visible cone, the near side, darkness inside; ellipsoids likewise.

#include "light_fixture.h"

static void the_density_is_one_over_the_visible_cone(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_SPHERE);
    d.radius = 1.0f;
    test_place(&d, 0.0, 0.0, 2.0);
    CoLight light = light_of(&d);
    const CoVec3 o = co_vec3(0, 0, 0), up = co_vec3(0, 0, 1);
    // sin = 1/2.
    test_near((double)co_sphere_light_pdf(&light, o, up),
              1.0 / (2.0 * test_pi * (1.0 - sqrt(0.75))), 1e-6);
    float t;
    assert_true(co_sphere_light_meet(&light, o, up, &t));
    test_near((double)t, 1.0, 1e-6);
    assert_false(co_sphere_light_meet(&light, o, co_vec3(0, 0, -1), &t));
    assert_false(co_sphere_light_meet(&light, o, co_normalize(co_vec3(0.7f, 0, 1)), &t));
}

static void inside_there_is_nothing(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_SPHERE);
    for (int stretched = 0; stretched < 2; stretched++) {
        if (stretched)
            test_stretch(&d, 1.0, 3.0, 0.5);
        CoLight light = light_of(&d);
        const CoVec3 inside = co_vec3(0.1f, 0, 0), dir = co_vec3(0, 1, 0);
        CoVec3 wi;
        float t;
        assert_true(co_sphere_light_is_around(&light, inside));
        assert_false(co_sphere_light_is_around(&light, co_vec3(0.51f, 0, 0)));
        assert_false(co_sphere_light_sample(&light, inside, 0.5f, 0.5f, &wi));
        assert_true(co_sphere_light_pdf(&light, inside, dir) == 0.0f);
        assert_false(co_sphere_light_meet(&light, inside, dir, &t));
    }
}

// Samples' mean of 1 / density is the solid angle that a fine grid of directions finds.
static void an_ellipsoids_density_is_of_its_shape(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_SPHERE);
    test_stretch(&d, 4.0, 1.0, 2.0);
    test_turn(&d, 1, 30.0);
    test_place(&d, 0.5, 0.3, 3.0);
    CoLight light = light_of(&d);
    const CoVec3 o = co_vec3(0, 0, 0);
    double sampled = 0.0, seen = 0.0;
    enum {
        GRID = 200
    };
    for (int i = 0; i < GRID * GRID; i++) {
        float t, x = ((float)(i % GRID) + 0.5f) / GRID, y = ((float)(i / GRID) + 0.5f) / GRID;
        CoVec3 wi;
        assert_true(co_sphere_light_sample(&light, o, x, y, &wi));
        sampled += 1.0 / (double)co_sphere_light_pdf(&light, o, wi) / (GRID * GRID);
        float z = x, r = sqrtf(1.0f - z * z), s = 6.2831853f * y; // the upper half of directions
        CoVec3 dir = co_vec3(r * cosf(s), r * sinf(s), z);
        seen += co_sphere_light_meet(&light, o, dir, &t) ? 2.0 * test_pi / (GRID * GRID) : 0.0;
    }
    test_near(sampled, seen, 0.01);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_density_is_one_over_the_visible_cone),
        cmocka_unit_test(inside_there_is_nothing),
        cmocka_unit_test(an_ellipsoids_density_is_of_its_shape),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
