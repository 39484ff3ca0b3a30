// What a product of floats is off by.

#ifndef CO_SIMD_RESIDUE_H
#define CO_SIMD_RESIDUE_H

#include "simd/four.h"

#ifdef __FMA__
#include <immintrin.h>
#endif

// a * b - p rounded once, for a p near the product. Without a fused operation by doubles, in which
// both the product and that difference are exact.
static inline float co_float_residue(float a, float b, float p)
{
#ifdef __FMA__
    return __builtin_fmaf(a, b, -p);
#else
    return (float)((double)a * (double)b - (double)p);
#endif
}

static inline CoFour co_four_residue(CoFour a, CoFour b, CoFour p)
{
#ifdef __FMA__
    return _mm_fmsub_ps(a, b, p);
#else
    return (CoFour){co_float_residue(a[0], b[0], p[0]), co_float_residue(a[1], b[1], p[1]),
                    co_float_residue(a[2], b[2], p[2]), co_float_residue(a[3], b[3], p[3])};
#endif
}

#endif
