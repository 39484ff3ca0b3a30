#include "sort/ray_keys.h"

#include "simd/isa.h"

#include <stddef.h>

CoRayKeysFn *co_ray_keys(const char *isa)
{
#if defined(__x86_64__)
    static CoRayKeysFn *const table[CO_ISA_COUNT] = {co_ray_keys_scalar, co_ray_keys_sse42,
                                                     co_ray_keys_avx2, co_ray_keys_avx512};
#else
    static CoRayKeysFn *const table[CO_ISA_COUNT] = {co_ray_keys_scalar};
#endif
    CoIsa chosen = co_isa_best();
    if (isa && *isa && !co_isa_parse(isa, &chosen))
        return NULL;
    return co_isa_flags() >> chosen & 1u ? table[chosen] : NULL;
}
