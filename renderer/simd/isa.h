// Instruction sets: what this machine has, what the user allows, and their names.
//
// Threads: all functions may be called from any thread; the mask is process-wide.

#ifndef CO_SIMD_ISA_H
#define CO_SIMD_ISA_H

#include <stdbool.h>
#include <stdint.h>

// Lowest first. Values are also bit numbers in flags and masks.
typedef enum CoIsa {
    CO_ISA_SCALAR = 0,
    CO_ISA_SSE42,
    CO_ISA_AVX2,
    CO_ISA_AVX512, // F, VL, DQ and BW
    CO_ISA_COUNT
} CoIsa;

// Bits (1 << CoIsa) of what may be used: the machine's, by the mask. Scalar is always there.
uint32_t co_isa_flags(void);

// Sets the mask. Before the first call it is what the environment variable COHORT_ISA names, with
// everything below it; an unset, empty or unknown name allows all.
void co_isa_mask_set(uint32_t mask);

// The mask that allows `isa` and everything below.
uint32_t co_isa_mask_up_to(CoIsa isa);

// "scalar", "sse42", "avx2", "avx512".
const char *co_isa_name(CoIsa isa);

// The inverse. False, *out untouched, for an unknown name.
bool co_isa_parse(const char *name, CoIsa *out);

// The highest of co_isa_flags().
CoIsa co_isa_best(void);

#endif
