#include "rays/ray_kernels.h"

#include "simd/isa.h"

#include <stddef.h>

#if defined(__x86_64__)
static const CoRayKernels table[CO_ISA_COUNT] = {
    {"scalar", co_ray_encode_scalar, co_ray_decode_batch_scalar},
    {"sse42", co_ray_encode_sse42, co_ray_decode_batch_sse42},
    {"avx2", co_ray_encode_avx2, co_ray_decode_batch_avx2},
    {"avx512", co_ray_encode_avx512, co_ray_decode_batch_avx512},
};
#else
static const CoRayKernels table[CO_ISA_COUNT] = {
    {"scalar", co_ray_encode_scalar, co_ray_decode_batch_scalar}};
#endif

const CoRayKernels *co_ray_kernels(const char *isa)
{
    CoIsa chosen = co_isa_best();
    if (isa && *isa && !co_isa_parse(isa, &chosen))
        return NULL;
    return co_isa_flags() >> chosen & 1u ? &table[chosen] : NULL;
}
