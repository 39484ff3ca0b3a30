// Maps from the unit square to disks, hemispheres and cones, all area-preserving and continuous
// enough to keep the stratification of their input.

#ifndef CO_MATH_WARP_H
#define CO_MATH_WARP_H

#include "math/elementary.h"
#include "math/vec.h"

// Uniform over the unit disk by concentric squares (Shirley, Chiu 1997).
static inline void co_warp_disk(float u0, float u1, float *x, float *y)
{
    float a = 2.0f * u0 - 1.0f, b = 2.0f * u1 - 1.0f;
    float radius = fabsf(a) > fabsf(b) ? a : b;
    if (radius == 0.0f) {
        *x = *y = 0.0f;
        return;
    }
    bool is_wide = fabsf(a) > fabsf(b);
    float ratio = is_wide ? b / a : a / b;
    double sine, cosine;
    co_sincos_eighth_d((double)(0.25f * CO_PI * ratio), &sine, &cosine);
    *x = radius * (float)(is_wide ? cosine : sine);
    *y = radius * (float)(is_wide ? sine : cosine);
}

// Density cos / pi over the hemisphere around +z.
static inline CoVec3 co_warp_cosine(float u0, float u1)
{
    float x, y;
    co_warp_disk(u0, u1, &x, &y);
    return co_vec3(x, y, sqrtf(co_max(0.0f, 1.0f - (x * x + y * y))));
}

// Uniform over the cone around +z with 1 - cos(half angle) = `versine` in [0, 2]: the versine,
// because it keeps its digits where the cosine rounds to 1.
static inline CoVec3 co_warp_cone(float versine, float u0, float u1)
{
    float x, y;
    co_warp_disk(u0, u1, &x, &y);
    float r2 = x * x + y * y;
    float h = versine * r2; // 1 - cos(theta)
    float scale = sqrtf(co_max(0.0f, versine * (2.0f - h)));
    return co_vec3(x * scale, y * scale, 1.0f - h);
}

// World vector of a local one in the frame (s, t, n).
static inline CoVec3 co_from_frame(CoVec3 s, CoVec3 t, CoVec3 n, CoVec3 v)
{
    return co_vec3(s.x * v.x + t.x * v.y + n.x * v.z, s.y * v.x + t.y * v.y + n.y * v.z,
                   s.z * v.x + t.z * v.y + n.z * v.z);
}

static inline CoVec3 co_to_frame(CoVec3 s, CoVec3 t, CoVec3 n, CoVec3 v)
{
    return co_vec3(co_dot(s, v), co_dot(t, v), co_dot(n, v));
}

#endif
