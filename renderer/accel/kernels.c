// The table of traversal kernels, one per instruction set.

#include "accel/accel.h"

#include "accel/kernels/traverse.h"
#include "simd/isa.h"

#include <stddef.h>

#if defined(__x86_64__)
static const CoAccelKernels table[CO_ISA_COUNT] = {
    {"scalar", co_accel_traverse_scalar, co_accel_next_scalar},
    {"sse42", co_accel_traverse_sse42, co_accel_next_sse42},
    {"avx2", co_accel_traverse_avx2, co_accel_next_avx2},
    {"avx512", co_accel_traverse_avx512, co_accel_next_avx512},
};
#else
static const CoAccelKernels table[CO_ISA_COUNT] = {
    {"scalar", co_accel_traverse_scalar, co_accel_next_scalar}};
#endif

const CoAccelKernels *co_accel_kernels(const char *isa)
{
    CoIsa chosen = co_isa_best();
    if (isa && *isa && !co_isa_parse(isa, &chosen))
        return NULL;
    return co_isa_flags() >> chosen & 1u ? &table[chosen] : NULL;
}
