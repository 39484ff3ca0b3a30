// Where records begin: bounds of their origins, known as they are written, so that a sort need not
// read them once more.

#ifndef CO_RAYS_RAY_BOUNDS_H
#define CO_RAYS_RAY_BOUNDS_H

#include "math/vec.h"

#include <stddef.h>
#include <stdint.h>

typedef struct CoRayBounds {
    CoVec3 low, high; // of the finite origins; infinite the wrong way round: there are none
    size_t invalid;   // records whose origin is not finite
} CoRayBounds;

// Of no records.
CoRayBounds co_ray_bounds_none(void);

// Adds `count` records of `stride` words, 9 at least. What is added in parts, in whatever order,
// comes to the same values; zeros may differ in sign.
void co_ray_bounds_add(CoRayBounds *bounds, const uint32_t *words, size_t count, uint32_t stride);

// Adds all of the other one's records.
void co_ray_bounds_join(CoRayBounds *bounds, const CoRayBounds *other);

#endif
