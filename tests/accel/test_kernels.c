// The table of kernels: names, the mask, the best.

#include "accel/accel.h"
#include "simd/isa.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static void names_choose_kernels(void **state)
{
    (void)state;
    uint32_t flags = co_isa_flags();
    for (int i = 0; i < CO_ISA_COUNT; i++) {
        const CoAccelKernels *kernels = co_accel_kernels(co_isa_name((CoIsa)i));
        assert_int_equal(kernels != NULL, flags >> i & 1u);
        if (kernels)
            assert_string_equal(kernels->isa, co_isa_name((CoIsa)i));
    }
    assert_null(co_accel_kernels("mmx"));
    assert_string_equal(co_accel_kernels(NULL)->isa, co_isa_name(co_isa_best()));
    assert_ptr_equal(co_accel_kernels(""), co_accel_kernels(NULL));
}

static void masked_kernels_are_gone(void **state)
{
    (void)state;
    co_isa_mask_set(0);
    assert_string_equal(co_accel_kernels(NULL)->isa, "scalar");
    assert_null(co_accel_kernels("avx2"));
    co_isa_mask_set(co_isa_mask_up_to(CO_ISA_AVX512));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_choose_kernels),
        cmocka_unit_test(masked_kernels_are_gone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
