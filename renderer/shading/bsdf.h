// Surface scattering: one BSDF per hit, made from a material and its texture values.
//
// Words are pbrt's: wo and wi point away from the surface, f is the BSDF value, eta relative index.
// Everything returned already honours reciprocity breaking by shading normals: directions are in the
// render frame, cosines are absolute, and light leaking through ng is zero.

#ifndef CO_SHADING_BSDF_H
#define CO_SHADING_BSDF_H

#include "cohort/scene.h"
#include "math/vec.h"

// Values of a material's inputs at a hit: constants, primvars and textures resolved.
typedef struct CoPreviewSurface {
    CoVec3 diffuse_color, emissive_color, specular_color;
    float metallic, roughness, clearcoat, clearcoat_roughness, opacity, opacity_threshold, ior;
    bool use_specular_workflow, opacity_presence;
} CoPreviewSurface;

typedef struct CoBsdf {
    CoVec3 s, t, n; // shading frame, n on the side of wo
    CoVec3 ng;      // geometric normal, on the side of wo
    CoVec3 diffuse; // albedo of the Lambertian part, dimming by Fresnel aside
    CoVec3 f0, f90;
    float alpha;      // GGX roughness of the specular lobe; 0 = delta
    float coat;       // weight of the clearcoat
    float coat_alpha, coat_f0;
    float opacity;    // of the diffuse part; the rest goes straight through
    float p_diffuse, p_specular, p_coat, p_through; // lobe selection probabilities, sum 1 (or all 0)
} CoBsdf;

// Lambertian with this albedo.
void co_bsdf_lambert(CoVec3 albedo, CoVec3 ns, CoVec3 ng, CoVec3 wo, CoBsdf *out);

// UsdPreviewSurface (field definitions of its specification, version 2.x).
void co_bsdf_preview(const CoPreviewSurface *in, CoVec3 ns, CoVec3 ng, CoVec3 wo, CoBsdf *out);

// Whether any lobe is not a delta: only then do light samples make sense.
bool co_bsdf_has_smooth(const CoBsdf *bsdf);

// Returns f * |cos| for a pair of directions and the solid-angle pdf with which co_bsdf_sample makes
// wi, over all smooth lobes; delta lobes count as 0.
CoVec3 co_bsdf_eval(const CoBsdf *bsdf, CoVec3 wo, CoVec3 wi, float *pdf);

typedef struct CoBsdfSample {
    CoVec3 wi;
    CoVec3 weight;  // delta: f |cos| / pdf; smooth: 0, use co_bsdf_eval with the decoded direction
    bool is_delta;
    bool is_through; // straight through: keeps the ray's footprint
} CoBsdfSample;

// Draws a direction: uc picks the lobe, (u0, u1) the direction. False: absorbed.
bool co_bsdf_sample(const CoBsdf *bsdf, CoVec3 wo, float uc, float u0, float u1, CoBsdfSample *out);

// Hemispherical reflectance estimate of the surface for the albedo AOV.
CoVec3 co_bsdf_albedo(const CoBsdf *bsdf, CoVec3 wo);

#endif
