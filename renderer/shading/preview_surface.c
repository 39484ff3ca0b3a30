// Makers of BSDFs: UsdPreviewSurface's inputs, and Lambertian surfaces.

#include "shading/bsdf_internal.h"

static float unit(float x)
{
    return x > 0.0f ? co_min(x, 1.0f) : 0.0f;
}

static CoVec3 unit3(CoVec3 c)
{
    return co_vec3(unit(c.x), unit(c.y), unit(c.z));
}

// alpha of a roughness input; 0 where the lobe is a mirror.
static float alpha_of(float roughness)
{
    float r = unit(roughness), alpha = r * r;
    return alpha < CO_BSDF_ALPHA_MIN ? 0.0f : alpha;
}

// Reflectance at normal incidence; ior 0 and infinity both reflect everything.
static float reflectance_of(float ior)
{
    if (!(ior >= 0.0f))
        ior = 1.5f;
    float r = ior > 1e18f ? 1.0f : (1.0f - ior) / (1.0f + ior);
    return r * r;
}

void co_bsdf_lambert(CoVec3 albedo, CoVec3 ns, CoVec3 ng, CoVec3 wo, CoBsdf *out)
{
    *out = (CoBsdf){.opacity = 1.0f, .is_lambert = true};
    co_bsdf_set_frame(out, ns, ng, wo);
    out->diffuse = unit3(albedo);
    out->p_diffuse = co_max3(out->diffuse) > 0.0f ? 1.0f : 0.0f;
}

void co_bsdf_preview(const CoPreviewSurface *in, CoVec3 ns, CoVec3 ng, CoVec3 wo, CoBsdf *out)
{
    *out = (CoBsdf){.opacity = 1.0f};
    co_bsdf_set_frame(out, ns, ng, wo);
    CoVec3 diffuse = unit3(in->diffuse_color), white = co_vec3_splat(1.0f);
    float r0 = reflectance_of(in->ior);
    if (in->use_specular_workflow) {
        out->diffuse = diffuse;
        out->f0 = unit3(in->specular_color);
        out->f90 = white;
    } else {
        float metallic = unit(in->metallic);
        CoVec3 tint = co_lerp3(white, diffuse, metallic);
        out->diffuse = co_scale(diffuse, 1.0f - metallic);
        out->f0 = co_lerp3(co_scale(tint, r0), tint, metallic);
        out->f90 = tint;
    }
    out->alpha = alpha_of(in->roughness);
    out->coat = unit(in->clearcoat);
    out->coat_alpha = alpha_of(in->clearcoat_roughness);
    out->coat_f0 = r0;
    bool is_transparent = !in->opacity_presence && !(in->opacity_threshold > 0.0f);
    if (is_transparent)
        out->opacity = unit(in->opacity);
    co_bsdf_set_selection(out, wo);
}
