// Every lane operation over arrays, for each instruction set.

#ifndef TESTS_SIMD_LANE_CALLS_H
#define TESTS_SIMD_LANE_CALLS_H

#include <stdint.h>

enum {
    LANE_CALL_COUNT = 21, // operations
    WIDE_CALL_COUNT = 17
};

// Applies each operation to a[i], b[i] for i < count (a multiple of 8) and stores its bits at
// out[operation * count + i].
typedef void LaneCalls(const float *a, const float *b, const uint8_t *index, uint32_t count,
                       float *out);

LaneCalls lane_calls_scalar;
LaneCalls lane_calls_sse42;
LaneCalls lane_calls_avx2;
LaneCalls lane_calls_avx512;

// The same for wide vectors; count is a multiple of 16. The last operation is muladd, by c.
typedef void WideCalls(const float *a, const float *b, const float *c, uint32_t count, float *out);

WideCalls wide_calls_scalar;
WideCalls wide_calls_sse42;
WideCalls wide_calls_avx2;
WideCalls wide_calls_avx512;

#endif
