// From descriptions to prepared lights: areas, sides, frames, and what is left dark.

#include "light_fixture.h"

static void areas_are_those_of_what_the_transform_makes(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_RECT);
    d.width = 3.0f;
    test_stretch(&d, 2.0, 5.0, 1.0);
    test_turn(&d, 1, 33.0);
    test_near((double)light_of(&d).area, 30.0, 1e-6);
    CohortLightDesc disk = test_light(COHORT_LIGHT_DISK);
    test_stretch(&disk, 4.0, 1.0, 7.0);
    test_near((double)light_of(&disk).area, test_pi, 1e-6);
    CohortLightDesc ball = test_light(COHORT_LIGHT_SPHERE);
    test_near((double)light_of(&ball).area, test_pi, 1e-6);
    // A spheroid twice as long as wide: 2 pi (1 + 2 / e asin e), e^2 = 3 / 4, radius 1.
    ball.radius = 1.0f;
    test_stretch(&ball, 1.0, 1.0, 2.0);
    double e = sqrt(0.75);
    test_near((double)light_of(&ball).area, 2.0 * test_pi * (1.0 + 2.0 / e * asin(e)), 1e-4);
}

static void normalized_intensity_is_power_over_size(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_RECT);
    d.normalize = true;
    d.width = 4.0f;
    d.exposure = 3.0f;
    test_near((double)light_of(&d).radiance.x, 8.0 / 4.0, 1e-6);
    CohortLightDesc sun = test_light(COHORT_LIGHT_DISTANT);
    sun.normalize = true;
    sun.angle_degrees = 90.0f;
    test_near((double)light_of(&sun).radiance.y, 1.0 / (test_pi * 0.5), 1e-6);
    CohortLightDesc dome = test_light(COHORT_LIGHT_DOME);
    dome.normalize = true; // has no size
    assert_true(light_of(&dome).radiance.z == 1.0f);
}

static void a_mirrored_light_shines_along_minus_z(void **state)
{
    (void)state;
    for (int mirror = 0; mirror < 8; mirror++) {
        CohortLightDesc d = test_light(COHORT_LIGHT_RECT);
        test_stretch(&d, mirror & 1 ? -1.0 : 1.0, mirror & 2 ? -1.0 : 1.0, mirror & 4 ? -1.0 : 1.0);
        CoLight light = light_of(&d);
        assert_true(light.normal.z == (mirror & 4 ? 1.0f : -1.0f));
        assert_true(light.axis.z == light.normal.z);
    }
}

static void the_frame_is_taken_off_in_double(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_SPHERE);
    test_place(&d, 1e9 + 0.25, -1e9, 3.0);
    const double frame[3] = {1e9, -1e9 - 0.5, 1.0};
    CoLight light;
    assert_true(co_light_setup(&light, &d, NULL, frame, identity_rgb, NULL));
    assert_true(light.center.x == 0.25f && light.center.y == 0.5f && light.center.z == 2.0f);
}

static void what_gives_no_light_is_left_inactive(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_SPHERE);
    assert_true(light_of(&d).is_active);
    d.hidden = true;
    assert_false(light_of(&d).is_active);
    d.hidden = false;
    d.intensity = 0.0f;
    assert_false(light_of(&d).is_active);
    d.intensity = 1.0f;
    d.radius = -1.0f;
    assert_false(light_of(&d).is_active);
    assert_non_null(strstr(co_light_problem(&d), "radius"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(areas_are_those_of_what_the_transform_makes),
        cmocka_unit_test(normalized_intensity_is_power_over_size),
        cmocka_unit_test(a_mirrored_light_shines_along_minus_z),
        cmocka_unit_test(the_frame_is_taken_off_in_double),
        cmocka_unit_test(what_gives_no_light_is_left_inactive),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
