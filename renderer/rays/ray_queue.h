// Rays on their way into records: the fields of a few, each field by itself, so that they are
// encoded together.
//
// Source: Eisenacher et al. 2013, 3.1 and figure 3 (the record).

#ifndef CO_RAYS_RAY_QUEUE_H
#define CO_RAYS_RAY_QUEUE_H

#include "rays/ray_parts.h"

enum {
    CO_RAY_QUEUE_RAYS = 32
};

// X(type, name), as in CoRay and CoRayKey; direction and normal are there as codes.
#define CO_RAY_QUEUE_FIELDS(X) \
    X(float, org_x) \
    X(float, org_y) \
    X(float, org_z) \
    X(float, weight_x) \
    X(float, weight_y) \
    X(float, weight_z) \
    X(float, pdf) \
    X(float, width) \
    X(float, spread) \
    X(float, tnear) \
    X(uint32_t, code_x) /* both 0: no direction */ \
    X(uint32_t, code_y) \
    X(uint32_t, normal_code) \
    X(uint32_t, emitter) \
    X(uint32_t, path) \
    X(uint32_t, kind) \
    X(uint32_t, depth) \
    X(uint32_t, branch) \
    X(uint32_t, flags) \
    X(uint32_t, extra) \
    X(uint32_t, pixel) \
    X(uint32_t, sample) \
    X(uint32_t, seed)

// {.count = 0} is empty.
typedef struct CoRayQueue {
#define CO_RAY_QUEUE_MEMBER(type, name) _Alignas(64) type name[CO_RAY_QUEUE_RAYS];
    CO_RAY_QUEUE_FIELDS(CO_RAY_QUEUE_MEMBER)
#undef CO_RAY_QUEUE_MEMBER
    uint32_t count;
} CoRayQueue;

// What becomes of the rays of a queue, in their order.
typedef struct CoRayEncoded {
    uint32_t words[CO_RAY_QUEUE_RAYS][CO_RAY_WORDS_MAX];
    uint32_t bin[CO_RAY_QUEUE_RAYS]; // of co_ray_bin
    uint32_t is_kept;       // bit i: ray i has a record; else the roulette of its weight took it
    uint32_t has_overflown; // bit i: its weight is above RGB9e5's own 65408
} CoRayEncoded;

// Codes of a direction and a normal that come without: for co_ray_queue_add.
void co_ray_find_direction_code(CoVec3 dir, uint32_t code[2]);

static inline uint32_t co_ray_find_normal_code(CoVec3 normal)
{
    CoOct code;
    co_oct_nearest(normal, CO_NORMAL_MAX, &code);
    return (uint32_t)(code.x + CO_NORMAL_MAX) | (uint32_t)(code.y + CO_NORMAL_MAX) << 8 |
           CO_NORMAL_CODE;
}

// Puts a ray into a queue that is not full. True if it is full then.
static inline bool co_ray_queue_add(CoRayQueue *queue, const CoRay *ray, CoRayKey key)
{
    uint32_t i = queue->count++, code[2] = {ray->code[0], ray->code[1]};
    if (!code[0] || !code[1])
        co_ray_find_direction_code(ray->dir, code);
    queue->org_x[i] = ray->org.x;
    queue->org_y[i] = ray->org.y;
    queue->org_z[i] = ray->org.z;
    queue->weight_x[i] = ray->weight.x;
    queue->weight_y[i] = ray->weight.y;
    queue->weight_z[i] = ray->weight.z;
    queue->pdf[i] = ray->pdf;
    queue->width[i] = ray->width;
    queue->spread[i] = ray->spread;
    queue->tnear[i] = ray->tnear;
    queue->code_x[i] = code[0];
    queue->code_y[i] = code[1];
    queue->normal_code[i] =
        ray->normal_code ? ray->normal_code : co_ray_find_normal_code(ray->normal);
    queue->emitter[i] = ray->emitter;
    queue->path[i] = ray->path;
    queue->kind[i] = ray->kind;
    queue->depth[i] = ray->depth;
    queue->branch[i] = ray->branch;
    queue->flags[i] = ray->flags;
    queue->extra[i] = ray->extra;
    queue->pixel[i] = key.pixel;
    queue->sample[i] = key.sample;
    queue->seed[i] = key.seed;
    return queue->count == CO_RAY_QUEUE_RAYS;
}

#endif
