#include "rays/ray_bounds.h"

#include <math.h>
#include <string.h>

enum {
    LANES = 4, // an origin and the word behind it: one vector, whatever the processor
    PART = 256 // records whose origins are looked at one by one if one of them is odd
};

CoRayBounds co_ray_bounds_none(void)
{
    return (CoRayBounds){co_vec3_splat(INFINITY), co_vec3_splat(-INFINITY), 0};
}

typedef struct Lanes {
    float low[LANES], high[LANES];
    float left[LANES]; // of what is taken from itself: nothing, but where it is not finite
} Lanes;

static inline void add_lanes(Lanes *lanes, const uint32_t *words)
{
    float v[LANES];
    memcpy(v, words, sizeof v);
    for (int k = 0; k < LANES; k++) {
        lanes->low[k] = co_min(v[k], lanes->low[k]);
        lanes->high[k] = co_max(v[k], lanes->high[k]);
        lanes->left[k] += v[k] - v[k];
    }
}

static inline void join_lanes(Lanes *lanes, const Lanes *other)
{
    for (int k = 0; k < LANES; k++) {
        lanes->low[k] = co_min(other->low[k], lanes->low[k]);
        lanes->high[k] = co_max(other->high[k], lanes->high[k]);
        lanes->left[k] += other->left[k];
    }
}

// False if an origin is not finite. Two records at once: each waits for the one before it.
static bool add_finite(CoRayBounds *bounds, const uint32_t *words, size_t count, uint32_t stride)
{
    static const Lanes none = {{INFINITY, INFINITY, INFINITY, INFINITY},
                               {-INFINITY, -INFINITY, -INFINITY, -INFINITY},
                               {0.0f, 0.0f, 0.0f, 0.0f}};
    Lanes lanes = none, others = none;
    const uint32_t *end = words + count / 2 * 2 * stride;
    for (; words < end; words += 2 * stride) {
        add_lanes(&lanes, words);
        add_lanes(&others, words + stride);
    }
    if (count % 2)
        add_lanes(&lanes, words);
    join_lanes(&lanes, &others);
    if (!(lanes.left[0] == 0.0f && lanes.left[1] == 0.0f && lanes.left[2] == 0.0f))
        return false;
    CoRayBounds all = {co_vec3_load(lanes.low), co_vec3_load(lanes.high), 0};
    co_ray_bounds_join(bounds, &all);
    return true;
}

static void add_each(CoRayBounds *bounds, const uint32_t *words, size_t count, uint32_t stride)
{
    for (size_t i = 0; i < count; i++)
        bounds->invalid += !add_finite(bounds, words + i * stride, 1, stride);
}

void co_ray_bounds_add(CoRayBounds *bounds, const uint32_t *words, size_t count, uint32_t stride)
{
    for (size_t i = 0; i < count; i += PART) {
        size_t part = count - i < PART ? count - i : PART;
        if (!add_finite(bounds, words + i * stride, part, stride))
            add_each(bounds, words + i * stride, part, stride);
    }
}

void co_ray_bounds_join(CoRayBounds *bounds, const CoRayBounds *other)
{
    CoVec3 low = bounds->low, high = bounds->high, l = other->low, h = other->high;
    bounds->low = co_vec3(co_min(low.x, l.x), co_min(low.y, l.y), co_min(low.z, l.z));
    bounds->high = co_vec3(co_max(high.x, h.x), co_max(high.y, h.y), co_max(high.z, h.z));
    bounds->invalid += other->invalid;
}
