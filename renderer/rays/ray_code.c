// The 36-byte record of a ray (Eisenacher et al. 2013, figure 3).
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
#include "rays/ray.h"

#include "base/hash.h"

#include <stdlib.h>
#include <string.h>

#define DIRECTION_MAX ((1 << 25) - 1) // symmetric, so that 0 and the axes are exact
#define NORMAL_MAX 127
#define NORMAL_CODE 0x10000u // marks a code, which may be 0
#define DEPTH_MAX 1023u
#define EMITTER_MAX 0xffffffu

#define MANTISSA_MAX 511.0
#define EXPONENT_BIAS 24        // value = mantissa * 2^(exponent - 24): the range of RGB9e5
#define EXPONENT_MAX_RGB9E5 7   // 511 * 2^7 = 65408
#define EXPONENT_MAX_FLAG 39    // with the one more bit of camera and BSDF rays
#define EXPONENT_MAX_LIGHT 119  // the highest whose 511 is still a float
#define EXPONENT_BIAS_LIGHT 149 // mantissa 1 at exponent 0 is the least float
#define EXPONENT_FLAG 128u

#define PDF_NONE 0u
#define PDF_DELTA 0xffffu

#define STEP_ORIGIN 160 // log2 code of 1: widths from 1e-12 to 1e7 in quarter octaves

_Static_assert(CO_RAY_WORDS * sizeof(uint32_t) == 36, "the record of the paper");
_Static_assert(CO_RAY_WORDS_MAX * sizeof(uint32_t) == 44, "the record with every optional word");
_Static_assert(sizeof(float) == sizeof(uint32_t), "floats travel in words");

static uint32_t float_bits(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static float bits_float(uint32_t bits)
{
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static double power_of_two(int exponent) // -1022 to 1023
{
    uint64_t bits = (uint64_t)(exponent + 1023) << 52;
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

// --- unit vectors: the octahedral map (Meyer et al. 2010) on a grid of integers -----------------

typedef struct Oct {
    int32_t x, y; // [-max, max]
} Oct;

// x with the sign of `like`, for x >= 0.
static int32_t with_sign(int32_t x, int32_t like)
{
    int32_t mask = like >> 31;
    return (x ^ mask) - mask;
}

// The squared length is an integer below 2^52, so the only roundings are the root, the quotient and
// the last one to float. No branches: half of all directions are in the folded half, no one knows
// which.
static CoVec3 oct_decode(Oct code, int32_t max)
{
    int32_t ax = abs(code.x), ay = abs(code.y), z = max - ax - ay;
    int32_t fold = z & z >> 31; // what |x| and |y| have too much where z < 0
    double dx = with_sign(ax + fold, code.x), dy = with_sign(ay + fold, code.y), dz = z;
    double inv = 1.0 / sqrt(dx * dx + dy * dy + dz * dz);
    return co_vec3((float)(dx * inv), (float)(dy * inv), (float)(dz * inv));
}

static int32_t clamp_code(int32_t x, int32_t max)
{
    return x > max ? max : x < -max ? -max : x;
}

// Nearest point of the grid. False, and the +z axis, for vectors that are zero or not finite.
static bool oct_nearest(CoVec3 v, int32_t max, Oct *out)
{
    double x = fabs((double)v.x), y = fabs((double)v.y), sum = x + y + fabs((double)v.z);
    *out = (Oct){0, 0};
    if (!(sum > 0.0) || !isfinite(sum))
        return false;
    // Positive, so that truncation rounds to the nearest; the quotient never passes max by half.
    double scale = max / sum;
    int32_t ax = (int32_t)(x * scale + 0.5), ay = (int32_t)(y * scale + 0.5);
    bool is_folded = v.z < 0.0f;
    int32_t folded_x = is_folded ? max - ay : ax, folded_y = is_folded ? max - ax : ay;
    out->x = with_sign(folded_x, (int32_t)float_bits(v.x));
    out->y = with_sign(folded_y, (int32_t)float_bits(v.y));
    return true;
}

static bool is_same(CoVec3 a, CoVec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

// A decoded direction must encode to itself: shading evaluates with the quantized direction before
// it stores the ray. Rounding to float moves a grid point by less than one step (0.8 at most), so
// the code that decodes to v, if there is one, is the nearest or a neighbor of it.
static bool direction_encode(CoVec3 v, Oct *out)
{
    if (!oct_nearest(v, DIRECTION_MAX, out))
        return false;
    Oct nearest = *out;
    if (is_same(oct_decode(nearest, DIRECTION_MAX), v))
        return true;
    float length2 = co_dot(v, v);
    if (!(fabsf(length2 - 1.0f) < 1e-6f)) // no decoded direction is that far from unit length
        return true;
    for (int32_t i = 0; i < 9; i++) {
        Oct code = {clamp_code(nearest.x + i % 3 - 1, DIRECTION_MAX),
                    clamp_code(nearest.y + i / 3 - 1, DIRECTION_MAX)};
        if (is_same(oct_decode(code, DIRECTION_MAX), v)) {
            *out = code;
            break;
        }
    }
    return true;
}

CoVec3 co_ray_quantize_direction(CoVec3 dir)
{
    Oct code;
    direction_encode(dir, &code);
    return oct_decode(code, DIRECTION_MAX);
}

// Codes outside the encoder are never 0: the grid begins at 1.
CoVec3 co_ray_snap_direction(CoVec3 dir, uint32_t code[2])
{
    Oct nearest;
    bool has_direction = oct_nearest(dir, DIRECTION_MAX, &nearest);
    code[0] = has_direction ? (uint32_t)(nearest.x + DIRECTION_MAX + 1) : 0;
    code[1] = has_direction ? (uint32_t)(nearest.y + DIRECTION_MAX + 1) : 0;
    return oct_decode(nearest, DIRECTION_MAX);
}

static bool find_code(const CoRay *ray, Oct *out)
{
    if (!ray->code[0] || !ray->code[1])
        return direction_encode(ray->dir, out);
    out->x = (int32_t)ray->code[0] - DIRECTION_MAX - 1;
    out->y = (int32_t)ray->code[1] - DIRECTION_MAX - 1;
    return true;
}

static Oct direction_code(const uint32_t *words)
{
    Oct code = {(int32_t)(words[3] & 0x3ffffffu) - DIRECTION_MAX,
                (int32_t)(words[4] & 0x3ffffffu) - DIRECTION_MAX};
    return code;
}

CoVec3 co_ray_decode_direction(const uint32_t *words)
{
    return oct_decode(direction_code(words), DIRECTION_MAX);
}

static uint32_t normal_encode(CoVec3 n)
{
    Oct code;
    oct_nearest(n, NORMAL_MAX, &code);
    return (uint32_t)(code.x + NORMAL_MAX) | (uint32_t)(code.y + NORMAL_MAX) << 8;
}

static CoVec3 normal_decode(uint32_t bits)
{
    Oct code = {(int32_t)(bits & 255u) - NORMAL_MAX, (int32_t)(bits >> 8 & 255u) - NORMAL_MAX};
    return oct_decode(code, NORMAL_MAX);
}

CoVec3 co_ray_quantize_normal(CoVec3 n)
{
    return normal_decode(normal_encode(n));
}

CoVec3 co_ray_snap_normal(CoVec3 n, uint32_t *code)
{
    uint32_t bits = normal_encode(n);
    *code = bits | NORMAL_CODE;
    return normal_decode(bits);
}

// --- pdf: 6 bits of exponent, 10 of mantissa, 2^-31 to 2^33 -------------------------------------

// A positive pdf stays positive and finite: 0 and infinity mean something else.
static uint32_t pdf_encode(float pdf)
{
    if (!(pdf > 0.0f))
        return PDF_NONE;
    if (isinf(pdf))
        return PDF_DELTA;
    int64_t code = (int64_t)((float_bits(pdf) + (1u << 12)) >> 13) - ((127 - 31) << 10);
    return code < 1 ? 1u : code >= (int64_t)PDF_DELTA ? PDF_DELTA - 1 : (uint32_t)code;
}

static float pdf_decode(uint32_t code)
{
    if (code == PDF_NONE)
        return 0.0f;
    if (code == PDF_DELTA)
        return INFINITY;
    return bits_float((code + ((127 - 31) << 10)) << 13);
}

float co_ray_quantize_pdf(float pdf)
{
    return pdf_decode(pdf_encode(pdf));
}

// --- widths: log2 in quarter octaves, 0 stays 0 -------------------------------------------------

static uint32_t step_encode(float x)
{
    if (!(x > 0.0f))
        return 0;
    if (isinf(x))
        return 255;
    uint32_t bits = float_bits(x);
    uint32_t mantissa = bits & 0x7fffffu;
    // Mantissas of 2^(1/8), 2^(3/8), 2^(5/8), 2^(7/8): the borders between quarter octaves.
    int quarter = (mantissa > 0x0b95c1u) + (mantissa > 0x25fed6u) + (mantissa > 0x45672au) +
                  (mantissa > 0x6ac0c6u);
    int code = 4 * ((int)(bits >> 23) - 127) + quarter + STEP_ORIGIN;
    return code < 1 ? 1u : code > 255 ? 255u : (uint32_t)code;
}

static float step_decode(uint32_t code)
{
    static const float quarters[4] = {1.0f, 1.18920711500272f, 1.41421356237310f,
                                      1.68179283050743f};
    if (code == 0)
        return 0.0f;
    uint32_t octave = code / 4 + 127 - STEP_ORIGIN / 4;
    return quarters[code % 4] * bits_float(octave << 23);
}

// --- weight: RGB9e5, rounded stochastically -----------------------------------------------------

// A throughput below 2^-24 is a path not worth following: there the rounding to 0 or 1 is the
// roulette. The weight of a light ray says nothing of the kind: it is divided by the pdf of its
// direction, which a small light makes huge, and the light's radiance, as huge, comes at the ray's
// end. So light rays keep nine bits of every float.
typedef struct Weight {
    uint32_t mantissa[3];
    int exponent; // value = mantissa * 2^exponent
} Weight;

static int exponent_bias(uint32_t kind)
{
    return kind == CO_RAY_LIGHT ? EXPONENT_BIAS_LIGHT : EXPONENT_BIAS;
}

static int exponent_max(uint32_t kind)
{
    return kind == CO_RAY_LIGHT ? EXPONENT_MAX_LIGHT : EXPONENT_MAX_FLAG;
}

// Independent of order: a function of the path, the vertex, the branch and which ray of them it is.
static uint64_t weight_seed(const CoRay *ray, CoRayKey key, Oct code)
{
    uint64_t h = co_hash64((uint64_t)key.pixel << 32 | key.sample);
    uint64_t vertex = (uint64_t)key.seed << 32 | ray->depth << 2 | ray->kind;
    uint64_t branch = (uint64_t)ray->branch << 32 | ray->emitter;
    uint64_t direction = (uint64_t)(uint32_t)code.x << 32 | (uint32_t)code.y;
    // Odd factors keep what is short from canceling; one round for all of it.
    return co_hash64(h ^ vertex * 0x9e3779b97f4a7c15u ^ branch * 0xd1342543de82ef95u ^
                     direction * 0xaf251af3b0f025b5u);
}

// The exponent is the least with max(weight) <= 511 * 2^exponent, so that rounding up never gives
// 512, but not below `exponent_min`.
static void weight_encode(CoVec3 w, int exponent_min, uint64_t seed, Weight *out)
{
    double channels[3] = {(double)w.x, (double)w.y, (double)w.z};
    double max = (double)co_max3(w);
    uint64_t bits;
    memcpy(&bits, &max, sizeof bits);
    int exponent = (int)(bits >> 52) - 1023 - 8;
    if (exponent < exponent_min)
        exponent = exponent_min;
    if (max * power_of_two(-exponent) > MANTISSA_MAX)
        exponent++;
    double scale = power_of_two(-exponent);
    for (int i = 0; i < 3; i++) {
        double u = (double)(co_hash64(seed + (uint64_t)i) >> 11) * 0x1p-53;
        out->mantissa[i] = (uint32_t)(channels[i] * scale + u);
    }
    out->exponent = exponent;
}

static CoVec3 weight_decode(uint32_t word, uint32_t high_bits, uint32_t kind)
{
    int exponent = (int)(word >> 27 | high_bits << 5) - exponent_bias(kind);
    double scale = power_of_two(exponent > EXPONENT_MAX_LIGHT ? EXPONENT_MAX_LIGHT : exponent);
    return co_vec3((float)((word & 511u) * scale), (float)((word >> 9 & 511u) * scale),
                   (float)((word >> 18 & 511u) * scale));
}

// --- the record ---------------------------------------------------------------------------------

static bool is_valid(const CoRay *ray, bool has_direction)
{
    CoVec3 w = ray->weight;
    if (!has_direction || !co_is_finite3(ray->org) || !co_is_finite3(w))
        return false;
    if (!(w.x >= 0.0f && w.y >= 0.0f && w.z >= 0.0f))
        return false;
    return (double)co_max3(w) <= MANTISSA_MAX * power_of_two(exponent_max(ray->kind));
}

static void encode_words(const CoRay *ray, uint32_t options, Oct code, const Weight *weight,
                         uint32_t *words)
{
    uint32_t depth = ray->depth > DEPTH_MAX ? DEPTH_MAX : ray->depth;
    uint32_t exponent = (uint32_t)(weight->exponent + exponent_bias(ray->kind));
    uint32_t high = exponent >> 5, flags = ray->flags & (EXPONENT_FLAG - 1);
    uint32_t ends;
    if (ray->kind == CO_RAY_LIGHT)
        ends = (ray->emitter & EMITTER_MAX) | high << 24;
    else if (ray->normal_code)
        ends = pdf_encode(ray->pdf) | ray->normal_code << 16;
    else
        ends = pdf_encode(ray->pdf) | normal_encode(ray->normal) << 16;
    if (ray->kind != CO_RAY_LIGHT && high)
        flags |= EXPONENT_FLAG;
    words[0] = float_bits(ray->org.x);
    words[1] = float_bits(ray->org.y);
    words[2] = float_bits(ray->org.z);
    words[3] = (uint32_t)(code.x + DIRECTION_MAX) | (depth & 63u) << 26;
    words[4] = (uint32_t)(code.y + DIRECTION_MAX) | (depth >> 6) << 26 | (ray->kind & 3u) << 30;
    words[5] =
        weight->mantissa[0] | weight->mantissa[1] << 9 | weight->mantissa[2] << 18 | exponent << 27;
    words[6] = ends;
    words[7] = ray->path;
    words[8] = (ray->branch & 255u) | step_encode(ray->width) << 8 |
               step_encode(ray->spread) << 16 | flags << 24;
    uint32_t next = CO_RAY_WORDS;
    if (options & CO_RAY_OPTION_TNEAR)
        words[next++] = float_bits(ray->tnear);
    if (options & CO_RAY_OPTION_EXTRA)
        words[next] = ray->extra;
}

uint32_t co_ray_encode(const CoRay *ray, uint32_t options, CoRayKey key, uint32_t *words,
                       uint32_t *overflow)
{
    Oct code;
    Weight weight = {{1, 1, 1}, 0};
    bool has_direction = find_code(ray, &code);
    if (!is_valid(ray, has_direction)) {
        encode_words(ray, options, code, &weight, words);
        words[0] = words[1] = words[2] = float_bits(NAN);
        return 1;
    }
    weight_encode(ray->weight, -exponent_bias(ray->kind), weight_seed(ray, key, code), &weight);
    if ((weight.mantissa[0] | weight.mantissa[1] | weight.mantissa[2]) == 0)
        return 0;
    if (weight.exponent > EXPONENT_MAX_RGB9E5)
        ++*overflow;
    encode_words(ray, options, code, &weight, words);
    return 1;
}

void co_ray_decode_shading(const uint32_t *words, uint32_t options, CoRay *out)
{
    memset(out, 0, sizeof *out);
    out->kind = words[4] >> 30;
    out->depth = (words[3] >> 26) | (words[4] >> 26 & 15u) << 6;
    out->flags = words[8] >> 24;
    if (out->kind == CO_RAY_LIGHT) {
        out->weight = weight_decode(words[5], words[6] >> 24, out->kind);
        out->emitter = co_ray_emitter(words);
    } else {
        out->weight = weight_decode(words[5], out->flags >> 7, out->kind);
        out->flags &= EXPONENT_FLAG - 1;
    }
    out->path = words[7];
    out->branch = words[8] & 255u;
    out->width = step_decode(words[8] >> 8 & 255u);
    out->spread = step_decode(words[8] >> 16 & 255u);
    uint32_t next = CO_RAY_WORDS;
    if (options & CO_RAY_OPTION_TNEAR)
        out->tnear = bits_float(words[next++]);
    if (options & CO_RAY_OPTION_EXTRA)
        out->extra = words[next];
}

void co_ray_decode(const uint32_t *words, uint32_t options, CoRay *out)
{
    co_ray_decode_shading(words, options, out);
    out->org = co_vec3(bits_float(words[0]), bits_float(words[1]), bits_float(words[2]));
    out->dir = co_ray_decode_direction(words);
    out->code[0] = (words[3] & 0x3ffffffu) + 1;
    out->code[1] = (words[4] & 0x3ffffffu) + 1;
    if (out->kind == CO_RAY_LIGHT)
        return;
    out->pdf = pdf_decode(words[6] & 0xffffu);
    out->normal = normal_decode(words[6] >> 16);
}
