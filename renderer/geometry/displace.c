#include "geometry/displace.h"

#include "base/parallel.h"
#include "geometry/grid.h"
#include "geometry/unit_code.h"
#include "math/elementary.h"

#define CHUNK ((size_t)1 << 18) // points whose amounts are asked for at a time
#define GRAIN 1024
#define SAME_NORMAL 0.9999f // corners whose normals were that near share one: 0.8 degrees

typedef struct Displacement {
    CoMesh *mesh;
    CoMeshShading *shading;
    CoMeshBlock *scratch;
    float *points;      // the mesh's
    size_t *first;      // [points + 1] first use of a point
    uint32_t *uses;     // triangles at each point, ascending
    float *amounts;     // [points]
    CoVec3 *directions; // [points] outward, zero where there is none
    uint32_t *rest;     // [3 triangles] codes of the corners' normals; NULL: one normal per point
    uint32_t *normals;  // new codes, per point or corner element; NULL: faceted
    CoDisplaceCounts *counts_of; // by worker
    CoVec3 *lo, *hi;             // by worker
} Displacement;

// ---- Which triangles meet at a point -----------------------------------------------------------

// False for triangles that have collapsed (patch.h): they have no place on the surface.
static bool load_corners(const CoMesh *mesh, uint32_t tri, uint32_t point[3])
{
    co_mesh_triangle(mesh, tri, point);
    return point[0] != point[1] && point[1] != point[2] && point[2] != point[0];
}

static bool find_uses(Displacement *d)
{
    const CoMesh *mesh = d->mesh;
    d->first = co_mesh_block_alloc(&d->scratch, mesh->point_count + (size_t)2, sizeof *d->first);
    d->uses = co_mesh_block_alloc(&d->scratch, mesh->tri_count, 3 * sizeof *d->uses);
    if (!d->first || !d->uses)
        return false;
    // Counted two places on, so that filling in leaves each beginning where it belongs.
    uint32_t point[3];
    for (uint32_t t = 0; t < mesh->tri_count; t++) {
        if (!load_corners(mesh, t, point))
            continue;
        for (int c = 0; c < 3; c++)
            d->first[(size_t)point[c] + 2]++;
    }
    for (size_t p = 2; p < mesh->point_count + (size_t)2; p++)
        d->first[p] += d->first[p - 1];
    for (uint32_t t = 0; t < mesh->tri_count; t++) {
        if (!load_corners(mesh, t, point))
            continue;
        for (int c = 0; c < 3; c++)
            d->uses[d->first[(size_t)point[c] + 1]++] = t;
    }
    return true;
}

// The corner of a triangle that is the point.
static int corner_of(const CoMesh *mesh, uint32_t tri, uint32_t point)
{
    uint32_t of[3];
    co_mesh_triangle(mesh, tri, of);
    return of[0] == point ? 0 : of[1] == point ? 1 : 2;
}

// ---- Normals -----------------------------------------------------------------------------------

// The triangle's normal as wound, as long as its angle at corner c. Zero without an area.
static CoVec3 angle_normal(const CoMesh *mesh, uint32_t tri, int c)
{
    uint32_t point[3];
    CoVec3 p[3];
    co_mesh_triangle(mesh, tri, point);
    for (int k = 0; k < 3; k++)
        p[k] = co_vec3_load(mesh->points + 3 * (size_t)point[(c + k) % 3]);
    CoVec3 a = co_normalize(co_sub(p[1], p[0])), b = co_normalize(co_sub(p[2], p[0]));
    CoVec3 n = co_cross(a, b);
    float sine = co_length(n);
    if (!(sine > 0.0f))
        return co_vec3_splat(0.0f);
    return co_scale(n, co_atan2f(sine, co_dot(a, b)) / sine);
}

static float corner_angle(const CoMesh *mesh, uint32_t tri, int c)
{
    return co_length(angle_normal(mesh, tri, c));
}

static void keep_rest_normals(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const Displacement *d = context;
    for (size_t t = begin; t < end; t++)
        for (size_t c = 0; c < 3; c++) {
            CoSurface s;
            co_mesh_surface(d->mesh, (uint32_t)t, c == 1 ? 1.0f : 0.0f, c == 2 ? 1.0f : 0.0f, &s);
            d->rest[3 * t + c] = co_unit_encode(s.ns);
        }
}

static CoVec3 average_normal(const Displacement *d, uint32_t point)
{
    CoVec3 sum = co_vec3_splat(0.0f);
    for (size_t k = d->first[point]; k < d->first[point + 1]; k++) {
        uint32_t tri = d->uses[k];
        int c = corner_of(d->mesh, tri, point);
        CoVec3 n = co_unit_decode(d->rest[3 * (size_t)tri + (size_t)c]);
        sum = co_madd(sum, n, corner_angle(d->mesh, tri, c));
    }
    return co_normalize(sum);
}

static void find_directions(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const Displacement *d = context;
    for (size_t p = begin; p < end; p++) {
        CoVec3 n = co_vec3_splat(0.0f);
        if (d->rest) {
            n = average_normal(d, (uint32_t)p);
        } else {
            n = co_unit_decode(d->shading->limit_normals[p]);
            if (d->shading->left_handed)
                n = co_neg(n);
        }
        d->directions[p] = co_is_finite3(n) ? n : co_vec3_splat(0.0f);
    }
}

// The new normal at a corner: of the triangles around the point whose normals there were the same.
static CoVec3 joined_normal(const Displacement *d, uint32_t point, CoVec3 rest)
{
    CoVec3 sum = co_vec3_splat(0.0f);
    for (size_t k = d->first[point]; k < d->first[point + 1]; k++) {
        uint32_t tri = d->uses[k];
        int c = corner_of(d->mesh, tri, point);
        if (d->rest &&
            !(co_dot(co_unit_decode(d->rest[3 * (size_t)tri + (size_t)c]), rest) > SAME_NORMAL))
            continue;
        sum = co_add(sum, angle_normal(d->mesh, tri, c));
    }
    return co_normalize(sum);
}

static void find_normals(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const Displacement *d = context;
    for (size_t p = begin; p < end; p++) {
        uint32_t point = (uint32_t)p;
        if (!d->rest) {
            d->normals[p] = co_unit_encode(joined_normal(d, point, co_vec3_splat(0.0f)));
            continue;
        }
        for (size_t k = d->first[p]; k < d->first[p + 1]; k++) {
            uint32_t tri = d->uses[k];
            int c = corner_of(d->mesh, tri, point);
            CoGridPlace g = co_grid_place(d->shading, tri);
            uint32_t element = co_grid_corner(d->shading, &g, tri, c);
            CoVec3 rest = co_unit_decode(d->rest[3 * (size_t)tri + (size_t)c]);
            d->normals[element] = co_unit_encode(joined_normal(d, point, rest));
        }
    }
}

// ---- Corner elements ---------------------------------------------------------------------------

// Numbers the corner elements of a mesh that had no need of them, and counts them.
static bool lay_out_corners(Displacement *d, size_t *count)
{
    const CoMesh *mesh = d->mesh;
    CoMeshShading *s = d->shading;
    *count = 0;
    if (s->grid == CO_GRID_POLYGON) {
        for (size_t k = 0; k < 3 * (size_t)mesh->tri_count; k++)
            *count = s->tri_corners[k] >= *count ? s->tri_corners[k] + (size_t)1 : *count;
        return true;
    }
    uint32_t *first = NULL;
    if (!co_grid_has_corners(s)) {
        first = co_mesh_block_alloc(&s->blocks, mesh->face_count, sizeof *first);
        if (!first)
            return false;
    }
    size_t next = 0;
    for (uint32_t f = 0; f < mesh->face_count; f++) {
        size_t own = co_grid_corner_count(s->grid, co_grid_level(s, f), co_grid_valence(s, f));
        size_t begin = first ? next : co_grid_corner_first(s, f);
        if (first)
            first[f] = (uint32_t)next;
        next = begin + own;
        *count = next > *count ? next : *count;
    }
    if (first)
        s->corner_first = first;
    return *count <= UINT32_MAX;
}

// Where the new normals go: none for faceted meshes, the old ones' places where these are one for
// each.
static bool make_normals(Displacement *d)
{
    CoMeshShading *s = d->shading;
    bool is_faceted = !s->limit_normals && !s->normals.values && !s->is_bilinear;
    if (is_faceted)
        return true;
    if (!d->rest) {
        d->normals = (uint32_t *)(uintptr_t)s->limit_normals;
        return true;
    }
    size_t count;
    if (!lay_out_corners(d, &count))
        return false;
    d->normals = co_mesh_block_alloc(&s->blocks, count, sizeof *d->normals);
    if (!d->normals)
        return false;
    s->has_corner_normals = true;
    co_mesh_block_drop(&s->blocks, s->limit_normals);
    co_mesh_block_drop(&s->blocks, s->own_normals);
    s->limit_normals = NULL;
    s->own_normals = NULL;
    s->has_derived_normals = false;
    return true;
}

// ---- Points ------------------------------------------------------------------------------------

static bool find_amounts(Displacement *d, CoDisplaceFn *fn, void *cookie, CohortError *err)
{
    const CoMesh *mesh = d->mesh;
    CoDisplacePoint *ask = co_mesh_block_alloc(&d->scratch, CHUNK, sizeof *ask);
    float *answer = co_mesh_block_alloc(&d->scratch, CHUNK, sizeof *answer);
    uint32_t *which = co_mesh_block_alloc(&d->scratch, CHUNK, sizeof *which);
    CO_CHECK(ask && answer && which, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    size_t count = 0;
    for (uint32_t p = 0; p < mesh->point_count; p++) {
        if (d->first[p] < d->first[p + 1]) {
            uint32_t tri = d->uses[d->first[p]];
            int c = corner_of(mesh, tri, p);
            ask[count] = (CoDisplacePoint){tri, c == 1 ? 1.0f : 0.0f, c == 2 ? 1.0f : 0.0f};
            which[count++] = p;
        }
        if (count < CHUNK && p + 1 < mesh->point_count)
            continue;
        if (!fn(cookie, ask, count, answer, err))
            return false;
        for (size_t k = 0; k < count; k++)
            d->amounts[which[k]] = answer[k];
        count = 0;
    }
    return true;
}

static void move_points(void *context, size_t begin, size_t end, uint32_t worker)
{
    Displacement *d = context;
    CoVec3 *lo = &d->lo[worker], *hi = &d->hi[worker];
    for (size_t p = begin; p < end; p++) {
        if (d->first[p] == d->first[p + 1])
            continue;
        CoVec3 rest = co_vec3_load(d->points + 3 * p);
        CoVec3 moved = co_madd(rest, d->directions[p], d->amounts[p]);
        if (!co_is_finite3(moved)) {
            d->counts_of[worker].broken++;
            moved = rest;
        } else if (d->amounts[p] != 0.0f) {
            d->counts_of[worker].moved++;
        }
        d->points[3 * p] = moved.x;
        d->points[3 * p + 1] = moved.y;
        d->points[3 * p + 2] = moved.z;
        *lo = co_vec3(co_min(lo->x, moved.x), co_min(lo->y, moved.y), co_min(lo->z, moved.z));
        *hi = co_vec3(co_max(hi->x, moved.x), co_max(hi->y, moved.y), co_max(hi->z, moved.z));
    }
}

static void join_workers(Displacement *d, size_t workers, CoDisplaceCounts *counts)
{
    CoVec3 lo = co_vec3_splat(INFINITY), hi = co_vec3_splat(-INFINITY);
    *counts = (CoDisplaceCounts){0};
    for (size_t w = 0; w < workers; w++) {
        counts->moved += d->counts_of[w].moved;
        counts->broken += d->counts_of[w].broken;
        lo = co_vec3(co_min(lo.x, d->lo[w].x), co_min(lo.y, d->lo[w].y), co_min(lo.z, d->lo[w].z));
        hi = co_vec3(co_max(hi.x, d->hi[w].x), co_max(hi.y, d->hi[w].y), co_max(hi.z, d->hi[w].z));
    }
    d->mesh->box_min = lo;
    d->mesh->box_max = hi;
    d->mesh->is_flat = false;
}

// Centers of polygons, by which hits find their Ptex sub-face.
static void move_centers(Displacement *d)
{
    const CoMeshShading *s = d->shading;
    for (uint32_t t = 0; s->face_centers && t < d->mesh->tri_count; t++) {
        uint32_t face = s->tri_face[t];
        if (t > 0 && s->tri_face[t - 1] == face)
            continue;
        uint32_t count = co_grid_valence(s, face);
        double sum[3] = {0.0, 0.0, 0.0};
        for (uint32_t k = 0; k < count; k++)
            for (size_t c = 0; c < 3; c++)
                sum[c] +=
                    (double)d->points[3 * (size_t)s->face_vertices[s->corner_first[face] + k] + c];
        float *center = (float *)(uintptr_t)s->face_centers + 3 * (size_t)face;
        for (int c = 0; c < 3; c++)
            center[c] = (float)(sum[c] / count);
    }
}

// ---- All of it ---------------------------------------------------------------------------------

static bool allocate(Displacement *d, size_t workers)
{
    CoMeshBlock **scratch = &d->scratch;
    size_t points = d->mesh->point_count;
    const CoMeshShading *s = d->shading;
    bool needs_rest = !s->limit_normals || s->has_corner_normals || s->has_derived_normals;
    if (needs_rest)
        d->rest = co_mesh_block_alloc(scratch, d->mesh->tri_count, 3 * sizeof *d->rest);
    d->amounts = co_mesh_block_alloc(scratch, points, sizeof *d->amounts);
    d->directions = co_mesh_block_alloc(scratch, points, sizeof *d->directions);
    d->counts_of = co_mesh_block_alloc(scratch, workers, sizeof *d->counts_of);
    d->lo = co_mesh_block_alloc(scratch, workers, sizeof *d->lo);
    d->hi = co_mesh_block_alloc(scratch, workers, sizeof *d->hi);
    if ((needs_rest && !d->rest) || !d->amounts || !d->directions || !d->counts_of || !d->lo ||
        !d->hi)
        return false;
    for (size_t w = 0; w < workers; w++) {
        d->lo[w] = co_vec3_splat(INFINITY);
        d->hi[w] = co_vec3_splat(-INFINITY);
    }
    return find_uses(d);
}

static bool displace(Displacement *d, CoDisplaceFn *fn, void *cookie, CoDisplaceCounts *counts,
                     CohortError *err)
{
    CoMesh *mesh = d->mesh;
    size_t workers = co_worker_count();
    CO_CHECK(allocate(d, workers), err, COHORT_ERROR_OUT_OF_MEMORY,
             "out of memory for displacing %u points", mesh->point_count);
    if (!find_amounts(d, fn, cookie, err))
        return false;
    if (d->rest)
        co_parallel_for(mesh->tri_count, GRAIN, keep_rest_normals, d);
    co_parallel_for(mesh->point_count, GRAIN, find_directions, d);
    CO_CHECK(make_normals(d), err, COHORT_ERROR_OUT_OF_MEMORY,
             "out of memory for the normals of %u triangles", mesh->tri_count);
    co_parallel_for(mesh->point_count, GRAIN, move_points, d);
    join_workers(d, workers, counts);
    move_centers(d);
    if (!d->normals)
        return true;
    co_parallel_for(mesh->point_count, GRAIN, find_normals, d);
    d->shading->limit_normals = d->normals;
    d->shading->normals.values = NULL;
    return true;
}

bool co_mesh_displace(CoMesh *mesh, CoDisplaceFn *fn, void *cookie, CoDisplaceCounts *counts,
                      CohortError *err)
{
    *counts = (CoDisplaceCounts){0};
    if (mesh->tri_count == 0)
        return true;
    Displacement d = {
        .mesh = mesh, .shading = mesh->shading, .points = (float *)(uintptr_t)mesh->points};
    bool ok = displace(&d, fn, cookie, counts, err);
    co_mesh_block_free(&d.scratch);
    mesh->bytes = co_mesh_block_bytes(mesh->shading->blocks);
    return ok;
}
