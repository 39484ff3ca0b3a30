// Polygon meshes (scheme none): the points as they stand, each n-gon as n - 2 triangles.
//
// A quad splits along 0-2 unless only 1-3 lies inside it (a reflex vertex at 1 or 3). Larger
// polygons are seen along their Newell normal: convex ones become a fan of vertex 0, others are
// clipped ear by ear, lowest ear first; where self-intersection leaves no ear, the lowest vertex is
// clipped. Polygons above MAX_EARS vertices become a fan in any case: clipping takes cubic time at
// worst, and input decides the size.

#include "base/parallel.h"
#include "geometry/grid.h"
#include "geometry/mesh_internal.h"

#include <string.h>

#define MAX_EARS 2048u

typedef struct Point2 {
    double x, y;
} Point2;

typedef struct PolygonJob {
    const CoMeshBuild *build;
    const uint32_t *first_tri;
    uint32_t *tri_corners, *indices, *tri_face;
    Point2 *points; // max_valence per worker
    uint32_t *rings;
    size_t max_valence;
} PolygonJob;

static const float *face_point(const CoMeshBuild *build, uint32_t first, uint32_t k)
{
    return build->desc->points + 3 * (size_t)build->desc->face_vertex_indices[first + k];
}

// Newell's normal, relative to vertex 0 so that far-off polygons keep their digits.
static void newell_normal(const CoMeshBuild *build, uint32_t first, uint32_t n, double out[3])
{
    const float *o = face_point(build, first, 0);
    out[0] = out[1] = out[2] = 0.0;
    for (uint32_t k = 1; k + 1 < n; k++) {
        const float *p = face_point(build, first, k), *q = face_point(build, first, k + 1);
        double a[3], b[3];
        for (int c = 0; c < 3; c++) {
            a[c] = (double)p[c] - (double)o[c];
            b[c] = (double)q[c] - (double)o[c];
        }
        out[0] += a[1] * b[2] - a[2] * b[1];
        out[1] += a[2] * b[0] - a[0] * b[2];
        out[2] += a[0] * b[1] - a[1] * b[0];
    }
}

// Drops the axis along which the normal is longest; the result turns counterclockwise overall.
static void project(const CoMeshBuild *build, uint32_t first, uint32_t n, Point2 *out)
{
    double normal[3];
    newell_normal(build, first, n, normal);
    int axis = 0;
    for (int c = 1; c < 3; c++)
        if (fabs(normal[c]) > fabs(normal[axis]))
            axis = c;
    int x = (axis + 1) % 3, y = (axis + 2) % 3;
    if (normal[axis] < 0.0) {
        int swap = x;
        x = y;
        y = swap;
    }
    for (uint32_t k = 0; k < n; k++) {
        const float *p = face_point(build, first, k);
        out[k] = (Point2){(double)p[x], (double)p[y]};
    }
}

// Twice the signed area of a triangle.
static double turn(Point2 a, Point2 b, Point2 c)
{
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

static void emit(uint32_t **out, uint32_t first, uint32_t a, uint32_t b, uint32_t c)
{
    (*out)[0] = first + a;
    (*out)[1] = first + b;
    (*out)[2] = first + c;
    *out += 3;
}

static void emit_fan(uint32_t **out, uint32_t first, uint32_t n)
{
    for (uint32_t k = 1; k + 1 < n; k++)
        emit(out, first, 0, k, k + 1);
}

static void emit_quad(uint32_t **out, uint32_t first, const Point2 *p)
{
    double along02 = fmin(turn(p[0], p[1], p[2]), turn(p[0], p[2], p[3]));
    double along13 = fmin(turn(p[0], p[1], p[3]), turn(p[1], p[2], p[3]));
    if (along02 < 0.0 && along13 > along02) {
        emit(out, first, 0, 1, 3);
        emit(out, first, 1, 2, 3);
    } else {
        emit_fan(out, first, 4);
    }
}

static bool is_convex(const Point2 *p, uint32_t n)
{
    for (uint32_t k = 0; k < n; k++)
        if (turn(p[k], p[(k + 1) % n], p[(k + 2) % n]) < 0.0)
            return false;
    return true;
}

static bool triangle_contains(Point2 a, Point2 b, Point2 c, Point2 p)
{
    return turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
}

static bool same_point(Point2 a, Point2 b)
{
    return a.x == b.x && a.y == b.y;
}

// Whether ring[k] can be cut off: it turns left and nothing else lies in its triangle.
static bool is_ear(const Point2 *p, const uint32_t *ring, uint32_t count, uint32_t k)
{
    Point2 a = p[ring[(k + count - 1) % count]], b = p[ring[k]], c = p[ring[(k + 1) % count]];
    if (turn(a, b, c) <= 0.0)
        return false;
    for (uint32_t m = 0; m < count; m++) {
        Point2 q = p[ring[m]];
        if (same_point(q, a) || same_point(q, b) || same_point(q, c))
            continue;
        if (triangle_contains(a, b, c, q))
            return false;
    }
    return true;
}

static void emit_ears(uint32_t **out, uint32_t first, const Point2 *p, uint32_t *ring, uint32_t n)
{
    for (uint32_t k = 0; k < n; k++)
        ring[k] = k;
    for (uint32_t count = n; count >= 3; count--) {
        uint32_t ear = 0;
        while (ear < count && count > 3 && !is_ear(p, ring, count, ear))
            ear++;
        if (ear == count || count == 3)
            ear = count == 3 ? 1 : 0;
        emit(out, first, ring[(ear + count - 1) % count], ring[ear], ring[(ear + 1) % count]);
        memmove(ring + ear, ring + ear + 1, (count - ear - 1) * sizeof *ring);
    }
}

static void triangulate(const PolygonJob *job, size_t face, uint32_t worker)
{
    const CoMeshBuild *build = job->build;
    uint32_t first = build->face_first[face], n = build->face_first[face + 1] - first;
    uint32_t *out = job->tri_corners + 3 * (size_t)job->first_tri[face];
    if (n == 3 || n > MAX_EARS) {
        emit_fan(&out, first, n);
        return;
    }
    Point2 *points = job->points + worker * job->max_valence;
    project(build, first, n, points);
    if (n == 4)
        emit_quad(&out, first, points);
    else if (is_convex(points, n))
        emit_fan(&out, first, n);
    else
        emit_ears(&out, first, points, job->rings + worker * job->max_valence, n);
}

static void triangulate_faces(void *context, size_t begin, size_t end, uint32_t worker)
{
    const PolygonJob *job = context;
    const CoMeshBuild *build = job->build;
    for (size_t f = begin; f < end; f++) {
        if (build->face_dropped[f])
            continue;
        triangulate(job, f, worker);
        uint32_t count = build->face_first[f + 1] - build->face_first[f] - 2;
        size_t tri = job->first_tri[f];
        for (uint32_t k = 0; k < count; k++)
            job->tri_face[tri + k] = (uint32_t)f;
        for (size_t k = 3 * tri; k < 3 * (tri + count); k++)
            job->indices[k] = (uint32_t)build->desc->face_vertex_indices[job->tri_corners[k]];
    }
}

static bool copy_points(CoMeshBuild *build)
{
    const CohortMeshDesc *d = build->desc;
    float *points = co_mesh_keep(build, d->point_count, 3 * sizeof *points);
    CO_MESH_CHECK_MEMORY(build, points);
    for (size_t k = 0; k < 3 * d->point_count; k++)
        points[k] = isfinite(d->points[k]) ? d->points[k] : 0.0f;
    build->mesh->points = points;
    build->mesh->point_count = (uint32_t)d->point_count;
    return true;
}

static void average_vertices(const CoMeshBuild *build, size_t face, float center[3])
{
    double sum[3] = {0.0, 0.0, 0.0};
    uint32_t count = build->face_first[face + 1] - build->face_first[face];
    for (uint32_t k = 0; k < count; k++)
        for (int c = 0; c < 3; c++)
            sum[c] += (double)face_point(build, build->face_first[face], k)[c];
    for (int c = 0; c < 3; c++)
        center[c] = (float)(sum[c] / count);
}

// Ptex coordinates of polygons above four vertices need the polygon itself and its center.
static bool copy_polygons(CoMeshBuild *build)
{
    const CohortMeshDesc *d = build->desc;
    uint32_t *vertices = co_mesh_keep(build, d->face_vertex_index_count, sizeof *vertices);
    uint32_t *first = co_mesh_keep(build, d->face_count, sizeof *first);
    float *centers = co_mesh_keep(build, d->face_count, 3 * sizeof *centers);
    CO_MESH_CHECK_MEMORY(build, vertices);
    CO_MESH_CHECK_MEMORY(build, first);
    CO_MESH_CHECK_MEMORY(build, centers);
    memcpy(vertices, d->face_vertex_indices, d->face_vertex_index_count * sizeof *vertices);
    memcpy(first, build->face_first, d->face_count * sizeof *first);
    for (size_t f = 0; f < d->face_count; f++)
        if (!build->face_dropped[f])
            average_vertices(build, f, centers + 3 * f);
    build->shading->face_vertices = vertices;
    build->shading->corner_first = first;
    build->shading->face_centers = centers;
    return true;
}

static bool build_triangles(CoMeshBuild *build, PolygonJob *job, uint32_t *first_tri)
{
    const CohortMeshDesc *d = build->desc;
    uint32_t tri_count = 0; // below the number of face-vertices
    for (size_t f = 0; f < d->face_count; f++) {
        first_tri[f] = tri_count;
        if (build->face_dropped[f])
            continue;
        uint32_t valence = (uint32_t)d->face_vertex_counts[f];
        tri_count += valence - 2;
        job->max_valence = valence > job->max_valence ? valence : job->max_valence;
    }
    size_t workers = co_worker_count();
    size_t scratch = job->max_valence > MAX_EARS ? MAX_EARS : job->max_valence;
    job->max_valence = scratch;
    job->points = co_mesh_scratch(build, workers * scratch, sizeof *job->points);
    job->rings = co_mesh_scratch(build, workers * scratch, sizeof *job->rings);
    job->tri_corners = co_mesh_keep(build, tri_count, 3 * sizeof *job->tri_corners);
    job->indices = co_mesh_keep(build, tri_count, 3 * sizeof *job->indices);
    job->tri_face = co_mesh_keep(build, tri_count, sizeof *job->tri_face);
    CO_MESH_CHECK_MEMORY(build, job->points);
    CO_MESH_CHECK_MEMORY(build, job->rings);
    CO_MESH_CHECK_MEMORY(build, job->tri_corners);
    CO_MESH_CHECK_MEMORY(build, job->indices);
    CO_MESH_CHECK_MEMORY(build, job->tri_face);
    job->first_tri = first_tri;
    co_parallel_for(d->face_count, 1024, triangulate_faces, job);
    build->shading->tri_corners = job->tri_corners;
    build->shading->tri_face = job->tri_face;
    build->mesh->indices = job->indices;
    build->mesh->tri_count = tri_count;
    return true;
}

static void find_normals(CoMeshBuild *build)
{
    for (uint32_t k = 0; k < build->source_count; k++) {
        const CoPrimvar *primvar = build->sources[k].primvar;
        if (strcmp(primvar->name, "normals") != 0)
            continue;
        if (primvar->components == 3)
            build->shading->normals = *primvar;
        else
            co_mesh_warn(build, "primvar normals has %u components, not 3: no shading normals",
                         primvar->components);
    }
}

bool co_mesh_build_polygons(CoMeshBuild *build)
{
    build->shading->grid = CO_GRID_POLYGON;
    uint32_t *first_tri = co_mesh_scratch(build, build->desc->face_count, sizeof *first_tri);
    CO_MESH_CHECK_MEMORY(build, first_tri);
    PolygonJob job = {.build = build};
    if (!copy_points(build) || !build_triangles(build, &job, first_tri) ||
        !co_mesh_copy_primvars(build))
        return false;
    if (job.max_valence > 4 && !copy_polygons(build))
        return false;
    find_normals(build);
    return true;
}
