// Values between two others: halves rounded to nearest and even, rotations the shorter way.

#include "lex/number.h"
#include "stage/stage_data.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static CoValue value_of(CohortType type, const void *data, uint32_t count)
{
    return (CoValue){.type = type, .is_array = count > 1, .count = count, .data = data};
}

static uint16_t half_between(uint16_t a, uint16_t b, double u)
{
    uint16_t out = 0;
    CoValue x = value_of(COHORT_TYPE_HALF, &a, 1), y = value_of(COHORT_TYPE_HALF, &b, 1);
    co_value_interpolate(&x, &y, u, &out);
    return out;
}

// All finite ones, of both signs: the ends give the ends, the middle of two neighbors the even one,
// and what is a little off the middle the nearer.
static void halves_round_to_nearest_and_even(void **state)
{
    (void)state;
    for (uint32_t sign = 0; sign < 0x10000; sign += 0x8000) {
        for (uint32_t bits = 0; bits < 0x7bff; bits++) {
            uint16_t a = (uint16_t)(sign | bits), b = (uint16_t)(a + 1);
            assert_int_equal(half_between(a, b, 0.0), a);
            assert_int_equal(half_between(a, b, 1.0), b);
            assert_int_equal(half_between(a, b, 0.5), bits & 1 ? b : a);
            assert_int_equal(half_between(a, b, 0.499), a);
            assert_int_equal(half_between(a, b, 0.501), b);
        }
    }
}

static void halves_overflow_to_infinity(void **state)
{
    (void)state;
    const uint16_t most = 0x7bff, infinity = 0x7c00, nan = 0x7e00; // 65504
    assert_int_equal(half_between(0, most, 1.0002), most);         // below 65520
    assert_int_equal(half_between(0, most, 1.0003), infinity);
    assert_int_equal(half_between(0, most, -1.0003), 0x8000 | infinity);
    assert_int_equal(half_between(infinity, infinity, 0.5), infinity);
    assert_int_equal(half_between(nan, 0, 0.5) & 0x7e00, nan);
    assert_int_equal(half_between(0x8000, 0x8000, 0.5), 0x8000); // -0 stays
}

static double norm(const double q[4])
{
    return sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
}

static void turn_about_z(double angle, double q[4])
{
    q[0] = q[1] = 0.0;
    q[2] = sin(0.5 * angle);
    q[3] = cos(0.5 * angle);
}

static void rotations_take_the_shorter_way(void **state)
{
    (void)state;
    for (int i = 0; i <= 64; i++) {
        double to = 6.0 * (i - 32) / 32.0, a[4], b[4], want[4], got[4];
        turn_about_z(0.0, a);
        turn_about_z(to, b);
        CoValue x = value_of(COHORT_TYPE_QUATD, a, 1), y = value_of(COHORT_TYPE_QUATD, b, 1);
        for (double u = 0.0; u <= 1.0; u += 0.125) {
            double way = to > 3.14159265358979    ? to - 6.28318530717959
                         : to < -3.14159265358979 ? to + 6.28318530717959
                                                  : to;
            turn_about_z(way * u, want);
            co_value_interpolate(&x, &y, u, got);
            double dot = 0.0;
            for (int k = 0; k < 4; k++)
                dot += want[k] * got[k];
            assert_true(fabs(fabs(dot) - 1.0) < 1e-9);
            assert_true(fabs(norm(got) - 1.0) < 1e-9);
        }
    }
}

// Next to each other, one and the same, and opposite: always numbers.
static void rotations_stay_finite(void **state)
{
    (void)state;
    const double angles[] = {0.0, 1e-12, 1e-6, 1e-3, 3.14159265, 3.14159265358979, 6.2831853};
    for (size_t i = 0; i < sizeof angles / sizeof *angles; i++) {
        double a[4], b[4], got[4];
        turn_about_z(0.3, a);
        turn_about_z(0.3 + angles[i], b);
        CoValue x = value_of(COHORT_TYPE_QUATD, a, 1), y = value_of(COHORT_TYPE_QUATD, b, 1);
        for (double u = 0.0; u <= 1.0; u += 0.25) {
            co_value_interpolate(&x, &y, u, got);
            assert_true(fabs(norm(got) - 1.0) < 1e-5);
        }
        co_value_interpolate(&x, &y, 0.0, got);
        for (int k = 0; k < 4; k++)
            assert_true(fabs(got[k] - a[k]) < 1e-12);
    }
}

static void only_what_is_alike_is_interpolated(void **state)
{
    (void)state;
    const float floats[6] = {0};
    const int32_t ints[2] = {0};
    CoValue one = value_of(COHORT_TYPE_FLOAT, floats, 1),
            two = value_of(COHORT_TYPE_FLOAT, floats, 2);
    CoValue whole = value_of(COHORT_TYPE_INT, ints, 1);
    CoValue list = value_of(COHORT_TYPE_FLOAT, floats, 1);
    list.is_array = true;
    assert_true(co_value_can_interpolate(&one, &one));
    assert_true(co_value_can_interpolate(&two, &two));
    assert_false(co_value_can_interpolate(&one, &two));
    assert_false(co_value_can_interpolate(&one, &whole));
    assert_false(co_value_can_interpolate(&whole, &whole));
    assert_false(co_value_can_interpolate(&one, &list));
}

static void arrays_are_interpolated_one_by_one(void **state)
{
    (void)state;
    const float a[6] = {0, 1, 2, 3, 4, 5}, b[6] = {8, 1, -2, 3e38f, 4, -5};
    float got[7];
    got[6] = 77.0f;
    CoValue x = value_of(COHORT_TYPE_FLOAT3, a, 2), y = value_of(COHORT_TYPE_FLOAT3, b, 2);
    co_value_interpolate(&x, &y, 0.25, got);
    for (int i = 0; i < 6; i++)
        assert_true(got[i] == (float)(0.75 * (double)a[i] + 0.25 * (double)b[i]));
    assert_true(got[6] == 77.0f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(halves_round_to_nearest_and_even),
        cmocka_unit_test(halves_overflow_to_infinity),
        cmocka_unit_test(rotations_take_the_shorter_way),
        cmocka_unit_test(rotations_stay_finite),
        cmocka_unit_test(only_what_is_alike_is_interpolated),
        cmocka_unit_test(arrays_are_interpolated_one_by_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
