// Colors of black bodies: luminance 1, red when cool, blue when hot, tame beyond the table.

#include "light_fixture.h"

static void blackbodies_are_those_of_usd(void **state)
{
    (void)state;
    // UsdLuxBlackbodyTemperatureAsRgb of usd-core 26.11.
    static const float measured[][4] = {
        {500, 4.3055f, 0.11836f, 0.0f},      {1500, 3.12852f, 0.46823f, 0.0f},
        {2000, 2.52057f, 0.64689f, 0.0204f}, {3200, 1.6799f, 0.8660f, 0.3256f},
        {6500, 1.0433f, 0.9836f, 1.0346f},   {10000, 0.8718f, 0.9947f, 1.4300f},
        {40000, 0.8718f, 0.9947f, 1.4300f},
    };
    for (int i = 0; i < 7; i++) {
        CoVec3 rgb = co_blackbody_rgb(measured[i][0]);
        assert_true(fabsf(rgb.x - measured[i][1]) < 4e-3f);
        assert_true(fabsf(rgb.y - measured[i][2]) < 4e-3f);
        assert_true(fabsf(rgb.z - measured[i][3]) < 4e-3f);
    }
}

static void luminance_is_one_and_nothing_negative(void **state)
{
    (void)state;
    for (float kelvin = 900.0f; kelvin < 11000.0f; kelvin += 37.0f) {
        CoVec3 c = co_blackbody_rgb(kelvin);
        assert_true(c.x >= 0.0f && c.y >= 0.0f && c.z >= 0.0f);
        test_near((double)(0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z), 1.0,
                  1e-3); // what is negative counts as none
    }
}

static void the_hotter_the_bluer(void **state)
{
    (void)state;
    float last = -1.0f;
    for (float kelvin = 2000.0f; kelvin <= 10000.0f; kelvin += 50.0f) {
        CoVec3 c = co_blackbody_rgb(kelvin);
        assert_true(c.z / c.x > last);
        last = c.z / c.x;
    }
}

static void beyond_the_table_its_ends_hold(void **state)
{
    (void)state;
    const float pairs[][2] = {
        {-5.0f, 1000.0f}, {0.0f, 1000.0f}, {INFINITY, 10000.0f}, {1e9f, 10000.0f}, {NAN, 6500.0f}};
    for (size_t i = 0; i < sizeof pairs / sizeof *pairs; i++) {
        CoVec3 a = co_blackbody_rgb(pairs[i][0]), b = co_blackbody_rgb(pairs[i][1]);
        assert_true(a.x == b.x && a.y == b.y && a.z == b.z);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blackbodies_are_those_of_usd),
        cmocka_unit_test(luminance_is_one_and_nothing_negative),
        cmocka_unit_test(the_hotter_the_bluer),
        cmocka_unit_test(beyond_the_table_its_ends_hold),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
