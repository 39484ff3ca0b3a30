// What the words of a record hold, for the encoder and the decoder alike.
//
//   word 0-2  origin, float32
//   word 3    direction x, 26 bits; low 6 bits of the depth
//   word 4    direction y, 26 bits; high 4 bits of the depth; kind, 2 bits
//   word 5    weight, RGB9e5; light rays: with an exponent from a lower origin
//   word 6    camera and BSDF rays: pdf, 16 bits; normal 2 x 8. Light rays: emitter, 24 bits;
//             upper bits of the weight's exponent, 8 bits
//   word 7    path
//   word 8    branch, width, spread, flags, 8 bits each; the highest flag bit is the upper bit of
//             the weight's exponent in camera and BSDF rays
//   word 9-   t_near and extra, where the scene asks for them

#ifndef CO_RAYS_RAY_PARTS_H
#define CO_RAYS_RAY_PARTS_H

#include "math/bits.h"
#include "rays/ray.h"

enum {
    CO_NORMAL_MAX = 127,
    CO_NORMAL_CODE = 0x10000, // marks a code, which may be 0
    CO_DEPTH_MAX = 1023,
    CO_EMITTER_MAX = 0xffffff,
    CO_DIRECTION_MASK = 0x3ffffff
};

// The weight of BSDF rays is mantissa * 2^(exponent - 24), the range of RGB9e5, with one more bit.
// A throughput below 2^-24 is a path not worth following: there the rounding to 0 or 1 is the
// roulette. The weight of a light ray says nothing of the kind: it is divided by the pdf of its
// direction, which a small light makes huge, and the light's radiance, as huge, comes at the ray's
// end. So light rays keep nine bits of every float.
enum {
    CO_MANTISSA_MAX = 511,
    CO_EXPONENT_MAX_RGB9E5 = 7, // 511 * 2^7 = 65408
    CO_EXPONENT_BIAS = 24,
    CO_EXPONENT_MAX = 39, // with the one more bit
    CO_EXPONENT_FLAG = 128,
    CO_EXPONENT_BIAS_LIGHT = 149, // mantissa 1 at exponent 0 is the least float
    CO_EXPONENT_MAX_LIGHT = 119   // the highest whose 511 is still a float
};

// pdf: 6 bits of exponent, 10 of mantissa, 2^-31 to 2^33.
enum {
    CO_PDF_NONE = 0,
    CO_PDF_DELTA = 0xffff,
    CO_PDF_SHIFT = 13,
    CO_PDF_ORIGIN = (127 - 31) << 10
};

// Widths: log2 in quarter octaves, 0 stays 0; the code of 1: widths from 1e-12 to 1e7.
enum {
    CO_STEP_ORIGIN = 160
};

_Static_assert(CO_RAY_WORDS * sizeof(uint32_t) == 36, "the record of the paper");
_Static_assert(CO_RAY_WORDS_MAX * sizeof(uint32_t) == 44, "the record with every optional word");
_Static_assert(sizeof(float) == sizeof(uint32_t), "floats travel in words");

static inline double co_power_of_two(int exponent) // -1022 to 1023
{
    return co_double_from_bits((uint64_t)(exponent + 1023) << 52);
}

static inline int co_exponent_bias(uint32_t kind)
{
    return kind == CO_RAY_LIGHT ? CO_EXPONENT_BIAS_LIGHT : CO_EXPONENT_BIAS;
}

// A positive pdf stays positive and finite: 0 and infinity mean something else.
static inline uint32_t co_pdf_encode(float pdf)
{
    uint32_t bits = co_float_bits(pdf);
    int32_t code = (int32_t)((bits + (1u << (CO_PDF_SHIFT - 1))) >> CO_PDF_SHIFT) - CO_PDF_ORIGIN;
    code = code < 1 ? 1 : code;
    code = code > CO_PDF_DELTA - 1 ? CO_PDF_DELTA - 1 : code;
    code = bits == 0x7f800000u ? CO_PDF_DELTA : code;
    return pdf > 0.0f ? (uint32_t)code : CO_PDF_NONE;
}

static inline float co_pdf_decode(uint32_t code)
{
    if (code == CO_PDF_NONE)
        return 0.0f;
    if (code == CO_PDF_DELTA)
        return INFINITY;
    return co_float_from_bits((code + CO_PDF_ORIGIN) << CO_PDF_SHIFT);
}

#endif
