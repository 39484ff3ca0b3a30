// Materials: from what the scene's user gave to what a hit evaluates.

#include "integrate/material.h"

#include "base/error.h"
#include "math/elementary.h"

#include <string.h>

static CohortInput constant(float a, float b, float c)
{
    CohortInput input = {.kind = COHORT_INPUT_CONSTANT, .value = {a, b, c, 1.0f}};
    return input;
}

CohortMaterialDesc cohort_material_default(void)
{
    CohortMaterialDesc desc = {
        .diffuse_color = constant(0.18f, 0.18f, 0.18f),
        .emissive_color = constant(0.0f, 0.0f, 0.0f),
        .specular_color = constant(0.0f, 0.0f, 0.0f),
        .metallic = constant(0.0f, 0.0f, 0.0f),
        .roughness = constant(0.5f, 0.0f, 0.0f),
        .clearcoat = constant(0.0f, 0.0f, 0.0f),
        .clearcoat_roughness = constant(0.01f, 0.0f, 0.0f),
        .opacity = constant(1.0f, 0.0f, 0.0f),
        .ior = constant(1.5f, 0.0f, 0.0f),
        .normal = constant(0.0f, 0.0f, 1.0f),
        .displacement = constant(0.0f, 0.0f, 0.0f),
    };
    return desc;
}

uint32_t cohort_scene_new_material(CohortScene *scene, CohortError *err)
{
    if (!co_scene_grow((void **)&scene->materials, &scene->material_capacity, scene->material_count,
                       sizeof(CoMaterial))) {
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for a material");
        return COHORT_INVALID_ID;
    }
    memset(&scene->materials[scene->material_count], 0, sizeof(CoMaterial));
    scene->materials[scene->material_count].arena.tag = CO_MEMORY_SCENE;
    return scene->material_count++;
}

static bool compile_input(CoMaterial *material, const CohortMaterialDesc *desc,
                          const CohortInput *input, CoInputSource *out, CohortError *err)
{
    out->kind = input->kind;
    memcpy(out->value, input->value, sizeof out->value);
    if (input->kind == COHORT_INPUT_PRIMVAR) {
        CO_CHECK(input->primvar, err, COHORT_ERROR_ARGUMENT, "%s: a primvar input needs a name",
                 desc->path ? desc->path : "material");
        out->primvar = co_arena_string(&material->arena, input->primvar, strlen(input->primvar));
        CO_CHECK_MEMORY(out->primvar, err);
    }
    if (input->kind == COHORT_INPUT_TEXTURE) {
        CO_CHECK(input->lookup < desc->lookup_count && input->channel < 4, err,
                 COHORT_ERROR_ARGUMENT, "%s: an input names lookup %u of %zu",
                 desc->path ? desc->path : "material", input->lookup, desc->lookup_count);
        out->lookup = input->lookup;
        out->channel = input->channel;
    }
    return true;
}

static bool is_all_zero(const float *v, int count)
{
    for (int i = 0; i < count; i++)
        if (v[i] != 0.0f)
            return false;
    return true;
}

static bool compile_lookup(const CohortScene *scene, CoMaterial *material,
                           const CohortLookupDesc *desc, CoLookupSource *out, CohortError *err)
{
    CO_CHECK(desc->texture < scene->texture_count, err, COHORT_ERROR_ARGUMENT,
             "a lookup names texture %u of %u", desc->texture, scene->texture_count);
    out->texture = desc->texture;
    out->is_ptex = scene->texture_descs[desc->texture].is_ptex;
    const char *st = desc->st_primvar ? desc->st_primvar : "st";
    out->st_primvar = co_arena_string(&material->arena, st, strlen(st));
    CO_CHECK_MEMORY(out->st_primvar, err);
    memcpy(out->st_fallback, desc->st_fallback, sizeof out->st_fallback);
    bool unscaled = is_all_zero(desc->st_scale, 2);
    float sx = unscaled ? 1.0f : desc->st_scale[0], sy = unscaled ? 1.0f : desc->st_scale[1];
    float sn, cs;
    co_sincosf(desc->st_rotation_degrees * (CO_PI / 180.0f), &sn, &cs);
    float m[2][3] = {{cs * sx, -sn * sy, desc->st_translation[0]},
                     {sn * sx, cs * sy, desc->st_translation[1]}};
    memcpy(out->m, m, sizeof m);
    for (int i = 0; i < 4; i++)
        out->scale[i] = is_all_zero(desc->scale, 4) ? 1.0f : desc->scale[i];
    memcpy(out->bias, desc->bias, sizeof out->bias);
    return true;
}

// A lookup that only displacement makes is no concern of hits, if it is the last.
static uint32_t count_hit_lookups(const CoMaterial *m, size_t count)
{
    bool is_last = count > 0 && m->displacement.kind == COHORT_INPUT_TEXTURE &&
                   m->displacement.lookup == count - 1;
    for (int i = 0; i < CO_INPUT_COUNT; i++)
        is_last = is_last &&
                  !(m->inputs[i].kind == COHORT_INPUT_TEXTURE && m->inputs[i].lookup == count - 1);
    return (uint32_t)count - is_last;
}

static bool compile_material(const CohortScene *scene, const CohortMaterialDesc *desc,
                             CoMaterial *m, CohortError *err)
{
    const CohortInput *inputs[CO_INPUT_COUNT] = {
        &desc->diffuse_color, &desc->emissive_color, &desc->specular_color,      &desc->metallic,
        &desc->roughness,     &desc->clearcoat,      &desc->clearcoat_roughness, &desc->opacity,
        &desc->ior,           &desc->normal};
    CO_CHECK(desc->lookup_count <= CO_MATERIAL_LOOKUPS_MAX, err, COHORT_ERROR_LIMIT,
             "%s: %zu texture nodes in one material; %d are supported",
             desc->path ? desc->path : "material", desc->lookup_count, CO_MATERIAL_LOOKUPS_MAX);
    for (int i = 0; i < CO_INPUT_COUNT; i++)
        if (!compile_input(m, desc, inputs[i], &m->inputs[i], err))
            return false;
    if (!compile_input(m, desc, &desc->displacement, &m->displacement, err))
        return false;
    for (size_t i = 0; i < desc->lookup_count; i++) {
        if (!compile_lookup(scene, m, &desc->lookups[i], &m->lookups[i], err))
            return false;
        m->reads_ptex = m->reads_ptex || m->lookups[i].is_ptex;
    }
    m->lookup_count = count_hit_lookups(m, desc->lookup_count);
    m->is_lambert = desc->lambert;
    m->use_specular_workflow = desc->use_specular_workflow;
    m->opacity_presence = desc->opacity_presence;
    m->opacity_threshold = desc->opacity_threshold;
    const CoInputSource *opacity = &m->inputs[CO_INPUT_OPACITY];
    m->may_pass = opacity->kind != COHORT_INPUT_CONSTANT || opacity->value[0] < 1.0f;
    m->has_normal = m->inputs[CO_INPUT_NORMAL].kind != COHORT_INPUT_CONSTANT;
    m->displaces =
        m->displacement.kind != COHORT_INPUT_CONSTANT || m->displacement.value[0] != 0.0f;
    m->is_set = true;
    return true;
}

bool cohort_scene_set_material(CohortScene *scene, uint32_t material,
                               const CohortMaterialDesc *desc, CohortError *err)
{
    CO_CHECK(material < scene->material_count, err, COHORT_ERROR_ARGUMENT,
             "there is no material %u in this scene", material);
    CoMaterial fresh = {.arena = {.tag = CO_MEMORY_SCENE}};
    if (!compile_material(scene, desc, &fresh, err)) {
        co_arena_clear(&fresh.arena);
        return false;
    }
    co_arena_clear(&scene->materials[material].arena);
    scene->materials[material] = fresh;
    scene->is_committed = false;
    scene->counts.material_builds++;
    return true;
}

// Half the footprint's diameter on the surface, brought into texture coordinates along dpds and
// across. m: 2x3 texture transform, row-major.
static void footprint(const CoTexCoord *tc, float width, const float *m, CoLookup *out)
{
    float e = co_dot(tc->dpds, tc->dpds), f = co_dot(tc->dpds, tc->dpdt),
          g = co_dot(tc->dpdt, tc->dpdt);
    float det = e * g - f * f;
    if (!(det > 0.0f) || !(width > 0.0f))
        return;
    float inv = 1.0f / det;
    CoVec3 grad_s = co_scale(co_sub(co_scale(tc->dpds, g), co_scale(tc->dpdt, f)), inv);
    CoVec3 grad_t = co_scale(co_sub(co_scale(tc->dpdt, e), co_scale(tc->dpds, f)), inv);
    CoVec3 a = co_normalize(tc->dpds);
    CoVec3 b = co_normalize(co_sub(tc->dpdt, co_scale(a, co_dot(tc->dpdt, a))));
    float as = co_dot(grad_s, a) * width, at = co_dot(grad_t, a) * width;
    float bs = co_dot(grad_s, b) * width, bt = co_dot(grad_t, b) * width;
    out->ds0 = m[0] * as + m[1] * at;
    out->dt0 = m[3] * as + m[4] * at;
    out->ds1 = m[0] * bs + m[1] * bt;
    out->dt1 = m[3] * bs + m[4] * bt;
}

static const float identity[6] = {1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f};

void co_material_lookup(const CohortScene *scene, const CoLookupSource *source, const CoMesh *mesh,
                        uint32_t tri, float u, float v, const CoSurface *surface, float width,
                        CoLookup *out)
{
    memset(out, 0, sizeof *out);
    out->texture = scene->texture_ids[source->texture];
    if (source->is_ptex) {
        CoTexCoord tc = {surface->ptex_u, surface->ptex_v, surface->ptex_dpdu, surface->ptex_dpdv};
        out->face = surface->ptex_face;
        out->s = tc.s;
        out->t = tc.t;
        footprint(&tc, width, identity, out);
        return;
    }
    CoTexCoord tc = {.s = source->st_fallback[0], .t = source->st_fallback[1]};
    int primvar = co_mesh_primvar_find(mesh, source->st_primvar);
    if (primvar >= 0)
        co_mesh_texcoord(mesh, primvar, tri, u, v, &tc);
    out->s = source->m[0][0] * tc.s + source->m[0][1] * tc.t + source->m[0][2];
    out->t = source->m[1][0] * tc.s + source->m[1][1] * tc.t + source->m[1][2];
    footprint(&tc, width, source->m[0], out);
}

static void input_value(const CoInputSource *source, const CoMaterial *material,
                        const CoShadeHit *hit, float out[4])
{
    memcpy(out, source->value, 4 * sizeof(float));
    if (source->kind == COHORT_INPUT_PRIMVAR) {
        int primvar = co_mesh_primvar_find(hit->mesh, source->primvar);
        if (primvar >= 0)
            co_mesh_primvar(hit->mesh, primvar, hit->tri, hit->u, hit->v, out);
    } else if (source->kind == COHORT_INPUT_TEXTURE) {
        const CoLookupSource *lookup = &material->lookups[source->lookup];
        const float *texel = hit->texels[source->lookup];
        for (uint32_t i = 0; i < 4; i++) {
            uint32_t c = source->channel + i < 4 ? source->channel + i : 3;
            out[i] = texel[c] * lookup->scale[c] + lookup->bias[c];
        }
    }
}

static CoVec3 input_color(const CoMaterial *m, CoMaterialInput input, const CoShadeHit *hit)
{
    float value[4];
    input_value(&m->inputs[input], m, hit, value);
    return co_vec3_load(value);
}

// Constants and primvars are linear Rec.709; textures came in the rendering space.
static CoVec3 rendering_color(const CoMaterial *m, CoMaterialInput input, const CoShadeHit *hit)
{
    CoVec3 color = input_color(m, input, hit);
    if (!m->rec709 || m->inputs[input].kind == COHORT_INPUT_TEXTURE)
        return color;
    return co_color_apply(m->rec709, color);
}

static float input_float(const CoMaterial *m, CoMaterialInput input, const CoShadeHit *hit)
{
    float value[4];
    input_value(&m->inputs[input], m, hit, value);
    return value[0];
}

void co_material_evaluate(const CoMaterial *m, const CoShadeHit *hit, CoPreviewSurface *out)
{
    out->diffuse_color = rendering_color(m, CO_INPUT_DIFFUSE, hit);
    out->emissive_color = rendering_color(m, CO_INPUT_EMISSIVE, hit);
    out->specular_color = rendering_color(m, CO_INPUT_SPECULAR, hit);
    out->metallic = input_float(m, CO_INPUT_METALLIC, hit);
    out->roughness = input_float(m, CO_INPUT_ROUGHNESS, hit);
    out->clearcoat = input_float(m, CO_INPUT_CLEARCOAT, hit);
    out->clearcoat_roughness = input_float(m, CO_INPUT_CLEARCOAT_ROUGHNESS, hit);
    out->opacity = input_float(m, CO_INPUT_OPACITY, hit);
    out->ior = input_float(m, CO_INPUT_IOR, hit);
    out->opacity_threshold = m->opacity_threshold;
    out->use_specular_workflow = m->use_specular_workflow;
    out->opacity_presence = m->opacity_presence;
}

float co_material_opacity(const CoMaterial *m, const CoShadeHit *hit)
{
    return input_float(m, CO_INPUT_OPACITY, hit);
}

bool co_material_normal(const CoMaterial *m, const CoShadeHit *hit, CoVec3 *n_tangent,
                        CoTexCoord *frame)
{
    if (!m->has_normal)
        return false;
    *n_tangent = input_color(m, CO_INPUT_NORMAL, hit);
    const CoInputSource *source = &m->inputs[CO_INPUT_NORMAL];
    const char *st = "st";
    if (source->kind == COHORT_INPUT_TEXTURE) {
        const CoLookupSource *lookup = &m->lookups[source->lookup];
        if (lookup->is_ptex) {
            frame->dpds = hit->surface.ptex_dpdu;
            frame->dpdt = hit->surface.ptex_dpdv;
            return true;
        }
        st = lookup->st_primvar;
    }
    int primvar = co_mesh_primvar_find(hit->mesh, st);
    if (primvar < 0)
        return false;
    co_mesh_texcoord(hit->mesh, primvar, hit->tri, hit->u, hit->v, frame);
    return true;
}
