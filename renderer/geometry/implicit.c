#include "geometry/implicit.h"

#include "base/error.h"
#include "math/elementary.h"

#include <string.h>

#define SIDES 128u   // around the axis
#define MERIDIAN 64u // from pole to pole of a sphere
#define MAX_SEGMENTS (MERIDIAN + 3)

// A profile turned around the axis: rings of radius r at height z, joined by segments. Normals are
// of the segments' ends, (radial, axial), for two segments may meet in an edge.
typedef struct Profile {
    double r[MAX_SEGMENTS + 1], z[MAX_SEGMENTS + 1];
    double normal[MAX_SEGMENTS][2][2];
    uint32_t segments;
} Profile;

static void profile_start(Profile *p, double r, double z)
{
    p->r[0] = r;
    p->z[0] = z;
}

static void profile_segment(Profile *p, double r, double z, const double n0[2], const double n1[2])
{
    uint32_t k = p->segments++;
    p->r[k + 1] = r;
    p->z[k + 1] = z;
    for (int c = 0; c < 2; c++) {
        p->normal[k][0][c] = n0[c];
        p->normal[k][1][c] = n1[c];
    }
}

// A straight segment: a cone's side, or a disk. The profile goes up, so outside is on its right.
// One of no length is left out: its ends are one ring.
static void profile_line(Profile *p, double r, double z)
{
    double dr = r - p->r[p->segments], dz = z - p->z[p->segments];
    double length = sqrt(dr * dr + dz * dz);
    if (length == 0.0)
        return;
    const double n[2] = {dz / length, -dr / length};
    profile_segment(p, r, z, n, n);
}

// Part of a circle around (0, center), in `steps` of the meridian from step `first` of the whole.
static void profile_arc(Profile *p, double radius, double center, uint32_t first, uint32_t steps)
{
    for (uint32_t k = first; k < first + steps; k++) {
        double n[2][2];
        for (uint32_t end = 0; end < 2; end++) {
            double angle = CO_PI_D * ((double)(k + end) / MERIDIAN - 0.5);
            co_sincos_d(angle, &n[end][1], &n[end][0]);
            // Poles and the equator exactly, so that rings close.
            if (k + end == 0 || k + end == MERIDIAN)
                n[end][0] = 0.0;
        }
        profile_segment(p, radius * n[1][0], center + radius * n[1][1], n[0], n[1]);
    }
}

static void make_profile(const CoImplicitDesc *d, Profile *p)
{
    double half = 0.5 * d->height, bottom = d->radius_bottom, top = d->radius_top;
    if (d->kind == CO_IMPLICIT_SPHERE) {
        profile_start(p, 0.0, -bottom);
        profile_arc(p, bottom, 0.0, 0, MERIDIAN);
        return;
    }
    if (d->kind == CO_IMPLICIT_CAPSULE) {
        profile_start(p, 0.0, -half - bottom);
        profile_arc(p, bottom, -half, 0, MERIDIAN / 2);
        profile_line(p, top, half);
        profile_arc(p, top, half, MERIDIAN / 2, MERIDIAN / 2);
        return;
    }
    top = d->kind == CO_IMPLICIT_CONE ? 0.0 : top;
    profile_start(p, 0.0, -half);
    profile_line(p, bottom, -half);
    profile_line(p, top, half);
    profile_line(p, 0.0, half);
}

typedef struct Shape {
    CoArena *arena;
    int axis;
    float *points, *normals, *st;
    int32_t *counts, *indices, *normal_indices, *st_indices;
    size_t point_count, face_count, index_count, normal_count, st_count;
} Shape;

// z runs along the axis; x and y follow in cyclic order, which keeps the winding.
static void store(float *out, int axis, double x, double y, double z)
{
    out[axis] = (float)z;
    out[(axis + 1) % 3] = (float)x;
    out[(axis + 2) % 3] = (float)y;
}

static bool shape_allocate(Shape *s, size_t points, size_t faces, size_t normals, size_t st)
{
    s->points = co_arena_array(s->arena, points, 3 * sizeof(float));
    s->counts = co_arena_array(s->arena, faces, sizeof(int32_t));
    s->indices = co_arena_array(s->arena, 4 * faces, sizeof(int32_t));
    s->normals = co_arena_array(s->arena, normals, 3 * sizeof(float));
    s->normal_indices = co_arena_array(s->arena, 4 * faces, sizeof(int32_t));
    s->st = co_arena_array(s->arena, st, 2 * sizeof(float));
    s->st_indices = co_arena_array(s->arena, 4 * faces, sizeof(int32_t));
    s->normal_count = normals;
    s->st_count = st;
    return s->points && s->counts && s->indices && s->normals && s->normal_indices && s->st &&
           s->st_indices;
}

static void shape_corner(Shape *s, uint32_t point, uint32_t normal, uint32_t st)
{
    s->indices[s->index_count] = (int32_t)point;
    s->normal_indices[s->index_count] = (int32_t)normal;
    s->st_indices[s->index_count] = (int32_t)st;
    s->index_count++;
    s->counts[s->face_count]++;
}

// Sine and cosine of half steps around the axis: entry 2k is side k, 2k + 1 the middle of its quad.
typedef struct Circle {
    double sine[2 * SIDES], cosine[2 * SIDES];
} Circle;

static void make_circle(Circle *c)
{
    for (uint32_t k = 0; k < 2 * SIDES; k++)
        co_sincos_d(CO_PI_D * (double)k / SIDES, &c->sine[k], &c->cosine[k]);
}

static void revolve_points(Shape *s, const Profile *p, const Circle *circle, uint32_t *ring_first)
{
    for (uint32_t ring = 0; ring <= p->segments; ring++) {
        ring_first[ring] = (uint32_t)s->point_count;
        uint32_t count = p->r[ring] > 0.0 ? SIDES : 1;
        for (uint32_t k = 0; k < count; k++)
            store(s->points + 3 * s->point_count++, s->axis, p->r[ring] * circle->cosine[2 * k],
                  p->r[ring] * circle->sine[2 * k], p->z[ring]);
    }
}

// Normal (2 segment + end) SIDES + side. At a tip, where all sides meet, each triangle takes the
// normal of its middle.
static void revolve_normals(Shape *s, const Profile *p, const Circle *circle)
{
    for (uint32_t k = 0; k < 2 * p->segments * SIDES; k++) {
        uint32_t side = k % SIDES, end = k / SIDES % 2, segment = k / (2 * SIDES);
        uint32_t at = 2 * side + (p->r[segment + end] > 0.0 ? 0 : 1);
        const double *n = p->normal[segment][end];
        store(s->normals + 3 * k, s->axis, n[0] * circle->cosine[at], n[0] * circle->sine[at],
              n[1]);
    }
}

// Texture coordinate ring (SIDES + 1) + side; at poles that of the triangle's middle.
static void revolve_st(Shape *s, const Profile *p)
{
    double length[MAX_SEGMENTS + 1] = {0.0};
    for (uint32_t k = 0; k < p->segments; k++) {
        double dr = p->r[k + 1] - p->r[k], dz = p->z[k + 1] - p->z[k];
        length[k + 1] = length[k] + sqrt(dr * dr + dz * dz);
    }
    double total = length[p->segments] > 0.0 ? length[p->segments] : 1.0;
    for (uint32_t ring = 0; ring <= p->segments; ring++) {
        for (uint32_t side = 0; side <= SIDES; side++) {
            float *st = s->st + 2 * (ring * (SIDES + 1) + side);
            st[0] = (float)(((double)side + (p->r[ring] > 0.0 ? 0.0 : 0.5)) / SIDES);
            st[1] = (float)(length[ring] / total);
        }
    }
}

// One corner of a face: ring segment + end, side counted without wrapping.
static void revolve_corner(Shape *s, const uint32_t *ring_first, uint32_t segment, uint32_t end,
                           uint32_t side)
{
    uint32_t ring = segment + end;
    bool pole = ring_first[ring + 1] - ring_first[ring] == 1;
    uint32_t point = ring_first[ring] + (pole ? 0 : side % SIDES);
    shape_corner(s, point, (2 * segment + end) * SIDES + side % SIDES, ring * (SIDES + 1) + side);
}

static void revolve_faces(Shape *s, const Profile *p, const uint32_t *ring_first)
{
    for (uint32_t k = 0; k < p->segments; k++) {
        bool lower = p->r[k] > 0.0, upper = p->r[k + 1] > 0.0;
        if (!lower && !upper)
            continue;
        for (uint32_t side = 0; side < SIDES; side++) {
            revolve_corner(s, ring_first, k, 0, side);
            if (lower)
                revolve_corner(s, ring_first, k, 0, side + 1);
            if (upper)
                revolve_corner(s, ring_first, k, 1, side + 1);
            revolve_corner(s, ring_first, k, 1, side);
            s->face_count++;
        }
    }
}

static bool make_revolved(const CoImplicitDesc *d, Shape *s)
{
    Profile profile = {.segments = 0};
    make_profile(d, &profile);
    Circle circle;
    make_circle(&circle);
    uint32_t n = profile.segments, ring_first[MAX_SEGMENTS + 2];
    if (!shape_allocate(s, (size_t)(n + 1) * SIDES, (size_t)n * SIDES, 2 * (size_t)n * SIDES,
                        (size_t)(n + 1) * (SIDES + 1)))
        return false;
    revolve_points(s, &profile, &circle, ring_first);
    ring_first[n + 1] = (uint32_t)s->point_count;
    revolve_normals(s, &profile, &circle);
    revolve_st(s, &profile);
    revolve_faces(s, &profile, ring_first);
    return true;
}

static const float unit_st[8] = {0, 0, 1, 0, 1, 1, 0, 1};

static bool make_cube(const CoImplicitDesc *d, Shape *s)
{
    // Outward faces; corner k has bit c set where coordinate c is positive.
    static const uint32_t faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                         {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    if (!shape_allocate(s, 8, 6, 0, 4))
        return false;
    double h = 0.5 * d->size;
    for (uint32_t k = 0; k < 8; k++)
        store(s->points + 3 * k, 2, k & 1 ? h : -h, k & 2 ? h : -h, k & 4 ? h : -h);
    s->point_count = 8;
    for (uint32_t f = 0; f < 6; f++) {
        for (uint32_t c = 0; c < 4; c++)
            shape_corner(s, faces[f][c], 0, c);
        s->face_count++;
    }
    for (int k = 0; k < 8; k++)
        s->st[k] = unit_st[k];
    return true;
}

static bool make_plane(const CoImplicitDesc *d, Shape *s)
{
    if (!shape_allocate(s, 4, 1, 0, 4))
        return false;
    // In the order of `store`, width comes first only for axis z.
    bool width_first = s->axis == 2;
    double x = 0.5 * (width_first ? d->width : d->length);
    double y = 0.5 * (width_first ? d->length : d->width);
    for (uint32_t k = 0; k < 4; k++) {
        float a = unit_st[2 * k], b = unit_st[2 * k + 1];
        store(s->points + 3 * k, s->axis, a > 0.0f ? x : -x, b > 0.0f ? y : -y, 0.0);
        s->st[2 * k] = width_first ? a : b;
        s->st[2 * k + 1] = width_first ? b : a;
        shape_corner(s, k, 0, k);
    }
    s->point_count = 4;
    s->face_count = 1;
    return true;
}

static bool check_size(const char *path, const char *name, double value, CohortError *err)
{
    if (isfinite(value) && value >= 0.0 && value <= 1e30)
        return true;
    CO_FAIL(err, COHORT_ERROR_SCENE, "%.80s: %s is %g, which is no size", path, name, value);
    co_error_place(err, NULL, 0, 0, path);
    return false;
}

static bool check_sizes(const CoImplicitDesc *d, const char *path, CohortError *err)
{
    CO_CHECK((unsigned)d->kind <= CO_IMPLICIT_PLANE && d->axis >= 0 && d->axis <= 2, err,
             COHORT_ERROR_ARGUMENT, "%.80s: no such implicit shape or axis", path);
    if (d->kind == CO_IMPLICIT_CUBE)
        return check_size(path, "size", d->size, err);
    if (d->kind == CO_IMPLICIT_PLANE)
        return check_size(path, "width", d->width, err) &&
               check_size(path, "length", d->length, err);
    // Where both ends are given by one attribute they are the same to the bit, NaN included.
    bool has_ends = (d->kind == CO_IMPLICIT_CYLINDER || d->kind == CO_IMPLICIT_CAPSULE) &&
                    memcmp(&d->radius_bottom, &d->radius_top, sizeof d->radius_top) != 0;
    if (!check_size(path, has_ends ? "radiusBottom" : "radius", d->radius_bottom, err))
        return false;
    if (d->kind == CO_IMPLICIT_SPHERE)
        return true;
    return check_size(path, "height", d->height, err) &&
           (d->kind == CO_IMPLICIT_CONE || check_size(path, "radiusTop", d->radius_top, err));
}

bool co_implicit_mesh(const CoImplicitDesc *desc, const char *path, CoArena *arena,
                      CohortMeshDesc *out, CohortError *err)
{
    path = path ? path : "implicit shape";
    if (!check_sizes(desc, path, err))
        return false;
    Shape s = {.arena = arena, .axis = desc->kind == CO_IMPLICIT_SPHERE ? 2 : desc->axis};
    bool ok = desc->kind == CO_IMPLICIT_CUBE    ? make_cube(desc, &s)
              : desc->kind == CO_IMPLICIT_PLANE ? make_plane(desc, &s)
                                                : make_revolved(desc, &s);
    CohortPrimvarDesc *primvars = co_arena_array(arena, 2, sizeof *primvars);
    CO_CHECK(ok && primvars, err, COHORT_ERROR_OUT_OF_MEMORY, "%.80s: out of memory", path);
    primvars[0] = (CohortPrimvarDesc){
        "st", COHORT_INTERPOLATION_FACE_VARYING, 2, s.st, s.st_count, s.st_indices, s.index_count};
    primvars[1] = (CohortPrimvarDesc){"normals",
                                      COHORT_INTERPOLATION_FACE_VARYING,
                                      3,
                                      s.normals,
                                      s.normal_count,
                                      s.normal_indices,
                                      s.index_count};
    *out = (CohortMeshDesc){.path = path,
                            .scheme = COHORT_SCHEME_NONE,
                            .points = s.points,
                            .point_count = s.point_count,
                            .face_vertex_counts = s.counts,
                            .face_count = s.face_count,
                            .face_vertex_indices = s.indices,
                            .face_vertex_index_count = s.index_count,
                            .primvars = primvars,
                            .primvar_count = s.normal_count ? 2 : 1,
                            .material = COHORT_INVALID_ID};
    return true;
}
