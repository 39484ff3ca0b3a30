// How lights are weighed: about the irradiance they give, and never 0 where they give any.

#include "light_fixture.h"

static CohortLightDesc lamp(CohortLightType type)
{
    CohortLightDesc d = test_light(type);
    test_place(&d, 0.0, 0.0, 10.0);
    return d;
}

static const CoVec3 origin = {0, 0, 0}, up = {0, 0, 1}, none = {0, 0, 0};

static void it_is_about_the_irradiance(void **state)
{
    (void)state;
    CohortLightDesc rect = lamp(COHORT_LIGHT_RECT), ball = lamp(COHORT_LIGHT_SPHERE);
    CohortLightDesc sun = test_light(COHORT_LIGHT_DISTANT), dome = test_light(COHORT_LIGHT_DOME);
    CoLight a = light_of(&rect), b = light_of(&ball), c = light_of(&sun), d = light_of(&dome);
    test_near((double)co_light_importance(&a, origin, up), 1.0 / 100.0, 0.1);
    test_near((double)co_light_importance(&b, origin, up), test_pi * 0.25 / 100.0, 0.1);
    double half = 0.265 * test_pi / 180.0;
    test_near((double)co_light_importance(&c, origin, up), test_pi * sin(half) * sin(half), 0.1);
    assert_true(co_light_importance(&d, origin, up) == 3.14159274f);
}

static void behind_and_inside_there_is_none(void **state)
{
    (void)state;
    CohortLightDesc rect = lamp(COHORT_LIGHT_RECT), ball = lamp(COHORT_LIGHT_SPHERE);
    CoLight a = light_of(&rect), b = light_of(&ball);
    assert_true(co_light_importance(&a, co_vec3(0, 0, 10.001f), none) == 0.0f);
    assert_true(co_light_importance(&a, co_vec3(0, 0, 9.999f), none) > 0.0f);
    assert_true(co_light_importance(&b, co_vec3(0, 0, 10.4f), none) == 0.0f);
    rect.hidden = true;
    CoLight hidden = light_of(&rect);
    assert_true(co_light_importance(&hidden, origin, up) == 0.0f);
}

// What is below the horizon by less than the light's size and a normal's rounding may still shine.
static void the_horizon_has_slack(void **state)
{
    (void)state;
    CohortLightDesc ball = test_light(COHORT_LIGHT_SPHERE);
    CoLight light = light_of(&ball);
    for (float z = -0.51f; z < 0.5f; z += 0.05f)
        assert_true(co_light_importance(&light, co_vec3(5, 0, z), up) > 0.0f);
    float low = co_light_importance(&light, co_vec3(5, 0, 4), up);
    assert_true(low > 0.0f && low < 0.1f * co_light_importance(&light, co_vec3(5, 0, -4), up));
}

static void a_cone_leaves_little_outside(void **state)
{
    (void)state;
    CohortLightDesc d = lamp(COHORT_LIGHT_DISK);
    CoLight open = light_of(&d);
    d.shaping_cone_angle_degrees = 10.0f;
    CoLight narrow = light_of(&d);
    assert_true(co_light_importance(&narrow, origin, up) == co_light_importance(&open, origin, up));
    const CoVec3 aside = co_vec3(6, 0, 0);
    test_near((double)co_light_importance(&narrow, aside, up),
              1e-3 * (double)co_light_importance(&open, aside, up), 1e-5);
}

static void brightness_has_a_large_range(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_SPHERE);
    d.intensity = 1e29f;
    CoLight light = light_of(&d);
    float most = co_light_importance(&light, co_vec3(0.50001f, 0, 0), none);
    assert_true(most > 1e29f && most <= 1e36f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_is_about_the_irradiance),
        cmocka_unit_test(behind_and_inside_there_is_none),
        cmocka_unit_test(the_horizon_has_slack),
        cmocka_unit_test(a_cone_leaves_little_outside),
        cmocka_unit_test(brightness_has_a_large_range),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
