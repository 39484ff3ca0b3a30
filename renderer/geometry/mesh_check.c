// Descriptions of meshes: what is refused, what is dropped with a warning.

#include "geometry/mesh_internal.h"

#include <math.h>
#include <string.h>

static bool check_levels(CoMeshBuild *build, const uint8_t *levels, size_t count, const char *of)
{
    for (size_t k = 0; levels && k < count; k++)
        CO_MESH_CHECK(build, levels[k] <= 10, COHORT_ERROR_ARGUMENT,
                      "subdivision level %u of %s %zu, at most 10 is possible", levels[k], of, k);
    return true;
}

static bool check_sizes(CoMeshBuild *build)
{
    const CohortMeshDesc *d = build->desc;
    CO_MESH_CHECK(build, (unsigned)d->scheme <= COHORT_SCHEME_NONE, COHORT_ERROR_ARGUMENT,
                  "unknown subdivision scheme %d", (int)d->scheme);
    CO_MESH_CHECK(build, d->level <= 10 || d->scheme == COHORT_SCHEME_NONE, COHORT_ERROR_ARGUMENT,
                  "subdivision level %u, at most 10 is possible", d->level);
    CO_MESH_CHECK(build,
                  d->point_count < INT32_MAX && d->face_count < INT32_MAX &&
                      d->face_vertex_index_count < INT32_MAX,
                  COHORT_ERROR_LIMIT, "more than 2^31 points, faces or face-vertices");
    CO_MESH_CHECK(
        build,
        (d->points || d->point_count == 0) && (d->face_vertex_counts || d->face_count == 0) &&
            (d->face_vertex_indices || d->face_vertex_index_count == 0) &&
            (d->hole_indices || d->hole_count == 0) && (d->primvars || d->primvar_count == 0),
        COHORT_ERROR_ARGUMENT, "an array is missing although its length is not 0");
    return d->scheme == COHORT_SCHEME_NONE ||
           (check_levels(build, d->edge_levels, d->face_vertex_index_count, "edge") &&
            check_levels(build, d->face_levels, d->face_count, "face"));
}

static bool check_topology(CoMeshBuild *build)
{
    const CohortMeshDesc *d = build->desc;
    uint64_t total = 0;
    for (size_t f = 0; f < d->face_count; f++) {
        int32_t count = d->face_vertex_counts[f];
        CO_MESH_CHECK(build, count >= 0, COHORT_ERROR_SCENE,
                      "faceVertexCounts[%zu] is %d, which no face can have", f, count);
        build->face_first[f] = (uint32_t)total;
        total += (uint64_t)count;
        CO_MESH_CHECK(build, total <= d->face_vertex_index_count, COHORT_ERROR_SCENE,
                      "faceVertexCounts ask for more than the %zu faceVertexIndices there are",
                      d->face_vertex_index_count);
    }
    CO_MESH_CHECK(build, total == d->face_vertex_index_count, COHORT_ERROR_SCENE,
                  "faceVertexCounts add up to %llu, but there are %zu faceVertexIndices",
                  (unsigned long long)total, d->face_vertex_index_count);
    build->face_first[d->face_count] = (uint32_t)total;
    for (size_t k = 0; k < d->face_vertex_index_count; k++) {
        int32_t index = d->face_vertex_indices[k];
        CO_MESH_CHECK(build, index >= 0 && (size_t)index < d->point_count, COHORT_ERROR_SCENE,
                      "faceVertexIndices[%zu] is %d, but there are %zu points", k, index,
                      d->point_count);
    }
    return true;
}

// Areas and distances of what lies farther away are no floats: trees could not tell it apart, and
// rays would take ages to miss it.
#define REACH 1e30f

static bool is_out_of_reach(float x)
{
    return isfinite(x) && fabsf(x) > REACH;
}

static bool drop_out_of_reach(CoMeshBuild *build)
{
    const CohortMeshDesc *d = build->desc;
    size_t far = 0;
    for (size_t k = 0; k < 3 * d->point_count; k++)
        far += is_out_of_reach(d->points[k]);
    if (far == 0)
        return true;
    float *points = co_mesh_scratch(build, 3 * d->point_count, sizeof *points);
    CO_MESH_CHECK_MEMORY(build, points);
    for (size_t k = 0; k < 3 * d->point_count; k++)
        points[k] = is_out_of_reach(d->points[k]) ? NAN : d->points[k];
    build->reachable = *d;
    build->reachable.points = points;
    build->desc = &build->reachable;
    return true;
}

static bool point_is_finite(const CohortMeshDesc *d, size_t k)
{
    return co_is_finite3(co_vec3_load(d->points + 3 * k));
}

bool co_mesh_face_is_broken(const CoMeshBuild *build, size_t face)
{
    for (uint32_t k = build->face_first[face]; k < build->face_first[face + 1]; k++)
        if (!point_is_finite(build->desc, (size_t)build->desc->face_vertex_indices[k]))
            return true;
    return false;
}

static void drop_face(CoMeshBuild *build, size_t face)
{
    build->dropped_count += build->face_dropped[face] == 0;
    build->face_dropped[face] = 1;
}

static void drop_holes(CoMeshBuild *build)
{
    const CohortMeshDesc *d = build->desc;
    size_t bad = 0;
    for (size_t k = 0; k < d->hole_count; k++) {
        int32_t face = d->hole_indices[k];
        if (face < 0 || (size_t)face >= d->face_count)
            bad++;
        else
            drop_face(build, (size_t)face);
    }
    if (bad)
        co_mesh_warn(build, "%zu holeIndices are out of range and ignored", bad);
}

// Drops faces of fewer than three vertices and, where points are not finite, the faces that use
// them.
static void drop_unusable(CoMeshBuild *build)
{
    const CohortMeshDesc *d = build->desc;
    size_t small = 0, broken = 0;
    for (size_t f = 0; f < d->face_count; f++) {
        if (d->face_vertex_counts[f] < 3) {
            small++;
            drop_face(build, f);
        } else if (build->has_broken_points && co_mesh_face_is_broken(build, f)) {
            broken++;
            drop_face(build, f);
        }
    }
    if (small)
        co_mesh_warn(build, "%zu faces of fewer than 3 vertices are dropped", small);
    if (broken)
        co_mesh_warn(build, "%zu faces with a point that is NaN or beyond 1e30 are dropped",
                     broken);
}

static bool check_points(CoMeshBuild *build)
{
    const CohortMeshDesc *d = build->desc;
    size_t finite = 0;
    for (size_t k = 0; k < d->point_count; k++)
        finite += point_is_finite(d, k);
    build->has_broken_points = finite != d->point_count;
    CO_MESH_CHECK(build, finite > 0 || d->face_vertex_index_count == 0, COHORT_ERROR_SCENE,
                  "none of the %zu points is finite and within 1e30", d->point_count);
    return true;
}

static uint32_t ptex_faces_of(int32_t vertex_count)
{
    return vertex_count == 4 ? 1 : (uint32_t)vertex_count;
}

// Walks the faces in order: a quad (and any face of a loop mesh) takes one Ptex face, an n-gon n.
static bool count_ptex_faces(CoMeshBuild *build)
{
    const CohortMeshDesc *d = build->desc;
    bool is_even = true; // all faces take as many
    if (d->scheme != COHORT_SCHEME_LOOP)
        for (size_t f = 1; f < d->face_count && is_even; f++)
            is_even = d->face_vertex_counts[f] == d->face_vertex_counts[0];
    if (is_even) {
        bool is_one = d->scheme == COHORT_SCHEME_LOOP || d->face_count == 0;
        uint32_t each = is_one ? 1 : ptex_faces_of(d->face_vertex_counts[0]);
        build->shading->ptex_each = each;
        build->mesh->ptex_face_count = each * (uint32_t)d->face_count;
        return true;
    }
    uint32_t *first = co_mesh_keep(build, d->face_count + 1, sizeof *first);
    CO_MESH_CHECK_MEMORY(build, first);
    uint32_t next = 0; // at most the number of face-vertices, hence no overflow
    for (size_t f = 0; f < d->face_count; f++) {
        first[f] = next;
        next += ptex_faces_of(d->face_vertex_counts[f]);
    }
    first[d->face_count] = next;
    build->shading->ptex_first = first;
    build->mesh->ptex_face_count = next;
    return true;
}

bool co_mesh_check(CoMeshBuild *build)
{
    if (!check_sizes(build) || !drop_out_of_reach(build))
        return false;
    const CohortMeshDesc *d = build->desc;
    build->face_first = co_mesh_scratch(build, d->face_count + 1, sizeof *build->face_first);
    build->face_dropped = co_mesh_scratch(build, d->face_count, 1);
    CO_MESH_CHECK_MEMORY(build, build->face_first);
    CO_MESH_CHECK_MEMORY(build, build->face_dropped);
    if (!check_topology(build) || !check_points(build) || !count_ptex_faces(build))
        return false;
    build->mesh->face_count = (uint32_t)d->face_count;
    drop_holes(build);
    drop_unusable(build);
    return true;
}
