// Instruction sets: names, masks and the environment.

#include "simd/isa.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

// Runs first: nothing has asked for the flags yet.
static void environment_sets_the_first_mask(void **state)
{
    (void)state;
    assert_int_equal(setenv("COHORT_ISA", "scalar", 1), 0);
    assert_int_equal(co_isa_flags(), 1u << CO_ISA_SCALAR);
    assert_int_equal(co_isa_best(), CO_ISA_SCALAR);
    assert_int_equal(setenv("COHORT_ISA", "avx512", 1), 0);
    assert_int_equal(co_isa_flags(), 1u << CO_ISA_SCALAR);
}

static void masks_only_take_away(void **state)
{
    (void)state;
    co_isa_mask_set(~0u);
    uint32_t all = co_isa_flags();
    assert_true(all & 1u << CO_ISA_SCALAR);
    for (int i = 0; i < CO_ISA_COUNT; i++) {
        co_isa_mask_set(co_isa_mask_up_to((CoIsa)i));
        assert_int_equal(co_isa_flags(), all & co_isa_mask_up_to((CoIsa)i));
        assert_true((int)co_isa_best() <= i);
    }
    co_isa_mask_set(0);
    assert_int_equal(co_isa_flags(), 1u << CO_ISA_SCALAR);
}

static void names_parse_back(void **state)
{
    (void)state;
    CoIsa isa = CO_ISA_AVX2;
    for (int i = 0; i < CO_ISA_COUNT; i++) {
        assert_true(co_isa_parse(co_isa_name((CoIsa)i), &isa));
        assert_int_equal(isa, i);
    }
    isa = CO_ISA_AVX2;
    assert_false(co_isa_parse("AVX2", &isa));
    assert_false(co_isa_parse("", &isa));
    assert_int_equal(isa, CO_ISA_AVX2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(environment_sets_the_first_mask),
        cmocka_unit_test(masks_only_take_away),
        cmocka_unit_test(names_parse_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
