#include "simd/isa.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

static const char *const names[CO_ISA_COUNT] = {"scalar", "sse42", "avx2", "avx512"};

// Bit 31 says that the mask was chosen; before that the environment decides.
static _Atomic uint32_t chosen_mask;
#define MASK_IS_CHOSEN 0x80000000u

static uint32_t machine_flags(void)
{
    uint32_t flags = 1u << CO_ISA_SCALAR;
#if defined(__x86_64__)
    __builtin_cpu_init();
    if (__builtin_cpu_supports("sse4.2") && __builtin_cpu_supports("popcnt"))
        flags |= 1u << CO_ISA_SSE42;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
        __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2"))
        flags |= 1u << CO_ISA_AVX2;
    if ((flags >> CO_ISA_AVX2 & 1u) && __builtin_cpu_supports("avx512f") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512bw"))
        flags |= 1u << CO_ISA_AVX512;
#endif
    return flags;
}

static uint32_t environment_mask(void)
{
    const char *name = getenv("COHORT_ISA");
    CoIsa isa;
    if (name && co_isa_parse(name, &isa))
        return co_isa_mask_up_to(isa);
    return co_isa_mask_up_to(CO_ISA_AVX512);
}

uint32_t co_isa_flags(void)
{
    uint32_t mask = atomic_load_explicit(&chosen_mask, memory_order_relaxed);
    if (!(mask & MASK_IS_CHOSEN)) {
        // Two threads that race here store the same value.
        mask = environment_mask() | MASK_IS_CHOSEN;
        atomic_store_explicit(&chosen_mask, mask, memory_order_relaxed);
    }
    return machine_flags() & (mask | 1u << CO_ISA_SCALAR);
}

void co_isa_mask_set(uint32_t mask)
{
    atomic_store_explicit(&chosen_mask, mask | MASK_IS_CHOSEN, memory_order_relaxed);
}

uint32_t co_isa_mask_up_to(CoIsa isa)
{
    return (2u << isa) - 1u;
}

const char *co_isa_name(CoIsa isa)
{
    return names[isa];
}

bool co_isa_parse(const char *name, CoIsa *out)
{
    for (int i = 0; i < CO_ISA_COUNT; i++) {
        if (strcmp(name, names[i]) == 0) {
            *out = (CoIsa)i;
            return true;
        }
    }
    return false;
}

CoIsa co_isa_best(void)
{
    uint32_t flags = co_isa_flags();
    CoIsa best = CO_ISA_SCALAR;
    for (int i = 0; i < CO_ISA_COUNT; i++)
        if (flags >> i & 1u)
            best = (CoIsa)i;
    return best;
}
