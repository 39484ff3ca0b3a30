// Four floats of one thing, such as a point and a spare: for work on single rays. Plain C with the
// compiler's vectors; every operation rounds once as IEEE 754 says, so all instruction sets agree.

#ifndef CO_SIMD_FOUR_H
#define CO_SIMD_FOUR_H

#include <stdbool.h>
#include <stdint.h>

typedef float CoFour __attribute__((vector_size(16)));
typedef int32_t CoFourBits
    __attribute__((vector_size(16))); // of a comparison: all ones where it holds

static inline CoFour co_four_set1(float a)
{
    return (CoFour){a, a, a, a};
}

// a where m, else b.
static inline CoFour co_four_select(CoFourBits m, CoFour a, CoFour b)
{
    return (CoFour)((m & (CoFourBits)a) | (~m & (CoFourBits)b));
}

static inline CoFour co_four_abs(CoFour a)
{
    return (CoFour)((CoFourBits)a & INT32_MAX);
}

static inline CoFour co_four_copysign(CoFour a, CoFour b)
{
    return (CoFour)(((CoFourBits)a & INT32_MAX) | ((CoFourBits)b & INT32_MIN));
}

// The second operand when one is NaN.
static inline CoFour co_four_min(CoFour a, CoFour b)
{
#ifdef __SSE__
    return __builtin_ia32_minps(a, b);
#else
    return co_four_select(a < b, a, b);
#endif
}

static inline CoFour co_four_max(CoFour a, CoFour b)
{
#ifdef __SSE__
    return __builtin_ia32_maxps(a, b);
#else
    return co_four_select(a > b, a, b);
#endif
}

// The first three have the same bits.
static inline bool co_four_same3(CoFour a, CoFour b)
{
    CoFourBits x = (CoFourBits)a ^ (CoFourBits)b;
    return (x[0] | x[1] | x[2]) == 0;
}

// The first three are numbers below a limit.
static inline bool co_four_below3(CoFour a, float limit)
{
    CoFourBits x = a < co_four_set1(limit);
#ifdef __SSE__
    return (__builtin_ia32_movmskps((CoFour)x) & 7) == 7;
#else
    return x[0] & x[1] & x[2] & 1;
#endif
}

// Largest of the first three and `least`.
static inline float co_four_largest3(CoFour a, float least)
{
    least = a[0] > least ? a[0] : least;
    least = a[1] > least ? a[1] : least;
    return a[2] > least ? a[2] : least;
}

static inline float co_four_smallest3(CoFour a, float most)
{
    most = a[0] < most ? a[0] : most;
    most = a[1] < most ? a[1] : most;
    return a[2] < most ? a[2] : most;
}

#endif
