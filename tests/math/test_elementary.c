// Own elementary functions against libm in double: error in units of the last place, and edges.
// Also tests bits.h.

#include "math/elementary.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

// Distance of got from want in units of float32's last place at want.
static double ulps(float got, double want)
{
    int exponent;
    frexp(want, &exponent);
    if (exponent < -125)
        exponent = -125;
    return fabs((double)got - want) / ldexp(1.0, exponent - 24);
}

static double worst_over(float lo, float hi, int count, float (*f)(float), double (*exact)(double))
{
    double worst = 0.0;
    for (int i = 0; i <= count; i++) {
        float x = lo + (hi - lo) * ((float)i / (float)count);
        double error = ulps(f(x), exact((double)x));
        if (!(error <= worst))
            worst = error;
    }
    return worst;
}

static float sine(float x)
{
    float s, c;
    co_sincosf(x, &s, &c);
    return s;
}

static float cosine(float x)
{
    float s, c;
    co_sincosf(x, &s, &c);
    return c;
}

static float power_of_two(float x)
{
    return co_powf(2.0f, x);
}

static void each_function_is_within_its_error(void **state)
{
    (void)state;
    const int n = 200000;
    assert_true(worst_over(-7.0f, 7.0f, n, sine, sin) < 0.52);
    assert_true(worst_over(-7.0f, 7.0f, n, cosine, cos) < 0.52);
    assert_true(worst_over(-1e6f, 1e6f, n, sine, sin) < 0.52);
    assert_true(worst_over(-1e6f, 1e6f, n, cosine, cos) < 0.52);
    assert_true(worst_over(-126.0f, 127.9f, n, power_of_two, exp2) < 0.52);
    assert_true(worst_over(-149.0f, -126.0f, n, power_of_two, exp2) < 0.52);
    assert_true(worst_over(-1.0f, 1.0f, n, co_acosf, acos) < 0.52);
    assert_true(worst_over(-1.0f, 1.0f, n, co_asinf, asin) < 0.52);
    assert_true(worst_over(0.999f, 1.0f, n, co_acosf, acos) < 0.52);
}

static void powers_and_angles_are_within_their_error(void **state)
{
    (void)state;
    double worst_pow = 0.0, worst_atan = 0.0;
    for (int i = 1; i < 600; i++)
        for (int j = -150; j < 150; j++) {
            float x = (float)i * 0.013f, y = (float)j * 0.21f;
            double p = pow((double)x, (double)y);
            if (p > 1e-37 && p < 1e38)
                worst_pow = fmax(worst_pow, ulps(co_powf(x, y), p));
            worst_atan = fmax(worst_atan, ulps(co_atan2f(y, x), atan2((double)y, (double)x)));
            worst_atan = fmax(worst_atan, ulps(co_atan2f(y, -x), atan2((double)y, (double)-x)));
            worst_atan = fmax(worst_atan, ulps(co_atan2f(x, y), atan2((double)x, (double)y)));
        }
    assert_true(worst_pow < 0.53);
    assert_true(worst_atan < 0.52);
}

static void powers_at_their_edges(void **state)
{
    (void)state;
    assert_true(co_powf(0.0f, 2.0f) == 0.0f && co_powf(0.0f, -2.0f) == INFINITY);
    assert_true(co_powf(INFINITY, 2.0f) == INFINITY && co_powf(INFINITY, -2.0f) == 0.0f);
    assert_true(co_powf(2.0f, INFINITY) == INFINITY && co_powf(0.5f, INFINITY) == 0.0f);
    assert_true(co_powf(2.0f, -INFINITY) == 0.0f && co_powf(NAN, 0.0f) == 1.0f);
    assert_true(isnan(co_powf(-2.0f, 2.0f)) && isnan(co_powf(NAN, 1.0f)));
    assert_true(isnan(co_powf(-INFINITY, 2.0f)) && isnan(co_powf(2.0f, NAN)));
    assert_true(co_powf(3.0f, 2.0f) == 9.0f);
    assert_true(co_powf(2.0f, 128.0f) == INFINITY && co_powf(2.0f, 3e38f) == INFINITY);
    assert_true(co_powf(2.0f, -151.0f) == 0.0f && co_powf(2.0f, -3e38f) == 0.0f);
    for (int k = -149; k < 128; k++) {
        assert_true(co_powf(2.0f, (float)k) == ldexpf(1.0f, k));
        assert_true(co_powf(ldexpf(1.0f, k), 1.0f) == ldexpf(1.0f, k));
    }
}

static void angles_at_their_edges(void **state)
{
    (void)state;
    assert_true(co_atan2f(0.0f, 0.0f) == 0.0f && co_atan2f(0.0f, 1.0f) == 0.0f);
    assert_true(co_atan2f(0.0f, -1.0f) == (float)CO_PI_D);
    assert_true(co_atan2f(-0.0f, -1.0f) == -(float)CO_PI_D);
    assert_true(co_atan2f(1.0f, 0.0f) == (float)(CO_PI_D / 2));
    assert_true(isnan(co_atan2f(NAN, 1.0f)) && isnan(co_atan2f(1.0f, INFINITY)));
    assert_true(co_acosf(1.5f) == 0.0f && co_acosf(-2.0f) == (float)CO_PI_D);
    assert_true(co_asinf(2.0f) == (float)(CO_PI_D / 2) && isnan(co_asinf(NAN)));
    assert_true(isnan(co_acosf(NAN)));
}

static void waves_of_no_number_are_no_number(void **state)
{
    (void)state;
    assert_true(isnan(sine(NAN)) && isnan(cosine(INFINITY)) && isnan(sine(-INFINITY)));
    assert_true(sine(0.0f) == 0.0f && cosine(0.0f) == 1.0f);
    assert_true(sine(3e38f) == 0.0f && cosine(-3e38f) == 1.0f);
}

static void bits_go_there_and_back(void **state)
{
    (void)state;
    assert_int_equal(co_float_bits(-1.0f), 0xbf800000u);
    assert_true(co_double_bits(-1.0) == 0xbff0000000000000u);
    static const uint64_t odd[] = {0,
                                   1,
                                   0x80000000u,
                                   0x7fc00001u,
                                   0x8000000000000000u,
                                   0x7ff8000000000001u}; // zeros, denormals, NaN with a payload
    for (size_t i = 0; i < sizeof odd / sizeof odd[0]; i++) {
        assert_int_equal(co_float_bits(co_float_from_bits((uint32_t)odd[i])), (uint32_t)odd[i]);
        assert_true(co_double_bits(co_double_from_bits(odd[i])) == odd[i]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_function_is_within_its_error),
        cmocka_unit_test(powers_and_angles_are_within_their_error),
        cmocka_unit_test(powers_at_their_edges),
        cmocka_unit_test(angles_at_their_edges),
        cmocka_unit_test(bits_go_there_and_back),
        cmocka_unit_test(waves_of_no_number_are_no_number),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
