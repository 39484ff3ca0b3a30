// Distant lights: a cone of directions, or one alone.

#include "light_fixture.h"

static CoLight distant(float degrees)
{
    CohortLightDesc d = test_light(COHORT_LIGHT_DISTANT);
    d.angle_degrees = degrees;
    return light_of(&d);
}

static void the_density_is_one_over_the_cone(void **state)
{
    (void)state;
    const float degrees[] = {0.53f, 10.0f, 90.0f, 180.0f, 360.0f, 720.0f};
    for (int i = 0; i < 6; i++) {
        CoLight light = distant(degrees[i]);
        double half = fmin((double)degrees[i] / 2.0, 180.0) * test_pi / 180.0;
        double sine = sin(0.5 * half);
        test_near((double)co_distant_light_pdf(&light), 1.0 / (4.0 * test_pi * sine * sine), 1e-5);
        CoVec3 mean = co_vec3(0, 0, 0);
        for (int k = 0; k < 32 * 32; k++) {
            CoVec3 wi = co_distant_light_sample(&light, ((float)(k % 32) + 0.5f) / 32,
                                                ((float)(k / 32) + 0.5f) / 32);
            assert_true(co_distant_light_meet(&light, wi));
            mean = co_add(mean, wi);
        }
        // Of a cap the mean height is that of its middle: (1 + cos) / 2.
        assert_true(fabs((double)mean.z / (32 * 32) - 0.5 * (1.0 + cos(half))) < 4e-3);
        assert_true(fabsf(mean.x) < 1.0f && fabsf(mean.y) < 1.0f);
    }
}

static void it_is_met_within_the_cone_alone(void **state)
{
    (void)state;
    CoLight light = distant(20.0f);
    const float near = sinf(0.1744f), far = sinf(0.1747f); // 10 degrees are 0.17453
    assert_true(co_distant_light_meet(&light, co_vec3(near, 0, sqrtf(1 - near * near))));
    assert_false(co_distant_light_meet(&light, co_vec3(far, 0, sqrtf(1 - far * far))));
    assert_false(co_distant_light_meet(&light, co_vec3(0, 0, -1)));
}

static void without_a_width_it_is_parallel(void **state)
{
    (void)state;
    const float widths[] = {0.0f, -3.0f, 1e-5f, NAN};
    for (int i = 0; i < 4; i++) {
        CoLight light = distant(widths[i]);
        assert_true(light.is_delta);
        assert_true(co_distant_light_pdf(&light) == 1.0f);
        CoVec3 wi = co_distant_light_sample(&light, 0.3f, 0.9f);
        assert_true(wi.x == 0.0f && wi.y == 0.0f && wi.z == 1.0f);
        assert_false(co_distant_light_meet(&light, wi));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_density_is_one_over_the_cone),
        cmocka_unit_test(it_is_met_within_the_cone_alone),
        cmocka_unit_test(without_a_width_it_is_parallel),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
