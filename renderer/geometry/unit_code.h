// Unit vectors in 32 bits: the octahedral map (Meyer et al. 2010), 16 bits an axis, within 7e-5
// radians. Made of steps that are the same bits everywhere.

#ifndef CO_GEOMETRY_UNIT_CODE_H
#define CO_GEOMETRY_UNIT_CODE_H

#include "math/vec.h"

#define CO_UNIT_HALF 32767.0f    // codes run from 0 to twice this
#define CO_UNIT_NONE 0xffffffffu // the zero vector
// No vectors: marks of those who keep codes. Above all codes of vectors but the zero one.
#define CO_UNIT_DERIVED 0xfffffffeu // follows from points
#define CO_UNIT_SHARED 0xfffffffdu  // is somebody else's

static inline uint32_t co_unit_encode(CoVec3 v)
{
    float sum = fabsf(v.x) + fabsf(v.y) + fabsf(v.z);
    if (!(sum > 0.0f && sum < INFINITY))
        return CO_UNIT_NONE;
    float x = v.x / sum, y = v.y / sum;
    if (v.z < 0.0f) {
        float folded = copysignf(1.0f - fabsf(y), x);
        y = copysignf(1.0f - fabsf(x), y);
        x = folded;
    }
    uint32_t a = (uint32_t)(x * CO_UNIT_HALF + (CO_UNIT_HALF + 0.5f));
    uint32_t b = (uint32_t)(y * CO_UNIT_HALF + (CO_UNIT_HALF + 0.5f));
    return a | b << 16;
}

static inline CoVec3 co_unit_decode(uint32_t code)
{
    if (code == CO_UNIT_NONE)
        return co_vec3_splat(0.0f);
    float x = ((float)(code & 0xffffu) - CO_UNIT_HALF) / CO_UNIT_HALF;
    float y = ((float)(code >> 16) - CO_UNIT_HALF) / CO_UNIT_HALF;
    float z = 1.0f - fabsf(x) - fabsf(y);
    if (z < 0.0f) {
        float folded = copysignf(1.0f - fabsf(y), x);
        y = copysignf(1.0f - fabsf(x), y);
        x = folded;
    }
    return co_normalize(co_vec3(x, y, z));
}

#endif
