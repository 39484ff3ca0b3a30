// Unit vectors on a grid of integers by the octahedral map (Meyer et al. 2010).
//
// Everything here is without branches that depend on the vector: half of all directions are in the
// folded half, no one knows which. Inline, since a struct of three floats that goes in or out of a
// function by value waits for the stores that it was put together with.

#ifndef CO_RAYS_OCTAHEDRAL_H
#define CO_RAYS_OCTAHEDRAL_H

#include "math/bits.h"
#include "math/vec.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

typedef struct CoOct {
    int32_t x, y; // [-max, max]; symmetric, so that 0 and the axes are exact
} CoOct;

// x with the sign of `like`, for x >= 0.
static inline int32_t co_oct_with_sign(int32_t x, int32_t like)
{
    int32_t mask = like >> 31;
    return (x ^ mask) - mask;
}

// The vector of a point, as long as the sum of its parts is max.
static inline void co_oct_unfold(CoOct code, int32_t max, int32_t out[3])
{
    int32_t ax = abs(code.x), ay = abs(code.y), z = max - ax - ay;
    int32_t fold = z & z >> 31; // what |x| and |y| have too much where z < 0
    out[0] = co_oct_with_sign(ax + fold, code.x);
    out[1] = co_oct_with_sign(ay + fold, code.y);
    out[2] = z;
}

// The unit vector of a point. The squared length is an integer below 2^52, so the only roundings
// are the root, the quotient and the last one to float.
static inline CoVec3 co_oct_decode(CoOct code, int32_t max)
{
    int32_t v[3];
    co_oct_unfold(code, max, v);
    double dx = v[0], dy = v[1], dz = v[2];
    double inv = 1.0 / sqrt(dx * dx + dy * dy + dz * dz);
    return co_vec3((float)(dx * inv), (float)(dy * inv), (float)(dz * inv));
}

static inline int32_t co_oct_sign_bits(float x)
{
    return (int32_t)co_float_bits(x);
}

// Nearest point of the grid. False, and the +z axis, for vectors that are zero or not finite.
static inline bool co_oct_nearest(CoVec3 v, int32_t max, CoOct *out)
{
    double x = fabs((double)v.x), y = fabs((double)v.y), sum = x + y + fabs((double)v.z);
    *out = (CoOct){0, 0};
    if (!(sum > 0.0 && sum <= DBL_MAX))
        return false;
    // Positive, so that truncation rounds to the nearest; the quotient never passes max by half.
    double scale = max / sum;
    int32_t ax = (int32_t)(x * scale + 0.5), ay = (int32_t)(y * scale + 0.5);
    int32_t fold = -(int32_t)(v.z < 0.0f) & (max - ax - ay);
    out->x = co_oct_with_sign(ax + fold, co_oct_sign_bits(v.x));
    out->y = co_oct_with_sign(ay + fold, co_oct_sign_bits(v.y));
    return true;
}

#endif
