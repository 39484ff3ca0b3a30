// What can be wrong with a mesh.

#include "check.h"

#include <math.h>
#include <string.h>

typedef struct MeshSizes {
    size_t points, faces, corners;
} MeshSizes;

// ---- Topology ----------------------------------------------------------------------------------

static void check_counts(Check *check, const CohortPrim *prim, const CohortValue *counts,
                         size_t corners)
{
    const int32_t *count = counts->data;
    int64_t total = 0;
    size_t bad = 0, first = 0;
    for (size_t i = 0; i < counts->count; i++) {
        total += count[i];
        if (count[i] < 3 && bad++ == 0)
            first = i;
    }
    if (bad)
        check_found(check, FINDING_TOPOLOGY, COHORT_SEVERITY_ERROR, prim, "faceVertexCounts",
                    "face %zu has %d corners%s", first, count[first],
                    bad > 1 ? ", and more are like it" : "");
    if (total < 0 || (uint64_t)total != corners)
        check_found(check, FINDING_TOPOLOGY, COHORT_SEVERITY_ERROR, prim, "faceVertexIndices",
                    "%zu indices for faces with %lld corners", corners, (long long)total);
}

// Says which is the first of the indices outside `count` things.
static void check_indices(Check *check, const CohortPrim *prim, const char *name,
                          const CohortValue *value, size_t count, const char *things)
{
    const int32_t *index = value->data;
    for (size_t i = 0; value->type == COHORT_TYPE_INT && i < value->count; i++)
        if (index[i] < 0 || (size_t)index[i] >= count) {
            check_found(check, FINDING_TOPOLOGY, COHORT_SEVERITY_ERROR, prim, name,
                        "index %d at %zu is outside the %zu %s", index[i], i, count, things);
            return;
        }
}

static bool check_topology(Check *check, const CohortPrim *prim, MeshSizes *sizes)
{
    CohortValue points = {0}, counts, indices;
    bool has_points = check_value(prim, "points", &points) && points.count;
    if (!check_value(prim, "faceVertexCounts", &counts) || counts.type != COHORT_TYPE_INT ||
        !check_value(prim, "faceVertexIndices", &indices) || indices.type != COHORT_TYPE_INT) {
        check_found(check, FINDING_TOPOLOGY, COHORT_SEVERITY_WARNING, prim, NULL,
                    "the mesh has no faces");
        return false;
    }
    if (!has_points && counts.count)
        check_found(check, FINDING_TOPOLOGY, COHORT_SEVERITY_ERROR, prim, NULL,
                    "the mesh has %zu faces, but no points", counts.count);
    check_counts(check, prim, &counts, indices.count);
    if (has_points)
        check_indices(check, prim, "faceVertexIndices", &indices, points.count, "points");
    *sizes = (MeshSizes){points.count, counts.count, indices.count};
    return has_points && counts.count;
}

// ---- Primvars ----------------------------------------------------------------------------------

// How many elements an interpolation asks for; 0: any number.
static size_t expected_count(const char *interpolation, const MeshSizes *sizes)
{
    if (!strcmp(interpolation, "uniform"))
        return sizes->faces;
    if (!strcmp(interpolation, "faceVarying"))
        return sizes->corners;
    if (!strcmp(interpolation, "vertex") || !strcmp(interpolation, "varying"))
        return sizes->points;
    return 0;
}

static const char *interpolation_of(const CohortPrim *prim, const char *name)
{
    CohortValue value;
    if (cohort_prim_attribute_metadata(prim, name, "interpolation", &value) &&
        value.type == COHORT_TYPE_TOKEN)
        return ((const CohortString *)value.data)->text;
    return !strcmp(name, "normals") ? "vertex" : "constant";
}

static void check_primvar(Check *check, const CohortPrim *prim, const char *name,
                          const MeshSizes *sizes)
{
    CohortValue value, indices, size;
    char indexed[1024];
    if (!check_value(prim, name, &value) || !value.is_array ||
        snprintf(indexed, sizeof indexed, "%s:indices", name) >= (int)sizeof indexed)
        return;
    const char *interpolation = interpolation_of(prim, name);
    size_t expected = expected_count(interpolation, sizes), per_element = 1;
    if (cohort_prim_attribute_metadata(prim, name, "elementSize", &size) &&
        size.type == COHORT_TYPE_INT && *(const int32_t *)size.data > 0)
        per_element = (size_t) * (const int32_t *)size.data;
    bool is_indexed = check_value(prim, indexed, &indices);
    if (is_indexed)
        check_indices(check, prim, indexed, &indices, value.count / per_element, "values");
    size_t count = is_indexed ? indices.count : value.count / per_element;
    if (expected && (count != expected || (!is_indexed && value.count % per_element)))
        check_found(check, FINDING_ARRAY_LENGTH, COHORT_SEVERITY_ERROR, prim,
                    is_indexed ? indexed : name, "%zu elements where %s interpolation asks for %zu",
                    is_indexed ? indices.count : value.count, interpolation,
                    expected * (is_indexed ? 1 : per_element));
}

// ---- Points ------------------------------------------------------------------------------------

static void grow(double box[6], const double p[3])
{
    for (int i = 0; i < 3; i++) {
        box[i] = fmin(box[i], p[i]);
        box[i + 3] = fmax(box[i + 3], p[i]);
    }
}

// The box of the points; false, and the first of them, when some are not finite.
static bool find_box(const CohortValue *points, double box[6], size_t *bad)
{
    const float *p = points->data;
    for (int i = 0; i < 6; i++)
        box[i] = i < 3 ? (double)INFINITY : -(double)INFINITY;
    for (size_t i = 0; i < points->count; i++) {
        const double q[3] = {(double)p[3 * i], (double)p[3 * i + 1], (double)p[3 * i + 2]};
        if (!isfinite(q[0]) || !isfinite(q[1]) || !isfinite(q[2])) {
            *bad = i;
            return false;
        }
        grow(box, q);
    }
    return true;
}

// Adds the corners of a box, carried up to the world, to the box of the stage.
static void grow_stage(Check *check, const CohortPrim *prim, const double box[6])
{
    double corners[8][3];
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 3; k++)
            corners[i][k] = box[k + (i >> k & 1 ? 3 : 0)];
    bool resets = false;
    for (; prim && !resets; prim = cohort_prim_parent(prim)) {
        double m[4][4];
        if (!cohort_prim_local_transform(prim, 0, m, &resets))
            continue;
        for (int i = 0; i < 8; i++) {
            const double p[3] = {corners[i][0], corners[i][1], corners[i][2]};
            for (int k = 0; k < 3; k++)
                corners[i][k] = p[0] * m[0][k] + p[1] * m[1][k] + p[2] * m[2][k] + m[3][k];
        }
    }
    for (int i = 0; i < 8; i++)
        if (isfinite(corners[i][0] + corners[i][1] + corners[i][2]))
            grow(check->box, corners[i]);
}

static void check_extent(Check *check, const CohortPrim *prim, const double box[6])
{
    CohortValue extent;
    if (!check_value(prim, "extent", &extent) || extent.type != COHORT_TYPE_FLOAT3)
        return;
    if (extent.count != 2) {
        check_found(check, FINDING_EXTENT, COHORT_SEVERITY_WARNING, prim, "extent",
                    "extent has %zu elements, expected 2", extent.count);
        return;
    }
    const float *e = extent.data;
    double slack = 0, outside = 0;
    for (int i = 0; i < 3; i++) {
        slack = fmax(slack, 0.01 * (box[i + 3] - box[i]));
        outside = fmax(outside, (double)e[i] - box[i]);
        outside = fmax(outside, box[i + 3] - (double)e[i + 3]);
    }
    if (!(outside <= slack))
        check_found(check, FINDING_EXTENT, COHORT_SEVERITY_WARNING, prim, "extent",
                    "points lie up to %g outside the authored extent", outside);
}

static void check_points(Check *check, const CohortPrim *prim, const MeshSizes *sizes)
{
    CohortValue points;
    double box[6];
    size_t bad;
    const double *times, *face_times;
    size_t time_count = cohort_prim_time_samples(prim, "points", &times);
    // Points that move may not change in number unless the faces do.
    if (cohort_prim_time_samples(prim, "faceVertexIndices", &face_times) == 0)
        for (size_t i = 0; i < time_count; i++)
            if (cohort_prim_value(prim, "points", times[i], &points) &&
                points.count != sizes->points) {
                check_found(check, FINDING_ARRAY_LENGTH, COHORT_SEVERITY_ERROR, prim, "points",
                            "%zu points at time %g, but %zu at first", points.count, times[i],
                            sizes->points);
                break;
            }
    if (!check_value(prim, "points", &points) || points.type != COHORT_TYPE_POINT3F)
        return;
    if (!find_box(&points, box, &bad)) {
        check_found(check, FINDING_VALUE, COHORT_SEVERITY_ERROR, prim, "points",
                    "point %zu is not finite", bad);
        return;
    }
    grow_stage(check, prim, box);
    if (!time_count)
        check_extent(check, prim, box);
}

// ---- Subsets -----------------------------------------------------------------------------------

static void check_subsets(Check *check, const CohortPrim *prim, const MeshSizes *sizes)
{
    for (size_t i = 0; i < cohort_prim_child_count(prim); i++) {
        const CohortPrim *subset = cohort_prim_child(prim, i);
        CohortValue indices, element;
        bool is_of_faces = !check_value(subset, "elementType", &element) ||
                           (element.type == COHORT_TYPE_TOKEN &&
                            !strcmp(((const CohortString *)element.data)->text, "face"));
        if (!strcmp(cohort_prim_type(subset), "GeomSubset") && is_of_faces &&
            check_value(subset, "indices", &indices))
            check_indices(check, subset, "indices", &indices, sizes->faces, "faces");
    }
}

void check_mesh(Check *check, const CohortPrim *prim)
{
    MeshSizes sizes;
    if (!check_topology(check, prim, &sizes))
        return;
    check_points(check, prim, &sizes);
    check_subsets(check, prim, &sizes);
    for (size_t i = 0; i < cohort_prim_property_count(prim); i++) {
        const char *name = cohort_prim_property_name(prim, i), *end = strrchr(name, ':');
        bool is_indices = end && !strcmp(end, ":indices");
        if (!strcmp(name, "normals") || (!strncmp(name, "primvars:", 9) && !is_indices))
            check_primvar(check, prim, name, &sizes);
    }
}
