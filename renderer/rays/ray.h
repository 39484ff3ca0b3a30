// Rays: the 36-byte record on disk and the field arrays of an active batch.
//
// Source: Eisenacher et al. 2013, 3.1 and figure 3; layout in ray_parts.h.

#ifndef CO_RAYS_RAY_H
#define CO_RAYS_RAY_H

#include "math/vec.h"
#include "rays/octahedral.h"

#include <stddef.h>
#include <stdint.h>

// Who made a ray.
typedef enum CoRayKind {
    CO_RAY_CAMERA = 0,
    CO_RAY_BSDF = 1,
    CO_RAY_LIGHT = 2 // towards a sampled point on an emitter; only visibility matters
} CoRayKind;

// Bits of CoRay.flags; the record keeps 7 of them (the eighth is an exponent bit of the weight).
enum {
    CO_RAY_FROM_SPLIT = 1, // left the vertex where the path split (sample counts n differ there)
    CO_RAY_HAS_SPLIT = 2,  // the path has passed its split vertex (this or an earlier one)
    CO_RAY_PASSED = 8,     // has passed through a cut-out; t_min counts
    CO_RAY_TIED = 16 // times how many cut-outs at one distance it has passed while others there are
                     // left, up to CO_RAY_TIED_MOST; t_min is just before them
};
enum {
    CO_RAY_TIED_MOST = 7
};

// One ray, decoded. Every consumer works on decoded values only.
typedef struct CoRay {
    CoVec3 org;       // render frame
    CoVec3 dir;       // unit to 1.1e-7
    float tnear;      // 0 unless the ray has passed a cut-out
    CoVec3 weight;    // path throughput; for light rays times f cos / pdf and the MIS weight
    float pdf;        // BSDF ray: solid-angle pdf; INFINITY = delta; 0 = no light sample was taken
    CoVec3 normal;    // BSDF ray: normal of the vertex it left, quantized
    uint32_t emitter; // light ray: which
    uint32_t path;    // pixel * samples of the round + sample in round
    uint32_t kind, depth; // CoRayKind; segment number, the camera's is 1
    uint32_t branch;      // which BSDF ray of the split this path follows
    float width, spread;  // footprint: width at the origin (scene units), growth per unit length
    uint32_t flags;
    uint32_t extra;   // index into the scene's interned table (optional word)
    uint32_t code[2]; // of dir, from co_ray_snap_direction or a decode; 0 = to be found from dir
    uint32_t normal_code; // of normal, from co_ray_snap_normal or a decode; 0 = to be found
} CoRay;

// Word layout of a record; 9 words, then optional ones in this order.
enum {
    CO_DIRECTION_MAX = (1 << 25) - 1, // of the grid that directions are on
    CO_RAY_WORDS = 9,
    CO_RAY_WORDS_MAX = 11,
    CO_RAY_OPTION_TNEAR = 1, // + 1 word: scenes with cut-outs
    CO_RAY_OPTION_EXTRA = 2  // + 1 word: scenes with linking
};

// Keys of the stochastic rounding of a weight: pure functions of the path, never of order.
typedef struct CoRayKey {
    uint32_t pixel, sample, seed; // sample = absolute index
} CoRayKey;

// Returns the number of words per record for these options: 9, 10 or 11.
static inline uint32_t co_ray_words(uint32_t options)
{
    return CO_RAY_WORDS + (options & 1u) + ((options >> 1) & 1u);
}

// Decodes one record; fields that it does not hold are 0.
void co_ray_decode(const uint32_t *words, uint32_t options, CoRay *out);

// Only the kind of a record.
static inline uint32_t co_ray_kind(const uint32_t *words)
{
    return words[4] >> 30;
}

// Only the path of a record.
static inline uint32_t co_ray_path(const uint32_t *words)
{
    return words[7];
}

// How many cut-outs at one distance a record has passed, see CO_RAY_TIED.
static inline uint32_t co_ray_ties(const uint32_t *words)
{
    return words[8] >> 28 & CO_RAY_TIED_MOST;
}

// Only the emitter of a light ray's record.
static inline uint32_t co_ray_emitter(const uint32_t *words)
{
    return words[6] & 0xffffffu;
}

// Only the direction of a record.
CoVec3 co_ray_decode_direction(const uint32_t *words);

// What shading asks of a record: all but the direction, pdf and normal; *out has zeros there.
void co_ray_decode_shading(const uint32_t *words, uint32_t options, CoRay *out);

// What a pdf, direction or normal becomes after a trip through the record. A vertex evaluates with
// these, so that both sides of multiple importance sampling see the same numbers.
float co_ray_quantize_pdf(float pdf);

// The code of the decoded direction next to `dir`, for CoRay.code, which saves the encoder the
// search for it. 0: no direction.
static inline CoOct co_ray_nearest_code(CoVec3 dir, uint32_t code[2])
{
    CoOct nearest;
    bool has_direction = co_oct_nearest(dir, CO_DIRECTION_MAX, &nearest);
    code[0] = has_direction ? (uint32_t)(nearest.x + CO_DIRECTION_MAX + 1) : 0;
    code[1] = has_direction ? (uint32_t)(nearest.y + CO_DIRECTION_MAX + 1) : 0;
    return nearest;
}

// The same, and the direction, which is what shading evaluates with.
static inline CoVec3 co_ray_snap_direction(CoVec3 dir, uint32_t code[2])
{
    return co_oct_decode(co_ray_nearest_code(dir, code), CO_DIRECTION_MAX);
}

// The same of a normal, with its code for CoRay.normal_code.
CoVec3 co_ray_snap_normal(CoVec3 n, uint32_t *code);

// Which of the six bins a direction of the grid is of: +x, -x, +y, -y, +z, -z of its largest
// component. Without branches: nobody could guess them.
static inline uint32_t co_ray_bin(CoOct code)
{
    int32_t v[3];
    co_oct_unfold(code, CO_DIRECTION_MAX, v);
    int32_t x = abs(v[0]), y = abs(v[1]), z = abs(v[2]);
    uint32_t is_x = (uint32_t)(x >= y) & (uint32_t)(x >= z), is_z = (is_x ^ 1u) & (uint32_t)(z > y);
    int32_t major = is_x ? v[0] : is_z ? v[2] : v[1];
    return (is_x ? 0u : is_z ? 4u : 2u) + (uint32_t)(major < 0);
}

// Field arrays of an active batch, in sort order: X(type, name). All 64-byte aligned, padded to 64.
// tfar: where the ray ends (camera: far clip; light: its emitter; else infinity).
// record: index of the record in the batch, so that the rest can be decoded when needed.
#define CO_RAY_FIELDS(X) \
    X(float, org_x) \
    X(float, org_y) \
    X(float, org_z) \
    X(float, dir_x) \
    X(float, dir_y) \
    X(float, dir_z) \
    X(float, tnear) \
    X(float, tfar) \
    X(uint32_t, record)

typedef struct CoRayBatch {
#define CO_RAY_MEMBER(type, name) type *name;
    CO_RAY_FIELDS(CO_RAY_MEMBER)
#undef CO_RAY_MEMBER
    size_t count, capacity;
} CoRayBatch;

// Hits of a batch, same order as the rays. t = INFINITY: no hit (or, for occlusion rays, not
// blocked).
#define CO_HIT_FIELDS(X) \
    X(float, t) \
    X(float, u) \
    X(float, v) \
    X(uint32_t, instance) /* instance path id, see accel/accel.h */ \
    X(uint32_t, tri)      /* triangle of the mesh, in face order */

typedef struct CoHitBatch {
#define CO_HIT_MEMBER(type, name) type *name;
    CO_HIT_FIELDS(CO_HIT_MEMBER)
#undef CO_HIT_MEMBER
    size_t count, capacity;
} CoHitBatch;

#endif
