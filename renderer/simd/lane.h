// Vectors of CO_LANE_WIDTH floats: the vocabulary of every kernel.
//
// A kernel includes this file and is compiled once per instruction set with CO_LANE_ISA defined as
// 0 (scalar), 1 (SSE4.2), 2 (AVX2) or 3 (AVX-512). Every operation rounds once per lane as IEEE 754
// says, so all widths give the same bits. Comparisons with NaN are false, except co_lane_ne.
// min and max follow SSE: a < b ? a : b, hence the second operand when one is NaN.

#ifndef CO_SIMD_LANE_H
#define CO_SIMD_LANE_H

#include <stdint.h>

#define CO_LANE_PASTE_(a, b) a##b
#define CO_LANE_PASTE(a, b) CO_LANE_PASTE_(a, b)

#if CO_LANE_ISA == 0
#include "simd/lane_scalar.h"
#define CO_LANE_NAME(name) CO_LANE_PASTE(name, _scalar)
#elif CO_LANE_ISA == 1
#include "simd/lane_sse42.h"
#define CO_LANE_NAME(name) CO_LANE_PASTE(name, _sse42)
#elif CO_LANE_ISA == 2
#include "simd/lane_avx2.h"
#define CO_LANE_NAME(name) CO_LANE_PASTE(name, _avx2)
#else
#include "simd/lane_avx512.h"
#define CO_LANE_NAME(name) CO_LANE_PASTE(name, _avx512)
#endif

// The middle of three: a limited to [lo, hi] where lo <= hi.
static inline CoLane co_lane_clamp(CoLane a, CoLane lo, CoLane hi)
{
    return co_lane_max(co_lane_min(a, hi), lo);
}

#endif
