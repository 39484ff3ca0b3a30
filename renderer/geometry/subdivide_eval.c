// Limit values at tessellated points: each face visits the points it owns, and, for face-local
// values, every point of its own grid. Faces run in parallel; they write different points.

#include "base/parallel.h"
#include "geometry/grid.h"
#include "geometry/subdivide.h"
#include "geometry/unit_code.h"

#include <string.h>

#define BATCH 128u

typedef struct Worker Worker;
typedef bool FlushFn(Worker *worker);

struct Worker {
    CoSubdivision *s;
    CoOsdSurface *surface;
    CohortError err;
    // The attribute being evaluated.
    uint32_t face;
    FlushFn *flush;
    uint32_t components;
    float *values;                 // written at target * components
    const CohortPrimvarDesc *desc; // varying primvars
    float center[4];               // of those: average over the face
    uint32_t *normals;             // with positions, or alone; NULL: none
    CoVec3 box_lo, box_hi;         // of the positions
    bool is_finite;
    // Points waiting for evaluation.
    uint32_t count;
    CoOsdCoord coords[BATCH];
    uint32_t targets[BATCH];
};

static bool flush(Worker *w)
{
    if (w->count == 0)
        return true;
    bool ok = w->flush(w);
    w->count = 0;
    return ok;
}

static bool visit(Worker *w, uint32_t target, uint32_t sub, float u, float v)
{
    w->coords[w->count] = (CoOsdCoord){.sub = sub, .u = u, .v = v};
    w->targets[w->count++] = target;
    return w->count < BATCH || flush(w);
}

// Coordinates of point i of 2^level on edge k of a face.
static CoOsdCoord edge_coord(const CoSubdivision *s, uint32_t face, uint32_t k, uint32_t level,
                             uint32_t i)
{
    uint32_t n = 1u << level;
    float t = (float)i / (float)n, r = (float)(n - i) / (float)n;
    if (co_subdivision_is_split(s, face)) {
        if (2 * i <= n)
            return (CoOsdCoord){k, 2.0f * t, 0.0f};
        return (CoOsdCoord){(k + 1) % (uint32_t)s->counts[face], 0.0f, 2.0f * r};
    }
    if (s->grid == CO_GRID_TRIANGLE)
        return k == 0   ? (CoOsdCoord){0, t, 0.0f}
               : k == 1 ? (CoOsdCoord){0, r, t}
                        : (CoOsdCoord){0, 0.0f, r};
    switch (k) {
    case 0:
        return (CoOsdCoord){0, t, 0.0f};
    case 1:
        return (CoOsdCoord){0, 1.0f, t};
    case 2:
        return (CoOsdCoord){0, r, 1.0f};
    default:
        return (CoOsdCoord){0, 0.0f, r};
    }
}

static bool visit_owned_boundary(Worker *w)
{
    const CoSubdivision *s = w->s;
    const int32_t *edges = co_osd_face_edges(s->osd, w->face);
    for (uint32_t k = 0; k < (uint32_t)s->counts[w->face]; k++) {
        uint32_t vertex = (uint32_t)s->indices[s->first[w->face] + k];
        uint32_t level = co_subdivision_edge_level(s, (uint32_t)edges[k]);
        CoOsdCoord c = edge_coord(s, w->face, k, level, 0);
        if (s->vertex_owner[vertex] == w->face && !visit(w, vertex, c.sub, c.u, c.v))
            return false;
        if (s->edge_owner[edges[k]] != w->face)
            continue;
        for (uint32_t i = 1; i < 1u << level; i++) {
            uint32_t point = co_subdivision_face_edge_point(s, w->face, k, i);
            c = edge_coord(s, w->face, k, level, i);
            if (!visit(w, point, c.sub, c.u, c.v))
                return false;
        }
    }
    return true;
}

// The points inside a face, in the order in which subdivide.c numbers them.
static bool visit_inner(Worker *w)
{
    const CoSubdivision *s = w->s;
    uint32_t point = s->face_point[w->face], n = 1u << co_subdivision_face_level(s, w->face);
    if (s->grid == CO_GRID_TRIANGLE || !co_subdivision_is_split(s, w->face)) {
        for (uint32_t j = 1; j < n; j++) {
            uint32_t end = s->grid == CO_GRID_TRIANGLE ? n - j : n;
            for (uint32_t i = 1; i < end; i++)
                if (!visit(w, point++, 0, (float)i / (float)n, (float)j / (float)n))
                    return false;
        }
        return true;
    }
    uint32_t m = n / 2, valence = (uint32_t)s->counts[w->face];
    if (!visit(w, point++, 0, 1.0f, 1.0f))
        return false;
    for (uint32_t k = 0; k < valence; k++)
        for (uint32_t j = 1; j < m; j++)
            if (!visit(w, point++, k, 1.0f, (float)j / (float)m))
                return false;
    for (uint32_t k = 0; k < valence; k++)
        for (uint32_t j = 1; j < m; j++)
            for (uint32_t i = 1; i < m; i++)
                if (!visit(w, point++, k, (float)i / (float)m, (float)j / (float)m))
                    return false;
    return true;
}

static bool visit_owned(Worker *w)
{
    return visit_owned_boundary(w) && visit_inner(w) && flush(w);
}

// Every corner element of a face, in the order of grid.h.
static bool visit_corners(Worker *w)
{
    const CoSubdivision *s = w->s;
    uint32_t element = s->corner_first[co_subdivision_cage_face(s, w->face)];
    bool split = co_subdivision_is_split(s, w->face);
    uint32_t side = 1u << co_subdivision_face_level(s, w->face);
    uint32_t subs = split ? (uint32_t)s->counts[w->face] : 1, n = split ? side / 2 : side;
    for (uint32_t k = 0; k < subs; k++) {
        for (uint32_t j = 0; j <= n; j++) {
            uint32_t end = s->grid == CO_GRID_TRIANGLE ? n - j : n;
            for (uint32_t i = 0; i <= end; i++) {
                float scale = n > 0 ? 1.0f / (float)n : 0.0f;
                if (!visit(w, element++, k, (float)i * scale, (float)j * scale))
                    return false;
            }
        }
    }
    if (split && n == 0 && !visit(w, element, 0, 1.0f, 1.0f))
        return false;
    return flush(w);
}

static void store_normals(Worker *w, const float *du, const float *dv)
{
    for (uint32_t k = 0; k < w->count; k++) {
        CoVec3 n = co_cross(co_normalize(co_vec3_load(du + 3 * k)),
                            co_normalize(co_vec3_load(dv + 3 * k)));
        w->normals[w->targets[k]] = co_unit_encode(n);
    }
}

static void extend_box(Worker *w, const float *points)
{
    for (uint32_t k = 0; k < w->count; k++) {
        CoVec3 p = co_vec3_load(points + 3 * k);
        w->is_finite = w->is_finite && co_is_finite3(p);
        w->box_lo =
            co_vec3(co_min(w->box_lo.x, p.x), co_min(w->box_lo.y, p.y), co_min(w->box_lo.z, p.z));
        w->box_hi =
            co_vec3(co_max(w->box_hi.x, p.x), co_max(w->box_hi.y, p.y), co_max(w->box_hi.z, p.z));
    }
}

static bool flush_limit(Worker *w)
{
    float p[4 * BATCH], du[4 * BATCH], dv[4 * BATCH];
    bool with_normals = w->normals != NULL;
    if (!co_osd_surface_eval(w->surface, w->coords, w->count, p, with_normals ? du : NULL,
                             with_normals ? dv : NULL, &w->err))
        return false;
    if (with_normals)
        store_normals(w, du, dv);
    if (w->values == w->s->points)
        extend_box(w, p);
    for (uint32_t k = 0; w->values && k < w->count; k++)
        memcpy(w->values + (size_t)w->targets[k] * w->components, p + k * w->components,
               w->components * sizeof *p);
    return true;
}

// Value of a varying primvar at vertex k of the face.
static const float *varying_value(const Worker *w, uint32_t k)
{
    const CoSubdivision *s = w->s;
    size_t vertex = (size_t)s->indices[s->first[w->face] + k];
    return w->desc->values + co_primvar_desc_value(w->desc, vertex) * w->components;
}

static void find_varying_center(Worker *w)
{
    uint32_t valence = (uint32_t)w->s->counts[w->face];
    for (uint32_t c = 0; c < w->components; c++) {
        float sum = 0.0f;
        for (uint32_t k = 0; k < valence; k++)
            sum += varying_value(w, k)[c];
        w->center[c] = sum / (float)valence;
    }
}

// Corner values of a face or sub-quad, component c, as coordinates run: (0,0) (1,0) (1,1) (0,1).
static void varying_corners(const Worker *w, uint32_t sub, uint32_t c, float out[4])
{
    uint32_t valence = (uint32_t)w->s->counts[w->face];
    if (!co_subdivision_is_split(w->s, w->face)) {
        for (uint32_t k = 0; k < valence; k++)
            out[k] = varying_value(w, k)[c];
        return;
    }
    float own = varying_value(w, sub)[c];
    out[0] = own;
    out[1] = 0.5f * (own + varying_value(w, (sub + 1) % valence)[c]);
    out[2] = w->center[c];
    out[3] = 0.5f * (own + varying_value(w, (sub + valence - 1) % valence)[c]);
}

// Varying data is linear in the cage's faces whatever the scheme.
static bool flush_varying(Worker *w)
{
    bool triangle = w->s->grid == CO_GRID_TRIANGLE;
    for (uint32_t c = 0; c < w->components; c++) {
        float corner[4] = {0};
        uint32_t sub = UINT32_MAX;
        for (uint32_t k = 0; k < w->count; k++) {
            float u = w->coords[k].u, v = w->coords[k].v;
            if (w->coords[k].sub != sub)
                varying_corners(w, w->coords[k].sub, c, corner);
            sub = w->coords[k].sub;
            float value = triangle ? corner[0] * (1 - u - v) + corner[1] * u + corner[2] * v
                                   : (corner[0] * (1 - u) + corner[1] * u) * (1 - v) +
                                         (corner[3] * (1 - u) + corner[2] * u) * v;
            w->values[(size_t)w->targets[k] * w->components + c] = value;
        }
    }
    return true;
}

static bool eval_points(Worker *w)
{
    const CoSubdivision *s = w->s;
    bool seams = s->has_normal_seams;
    w->flush = flush_limit;
    w->components = 3;
    w->values = s->points;
    w->normals = seams ? NULL : s->normals;
    if (!co_osd_surface_begin(w->surface, w->face, -1, &w->err) ||
        !co_osd_surface_values(w->surface, s->build->desc->points, 3, NULL, &w->err) ||
        !visit_owned(w))
        return false;
    if (!seams || !s->normals)
        return true;
    w->values = NULL;
    w->normals = s->normals;
    return visit_corners(w);
}

static bool eval_point_primvar(Worker *w, const CoPrimvarSource *source)
{
    const CohortPrimvarDesc *p = source->desc;
    w->desc = p;
    w->components = p->components;
    w->normals = NULL;
    w->values = source->refined;
    bool varying = p->interpolation == COHORT_INTERPOLATION_VARYING;
    w->flush = varying ? flush_varying : flush_limit;
    if (varying)
        find_varying_center(w);
    else if (!co_osd_surface_values(w->surface, source->control, p->components, NULL, &w->err))
        return false;
    return visit_owned(w);
}

static bool eval_corner_primvar(Worker *w, const CoPrimvarSource *source, int32_t channel)
{
    w->components = source->desc->components;
    w->normals = NULL;
    w->values = source->refined;
    w->flush = flush_limit;
    return co_osd_surface_begin(w->surface, w->face, channel, &w->err) &&
           co_osd_surface_values(w->surface, source->desc->values, source->desc->components, NULL,
                                 &w->err) &&
           visit_corners(w);
}

static bool eval_face(Worker *w)
{
    const CoMeshBuild *build = w->s->build;
    if (!eval_points(w))
        return false;
    // First what shares the vertex surface, then the channels.
    for (uint32_t k = 0; k < build->source_count; k++)
        if (build->sources[k].primvar->kind == CO_PRIMVAR_POINT &&
            !eval_point_primvar(w, &build->sources[k]))
            return false;
    int32_t channel = 0;
    for (uint32_t k = 0; k < build->source_count; k++)
        if (build->sources[k].primvar->kind == CO_PRIMVAR_CORNER &&
            !eval_corner_primvar(w, &build->sources[k], channel++))
            return false;
    return true;
}

static void eval_faces(void *context, size_t begin, size_t end, uint32_t worker)
{
    Worker *w = (Worker *)context + worker;
    for (uint32_t f = (uint32_t)begin; f < end && w->err.code == COHORT_OK; f++) {
        w->face = f;
        w->count = 0;
        if (w->s->is_live[f])
            eval_face(w);
    }
}

static void join_boxes(CoSubdivision *s, const Worker *workers, size_t count)
{
    s->is_finite = true;
    s->box_lo = co_vec3_splat(INFINITY);
    s->box_hi = co_vec3_splat(-INFINITY);
    for (size_t k = 0; k < count; k++) {
        CoVec3 lo = workers[k].box_lo, hi = workers[k].box_hi;
        s->is_finite = s->is_finite && workers[k].is_finite;
        s->box_lo = co_vec3(co_min(s->box_lo.x, lo.x), co_min(s->box_lo.y, lo.y),
                            co_min(s->box_lo.z, lo.z));
        s->box_hi = co_vec3(co_max(s->box_hi.x, hi.x), co_max(s->box_hi.y, hi.y),
                            co_max(s->box_hi.z, hi.z));
    }
}

static bool run(CoSubdivision *s)
{
    CoMeshBuild *build = s->build;
    size_t worker_count = co_worker_count();
    Worker *workers = co_mesh_scratch(build, worker_count, sizeof *workers);
    CO_MESH_CHECK_MEMORY(build, workers);
    CohortError err = {0};
    for (size_t k = 0; k < worker_count; k++) {
        workers[k].s = s;
        workers[k].is_finite = true;
        workers[k].box_lo = co_vec3_splat(INFINITY);
        workers[k].box_hi = co_vec3_splat(-INFINITY);
        workers[k].surface = co_osd_surface_create(s->osd, &err);
    }
    if (err.code == COHORT_OK)
        co_parallel_for(s->face_count, 16, eval_faces, workers);
    for (size_t k = 0; k < worker_count; k++) {
        co_osd_surface_destroy(workers[k].surface);
        if (err.code == COHORT_OK)
            err = workers[k].err;
    }
    join_boxes(s, workers, worker_count);
    CO_MESH_CHECK(build, err.code == COHORT_OK, err.code, "%s", err.message);
    return true;
}

// Vertex values in the order of points: OpenSubdiv knows no indices there.
static bool expand_vertex_values(CoMeshBuild *build, CoPrimvarSource *source)
{
    const CohortPrimvarDesc *p = source->desc;
    source->control = p->values;
    if (!p->indices || p->interpolation != COHORT_INTERPOLATION_VERTEX)
        return true;
    float *values =
        co_mesh_scratch(build, build->desc->point_count * p->components, sizeof *values);
    CO_MESH_CHECK_MEMORY(build, values);
    for (size_t k = 0; k < build->desc->point_count; k++)
        memcpy(values + k * p->components, p->values + co_primvar_desc_value(p, k) * p->components,
               p->components * sizeof *values);
    source->control = values;
    return true;
}

static bool allocate_values(CoSubdivision *s)
{
    CoMeshBuild *build = s->build;
    CoMeshShading *shading = build->shading;
    // One more, for kernels read points as four floats.
    s->points = co_mesh_keep(build, s->point_count + (size_t)1, 3 * sizeof *s->points);
    CO_MESH_CHECK_MEMORY(build, s->points);
    if (!shading->is_bilinear) {
        s->normals = s->has_normal_seams
                         ? co_mesh_scratch(build, s->corner_count, sizeof *s->normals)
                         : co_mesh_keep(build, s->point_count, sizeof *s->normals);
        CO_MESH_CHECK_MEMORY(build, s->normals);
        shading->limit_normals = s->normals;
    }
    for (uint32_t k = 0; k < build->source_count; k++) {
        CoPrimvar *primvar = build->sources[k].primvar;
        if (primvar->kind <= CO_PRIMVAR_UNIFORM)
            continue;
        size_t count = primvar->kind == CO_PRIMVAR_POINT ? s->point_count : s->corner_count;
        float *values = co_mesh_keep(build, count * primvar->components, sizeof *values);
        CO_MESH_CHECK_MEMORY(build, values);
        primvar->values = build->sources[k].refined = values;
        if (!expand_vertex_values(build, &build->sources[k]))
            return false;
    }
    return true;
}

// A NaN among control values reaches its neighborhood; it must not reach texture coordinates.
static void clean_values(CoSubdivision *s)
{
    CoMeshBuild *build = s->build;
    for (uint32_t k = 0; k < build->source_count; k++) {
        CoPrimvar *primvar = build->sources[k].primvar;
        if (primvar->kind <= CO_PRIMVAR_UNIFORM)
            continue;
        size_t count = primvar->kind == CO_PRIMVAR_POINT ? s->point_count : s->corner_count;
        float *values = build->sources[k].refined;
        size_t broken = 0;
        for (size_t m = 0; m < count * primvar->components; m++) {
            if (isfinite(values[m]))
                continue;
            values[m] = 0.0f;
            broken++;
        }
        if (broken)
            co_mesh_warn(build, "primvar %.64s: %zu NaN or infinite values are taken as 0",
                         primvar->name, broken);
    }
}

bool co_subdivision_eval(CoSubdivision *s)
{
    if (!allocate_values(s) || !run(s))
        return false;
    if (s->has_normal_seams && !co_subdivision_share_normals(s))
        return false;
    clean_values(s);
    return true;
}
