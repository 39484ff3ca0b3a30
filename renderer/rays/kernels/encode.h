// The fields of a queue to records. Each step runs over all places of the queue, filled or not;
// what each word holds stands in ray_parts.h. To be included by code.c alone.
#include "base/hash.h"
#include "rays/ray_parts.h"

typedef struct Weights {
    uint32_t mantissas[RAYS]; // of three channels, nine bits each
    int32_t exponent[RAYS];   // value = mantissa * 2^exponent
    uint32_t is_valid[RAYS];
} Weights;

// Independent of order: a function of the path, the vertex, the branch and which ray of them it is.
static inline void find_seeds(const CoRayQueue *q, uint64_t seeds[RAYS])
{
    for (uint32_t i = 0; i < RAYS; i++) {
        uint64_t h = co_hash64((uint64_t)q->pixel[i] << 32 | q->sample[i]);
        uint64_t vertex = (uint64_t)q->seed[i] << 32 | q->depth[i] << 2 | q->kind[i];
        uint64_t branch = (uint64_t)q->branch[i] << 32 | q->emitter[i];
        uint64_t x = q->code_x[i] - CO_DIRECTION_MAX - 1, y = q->code_y[i] - CO_DIRECTION_MAX - 1;
        uint64_t direction = (x & UINT32_MAX) << 32 | (y & UINT32_MAX);
        // Odd factors keep what is short from canceling; one round for all of it.
        seeds[i] = co_hash64(h ^ vertex * 0x9e3779b97f4a7c15u ^ branch * 0xd1342543de82ef95u ^
                             direction * 0xaf251af3b0f025b5u);
    }
}

// A float is finite when its exponent bits are not all set.
static inline uint32_t is_finite(float x)
{
    return (co_float_bits(x) & 0x7f800000u) != 0x7f800000u;
}

static inline void find_valid(const CoRayQueue *q, uint32_t is_valid[RAYS])
{
    for (uint32_t i = 0; i < RAYS; i++) {
        float x = q->weight_x[i], y = q->weight_y[i], z = q->weight_z[i];
        int exponent = q->kind[i] == CO_RAY_LIGHT ? CO_EXPONENT_MAX_LIGHT : CO_EXPONENT_MAX;
        float most = CO_MANTISSA_MAX * co_float_from_bits((uint32_t)(exponent + 127) << 23);
        uint32_t has_weight =
            (x >= 0.0f) & (y >= 0.0f) & (z >= 0.0f) & (x <= most) & (y <= most) & (z <= most);
        uint32_t has_origin =
            is_finite(q->org_x[i]) & is_finite(q->org_y[i]) & is_finite(q->org_z[i]);
        is_valid[i] = has_weight & has_origin & (q->code_x[i] != 0) & (q->code_y[i] != 0);
    }
}

// A number of [0, 1) in steps of 2^-53, from a hash: one in [1, 2) with 52 bits, and the last bit.
static inline double unit(uint64_t hash)
{
    uint64_t bits = 0x3ff0000000000000u | hash >> 12, low = 0x3ca0000000000000u & -(hash >> 11 & 1);
    return (co_double_from_bits(bits) - 1.0) + co_double_from_bits(low);
}

static inline uint32_t round_channel(float w, double scale, uint64_t hash)
{
    return (uint32_t)(int32_t)((double)w * scale + unit(hash));
}

// The exponent is the least with max(weight) <= 511 * 2^exponent, so that rounding up never gives
// 512, but not below that of the record's least weight.
static inline void encode_weights(const CoRayQueue *q, const uint64_t seeds[RAYS], Weights *out)
{
    for (uint32_t i = 0; i < RAYS; i++) {
        bool is_valid = out->is_valid[i];
        float x = is_valid ? q->weight_x[i] : 0.0f;
        float y = is_valid ? q->weight_y[i] : 0.0f;
        float z = is_valid ? q->weight_z[i] : 0.0f;
        double max = (double)co_max(co_max(x, y), z);
        int32_t exponent = (int32_t)(co_double_bits(max) >> 52) - 1023 - 8,
                least = -co_exponent_bias(q->kind[i]);
        exponent = exponent < least ? least : exponent;
        exponent += max * co_power_of_two(-exponent) > (double)CO_MANTISSA_MAX;
        double scale = co_power_of_two(-exponent);
        uint32_t mantissas = round_channel(x, scale, co_hash64(seeds[i])) |
                             round_channel(y, scale, co_hash64(seeds[i] + 1)) << 9 |
                             round_channel(z, scale, co_hash64(seeds[i] + 2)) << 18;
        out->mantissas[i] = is_valid ? mantissas : 1 | 1 << 9 | 1 << 18;
        out->exponent[i] = is_valid ? exponent : 0;
    }
}

static inline uint32_t step_encode(float x)
{
    uint32_t bits = co_float_bits(x), mantissa = bits & 0x7fffffu;
    // Mantissas of 2^(1/8), 2^(3/8), 2^(5/8), 2^(7/8): the borders between quarter octaves.
    int32_t quarter = (mantissa > 0x0b95c1u) + (mantissa > 0x25fed6u) + (mantissa > 0x45672au) +
                      (mantissa > 0x6ac0c6u);
    int32_t code = 4 * ((int32_t)(bits >> 23) - 127) + quarter + CO_STEP_ORIGIN;
    code = code < 1 ? 1 : code;
    code = code > 255 ? 255 : code; // infinite ones too
    return x > 0.0f ? (uint32_t)code : 0;
}

// Words 3 to 6 and 8, which are made of parts.
typedef struct Packed {
    uint32_t word3[RAYS], word4[RAYS], word5[RAYS], word6[RAYS], word8[RAYS];
} Packed;

static inline void find_bins(const Packed *packed, uint32_t bin[RAYS])
{
    for (uint32_t i = 0; i < RAYS; i++) {
        CoOct code = {(int32_t)(packed->word3[i] & CO_DIRECTION_MASK) - CO_DIRECTION_MAX,
                      (int32_t)(packed->word4[i] & CO_DIRECTION_MASK) - CO_DIRECTION_MAX};
        bin[i] = co_ray_bin(code);
    }
}

static inline void pack(const CoRayQueue *q, const Weights *weights, Packed *out)
{
    for (uint32_t i = 0; i < RAYS; i++) {
        bool has_direction = (q->code_x[i] != 0) & (q->code_y[i] != 0);
        bool is_light = q->kind[i] == CO_RAY_LIGHT;
        uint32_t x = has_direction ? q->code_x[i] - 1 : CO_DIRECTION_MAX;
        uint32_t y = has_direction ? q->code_y[i] - 1 : CO_DIRECTION_MAX;
        uint32_t depth = q->depth[i] > CO_DEPTH_MAX ? CO_DEPTH_MAX : q->depth[i];
        uint32_t exponent = (uint32_t)(weights->exponent[i] + co_exponent_bias(q->kind[i]));
        uint32_t high = exponent >> 5, flags = q->flags[i] & (CO_EXPONENT_FLAG - 1);
        uint32_t flag = !is_light && high ? CO_EXPONENT_FLAG : 0;
        out->word3[i] = x | (depth & 63u) << 26;
        out->word4[i] = y | (depth >> 6) << 26 | (q->kind[i] & 3u) << 30;
        out->word5[i] = weights->mantissas[i] | exponent << 27;
        out->word6[i] = is_light ? (q->emitter[i] & CO_EMITTER_MAX) | high << 24
                                 : co_pdf_encode(q->pdf[i]) | q->normal_code[i] << 16;
        out->word8[i] = (q->branch[i] & 255u) | step_encode(q->width[i]) << 8 |
                        step_encode(q->spread[i]) << 16 | (flags | flag) << 24;
    }
}

static inline void write_words(const CoRayQueue *q, uint32_t options, const Packed *packed,
                               const uint32_t is_valid[RAYS], CoRayEncoded *out)
{
    uint32_t extra_at = CO_RAY_WORDS + (options & CO_RAY_OPTION_TNEAR ? 1 : 0);
    for (uint32_t i = 0; i < q->count; i++) {
        uint32_t *words = out->words[i], nan = is_valid[i] ? 0 : 0x7fc00000u;
        words[0] = co_float_bits(q->org_x[i]) | nan;
        words[1] = co_float_bits(q->org_y[i]) | nan;
        words[2] = co_float_bits(q->org_z[i]) | nan;
        words[3] = packed->word3[i];
        words[4] = packed->word4[i];
        words[5] = packed->word5[i];
        words[6] = packed->word6[i];
        words[7] = q->path[i];
        words[8] = packed->word8[i];
        words[9] = co_float_bits(q->tnear[i]);
        words[extra_at] = q->extra[i];
    }
}

void CO_LANE_NAME(co_ray_encode)(const CoRayQueue *q, uint32_t options, CoRayEncoded *out)
{
    uint64_t seeds[RAYS];
    Weights weights;
    Packed packed;
    find_seeds(q, seeds);
    find_valid(q, weights.is_valid);
    encode_weights(q, seeds, &weights);
    pack(q, &weights, &packed);
    find_bins(&packed, out->bin);
    write_words(q, options, &packed, weights.is_valid, out);
    out->is_kept = out->has_overflown = 0;
    for (uint32_t i = 0; i < q->count; i++) {
        out->is_kept |= (uint32_t)(weights.mantissas[i] != 0) << i;
        out->has_overflown |= (uint32_t)(weights.exponent[i] > CO_EXPONENT_MAX_RGB9E5) << i;
    }
}
