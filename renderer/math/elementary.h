// Sines, powers and angles in float32, the same bits on every machine.
//
// libm picks variants by CPU, so nothing that reaches the image may call it. Here each function
// reduces its argument and sums a short Taylor series in double, in a fixed order and uncontracted,
// then rounds once: the error stays below 0.52 units in the last place on the ranges given
// (measured against libm in double). Only sqrt is taken from the machine: IEEE 754 fixes its bits.

#ifndef CO_MATH_ELEMENTARY_H
#define CO_MATH_ELEMENTARY_H

#include "math/bits.h"

#include <math.h>

#define CO_PI_D 3.14159265358979323846

// ---- Pieces in double: about 1e-11 relative ----------------------------------------------------

// sin and cos of |x| <= pi/4 and a little.
static inline void co_sincos_eighth_d(double r, double *sine, double *cosine)
{
    // In pairs: half the steps that wait for each other.
    double z = r * r, z2 = z * z;
    double s_high = (-1.0 / 5040 + z * (1.0 / 362880)) + z2 * (-1.0 / 39916800);
    double c_high =
        (-1.0 / 720 + z * (1.0 / 40320)) + z2 * (-1.0 / 3628800 + z * (1.0 / 479001600));
    *sine = r + r * z * ((-1.0 / 6 + z * (1.0 / 120)) + z2 * s_high);
    *cosine = 1.0 + z * ((-1.0 / 2 + z * (1.0 / 24)) + z2 * c_high);
}

// sin and cos of x. |x| above 2^30 has no phase worth keeping: it counts as 0. NaN and infinity
// give NaN.
static inline void co_sincos_d(double x, double *sine, double *cosine)
{
    if (!(fabs(x) <= 0x1p30))
        x = x - x == 0.0 ? 0.0 : x - x;
    // Nearest multiple of pi/2; pi/2 in two parts, so that k times the first is exact.
    double scaled = x * (2.0 / CO_PI_D);
    int64_t k = isnan(x) ? 0 : (int64_t)(scaled + (scaled < 0.0 ? -0.5 : 0.5));
    double r = (x - (double)k * 0x1.921fb5p+0) - (double)k * 0x1.110b4611a6263p-26;
    double s, c;
    co_sincos_eighth_d(r, &s, &c);
    double swapped_s = (k & 1) != 0 ? c : s;
    double swapped_c = (k & 1) != 0 ? s : c;
    *sine = (k & 2) != 0 ? -swapped_s : swapped_s;
    *cosine = ((k + 1) & 2) != 0 ? -swapped_c : swapped_c;
}

// 2^x for |x| <= 1000; outside, x is clamped to that, which any float32 result cannot tell.
static inline double co_exp2_d(double x)
{
    if (isnan(x))
        return x;
    x = x < -1000.0 ? -1000.0 : x > 1000.0 ? 1000.0 : x;
    int64_t k = (int64_t)(x + (x < 0.0 ? -0.5 : 0.5));
    double r = (x - (double)k) * 0.69314718055994530942;
    double low = 1.0 + r * (1.0 + r * (1.0 / 2 + r * (1.0 / 6 + r * (1.0 / 24))));
    double high =
        1.0 / 120 + r * (1.0 / 720 + r * (1.0 / 5040 + r * (1.0 / 40320 + r * (1.0 / 362880))));
    double r2 = r * r;
    return (low + high * (r2 * r2 * r)) * co_double_from_bits((uint64_t)(k + 1023) << 52);
}

// log2 of a positive, normal double: x = 2^k m with m around 1, log m = 2 atanh((m - 1) / (m + 1)).
static inline double co_log2_d(double x)
{
    uint64_t bits = co_double_bits(x);
    // sqrt(1/2)'s mantissa as the split puts m into [sqrt(1/2), sqrt(2)).
    int64_t k = (int64_t)((bits - 0x3fe6a09e667f3bcdu) >> 52);
    k = (k ^ 0x800) - 0x800; // the 12-bit difference, signed
    double m = co_double_from_bits(bits - ((uint64_t)k << 52));
    double f = (m - 1.0) / (m + 1.0);
    double z = f * f;
    double low = 1.0 + z * (1.0 / 3 + z * (1.0 / 5 + z * (1.0 / 7)));
    double high = 1.0 / 9 + z * (1.0 / 11 + z * (1.0 / 13 + z * (1.0 / 15)));
    double z2 = z * z;
    return (double)k + f * (low + high * (z2 * z2)) * 2.88539008177792681472; // 2 / ln 2
}

// Angle of (x, y), both finite, in [-pi, pi]. (0, 0) gives 0, signed as atan2 has it.
static inline double co_atan2_d(double y, double x)
{
    static const double atan_of_eighths[9] = {
        0.0,
        0.12435499454676143503,
        0.24497866312686415417,
        0.35877067027057222039,
        0.46364760900080611621,
        0.55859931534356243597,
        0.64350110879328438680,
        0.71882999962162450542,
        0.78539816339744830962,
    };
    double ax = fabs(x), ay = fabs(y);
    double big = ax > ay ? ax : ay, small = ax > ay ? ay : ax;
    double angle = 0.0;
    if (big > 0.0) {
        // atan(a) = atan(c) + atan((a - c) / (1 + a c)) with c the nearest eighth.
        double a = small / big;
        int i = (int)(a * 8.0 + 0.5);
        double c = (double)i * 0.125;
        double r = (a - c) / (1.0 + a * c);
        double z = r * r;
        angle = atan_of_eighths[i] +
                (r + r * z * (-1.0 / 3 + z * (1.0 / 5 + z * (-1.0 / 7 + z * (1.0 / 9)))));
    }
    if (ay > ax)
        angle = CO_PI_D / 2 - angle;
    if (signbit(x))
        angle = CO_PI_D - angle;
    return copysign(angle, y);
}

// ---- The functions ------------------------------------------------------------------------------

// Error below 0.51 ulp for |x| <= 2^20, growing to 1e-6 absolute at 2^30; see co_sincos_d beyond.
static inline void co_sincosf(float x, float *sine, float *cosine)
{
    double s, c;
    co_sincos_d((double)x, &s, &c);
    *sine = (float)s;
    *cosine = (float)c;
}

// x to the y for x >= 0; a negative x gives NaN unless y is 0. pow(x, 0) is 1, also for NaN.
// Overflow gives infinity, underflow denormals and then 0.
static inline float co_powf(float x, float y)
{
    if (y == 0.0f || x == 1.0f)
        return 1.0f;
    if (!(x > 0.0f) || isinf(x)) {
        if (x == 0.0f || isinf(x))
            return x < 0.0f ? NAN : isnan(y) ? y : (x == 0.0f) == (y > 0.0f) ? 0.0f : INFINITY;
        return NAN;
    }
    if (isinf(y))
        return (x > 1.0f) == (y > 0.0f) ? INFINITY : 0.0f;
    return (float)co_exp2_d((double)y * co_log2_d((double)x));
}

// Angle of (x, y) in [-pi, pi]; NaN where x or y is not finite.
static inline float co_atan2f(float y, float x)
{
    if (!isfinite(x) || !isfinite(y))
        return NAN;
    return (float)co_atan2_d((double)y, (double)x);
}

// Arguments are clamped to [-1, 1]: cosines may overstep by rounding. NaN gives NaN.
static inline float co_acosf(float x)
{
    double c = (double)x < -1.0 ? -1.0 : (double)x > 1.0 ? 1.0 : (double)x;
    if (isnan(c))
        return x;
    return (float)co_atan2_d(sqrt((1.0 - c) * (1.0 + c)), c);
}

static inline float co_asinf(float x)
{
    double s = (double)x < -1.0 ? -1.0 : (double)x > 1.0 ? 1.0 : (double)x;
    if (isnan(s))
        return x;
    return (float)co_atan2_d(s, sqrt((1.0 - s) * (1.0 + s)));
}

#endif
