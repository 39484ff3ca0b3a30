// Surface scattering: one BSDF per hit, made from a material and its texture values.
//
// Words are pbrt's: wo and wi point away from the surface, f is the BSDF value, eta relative index.
// Directions are in the render frame. A surface is two-sided: normals turn to the side of wo, and
// where wo is above ng but below ns, ns is bent until it sees wo. Light that would leak through ng
// is zero. Pure functions: any thread, no state.

#ifndef CO_SHADING_BSDF_H
#define CO_SHADING_BSDF_H

#include "cohort/scene.h"
#include "math/vec.h"

// GGX roughness below which a lobe is a perfect mirror (roughness 0.0316): narrower than a pixel,
// and too narrow for float32 directions.
#define CO_BSDF_ALPHA_MIN 1e-3f

// Values of a material's inputs at a hit: constants, primvars and textures resolved. Colors but the
// emissive one, metallic, both roughnesses, clearcoat and opacity are clamped to [0, 1]; what is
// not a number counts as 0. An ior that is negative or not a number counts as 1.5.
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
    CoVec3 reflected; // directional albedo of the specular lobe at wo
    float alpha;      // GGX roughness of the specular lobe; 0 = delta
    float coat;       // weight of the clearcoat
    float coat_alpha, coat_f0;
    float opacity; // of the diffuse part; the rest goes straight through
    float p_diffuse, p_specular, p_coat, p_through; // lobe selection, sum 1, or all 0: absorbs all
    bool is_lambert;                                // nothing but the diffuse lobe, opaque
} CoBsdf;

// Lambertian with this albedo.
void co_bsdf_lambert(CoVec3 albedo, CoVec3 ns, CoVec3 ng, CoVec3 wo, CoBsdf *out);

// UsdPreviewSurface (specification 2.x): GGX with F between F0 and F90 (Schlick 1994) at the half
// vector; Lambert dimmed by 1 - F, or by what the specular lobe takes from wo over all directions
// where that is more, so that both together reflect no more than they receive (this makes the
// diffuse part, and only it, depend on which way light runs); white clearcoat, added on top without
// dimming, as specified. Presence and threshold are decided before there is a BSDF: opacity then
// counts as 1. In transparent mode the diffuse part is scaled by opacity and (1 - opacity)(1 - F)
// goes straight through.
void co_bsdf_preview(const CoPreviewSurface *in, CoVec3 ns, CoVec3 ng, CoVec3 wo, CoBsdf *out);

// Whether any lobe is not a delta: only then do light samples make sense.
bool co_bsdf_has_smooth(const CoBsdf *bsdf);

// Returns f * |cos| for a pair of directions and the solid-angle pdf with which co_bsdf_sample
// makes wi, over all smooth lobes; delta lobes count as 0.
CoVec3 co_bsdf_eval(const CoBsdf *bsdf, CoVec3 wo, CoVec3 wi, float *pdf);

typedef struct CoBsdfSample {
    CoVec3 wi;
    CoVec3 weight; // delta: f |cos| / pdf; smooth: 0, use co_bsdf_eval with the decoded direction
    bool is_delta;
} CoBsdfSample;

// Draws a direction: uc picks the lobe, (u0, u1) the direction. False: absorbed.
bool co_bsdf_sample(const CoBsdf *bsdf, CoVec3 wo, float uc, float u0, float u1, CoBsdfSample *out);

// What goes straight through (opacityMode transparent): what the lobes above do not reflect of
// 1 - opacity, per channel.
CoVec3 co_bsdf_transmittance(const CoBsdf *bsdf, CoVec3 wo);

// Hemispherical reflectance estimate of the surface for the albedo AOV.
CoVec3 co_bsdf_albedo(const CoBsdf *bsdf, CoVec3 wo);

#endif
