// IEEE binary16, as Ptex files round it. Not the hardware's round-to-even, and no hardware at all:
// the same bits on every machine.

#ifndef CO_TEXTURE_HALF_H
#define CO_TEXTURE_HALF_H

#include "math/bits.h"

// Exact.
static inline float co_half_to_float(uint16_t half)
{
    uint32_t sign = (uint32_t)(half & 0x8000) << 16, exponent = half >> 10 & 31;
    uint32_t mantissa = half & 1023, bits;
    if (exponent == 0) {
        bits = sign | co_float_bits((float)mantissa * 0x1p-24f);
    } else if (exponent == 31) {
        bits = sign | 0x7f800000 | mantissa << 13;
    } else {
        bits = sign | (exponent + 112) << 23 | mantissa << 13;
    }
    return co_float_from_bits(bits);
}

// Rounds half away from zero; a zero of either sign gives +0.
static inline uint16_t co_half_from_float(float value)
{
    uint32_t bits = co_float_bits(value);
    uint32_t sign = bits >> 16 & 0x8000, rest = bits & 0x7fffffff;
    if (rest == 0)
        return 0;
    if (rest > 0x7f800000) {
        uint32_t mantissa = rest >> 13 & 1023;
        return (uint16_t)(sign | 0x7c00 | (mantissa ? mantissa : 1));
    }
    if (rest >= 0x47800000)
        return (uint16_t)(sign | 0x7c00);
    if (rest < 0x38800000) // below 2^-14
        return (uint16_t)(sign | (uint32_t)(co_float_from_bits(rest) * 0x1p24f + 0.5f));
    return (uint16_t)(sign | (rest - 0x38000000 + 0x1000) >> 13);
}

#endif
