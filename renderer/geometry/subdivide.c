#include "geometry/subdivide.h"

#include "geometry/grid.h"

#include <string.h>

uint32_t co_subdivision_face_edge_point(const CoSubdivision *s, uint32_t face, uint32_t k,
                                        uint32_t i)
{
    uint32_t edge = (uint32_t)co_osd_face_edges(s->osd, face)[k];
    uint32_t ends[2];
    co_osd_edge_vertices(s->osd, edge, ends);
    bool forward = ends[0] == (uint32_t)s->indices[s->first[face] + k];
    uint32_t n = 1u << co_subdivision_edge_level(s, edge);
    return co_subdivision_edge_point(s, edge) + (forward ? i : n - i) - 1;
}

// Points inside a face.
static uint64_t inner_point_count(const CoSubdivision *s, uint32_t face)
{
    uint64_t n = 1ull << co_subdivision_face_level(s, face), valence = (uint64_t)s->counts[face];
    if (s->grid == CO_GRID_TRIANGLE)
        return (n - 1) * (n > 1 ? n - 2 : 0) / 2;
    if (!co_subdivision_is_split(s, face))
        return (n - 1) * (n - 1);
    uint64_t m = n / 2;
    return m == 0 ? 1 : 1 + valence * (m - 1) * m;
}

static bool check_totals(CoMeshBuild *build, uint64_t points, uint64_t tris, uint64_t corners)
{
    CO_MESH_CHECK(build, points < INT32_MAX && tris < INT32_MAX && corners < UINT32_MAX,
                  COHORT_ERROR_LIMIT,
                  "level %u makes %llu triangles, more than 2^31: lower the level",
                  build->shading->level, (unsigned long long)tris);
    return true;
}

// Points of the cage and on its edges.
static uint64_t count_outer_points(CoSubdivision *s)
{
    uint64_t points = s->build->desc->point_count;
    uint32_t edge_count = co_osd_edge_count(s->osd);
    if (!s->edge_level)
        return points + (uint64_t)edge_count * ((1u << s->level) - 1);
    for (uint32_t e = 0; e < edge_count; e++) {
        s->edge_point[e] = (uint32_t)points;
        points += (1u << s->edge_level[e]) - 1;
    }
    return points;
}

// Finds the first point, triangle and corner element of each face.
static bool lay_out(CoSubdivision *s)
{
    CoMeshBuild *build = s->build;
    uint64_t points = count_outer_points(s), tris = 0, corners = 0;
    s->patch_count = 0;
    s->has_split = s->has_whole = false;
    for (uint32_t f = 0; f < s->face_count; f++) {
        uint32_t cage = co_subdivision_cage_face(s, f), valence = (uint32_t)s->counts[f];
        uint32_t level = co_subdivision_face_level(s, f);
        s->face_point[f] = (uint32_t)points;
        s->face_patch[f] = s->patch_count;
        s->first_tri[cage] = (uint32_t)tris;
        s->corner_first[cage] = (uint32_t)corners;
        if (s->is_live[f]) {
            points += inner_point_count(s, f);
            s->patch_count += co_subdivision_patch_count(s, f);
            s->has_split = s->has_split || co_subdivision_is_split(s, f);
            s->has_whole = s->has_whole || !co_subdivision_is_split(s, f);
            tris += co_grid_tri_count(s->grid, level, valence);
            corners += co_grid_corner_count(s->grid, level, valence);
        }
        if (!check_totals(build, points, tris, corners))
            return false;
    }
    s->point_count = (uint32_t)points;
    s->corner_count = (uint32_t)corners;
    build->mesh->tri_count = (uint32_t)tris;
    return true;
}

// A face is live if it is to be rendered, has a limit surface and no control point is broken.
static bool find_live(CoSubdivision *s)
{
    CoMeshBuild *build = s->build;
    CohortError err = {0};
    CoOsdSurface *surface = co_osd_surface_create(s->osd, &err);
    CO_MESH_CHECK_MEMORY(build, surface);
    bool ok = true;
    size_t broken = 0;
    for (uint32_t f = 0; ok && f < s->face_count; f++) {
        bool live = false;
        if (!build->face_dropped[co_subdivision_cage_face(s, f)])
            ok = co_osd_face_has_limit(s->osd, f, &live, &err);
        if (live && build->has_broken_points) {
            ok = co_osd_surface_begin(surface, f, -1, &err) &&
                 co_osd_surface_values(surface, build->desc->points, 3, &live, &err);
            broken += !live;
        }
        s->is_live[f] = live;
    }
    co_osd_surface_destroy(surface);
    CO_MESH_CHECK(build, ok, err.code, "%s", err.message);
    if (broken)
        co_mesh_warn(build, "%zu faces next to a point that is NaN or beyond 1e30 are dropped",
                     broken);
    return true;
}

// Owners are the first live faces in order; s->face_count means nobody.
static void find_owners(CoSubdivision *s)
{
    size_t point_count = s->build->desc->point_count;
    uint32_t edge_count = co_osd_edge_count(s->osd);
    for (size_t v = 0; v < point_count; v++)
        s->vertex_owner[v] = s->face_count;
    for (uint32_t e = 0; e < edge_count; e++)
        s->edge_owner[e] = s->face_count;
    for (uint32_t f = s->face_count; f-- > 0;) {
        if (!s->is_live[f])
            continue;
        const int32_t *edges = co_osd_face_edges(s->osd, f);
        for (int32_t k = 0; k < s->counts[f]; k++) {
            s->vertex_owner[s->indices[s->first[f] + (uint32_t)k]] = f;
            s->edge_owner[edges[k]] = f;
        }
    }
}

static bool face_is_finite(const CoSubdivision *s, uint32_t face)
{
    const CoMesh *mesh = s->build->mesh;
    uint32_t cage = co_subdivision_cage_face(s, face), point[3];
    uint32_t first = s->first_tri[cage];
    uint64_t count =
        co_grid_tri_count(s->grid, co_subdivision_face_level(s, face), (uint32_t)s->counts[face]);
    for (uint32_t tri = first; tri < first + count; tri++) {
        co_mesh_triangle(mesh, tri, point);
        for (int c = 0; c < 3; c++)
            if (!co_is_finite3(co_vec3_load(s->points + 3 * (size_t)point[c])))
                return false;
    }
    return true;
}

// Drops faces whose points came out infinite, which far-off control points can do. Returns how
// many.
static size_t drop_overflown(CoSubdivision *s)
{
    CoMeshBuild *build = s->build;
    size_t dropped = 0;
    if (s->is_finite)
        return 0;
    for (uint32_t f = 0; f < s->face_count; f++) {
        if (!s->is_live[f] || face_is_finite(s, f))
            continue;
        build->face_dropped[co_subdivision_cage_face(s, f)] = 1;
        dropped++;
    }
    return dropped;
}

// Whether some value is kept per corner element.
static bool has_corner_values(const CoSubdivision *s)
{
    for (uint32_t k = 0; k < s->build->source_count; k++)
        if (s->build->sources[k].primvar->kind == CO_PRIMVAR_CORNER)
            return true;
    return s->has_normal_seams;
}

static bool allocate_layout(CoSubdivision *s)
{
    CoMeshBuild *build = s->build;
    size_t point_count = build->desc->point_count, face_count = build->desc->face_count;
    s->first_tri = co_mesh_scratch(build, face_count, sizeof *s->first_tri);
    s->corner_first = co_mesh_scratch(build, face_count, sizeof *s->corner_first);
    s->face_point = co_mesh_scratch(build, s->face_count, sizeof *s->face_point);
    s->face_patch = co_mesh_scratch(build, s->face_count, sizeof *s->face_patch);
    s->is_live = co_mesh_scratch(build, s->face_count, 1);
    s->vertex_owner = co_mesh_scratch(build, point_count, sizeof *s->vertex_owner);
    s->edge_owner = co_mesh_scratch(build, co_osd_edge_count(s->osd), sizeof *s->edge_owner);
    CO_MESH_CHECK_MEMORY(build, s->first_tri);
    CO_MESH_CHECK_MEMORY(build, s->corner_first);
    CO_MESH_CHECK_MEMORY(build, s->face_point);
    CO_MESH_CHECK_MEMORY(build, s->face_patch);
    CO_MESH_CHECK_MEMORY(build, s->is_live);
    CO_MESH_CHECK_MEMORY(build, s->vertex_owner);
    CO_MESH_CHECK_MEMORY(build, s->edge_owner);
    return true;
}

// Where corner elements of faces begin: not kept where it follows from the face.
static bool keep_corners(CoSubdivision *s)
{
    CoMeshBuild *build = s->build;
    size_t face_count = build->desc->face_count;
    if (!has_corner_values(s) || s->corner_count == 0)
        return true;
    uint32_t each = s->corner_count / (uint32_t)face_count;
    bool is_even = each * face_count == s->corner_count;
    for (size_t f = 0; is_even && f < face_count; f++)
        is_even = s->corner_first[f] == f * each;
    if (is_even) {
        build->shading->corners_each = each;
        return true;
    }
    uint32_t *kept = co_mesh_keep(build, face_count, sizeof *kept);
    CO_MESH_CHECK_MEMORY(build, kept);
    memcpy(kept, s->corner_first, face_count * sizeof *kept);
    build->shading->corner_first = kept;
    return true;
}

static bool tessellate(CoSubdivision *s)
{
    CoMeshBuild *build = s->build;
    s->has_normal_seams = !build->shading->is_bilinear && co_osd_has_normal_seams(s->osd);
    if (!allocate_layout(s) || !find_live(s))
        return false;
    for (;;) {
        find_owners(s);
        if (!lay_out(s) || !co_subdivision_make_patches(s) || !co_subdivision_eval(s))
            return false;
        size_t dropped = drop_overflown(s);
        if (dropped == 0)
            break;
        co_mesh_warn(build, "%zu faces whose limit surface is infinite are dropped", dropped);
        for (uint32_t f = 0; f < s->face_count; f++)
            s->is_live[f] &= !build->face_dropped[co_subdivision_cage_face(s, f)];
    }
    build->mesh->points = s->points;
    build->mesh->point_count = s->point_count;
    if (build->mesh->tri_count) {
        build->mesh->box_min = s->box_lo;
        build->mesh->box_max = s->box_hi;
    }
    return keep_corners(s);
}

bool co_mesh_build_subdivision(CoMeshBuild *build)
{
    const CohortMeshDesc *d = build->desc;
    CoSubdivision s = {.build = build,
                       .grid = d->scheme == COHORT_SCHEME_LOOP ? CO_GRID_TRIANGLE : CO_GRID_QUAD,
                       .level = co_subdivision_finest(d)};
    build->shading->grid = s.grid;
    build->shading->is_bilinear = d->scheme == COHORT_SCHEME_BILINEAR;
    if (!co_mesh_copy_primvars(build) || !co_subdivision_make_cage(&s))
        return false;
    if (s.face_count == 0) {
        build->shading->primvar_count = 0;
        return true;
    }
    bool ok = co_subdivision_make_osd(&s) && co_subdivision_make_rates(&s) && tessellate(&s);
    co_osd_destroy(s.osd);
    return ok;
}
