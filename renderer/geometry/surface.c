// What a hit point looks like: position and its error, normals, derivatives, Ptex coordinates.

#include "geometry/grid.h"
#include "geometry/mesh_internal.h"
#include "geometry/unit_code.h"

static void load_triangle(const CoMesh *mesh, uint32_t tri, CoVec3 p[3])
{
    uint32_t point[3];
    co_mesh_triangle(mesh, tri, point);
    for (int c = 0; c < 3; c++)
        p[c] = co_vec3_load(mesh->points + 3 * (size_t)point[c]);
}

// Of a coordinate p made in double of those of the corners: half a unit in its last place (2^-24),
// then far more than double can have lost, then what rounding to a subnormal may lose.
static float rounding(float p, float a, float b, float c)
{
    return fabsf(p) * 6e-8f + (fabsf(a) + fabsf(b) + fabsf(c)) * 4e-15f + 1e-38f;
}

// One coordinate of the point at barycentrics, in double and rounded once: in float32, 1 - u - v
// alone would leave the plane by as much as corner 0 is far from the origin.
static float interpolate(float a, float b, float c, float u, float v, float *error)
{
    double w = 1.0 - (double)u - (double)v;
    double x = w * (double)a + (double)u * (double)b + (double)v * (double)c;
    float p = (float)x;
    *error = rounding(p, a, b, c);
    return p;
}

static void find_position(const CoVec3 p[3], float u, float v, CoSurface *out)
{
    out->p.x = interpolate(p[0].x, p[1].x, p[2].x, u, v, &out->p_error.x);
    out->p.y = interpolate(p[0].y, p[1].y, p[2].y, u, v, &out->p_error.y);
    out->p.z = interpolate(p[0].z, p[1].z, p[2].z, u, v, &out->p_error.z);
}

#define TEST_ERROR (16.0f * 0x1p-24f)

// Where a triangle is so many times as large as the coordinates of a ray that leaves it, the test
// takes doubles (CO_VAST in accel/kernels/triangle.h), so that no more is to be feared than of a
// triangle that is not.
#define VAST 16.0f

// The triangle test works on corners relative to the ray's origin, in float32: its error in the
// distance along the normal is a few units in the last place of the largest of these (Pharr, Jakob,
// Humphreys, "Physically Based Rendering", 6.8.4, bounds it by gamma(7) or so). Twice that is kept.
static float test_reach(const CoVec3 p[3])
{
    CoVec3 a = co_sub(p[1], p[0]), b = co_sub(p[2], p[0]), c = co_sub(p[2], p[1]);
    float size = 0.0f;
    const CoVec3 edges[3] = {a, b, c};
    for (int i = 0; i < 3; i++)
        size =
            co_max(size, co_max(fabsf(edges[i].x), co_max(fabsf(edges[i].y), fabsf(edges[i].z))));
    return TEST_ERROR * size;
}

// The triangle's normal in double: float32 would lose that of a sliver. Where there is none, +z, so
// that it is a unit vector whatever was hit.
static CoVec3 triangle_normal(const CoVec3 p[3])
{
    double a[3] = {(double)p[1].x - (double)p[0].x, (double)p[1].y - (double)p[0].y,
                   (double)p[1].z - (double)p[0].z};
    double b[3] = {(double)p[2].x - (double)p[0].x, (double)p[2].y - (double)p[0].y,
                   (double)p[2].z - (double)p[0].z};
    double n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (!(length > 0.0))
        return co_vec3(0.0f, 0.0f, 1.0f);
    return co_vec3((float)(n[0] / length), (float)(n[1] / length), (float)(n[2] / length));
}

static void grid_uv(const CoGridPlace *g, float u, float v, float uv[2])
{
    float w = 1.0f - u - v, scale = 1.0f / (float)g->n;
    uv[0] = (w * (float)g->i[0] + u * (float)g->i[1] + v * (float)g->i[2]) * scale;
    uv[1] = (w * (float)g->j[0] + u * (float)g->j[1] + v * (float)g->j[2]) * scale;
}

// Of a quad, as if its surface were bilinear.
static CoVec3 quad_normal(const CoMesh *mesh, const CoGridPlace *g, float u, float v)
{
    const CoPatchTable *table = mesh->shading->patches;
    uint32_t room[CO_PATCH_WORDS];
    const uint32_t *words = co_patch_words(table, g->patch, room);
    CoVec3 q[4];
    float uv[2];
    for (int k = 0; k < 4; k++)
        q[k] = co_vec3_load(mesh->points + 3 * (size_t)words[CO_PATCH_CORNER + k]);
    grid_uv(g, u, v, uv);
    return co_bilinear_normal(q, uv[0], uv[1]);
}

// Interpolated limit normal; the zero vector where that is the triangle's own.
static CoVec3 limit_normal(const CoMesh *mesh, const CoGridPlace *g, uint32_t tri, float u, float v)
{
    const CoMeshShading *s = mesh->shading;
    const float weight[3] = {1.0f - u - v, u, v};
    uint32_t point[3];
    co_mesh_triangle(mesh, tri, point);
    CoVec3 n = co_vec3_splat(0.0f);
    for (int c = 0; c < 3; c++) {
        uint32_t at = point[c];
        if (s->has_corner_normals)
            at = co_mesh_normal_at(s, co_grid_corner(s, g, tri, c), at);
        const uint32_t code = s->limit_normals[at];
        if (code == CO_UNIT_DERIVED) // so are those of the whole face
            return s->grid == CO_GRID_QUAD && g->valence == 4 ? quad_normal(mesh, g, u, v)
                                                              : co_vec3_splat(0.0f);
        n = co_madd(n, co_unit_decode(code), weight[c]);
    }
    return co_normalize(n);
}

static CoVec3 shading_normal(const CoMesh *mesh, const CoGridPlace *g, uint32_t tri, float u,
                             float v)
{
    const CoMeshShading *s = mesh->shading;
    if (s->normals.values) {
        float n[3];
        co_primvar_eval(mesh, &s->normals, tri, u, v, n);
        return co_normalize(co_vec3_load(n));
    }
    if (s->limit_normals)
        return limit_normal(mesh, g, tri, u, v);
    if (s->is_bilinear && g->n > 0)
        return quad_normal(mesh, g, u, v);
    return co_vec3_splat(0.0f);
}

void co_triangle_make(const CoMesh *mesh, uint32_t tri, CoTriangle *out)
{
    const CoMeshShading *s = mesh->shading;
    out->mesh = mesh;
    out->tri = tri;
    out->place = co_grid_place(s, tri);
    out->material = co_mesh_face_material(mesh, out->place.face);
    load_triangle(mesh, tri, out->p);
    out->reach = test_reach(out->p);
    out->center = co_scale(co_add(co_add(out->p[0], out->p[1]), out->p[2]), 1.0f / 3.0f);
    CoVec3 ng = triangle_normal(out->p);
    out->ng = s->left_handed ? co_neg(ng) : ng;
}

void co_triangle_surface(const CoTriangle *triangle, float u, float v, CoSurface *out)
{
    find_position(triangle->p, u, v, out);
    out->reach = triangle->reach;
    out->start = co_madd(out->p, co_sub(triangle->center, out->p), 64.0f * 0x1p-24f);
    out->ng = triangle->ng;
    CoVec3 ns = shading_normal(triangle->mesh, &triangle->place, triangle->tri, u, v);
    float facing = co_dot(ns, out->ng);
    // On the side of ng, or the two would disagree about what is outside.
    if (facing == 0.0f || !isfinite(facing))
        ns = out->ng;
    else if (facing < 0.0f)
        ns = co_neg(ns);
    out->ns = ns;
    out->face = triangle->place.face;
    out->material = triangle->material;
}

bool co_triangle_is_vast(const CoTriangle *triangle, float size)
{
    return triangle->mesh->is_flat && triangle->reach > VAST * TEST_ERROR * size;
}

void co_triangle_settle(const CoTriangle *triangle, const double q[3], float size, CoSurface *out)
{
    const CoVec3 *p = triangle->p;
    double a[3], b[3], height = 0.0, square = 0.0;
    for (int k = 0; k < 3; k++) {
        a[k] = (double)(&p[1].x)[k] - (double)(&p[0].x)[k];
        b[k] = (double)(&p[2].x)[k] - (double)(&p[0].x)[k];
    }
    const double n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                         a[0] * b[1] - a[1] * b[0]};
    for (int k = 0; k < 3; k++) {
        height += n[k] * (q[k] - (double)(&p[0].x)[k]);
        square += n[k] * n[k];
    }
    if (!(square > 0.0))
        return;
    float *at = &out->p.x, *error = &out->p_error.x;
    for (int k = 0; k < 3; k++) {
        at[k] = (float)(q[k] - height / square * n[k]);
        error[k] = rounding(at[k], (&p[0].x)[k], (&p[1].x)[k], (&p[2].x)[k]);
    }
    out->reach = VAST * TEST_ERROR * size;
    float drawn = 64.0f * 0x1p-24f * (out->reach / triangle->reach);
    out->start = co_madd(out->p, co_sub(triangle->center, out->p), drawn);
}

void co_triangle_ptex(const CoTriangle *triangle, float u, float v, CoSurface *out)
{
    co_surface_find_ptex(triangle->mesh, &triangle->place, triangle->tri, triangle->p, u, v, out);
}

void co_mesh_surface(const CoMesh *mesh, uint32_t tri, float u, float v, CoSurface *out)
{
    CoTriangle triangle;
    co_triangle_make(mesh, tri, &triangle);
    co_triangle_surface(&triangle, u, v, out);
    co_triangle_ptex(&triangle, u, v, out);
}
