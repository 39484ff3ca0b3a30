#include "geometry/subdivide.h"

// Marks faces OpenSubdiv cannot take with 2 in face_dropped and counts the others. Faces that meet
// a vertex twice it takes: their edges become sharp.
static bool mark_untakable(CoSubdivision *s, size_t *taken, size_t *taken_fv)
{
    CoMeshBuild *build = s->build;
    const CohortMeshDesc *d = build->desc;
    for (size_t f = 0; f < d->face_count; f++) {
        int32_t count = d->face_vertex_counts[f];
        if (count < 3) {
            build->face_dropped[f] = 2;
            continue;
        }
        CO_MESH_CHECK(build, s->grid != CO_GRID_TRIANGLE || count == 3, COHORT_ERROR_SCENE,
                      "face %zu has %d vertices, but the loop scheme takes triangles only", f,
                      count);
        CO_MESH_CHECK(build, count <= UINT16_MAX, COHORT_ERROR_LIMIT,
                      "face %zu has %d vertices, subdivision takes at most 65535", f, count);
        *taken += 1;
        *taken_fv += (size_t)count;
    }
    return true;
}

static bool copy_takable(CoSubdivision *s)
{
    CoMeshBuild *build = s->build;
    const CohortMeshDesc *d = build->desc;
    int32_t *counts = co_mesh_scratch(build, s->face_count, sizeof *counts);
    int32_t *indices = co_mesh_scratch(build, s->fv_count, sizeof *indices);
    uint32_t *cage_face = co_mesh_scratch(build, s->face_count, sizeof *cage_face);
    uint32_t *cage_fv = co_mesh_scratch(build, s->fv_count, sizeof *cage_fv);
    CO_MESH_CHECK_MEMORY(build, counts);
    CO_MESH_CHECK_MEMORY(build, indices);
    CO_MESH_CHECK_MEMORY(build, cage_face);
    CO_MESH_CHECK_MEMORY(build, cage_fv);
    uint32_t face = 0, fv = 0;
    for (size_t f = 0; f < d->face_count; f++) {
        if (build->face_dropped[f] == 2)
            continue;
        counts[face] = d->face_vertex_counts[f];
        cage_face[face++] = (uint32_t)f;
        for (uint32_t k = build->face_first[f]; k < build->face_first[f + 1]; k++) {
            indices[fv] = d->face_vertex_indices[k];
            cage_fv[fv++] = k;
        }
    }
    s->counts = counts;
    s->indices = indices;
    s->cage_face = cage_face;
    s->cage_fv = cage_fv;
    return true;
}

bool co_subdivision_make_cage(CoSubdivision *s)
{
    CoMeshBuild *build = s->build;
    const CohortMeshDesc *d = build->desc;
    size_t taken = 0, taken_fv = 0;
    if (!mark_untakable(s, &taken, &taken_fv))
        return false;
    s->face_count = (uint32_t)taken;
    s->fv_count = (uint32_t)taken_fv;
    s->counts = d->face_vertex_counts;
    s->indices = d->face_vertex_indices;
    if (taken != d->face_count && !copy_takable(s))
        return false;
    s->first = co_mesh_scratch(build, taken + 1, sizeof *s->first);
    CO_MESH_CHECK_MEMORY(build, s->first);
    for (size_t f = 0; f < taken; f++)
        s->first[f + 1] = s->first[f] + (uint32_t)s->counts[f];
    return true;
}

static bool vertex_in_range(const CoSubdivision *s, int32_t vertex)
{
    return vertex >= 0 && (size_t)vertex < s->build->desc->point_count;
}

static float usable_sharpness(float sharpness)
{
    return sharpness > 0.0f ? fminf(sharpness, 10.0f) : 0.0f;
}

static void warn_of_no_numbers(CoMeshBuild *build, const char *what, const float *sharpnesses,
                               size_t count)
{
    size_t broken = 0;
    for (size_t k = 0; k < count; k++)
        broken += isnan(sharpnesses[k]) ? 1 : 0;
    if (broken)
        co_mesh_warn(build, "%zu %s are NaN: smooth there", broken, what);
}

// Creases as OpenSubdiv takes them: one sharpness per edge. Creases that do not add up are ignored.
static bool make_creases(CoSubdivision *s, CoOsdDesc *out)
{
    CoMeshBuild *build = s->build;
    const CohortMeshDesc *d = build->desc;
    if (d->crease_count == 0)
        return true;
    size_t vertices = 0, edges = 0;
    bool usable = d->crease_lengths && d->crease_indices && d->crease_sharpnesses;
    for (size_t k = 0; usable && k < d->crease_count; k++) {
        usable = d->crease_lengths[k] >= 2;
        vertices += usable ? (size_t)d->crease_lengths[k] : 0;
        edges += usable ? (size_t)d->crease_lengths[k] - 1 : 0;
    }
    usable = usable && vertices == d->crease_index_count && vertices < INT32_MAX;
    bool per_edge = d->crease_sharpness_count == edges && edges != d->crease_count;
    usable = usable && (per_edge || d->crease_sharpness_count == d->crease_count);
    for (size_t k = 0; usable && k < vertices; k++)
        usable = vertex_in_range(s, d->crease_indices[k]);
    if (!usable) {
        co_mesh_warn(build, "creaseIndices, creaseLengths and creaseSharpnesses do not fit "
                            "together: creases are ignored");
        return true;
    }
    warn_of_no_numbers(build, "creaseSharpnesses", d->crease_sharpnesses,
                       d->crease_sharpness_count);
    int32_t *pairs = co_mesh_scratch(build, edges, 2 * sizeof *pairs);
    float *sharpnesses = co_mesh_scratch(build, edges, sizeof *sharpnesses);
    CO_MESH_CHECK_MEMORY(build, pairs);
    CO_MESH_CHECK_MEMORY(build, sharpnesses);
    size_t edge = 0;
    const int32_t *vertex = d->crease_indices;
    for (size_t k = 0; k < d->crease_count; k++, vertex++) {
        for (int32_t m = 1; m < d->crease_lengths[k]; m++, edge++, vertex++) {
            pairs[2 * edge] = vertex[0];
            pairs[2 * edge + 1] = vertex[1];
            sharpnesses[edge] = usable_sharpness(d->crease_sharpnesses[per_edge ? edge : k]);
        }
    }
    out->crease_pairs = pairs;
    out->crease_sharpnesses = sharpnesses;
    out->crease_count = (int32_t)edges;
    return true;
}

static bool make_corners(CoSubdivision *s, CoOsdDesc *out)
{
    CoMeshBuild *build = s->build;
    const CohortMeshDesc *d = build->desc;
    if (d->corner_count == 0)
        return true;
    bool usable = d->corner_indices && d->corner_sharpnesses && d->corner_count < INT32_MAX;
    for (size_t k = 0; usable && k < d->corner_count; k++)
        usable = vertex_in_range(s, d->corner_indices[k]);
    if (!usable) {
        co_mesh_warn(build, "cornerIndices and cornerSharpnesses do not fit: corners are ignored");
        return true;
    }
    warn_of_no_numbers(build, "cornerSharpnesses", d->corner_sharpnesses, d->corner_count);
    float *sharpnesses = co_mesh_scratch(build, d->corner_count, sizeof *sharpnesses);
    CO_MESH_CHECK_MEMORY(build, sharpnesses);
    for (size_t k = 0; k < d->corner_count; k++)
        sharpnesses[k] = usable_sharpness(d->corner_sharpnesses[k]);
    out->corners = d->corner_indices;
    out->corner_sharpnesses = sharpnesses;
    out->corner_count = (int32_t)d->corner_count;
    return true;
}

// The topology of each face-varying primvar: its indices, so that its seams are where it has them.
static bool make_channels(CoSubdivision *s, CoOsdDesc *out)
{
    CoMeshBuild *build = s->build;
    s->channels = co_mesh_scratch(build, build->source_count, sizeof *s->channels);
    CO_MESH_CHECK_MEMORY(build, s->channels);
    int32_t count = 0;
    for (uint32_t k = 0; k < build->source_count; k++) {
        const CohortPrimvarDesc *p = build->sources[k].desc;
        if (build->sources[k].primvar->kind != CO_PRIMVAR_CORNER)
            continue;
        CoOsdChannel *channel = &s->channels[count++];
        channel->value_count = (int32_t)p->value_count;
        channel->indices = p->indices;
        if (p->indices && !s->cage_fv)
            continue;
        int32_t *indices = co_mesh_scratch(build, s->fv_count, sizeof *indices);
        CO_MESH_CHECK_MEMORY(build, indices);
        for (uint32_t fv = 0; fv < s->fv_count; fv++)
            indices[fv] = (int32_t)co_primvar_desc_value(p, s->cage_fv ? s->cage_fv[fv] : fv);
        channel->indices = indices;
    }
    out->channels = s->channels;
    out->channel_count = count;
    return true;
}

bool co_subdivision_make_osd(CoSubdivision *s)
{
    CoMeshBuild *build = s->build;
    const CohortMeshDesc *d = build->desc;
    CO_MESH_CHECK(build,
                  (unsigned)d->interpolate_boundary <= COHORT_BOUNDARY_NONE &&
                      (unsigned)d->fvar_linear <= COHORT_FVAR_ALL,
                  COHORT_ERROR_ARGUMENT, "unknown boundary or face-varying rule");
    CoOsdDesc desc = {.scheme = d->scheme,
                      .interpolate_boundary = d->interpolate_boundary,
                      .fvar_linear = d->fvar_linear,
                      .triangle_rule_smooth = d->triangle_rule_smooth,
                      .vertex_count = (int32_t)d->point_count,
                      .face_count = (int32_t)s->face_count,
                      .face_vertex_counts = s->counts,
                      .face_vertex_indices = s->indices,
                      .exact_level = s->level};
    if (!make_creases(s, &desc) || !make_corners(s, &desc) || !make_channels(s, &desc))
        return false;
    char warning[256] = "";
    CohortError err = {0};
    s->osd = co_osd_create(&desc, warning, &err);
    CO_MESH_CHECK(build, s->osd, err.code, "%s", err.message);
    if (warning[0])
        co_mesh_warn(build, "OpenSubdiv: %.200s", warning);
    return true;
}
