// Evaluation and sampling of the lobes together.

#include "math/warp.h"
#include "shading/albedo_table.h"
#include "shading/bsdf_internal.h"
#include "shading/microfacet.h"

static float mean3(CoVec3 v)
{
    return (v.x + v.y + v.z) * (1.0f / 3.0f);
}

// (1 - cosine)^5
static float schlick(float cosine)
{
    float m = co_clamp(1.0f - cosine, 0.0f, 1.0f), m2 = m * m;
    return m2 * m2 * m;
}

static CoVec3 fresnel(const CoBsdf *bsdf, float weight)
{
    return co_lerp3(bsdf->f0, bsdf->f90, weight);
}

// Between the nodes of a table over roughness and cosine, both in [0, 1].
static float between(const float table[ALBEDO_NODES][ALBEDO_NODES], float roughness, float cosine)
{
    float x = co_clamp(cosine, 0.0f, 1.0f) * (ALBEDO_NODES - 1);
    float y = co_clamp(roughness, 0.0f, 1.0f) * (ALBEDO_NODES - 1);
    int i = x < ALBEDO_NODES - 2 ? (int)x : ALBEDO_NODES - 2;
    int j = y < ALBEDO_NODES - 2 ? (int)y : ALBEDO_NODES - 2;
    float u = x - (float)i, v = y - (float)j;
    // Off a mirror the albedo falls slowly at first.
    if (j == 0)
        v *= v;
    float low = table[j][i] + (table[j][i + 1] - table[j][i]) * u;
    float high = table[j + 1][i] + (table[j + 1][i + 1] - table[j + 1][i]) * u;
    return low + (high - low) * v;
}

// What the specular lobe reflects of what arrives along wo, over all directions.
static CoVec3 specular_albedo(const CoBsdf *bsdf, float cosine)
{
    if (bsdf->alpha == 0.0f)
        return fresnel(bsdf, schlick(cosine));
    float roughness = sqrtf(bsdf->alpha);
    CoVec3 sum = co_scale(bsdf->f0, between(albedo_f0, roughness, cosine));
    return co_madd(sum, bsdf->f90, between(albedo_f90, roughness, cosine));
}

static float coat_fresnel(const CoBsdf *bsdf, float weight)
{
    return bsdf->coat * (bsdf->coat_f0 + (1.0f - bsdf->coat_f0) * weight);
}

// Most normals come as unit vectors: a root and a division saved.
static CoVec3 unit_vector(CoVec3 v)
{
    return fabsf(co_dot(v, v) - 1.0f) < 4e-7f ? v : co_normalize(v);
}

void co_bsdf_set_frame(CoBsdf *bsdf, CoVec3 ns, CoVec3 ng, CoVec3 wo)
{
    ng = unit_vector(ng);
    ns = unit_vector(ns);
    if (co_dot(ng, ng) < 0.5f)
        ng = co_dot(ns, ns) < 0.5f ? wo : ns;
    if (co_dot(ns, ns) < 0.5f)
        ns = ng;
    if (co_dot(ng, wo) < 0.0f)
        ng = co_neg(ng);
    if (co_dot(ns, ng) < 0.0f)
        ns = co_neg(ns);
    // Seen from behind its shading normal: the nearest normal that just faces wo.
    const float least = 1e-2f;
    float cosine = co_dot(ns, wo);
    if (cosine < least)
        ns = co_normalize(co_madd(ns, wo, least - cosine));
    bsdf->n = ns;
    bsdf->ng = ng;
    co_basis(ns, &bsdf->s, &bsdf->t);
}

CoVec3 co_bsdf_transmittance(const CoBsdf *bsdf, CoVec3 wo)
{
    float weight = schlick(co_dot(bsdf->n, wo));
    CoVec3 f = fresnel(bsdf, weight), r = bsdf->reflected;
    CoVec3 kept =
        co_vec3(1.0f - co_max(f.x, r.x), 1.0f - co_max(f.y, r.y), 1.0f - co_max(f.z, r.z));
    return co_scale(kept, (1.0f - bsdf->opacity) * (1.0f - coat_fresnel(bsdf, weight)));
}

void co_bsdf_set_selection(CoBsdf *bsdf, CoVec3 wo)
{
    float cosine = co_dot(bsdf->n, wo), weight = schlick(cosine);
    bsdf->reflected = specular_albedo(bsdf, cosine);
    float f = mean3(fresnel(bsdf, weight)), reflected = mean3(bsdf->reflected);
    float diffuse = mean3(bsdf->diffuse) * bsdf->opacity * (1.0f - reflected);
    // A floor, lest the rare half vectors that reflect much get weights that explode.
    float specular = co_max(reflected, 0.02f * mean3(bsdf->f90));
    float coat = co_max(coat_fresnel(bsdf, weight), 0.02f * bsdf->coat);
    float through = (1.0f - bsdf->opacity) * (1.0f - f);
    float sum = diffuse + specular + coat + through;
    float scale = sum > 0.0f ? 1.0f / sum : 0.0f;
    bsdf->p_diffuse = diffuse * scale;
    bsdf->p_specular = specular * scale;
    bsdf->p_coat = coat * scale;
    bsdf->p_through = through * scale;
}

bool co_bsdf_has_smooth(const CoBsdf *bsdf)
{
    return bsdf->p_diffuse > 0.0f || (bsdf->p_specular > 0.0f && bsdf->alpha > 0.0f) ||
           (bsdf->p_coat > 0.0f && bsdf->coat_alpha > 0.0f);
}

static CoVec3 eval_lambert(const CoBsdf *bsdf, CoVec3 wo, CoVec3 wi, float *pdf)
{
    float cosine = co_dot(bsdf->n, wi);
    bool is_seen = cosine > 0.0f && co_dot(bsdf->ng, wi) > 0.0f && co_dot(bsdf->n, wo) > 0.0f;
    float cosine_pdf = is_seen ? cosine * CO_INV_PI : 0.0f;
    *pdf = bsdf->p_diffuse * cosine_pdf;
    return co_scale(bsdf->diffuse, cosine_pdf);
}

CoVec3 co_bsdf_eval(const CoBsdf *bsdf, CoVec3 wo, CoVec3 wi, float *pdf)
{
    if (bsdf->is_lambert)
        return eval_lambert(bsdf, wo, wi, pdf);
    *pdf = 0.0f;
    CoVec3 value = co_vec3_splat(0.0f);
    CoVec3 o = co_to_frame(bsdf->s, bsdf->t, bsdf->n, wo);
    CoVec3 i = co_to_frame(bsdf->s, bsdf->t, bsdf->n, wi);
    if (!(o.z > 0.0f) || !(i.z > 0.0f) || !(co_dot(bsdf->ng, wi) > 0.0f))
        return value;
    CoVec3 h = co_normalize(co_add(o, i));
    float weight = schlick(co_dot(o, h));
    CoVec3 f = fresnel(bsdf, weight);

    // At grazing angles the specular lobe takes more from wo than F of a half vector says: without
    // the other bound a white surface would give back almost twice what it receives.
    float cosine_pdf = i.z * CO_INV_PI;
    CoVec3 dimmed =
        co_vec3(1.0f - co_max(f.x, bsdf->reflected.x), 1.0f - co_max(f.y, bsdf->reflected.y),
                1.0f - co_max(f.z, bsdf->reflected.z));
    value = co_scale(co_mul(bsdf->diffuse, dimmed), bsdf->opacity * cosine_pdf);
    *pdf = bsdf->p_diffuse * cosine_pdf;
    float lobe_pdf;
    if (bsdf->alpha > 0.0f && bsdf->p_specular > 0.0f) {
        value = co_madd(value, f, co_ggx_eval(o, i, h, bsdf->alpha, &lobe_pdf));
        *pdf += bsdf->p_specular * lobe_pdf;
    }
    if (bsdf->coat_alpha > 0.0f && bsdf->p_coat > 0.0f) {
        float coat = co_ggx_eval(o, i, h, bsdf->coat_alpha, &lobe_pdf) * coat_fresnel(bsdf, weight);
        value = co_add(value, co_vec3_splat(coat));
        *pdf += bsdf->p_coat * lobe_pdf;
    }
    return value;
}

// Mirror direction of wo about the shading normal; false below the surface.
static bool mirror(const CoBsdf *bsdf, CoVec3 wo, CoVec3 *wi)
{
    CoVec3 n = co_scale(bsdf->n, 2.0f * co_dot(bsdf->n, wo));
    *wi = co_normalize(co_sub(n, wo));
    return co_dot(*wi, bsdf->ng) > 0.0f;
}

// Reflects off a microfacet drawn at this roughness; 0 is a mirror, and *is_delta.
static bool sample_specular(const CoBsdf *bsdf, CoVec3 wo, float alpha, float u0, float u1,
                            CoBsdfSample *out)
{
    out->is_delta = alpha == 0.0f;
    if (out->is_delta)
        return mirror(bsdf, wo, &out->wi);
    CoVec3 o = co_to_frame(bsdf->s, bsdf->t, bsdf->n, wo);
    CoVec3 h = co_ggx_sample(o, alpha, u0, u1);
    CoVec3 i = co_sub(co_scale(h, 2.0f * co_dot(o, h)), o);
    if (!(i.z > 0.0f))
        return false;
    out->wi = co_normalize(co_from_frame(bsdf->s, bsdf->t, bsdf->n, i));
    return co_dot(out->wi, bsdf->ng) > 0.0f;
}

bool co_bsdf_sample(const CoBsdf *bsdf, CoVec3 wo, float uc, float u0, float u1, CoBsdfSample *out)
{
    *out = (CoBsdfSample){0};
    float cosine = co_dot(bsdf->n, wo);
    if (!(cosine > 0.0f))
        return false;
    if (uc < bsdf->p_diffuse) {
        // A unit vector in an orthonormal frame: nothing is gained by normalizing again.
        CoVec3 local = co_warp_cosine(u0, u1);
        out->wi = co_from_frame(bsdf->s, bsdf->t, bsdf->n, local);
        return local.z > 0.0f && co_dot(out->wi, bsdf->ng) > 0.0f;
    }
    float weight = schlick(cosine);
    uc -= bsdf->p_diffuse;
    if (uc < bsdf->p_specular) {
        bool ok = sample_specular(bsdf, wo, bsdf->alpha, u0, u1, out);
        if (out->is_delta)
            out->weight = co_scale(fresnel(bsdf, weight), 1.0f / bsdf->p_specular);
        return ok;
    }
    uc -= bsdf->p_specular;
    if (uc < bsdf->p_coat) {
        bool ok = sample_specular(bsdf, wo, bsdf->coat_alpha, u0, u1, out);
        if (out->is_delta)
            out->weight = co_vec3_splat(coat_fresnel(bsdf, weight) / bsdf->p_coat);
        return ok;
    }
    if (!(bsdf->p_through > 0.0f))
        return false;
    out->wi = co_neg(wo);
    out->weight = co_scale(co_bsdf_transmittance(bsdf, wo), 1.0f / bsdf->p_through);
    out->is_delta = true;
    return true;
}

CoVec3 co_bsdf_albedo(const CoBsdf *bsdf, CoVec3 wo)
{
    CoVec3 f = bsdf->reflected;
    CoVec3 diffuse = co_scale(bsdf->diffuse, bsdf->opacity);
    CoVec3 sum = co_add(f, co_mul(diffuse, co_sub(co_vec3_splat(1.0f), f)));
    sum = co_add(sum, co_vec3_splat(coat_fresnel(bsdf, schlick(co_dot(bsdf->n, wo)))));
    return co_vec3(co_min(sum.x, 1.0f), co_min(sum.y, 1.0f), co_min(sum.z, 1.0f));
}
