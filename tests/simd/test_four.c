// Four floats of one thing: NaN in minima, signs and choices, the spare fourth.

#include "simd/four.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static void second_operand_wins_on_nan(void **state)
{
    (void)state;
    const CoFour a = {NAN, 1.0f, -0.0f, 5.0f}, b = {2.0f, NAN, 0.0f, -5.0f};
    CoFour low = co_four_min(a, b), high = co_four_max(a, b);
    assert_true(low[0] == 2.0f && isnan(low[1]) && low[3] == -5.0f);
    assert_true(high[0] == 2.0f && isnan(high[1]) && high[3] == 5.0f);
    assert_false(signbit(low[2]) || signbit(high[2]));
}

static void signs_and_choices(void **state)
{
    (void)state;
    const CoFour a = {-1.5f, 0.0f, -0.0f, -INFINITY}, b = {1.0f, -1.0f, -0.0f, 2.0f};
    CoFour size = co_four_abs(a), signed_a = co_four_copysign(a, b);
    assert_true(size[0] == 1.5f && !signbit(size[2]) && size[3] == INFINITY);
    assert_true(signed_a[0] == 1.5f && signbit(signed_a[1]) && signbit(signed_a[2]));
    CoFour chosen = co_four_select(a < b, a, b);
    assert_true(chosen[0] == -1.5f && chosen[1] == -1.0f && chosen[3] == -INFINITY);
}

static void the_fourth_is_spare(void **state)
{
    (void)state;
    const CoFour a = {1.0f, 3.0f, 2.0f, 9.0f}, b = {1.0f, 3.0f, 2.0f, -9.0f};
    assert_true(co_four_largest3(a, 0.0f) == 3.0f && co_four_largest3(a, 4.0f) == 4.0f);
    assert_true(co_four_smallest3(b, 5.0f) == 1.0f && co_four_smallest3(b, 0.5f) == 0.5f);
    assert_true(co_four_largest3(co_four_set1(NAN), 2.0f) == 2.0f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(second_operand_wins_on_nan),
        cmocka_unit_test(signs_and_choices),
        cmocka_unit_test(the_fourth_is_spare),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
