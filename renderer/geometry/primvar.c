// Primvars: checked, copied, and evaluated at a hit.

#include "geometry/grid.h"
#include "geometry/mesh_internal.h"

#include <string.h>

uint32_t co_primvar_element_count(const CoMeshBuild *build, CohortInterpolation interpolation)
{
    switch (interpolation) {
    case COHORT_INTERPOLATION_CONSTANT:
        return 1;
    case COHORT_INTERPOLATION_UNIFORM:
        return (uint32_t)build->desc->face_count;
    case COHORT_INTERPOLATION_VARYING:
    case COHORT_INTERPOLATION_VERTEX:
        return (uint32_t)build->desc->point_count;
    case COHORT_INTERPOLATION_FACE_VARYING:
        return (uint32_t)build->desc->face_vertex_index_count;
    }
    return 0;
}

static CoPrimvarKind primvar_kind(CohortInterpolation interpolation)
{
    switch (interpolation) {
    case COHORT_INTERPOLATION_CONSTANT:
        return CO_PRIMVAR_CONSTANT;
    case COHORT_INTERPOLATION_UNIFORM:
        return CO_PRIMVAR_UNIFORM;
    case COHORT_INTERPOLATION_VARYING:
    case COHORT_INTERPOLATION_VERTEX:
        return CO_PRIMVAR_POINT;
    case COHORT_INTERPOLATION_FACE_VARYING:
        return CO_PRIMVAR_CORNER;
    }
    return CO_PRIMVAR_CONSTANT;
}

// True when the primvar can be used; else it is warned about by name.
static bool primvar_is_usable(CoMeshBuild *build, const CohortPrimvarDesc *p)
{
    size_t want = co_primvar_element_count(build, p->interpolation);
    if (p->components < 1 || p->components > 4 || p->value_count > INT32_MAX ||
        (!p->values && p->value_count > 0) || (unsigned)p->interpolation > 4) {
        co_mesh_warn(build, "primvar %.64s is malformed and ignored", p->name);
        return false;
    }
    size_t have = p->indices ? p->index_count : p->value_count;
    if (have != want || (p->value_count == 0 && want > 0)) {
        co_mesh_warn(build, "primvar %.64s has %zu %s where %zu are needed: ignored", p->name,
                     have != want ? have : p->value_count,
                     p->indices && have != want ? "indices" : "values", want);
        return false;
    }
    for (size_t k = 0; p->indices && k < p->index_count; k++) {
        if (p->indices[k] < 0 || (size_t)p->indices[k] >= p->value_count) {
            co_mesh_warn(build, "primvar %.64s: index %d is out of its %zu values: ignored",
                         p->name, p->indices[k], p->value_count);
            return false;
        }
    }
    return true;
}

static bool is_wanted(const CoMeshBuild *build, const CohortPrimvarDesc *p)
{
    if (!p->name || !p->name[0])
        return false;
    return build->desc->scheme == COHORT_SCHEME_NONE || strcmp(p->name, "normals") != 0;
}

bool co_mesh_check_primvars(CoMeshBuild *build)
{
    const CohortMeshDesc *desc = build->desc;
    CoPrimvar *kept = co_mesh_keep(build, desc->primvar_count, sizeof *kept);
    build->sources = co_mesh_scratch(build, desc->primvar_count, sizeof *build->sources);
    CO_MESH_CHECK_MEMORY(build, kept);
    CO_MESH_CHECK_MEMORY(build, build->sources);
    uint32_t count = 0;
    for (size_t k = 0; k < desc->primvar_count; k++) {
        const CohortPrimvarDesc *p = &desc->primvars[k];
        if (!is_wanted(build, p) || !primvar_is_usable(build, p))
            continue;
        size_t length = strlen(p->name);
        char *name = co_mesh_keep(build, length + 1, 1);
        CO_MESH_CHECK_MEMORY(build, name);
        memcpy(name, p->name, length);
        kept[count] = (CoPrimvar){
            .name = name, .kind = primvar_kind(p->interpolation), .components = p->components};
        build->sources[count] = (CoPrimvarSource){.desc = p, .primvar = &kept[count]};
        count++;
    }
    build->source_count = count;
    build->shading->primvars = kept;
    build->shading->primvar_count = count;
    return true;
}

// Copies values, with 0 in place of what is not finite: a NaN must not reach texture coordinates.
static bool copy_values(CoMeshBuild *build, const CoPrimvarSource *source)
{
    const CohortPrimvarDesc *p = source->desc;
    size_t count = p->value_count * p->components; // both below 2^31 and 5
    float *values = co_mesh_keep(build, count, sizeof *values);
    CO_MESH_CHECK_MEMORY(build, values);
    size_t broken = 0;
    for (size_t k = 0; k < count; k++) {
        bool finite = isfinite(p->values[k]);
        values[k] = finite ? p->values[k] : 0.0f;
        broken += !finite;
    }
    if (broken)
        co_mesh_warn(build, "primvar %.64s: %zu NaN or infinite values are taken as 0", p->name,
                     broken);
    source->primvar->values = values;
    if (!p->indices)
        return true;
    uint32_t *indices = co_mesh_keep(build, p->index_count, sizeof *indices);
    CO_MESH_CHECK_MEMORY(build, indices);
    memcpy(indices, p->indices, p->index_count * sizeof *indices);
    source->primvar->indices = indices;
    return true;
}

bool co_mesh_copy_primvars(CoMeshBuild *build)
{
    bool refined = build->desc->scheme != COHORT_SCHEME_NONE;
    for (uint32_t k = 0; k < build->source_count; k++) {
        const CoPrimvarSource *source = &build->sources[k];
        bool by_face = source->primvar->kind <= CO_PRIMVAR_UNIFORM;
        if ((by_face || !refined) && !copy_values(build, source))
            return false;
    }
    return true;
}

int co_mesh_primvar_find(const CoMesh *mesh, const char *name)
{
    for (uint32_t k = 0; k < mesh->shading->primvar_count; k++)
        if (strcmp(mesh->shading->primvars[k].name, name) == 0)
            return (int)k;
    return -1;
}

static const float *element_value(const CoPrimvar *p, uint32_t element)
{
    size_t value = p->indices ? p->indices[element] : element;
    return p->values + value * p->components;
}

// The three corners' values of a primvar that varies over a triangle.
static void corner_values(const CoMesh *mesh, const CoPrimvar *p, uint32_t tri,
                          const float *value[3])
{
    if (p->kind == CO_PRIMVAR_POINT) {
        uint32_t point[3];
        co_mesh_triangle(mesh, tri, point);
        for (int c = 0; c < 3; c++)
            value[c] = element_value(p, point[c]);
        return;
    }
    CoGridPlace place = co_grid_place(mesh->shading, tri);
    for (int c = 0; c < 3; c++)
        value[c] = element_value(p, co_grid_corner(mesh->shading, &place, tri, c));
}

void co_primvar_eval(const CoMesh *mesh, const CoPrimvar *primvar, uint32_t tri, float u, float v,
                     float *out)
{
    if (primvar->kind <= CO_PRIMVAR_UNIFORM) {
        bool uniform = primvar->kind == CO_PRIMVAR_UNIFORM;
        uint32_t element = uniform ? co_grid_face(mesh->shading, tri) : 0;
        memcpy(out, element_value(primvar, element), primvar->components * sizeof *out);
        return;
    }
    const float *value[3];
    corner_values(mesh, primvar, tri, value);
    float w = 1.0f - u - v;
    for (uint32_t k = 0; k < primvar->components; k++)
        out[k] = w * value[0][k] + u * value[1][k] + v * value[2][k];
}

void co_mesh_primvar(const CoMesh *mesh, int primvar, uint32_t tri, float u, float v, float out[4])
{
    out[0] = out[1] = out[2] = 0.0f;
    out[3] = 1.0f;
    if (primvar >= 0 && (uint32_t)primvar < mesh->shading->primvar_count)
        co_primvar_eval(mesh, &mesh->shading->primvars[primvar], tri, u, v, out);
}

// dp/ds and dp/dt of the affine map that takes three points to three texture coordinates.
static void texcoord_derivatives(const CoVec3 p[3], const float *st[3], CoTexCoord *out)
{
    CoVec3 e1 = co_sub(p[1], p[0]), e2 = co_sub(p[2], p[0]);
    float s1 = st[1][0] - st[0][0], t1 = st[1][1] - st[0][1];
    float s2 = st[2][0] - st[0][0], t2 = st[2][1] - st[0][1];
    float inverse = 1.0f / (s1 * t2 - s2 * t1);
    CoVec3 dpds = co_scale(co_sub(co_scale(e1, t2), co_scale(e2, t1)), inverse);
    CoVec3 dpdt = co_scale(co_sub(co_scale(e2, s1), co_scale(e1, s2)), inverse);
    if (!co_is_finite3(dpds) || !co_is_finite3(dpdt))
        return;
    out->dpds = dpds;
    out->dpdt = dpdt;
}

void co_mesh_texcoord(const CoMesh *mesh, int primvar, uint32_t tri, float u, float v,
                      CoTexCoord *out)
{
    float value[4];
    co_mesh_primvar(mesh, primvar, tri, u, v, value);
    *out = (CoTexCoord){.s = value[0], .t = value[1]};
    if (primvar < 0 || (uint32_t)primvar >= mesh->shading->primvar_count)
        return;
    const CoPrimvar *source = &mesh->shading->primvars[primvar];
    if (source->kind <= CO_PRIMVAR_UNIFORM || source->components < 2)
        return;
    const float *st[3];
    corner_values(mesh, source, tri, st);
    uint32_t point[3];
    CoVec3 p[3];
    co_mesh_triangle(mesh, tri, point);
    for (int c = 0; c < 3; c++)
        p[c] = co_vec3_load(mesh->points + 3 * (size_t)point[c]);
    texcoord_derivatives(p, st, out);
}
