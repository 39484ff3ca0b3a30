// Records to rays, and what becomes of a direction, pdf or normal on the way through a record. What
// each word holds stands in ray_parts.h.
#include "rays/ray_queue.h"

#include "rays/octahedral.h"
#include "rays/ray_parts.h"

static bool is_same(CoVec3 a, CoVec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static int32_t clamp_code(int32_t x, int32_t max)
{
    return x > max ? max : x < -max ? -max : x;
}

// A decoded direction must encode to itself: shading evaluates with the quantized direction before
// it stores the ray. Rounding to float moves a grid point by less than one step (0.8 at most), so
// the code that decodes to v, if there is one, is the nearest or a neighbor of it.
static bool direction_encode(CoVec3 v, CoOct *out)
{
    if (!co_oct_nearest(v, CO_DIRECTION_MAX, out))
        return false;
    CoOct nearest = *out;
    if (is_same(co_oct_decode(nearest, CO_DIRECTION_MAX), v))
        return true;
    float length2 = co_dot(v, v);
    if (!(fabsf(length2 - 1.0f) < 1e-6f)) // no decoded direction is that far from unit length
        return true;
    for (int32_t i = 0; i < 9; i++) {
        CoOct code = {clamp_code(nearest.x + i % 3 - 1, CO_DIRECTION_MAX),
                      clamp_code(nearest.y + i / 3 - 1, CO_DIRECTION_MAX)};
        if (is_same(co_oct_decode(code, CO_DIRECTION_MAX), v)) {
            *out = code;
            break;
        }
    }
    return true;
}

void co_ray_find_direction_code(CoVec3 dir, uint32_t code[2])
{
    CoOct found;
    bool has_direction = direction_encode(dir, &found);
    code[0] = has_direction ? (uint32_t)(found.x + CO_DIRECTION_MAX + 1) : 0;
    code[1] = has_direction ? (uint32_t)(found.y + CO_DIRECTION_MAX + 1) : 0;
}

static CoOct direction_code(const uint32_t *words)
{
    CoOct code = {(int32_t)(words[3] & CO_DIRECTION_MASK) - CO_DIRECTION_MAX,
                  (int32_t)(words[4] & CO_DIRECTION_MASK) - CO_DIRECTION_MAX};
    return code;
}

CoVec3 co_ray_decode_direction(const uint32_t *words)
{
    return co_oct_decode(direction_code(words), CO_DIRECTION_MAX);
}

static CoVec3 normal_decode(uint32_t bits)
{
    CoOct code = {(int32_t)(bits & 255u) - CO_NORMAL_MAX,
                  (int32_t)(bits >> 8 & 255u) - CO_NORMAL_MAX};
    return co_oct_decode(code, CO_NORMAL_MAX);
}

CoVec3 co_ray_snap_normal(CoVec3 n, uint32_t *code)
{
    *code = co_ray_find_normal_code(n);
    return normal_decode(*code);
}

float co_ray_quantize_pdf(float pdf)
{
    return co_pdf_decode(co_pdf_encode(pdf));
}

static float step_decode(uint32_t code)
{
    static const float quarters[4] = {1.0f, 1.18920711500272f, 1.41421356237310f,
                                      1.68179283050743f};
    if (code == 0)
        return 0.0f;
    uint32_t octave = code / 4 + 127 - CO_STEP_ORIGIN / 4;
    return quarters[code % 4] * co_float_from_bits(octave << 23);
}

static CoVec3 weight_decode(uint32_t word, uint32_t high_bits, uint32_t kind)
{
    int exponent = (int)(word >> 27 | high_bits << 5) - co_exponent_bias(kind);
    double scale =
        co_power_of_two(exponent > CO_EXPONENT_MAX_LIGHT ? CO_EXPONENT_MAX_LIGHT : exponent);
    return co_vec3((float)((word & 511u) * scale), (float)((word >> 9 & 511u) * scale),
                   (float)((word >> 18 & 511u) * scale));
}

void co_ray_decode_shading(const uint32_t *words, uint32_t options, CoRay *out)
{
    memset(out, 0, sizeof *out);
    out->org = co_vec3(co_float_from_bits(words[0]), co_float_from_bits(words[1]),
                       co_float_from_bits(words[2]));
    out->kind = words[4] >> 30;
    out->depth = (words[3] >> 26) | (words[4] >> 26 & 15u) << 6;
    out->flags = words[8] >> 24;
    if (out->kind == CO_RAY_LIGHT) {
        out->weight = weight_decode(words[5], words[6] >> 24, out->kind);
        out->emitter = co_ray_emitter(words);
    } else {
        out->weight = weight_decode(words[5], out->flags >> 7, out->kind);
        out->flags &= CO_EXPONENT_FLAG - 1;
    }
    out->path = words[7];
    out->branch = words[8] & 255u;
    out->width = step_decode(words[8] >> 8 & 255u);
    out->spread = step_decode(words[8] >> 16 & 255u);
    uint32_t next = CO_RAY_WORDS;
    if (options & CO_RAY_OPTION_TNEAR)
        out->tnear = co_float_from_bits(words[next++]);
    if (options & CO_RAY_OPTION_EXTRA)
        out->extra = words[next];
}

void co_ray_decode(const uint32_t *words, uint32_t options, CoRay *out)
{
    co_ray_decode_shading(words, options, out);
    out->dir = co_ray_decode_direction(words);
    out->code[0] = (words[3] & CO_DIRECTION_MASK) + 1;
    out->code[1] = (words[4] & CO_DIRECTION_MASK) + 1;
    if (out->kind == CO_RAY_LIGHT)
        return;
    out->pdf = co_pdf_decode(words[6] & 0xffffu);
    out->normal_code = words[6] >> 16 | CO_NORMAL_CODE;
    out->normal = normal_decode(out->normal_code);
}
