// GGX microfacets with visible-normal sampling, in the local frame (normal +z).
//
// Sources: Walter et al. 2007 (distribution), Heitz 2014 (height-correlated masking), Dupuy and
// Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps".

#ifndef CO_SHADING_MICROFACET_H
#define CO_SHADING_MICROFACET_H

#include "math/elementary.h"
#include "math/vec.h"

// Density of microfacet normals. Written in the slope of h, which keeps its digits where h.z rounds
// to 1.
static inline float co_ggx_d(CoVec3 h, float alpha)
{
    float z2 = h.z * h.z;
    float slope2 = (h.x * h.x + h.y * h.y) / (alpha * alpha);
    float d = z2 + slope2;
    return 1.0f / (CO_PI * alpha * alpha * d * d);
}

// Smith's Lambda.
static inline float co_ggx_lambda(CoVec3 w, float alpha)
{
    float z2 = w.z * w.z;
    if (!(z2 > 1e-14f))
        return 1e7f * alpha;
    float tan2 = (w.x * w.x + w.y * w.y) / z2;
    return 0.5f * (sqrtf(1.0f + alpha * alpha * tan2) - 1.0f);
}

// The half vector of a reflection, drawn from the normals visible from wo (wo.z > 0).
static inline CoVec3 co_ggx_sample(CoVec3 wo, float alpha, float u0, float u1)
{
    // The hemisphere stretched to unit roughness; there the reflections off it fill a spherical
    // cap.
    CoVec3 v = co_normalize(co_vec3(alpha * wo.x, alpha * wo.y, wo.z));
    float sine, cosine;
    co_sincosf(2.0f * CO_PI * u0, &sine, &cosine);
    float z = (1.0f - u1) * (1.0f + v.z) - v.z;
    float r = sqrtf(co_clamp(1.0f - z * z, 0.0f, 1.0f));
    CoVec3 h = co_add(co_vec3(r * cosine, r * sine, z), v);
    return co_normalize(co_vec3(alpha * h.x, alpha * h.y, co_max(h.z, 1e-9f)));
}

// Value times |cos wi| without Fresnel, and the solid-angle pdf of co_ggx_sample's reflections.
static inline float co_ggx_eval(CoVec3 wo, CoVec3 wi, CoVec3 h, float alpha, float *pdf)
{
    float common = co_ggx_d(h, alpha) / (4.0f * wo.z);
    float lambda_o = co_ggx_lambda(wo, alpha);
    *pdf = common / (1.0f + lambda_o);
    return common / (1.0f + lambda_o + co_ggx_lambda(wi, alpha));
}

#endif
