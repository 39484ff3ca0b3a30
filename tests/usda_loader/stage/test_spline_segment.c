// Curved segments: handles that are too long, and verticals. The figures are the reference's.

#include "stage/spline_segment.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static void expect(double from, double to, const double handles[4], double at, double wanted)
{
    CoSplineKnot a = {.time = from, .post = {.is_set = true}}, b = {.time = to, .pre.is_set = true};
    a.value = from;
    b.value = to;
    a.post.width = handles[0];
    a.post.slope = handles[1];
    b.pre.width = handles[2];
    b.pre.slope = handles[3];
    double got = co_spline_segment(&a, &b, false, at);
    if (fabs(got - wanted) > 1e-6 * fmax(1, fabs(wanted))) {
        print_error("at %g: %.9g, expected %.9g\n", at, got, wanted);
        fail();
    }
}

static void handles_of_fair_length(void **state)
{
    (void)state;
    const double handles[] = {0.2, 1, 0.5, 2};
    expect(0, 1, handles, 0.25, 0.131174);
    expect(0, 1, handles, 0.5, 0.282369);
    expect(0, 1, handles, 0.9, 0.810819);
}

static void one_handle_much_too_long(void **state)
{
    (void)state;
    const double hair[] = {1e-7, 1, 3, 2}, none[] = {3, 1, 0, 2};
    expect(0, 1, hair, 0.25, -0.190545);
    expect(0, 1, hair, 0.5, 0.110121);
    expect(0, 1, hair, 0.9, 0.803491);
    expect(0, 1, none, 0.25, 0.25);
    expect(0, 1, none, 0.9, 0.9);
}

// Where the reference's closed form is off by some 1e-5.
static void next_to_a_vertical(void **state)
{
    (void)state;
    const double handles[] = {1.35, -20, 0.27, -20};
    expect(0, 1, handles, 0.001, -0.01987956);
    expect(0, 1, handles, 0.5, -8.56906658);
    expect(0, 1, handles, 0.9, -7.34274497);
}

static void straight_and_empty_handles(void **state)
{
    (void)state;
    const double third[] = {1.0 / 3, 1, 1.0 / 3, 1}, none[4] = {0}, below[] = {-1, 5, -1, 5};
    for (double t = 0.125; t < 1; t += 0.125) {
        expect(0, 1, third, t, t);
        expect(0, 1, none, t, t);
        expect(0, 1, below, t, t);
        expect(-1e6, 1e6, third, t, t);
    }
}

static void two_values_and_hermite(void **state)
{
    (void)state;
    CoSplineKnot a = {.value = 3, .pre_value = 9, .has_pre_value = true};
    CoSplineKnot b = {.time = 2, .value = 9, .pre_value = 3, .has_pre_value = true};
    assert_true(fabs(co_spline_segment(&a, &b, true, 1) - 3) < 1e-12);
    assert_true(fabs(co_spline_segment(&a, &b, false, 1) - 3) < 1e-12);
    b.pre_value = 4;
    assert_true(fabs(co_spline_segment(&a, &b, true, 0.5) - 3.15625) < 1e-12);
    a.post.is_set = true;
    a.post.slope = 1;
    assert_true(fabs(co_spline_segment(&a, &b, true, 1) - 3.75) < 1e-12);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(handles_of_fair_length), cmocka_unit_test(one_handle_much_too_long),
        cmocka_unit_test(next_to_a_vertical),     cmocka_unit_test(straight_and_empty_handles),
        cmocka_unit_test(two_values_and_hermite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
