// What a light sends: its image between texel centers, focus, cone.

#include "light_fixture.h"

static void images_are_looked_up_between_texel_centers(void **state)
{
    (void)state;
    const float pixels[2][2][4] = {{{1, 0, 0, 1}, {3, NAN, -2, 1}},
                                   {{5, 0, 0, 1}, {7, 1e31f, 0, 1}}};
    const CoLightImage image = {pixels[0][0], 2, 2};
    assert_true(co_light_image_lookup(&image, 0.5f, 0.5f, false).x == 1.0f);
    assert_true(co_light_image_lookup(&image, 1.0f, 0.5f, false).x == 2.0f);
    assert_true(co_light_image_lookup(&image, 1.0f, 1.0f, false).x == 4.0f);
    // Beyond the last center columns wrap or stay; rows stay.
    assert_true(co_light_image_lookup(&image, 0.0f, 0.5f, false).x == 1.0f);
    assert_true(co_light_image_lookup(&image, 0.0f, 0.5f, true).x == 2.0f);
    assert_true(co_light_image_lookup(&image, 2.0f, 2.0f, true).x == 6.0f);
    assert_true(co_light_image_lookup(&image, 0.5f, -9.0f, true).x == 1.0f);
    // What is no light is none.
    CoVec3 odd = co_light_image_texel(&image, 1, 0), huge = co_light_image_texel(&image, 1, 1);
    assert_true(odd.y == 0.0f && odd.z == 0.0f && huge.y == 0.0f);
}

static void focus_tints_what_leaves_aside(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_DISK);
    d.shaping_focus = 2.0f;
    d.shaping_focus_tint[0] = 1.0f;
    CoLight light = light_of(&d);
    CoVec3 ahead = co_light_emission(&light, co_vec3(0, 0, 1), 0, 0);
    assert_true(ahead.x == 1.0f && ahead.y == 1.0f);
    // cos^2 of 60 degrees is a quarter.
    CoVec3 aside = co_light_emission(&light, co_vec3(sqrtf(0.75f), 0, 0.5f), 0, 0);
    test_near((double)aside.x, 1.0, 1e-6);
    test_near((double)aside.y, 0.25, 1e-5);
}

static CoVec3 at_degrees(double degrees)
{
    double a = degrees * test_pi / 180.0;
    return co_vec3((float)sin(a), 0.0f, (float)cos(a));
}

static void the_cone_ends_it_softly(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_SPHERE);
    d.shaping_cone_angle_degrees = 40.0f;
    CoLight hard = light_of(&d);
    assert_true(co_light_emission(&hard, at_degrees(39.9), 0, 0).x == 1.0f);
    assert_true(co_light_emission(&hard, at_degrees(40.1), 0, 0).x == 0.0f);
    d.shaping_cone_softness = 0.5f; // from 20 degrees on
    CoLight soft = light_of(&d);
    assert_true(co_light_emission(&soft, at_degrees(19.9), 0, 0).x == 1.0f);
    test_near((double)co_light_emission(&soft, at_degrees(30.0), 0, 0).x, 0.5, 1e-4);
    test_near((double)co_light_emission(&soft, at_degrees(35.0), 0, 0).x, 0.15625, 1e-3);
    assert_true(co_light_emission(&soft, at_degrees(40.1), 0, 0).x == 0.0f);
}

static void a_rect_shines_its_image(void **state)
{
    (void)state;
    const float pixels[4][4] = {{1, 1, 1, 1}, {2, 2, 2, 1}, {3, 3, 3, 1}, {4, 4, 4, 1}};
    const CoLightImage image = {pixels[0], 2, 2};
    CohortLightDesc d = test_light(COHORT_LIGHT_RECT);
    d.intensity = 10.0f;
    CoLight light = light_with(&d, &image);
    // The first texel stands at (+X, +Y).
    assert_true(co_light_emission(&light, co_vec3(0, 0, 1), 1, 1).x == 10.0f);
    assert_true(co_light_emission(&light, co_vec3(0, 0, 1), -1, 1).x == 20.0f);
    assert_true(co_light_emission(&light, co_vec3(0, 0, 1), 1, -1).x == 30.0f);
    assert_true(co_light_emission(&light, co_vec3(0, 0, 1), 0, 0).x == 25.0f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(images_are_looked_up_between_texel_centers),
        cmocka_unit_test(focus_tints_what_leaves_aside),
        cmocka_unit_test(the_cone_ends_it_softly),
        cmocka_unit_test(a_rect_shines_its_image),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
