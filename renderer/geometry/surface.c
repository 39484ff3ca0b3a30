#include "geometry/grid.h"
#include "geometry/mesh_internal.h"

static void load_triangle(const CoMesh *mesh, uint32_t tri, CoVec3 p[3])
{
    for (size_t c = 0; c < 3; c++)
        p[c] = co_vec3_load(mesh->points + 3 * (size_t)mesh->indices[3 * (size_t)tri + c]);
}

// One coordinate of the point at barycentrics, in double and rounded once: in float32, 1 - u - v
// alone would leave the plane by as much as corner 0 is far from the origin.
static float interpolate(float a, float b, float c, float u, float v, float *error)
{
    double w = 1.0 - (double)u - (double)v;
    double x = w * (double)a + (double)u * (double)b + (double)v * (double)c;
    float p = (float)x;
    // Half a unit in the last place of p (2^-24), then far more than double can have lost, then
    // what rounding to a subnormal may lose.
    *error = fabsf(p) * 6e-8f + (fabsf(a) + fabsf(b) + fabsf(c)) * 4e-15f + 1e-38f;
    return p;
}

static void find_position(const CoVec3 p[3], float u, float v, CoSurface *out)
{
    out->p.x = interpolate(p[0].x, p[1].x, p[2].x, u, v, &out->p_error.x);
    out->p.y = interpolate(p[0].y, p[1].y, p[2].y, u, v, &out->p_error.y);
    out->p.z = interpolate(p[0].z, p[1].z, p[2].z, u, v, &out->p_error.z);
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

// Corners of the bilinear patch (whole face or sub-quad) a triangle lies in, by their grid points.
static void patch_corners(const CoMesh *mesh, const CoGridPlace *g, uint32_t tri, CoVec3 q[4])
{
    uint32_t local = 2 * (g->j[0] * g->n + g->i[0]) + (g->j[1] > g->j[0]);
    const uint32_t *first = mesh->indices + 3 * (size_t)(tri - local);
    size_t n = g->n;
    size_t index[4] = {first[0], first[6 * (n - 1) + 1], first[6 * (n * n - 1) + 2],
                       first[6 * n * (n - 1) + 5]};
    for (int k = 0; k < 4; k++)
        q[k] = co_vec3_load(mesh->points + 3 * index[k]);
}

// Normal of the bilinear patch at (u, v).
static CoVec3 bilinear_normal(const CoVec3 q[4], float u, float v)
{
    CoVec3 du = co_lerp3(co_sub(q[1], q[0]), co_sub(q[2], q[3]), v);
    CoVec3 dv = co_lerp3(co_sub(q[3], q[0]), co_sub(q[2], q[1]), u);
    return co_normalize(co_cross(du, dv));
}

static void grid_uv(const CoGridPlace *g, float u, float v, float uv[2])
{
    float w = 1.0f - u - v, scale = 1.0f / (float)g->n;
    uv[0] = (w * (float)g->i[0] + u * (float)g->i[1] + v * (float)g->i[2]) * scale;
    uv[1] = (w * (float)g->j[0] + u * (float)g->j[1] + v * (float)g->j[2]) * scale;
}

// Ptex coordinates inside a face split into sub-faces, from barycentrics of fan triangle k: corners
// v[k], v[k+1] and the center. Each fan triangle straddles sub-faces k and k + 1, which meet on the
// line from the middle of edge k to the center.
static void fan_ptex(const CoVec3 q[3], uint32_t k, uint32_t valence, const float b[3],
                     CoSurface *out)
{
    CoVec3 middle = co_scale(co_add(q[0], q[1]), 0.5f);
    CoVec3 inward = co_sub(q[2], middle);
    if (b[0] >= b[1]) {
        out->ptex_face = k;
        out->ptex_u = 2.0f * b[1] + b[2];
        out->ptex_v = b[2];
        out->ptex_dpdu = co_sub(middle, q[0]);
        out->ptex_dpdv = inward;
    } else {
        out->ptex_face = (k + 1) % valence;
        out->ptex_u = b[2];
        out->ptex_v = 2.0f * b[0] + b[2];
        out->ptex_dpdu = inward;
        out->ptex_dpdv = co_sub(middle, q[1]);
    }
}

// A triangle is its own fan around the centroid: the fan triangle is opposite the least
// barycentric.
static void triangle_ptex(const CoVec3 p[3], float u, float v, CoSurface *out)
{
    float b[3] = {1.0f - u - v, u, v};
    uint32_t least = b[1] < b[0] ? 1 : 0;
    least = b[2] < b[least] ? 2 : least;
    uint32_t k = (least + 1) % 3, next = (least + 2) % 3;
    CoVec3 center = co_scale(co_add(co_add(p[0], p[1]), p[2]), 1.0f / 3.0f);
    CoVec3 q[3] = {p[k], p[next], center};
    float fan[3] = {b[k] - b[least], b[next] - b[least], 3.0f * b[least]};
    fan_ptex(q, k, 3, fan, out);
}

// Barycentrics of p projected onto triangle q along n; false when the triangle has no area that
// way.
static bool project_barycentric(const CoVec3 q[3], CoVec3 n, CoVec3 p, float b[3])
{
    CoVec3 e1 = co_sub(q[1], q[0]), e2 = co_sub(q[2], q[0]), d = co_sub(p, q[0]);
    float inverse = 1.0f / co_dot(n, co_cross(e1, e2));
    b[1] = co_dot(n, co_cross(d, e2)) * inverse;
    b[2] = co_dot(n, co_cross(e1, d)) * inverse;
    b[0] = 1.0f - b[1] - b[2];
    return isfinite(b[0]) && isfinite(b[1]) && isfinite(b[2]);
}

// The fan triangle that holds the point best: exact where the polygon is star-shaped around its
// center, else clamped into the nearest.
static void polygon_ptex(const CoMesh *mesh, const CoGridPlace *g, CoSurface *out)
{
    const CoMeshShading *s = mesh->shading;
    const uint32_t *vertices = s->face_vertices + s->corner_first[g->face];
    CoVec3 center = co_vec3(0.0f, 0.0f, 0.0f);
    for (uint32_t k = 0; k < g->valence; k++)
        center = co_add(center, co_vec3_load(mesh->points + 3 * (size_t)vertices[k]));
    center = co_scale(center, 1.0f / (float)g->valence);
    float best = -INFINITY, best_b[3] = {1.0f, 0.0f, 0.0f};
    uint32_t best_k = 0;
    CoVec3 best_q[3] = {center, center, center};
    for (uint32_t k = 0; k < g->valence && best < 0.0f; k++) {
        CoVec3 q[3] = {co_vec3_load(mesh->points + 3 * (size_t)vertices[k]),
                       co_vec3_load(mesh->points + 3 * (size_t)vertices[(k + 1) % g->valence]),
                       center};
        float b[3];
        if (!project_barycentric(q, out->ng, out->p, b))
            continue;
        float inside = fminf(b[0], fminf(b[1], b[2]));
        if (inside <= best)
            continue;
        best = inside;
        best_k = k;
        for (int c = 0; c < 3; c++) {
            best_q[c] = q[c];
            best_b[c] = b[c];
        }
    }
    fan_ptex(best_q, best_k, g->valence, best_b, out);
}

// Corner uv of a quad face.
static const float quad_uv[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};

// dp/du and dp/dv of the affine map from three (u, v) to three points.
static void affine_derivatives(const CoVec3 p[3], float uv[3][2], CoVec3 *dpdu, CoVec3 *dpdv)
{
    CoVec3 e1 = co_sub(p[1], p[0]), e2 = co_sub(p[2], p[0]);
    float u1 = uv[1][0] - uv[0][0], v1 = uv[1][1] - uv[0][1];
    float u2 = uv[2][0] - uv[0][0], v2 = uv[2][1] - uv[0][1];
    float inverse = 1.0f / (u1 * v2 - u2 * v1);
    *dpdu = co_scale(co_sub(co_scale(e1, v2), co_scale(e2, v1)), inverse);
    *dpdv = co_scale(co_sub(co_scale(e2, u1), co_scale(e1, u2)), inverse);
}

// Ptex coordinates of triangles whose corners lie at known (u, v) of one Ptex face.
static void corner_ptex(const CoMesh *mesh, const CoGridPlace *g, uint32_t tri, const CoVec3 p[3],
                        const float b[3], CoSurface *out)
{
    const CoMeshShading *s = mesh->shading;
    float uv[3][2];
    if (g->n > 0) {
        float scale = 1.0f / (float)g->n;
        for (int c = 0; c < 3; c++) {
            uv[c][0] = (float)g->i[c] * scale;
            uv[c][1] = (float)g->j[c] * scale;
        }
    } else {
        // A quad's two triangles: their least face-vertices are corner 0 and corner 0 or 1.
        const uint32_t *corners = s->tri_corners + 3 * (size_t)tri;
        bool is_second = tri > 0 && s->unit_face[tri - 1] == g->face;
        const uint32_t *first = is_second ? corners - 3 : corners;
        for (int c = 0; c < 3; c++) {
            uv[c][0] = quad_uv[corners[c] - first[0]][0];
            uv[c][1] = quad_uv[corners[c] - first[0]][1];
        }
    }
    out->ptex_face = g->sub;
    out->ptex_u = b[0] * uv[0][0] + b[1] * uv[1][0] + b[2] * uv[2][0];
    out->ptex_v = b[0] * uv[0][1] + b[1] * uv[1][1] + b[2] * uv[2][1];
    affine_derivatives(p, uv, &out->ptex_dpdu, &out->ptex_dpdv);
}

static void find_ptex(const CoMesh *mesh, const CoGridPlace *g, uint32_t tri, const CoVec3 p[3],
                      float u, float v, CoSurface *out)
{
    const CoMeshShading *s = mesh->shading;
    float b[3] = {1.0f - u - v, u, v};
    if (g->n > 0 || g->valence == 4)
        corner_ptex(mesh, g, tri, p, b, out);
    else if (s->grid != CO_GRID_POLYGON)
        fan_ptex(p, g->sub, g->valence, b, out);
    else if (g->valence == 3)
        triangle_ptex(p, u, v, out);
    else
        polygon_ptex(mesh, g, out);
    out->ptex_u = co_clamp(out->ptex_u, 0.0f, 1.0f);
    out->ptex_v = co_clamp(out->ptex_v, 0.0f, 1.0f);
    out->ptex_face += s->ptex_face_offset + (s->ptex_first ? s->ptex_first[g->face] : g->face);
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
    if (s->is_bilinear && g->n > 0) {
        CoVec3 q[4];
        float uv[2];
        patch_corners(mesh, g, tri, q);
        grid_uv(g, u, v, uv);
        return bilinear_normal(q, uv[0], uv[1]);
    }
    return co_vec3(0.0f, 0.0f, 0.0f);
}

void co_mesh_surface(const CoMesh *mesh, uint32_t tri, float u, float v, CoSurface *out)
{
    const CoMeshShading *s = mesh->shading;
    CoGridPlace g = co_grid_place(s, tri);
    CoVec3 p[3];
    load_triangle(mesh, tri, p);
    find_position(p, u, v, out);
    CoVec3 ng = triangle_normal(p);
    out->ng = s->left_handed ? co_neg(ng) : ng;
    CoVec3 ns = shading_normal(mesh, &g, tri, u, v);
    float facing = co_dot(ns, out->ng);
    // On the side of ng, or the two would disagree about what is outside.
    if (facing == 0.0f || !isfinite(facing))
        ns = out->ng;
    else if (facing < 0.0f)
        ns = co_neg(ns);
    out->ns = ns;
    out->face = g.face;
    out->material = co_mesh_face_material(mesh, g.face);
    find_ptex(mesh, &g, tri, p, u, v, out);
}
