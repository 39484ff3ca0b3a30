// Vectors of CO_LANE_WIDTH floats: the vocabulary of every kernel.
//
// A kernel includes this file and is compiled once per instruction set with CO_LANE_ISA defined as
// 0 (scalar), 1 (SSE4.2), 2 (AVX2) or 3 (AVX-512). Every operation rounds once per lane as IEEE 754
// says, so all widths give the same bits; co_lane_muladd alone may or may not round in between, and
// is for tests that only cull. co_lane_residue(a, b, p) is a * b - p rounded once, for a p near the
// product: what is off between them. Comparisons with NaN are false, except co_lane_ne. min and max
// follow SSE: a < b ? a : b, hence the second operand when one is NaN.

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

// Wide vectors of CO_WIDE_WIDTH floats, for work on many rays at once: 16 with AVX-512, else lanes.
// The same operations with the same meaning.
#if CO_LANE_ISA != 3
enum {
    CO_WIDE_WIDTH = CO_LANE_WIDTH
};
typedef CoLane CoWide;
typedef CoLaneMask CoWideMask;
#define co_wide_load co_lane_load
#define co_wide_store co_lane_store
#define co_wide_set1 co_lane_set1
#define co_wide_add co_lane_add
#define co_wide_sub co_lane_sub
#define co_wide_mul co_lane_mul
#define co_wide_div co_lane_div
#define co_wide_muladd co_lane_muladd
#define co_wide_residue co_lane_residue
#define co_wide_min co_lane_min
#define co_wide_max co_lane_max
#define co_wide_abs co_lane_abs
#define co_wide_copysign co_lane_copysign
#define co_wide_lt co_lane_lt
#define co_wide_le co_lane_le
#define co_wide_ne co_lane_ne
#define co_wide_and co_lane_and
#define co_wide_select co_lane_select
#define co_wide_bits co_lane_bits
#define co_wide_mask co_lane_mask
#define co_wide_lookup16 co_lane_lookup16
#define co_wide_load_points co_lane_load_points
#endif

#endif
