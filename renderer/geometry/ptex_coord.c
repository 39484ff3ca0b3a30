// Ptex coordinates of a hit: which Ptex face of the cage, where in it, and how p moves with them.
//
// A face of n vertices, n other than 4, is n Ptex sub-faces around its center, the average of its
// vertices; sub-face k runs from vertex k, (0,0), over the middle of the edge that follows, (1,0),
// to the center, (1,1), and the middle of the edge before, (0,1).

#include "geometry/grid.h"
#include "geometry/mesh_internal.h"

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

// Fan triangle k of a polygon: its vertices k and k + 1 and its center.
static void fan_triangle(const CoMesh *mesh, const CoGridPlace *g, uint32_t k, CoVec3 q[3])
{
    const CoMeshShading *s = mesh->shading;
    const uint32_t *vertices = s->face_vertices + s->corner_first[g->face];
    q[0] = co_vec3_load(mesh->points + 3 * (size_t)vertices[k]);
    q[1] = co_vec3_load(mesh->points + 3 * (size_t)vertices[(k + 1) % g->valence]);
    q[2] = co_vec3_load(s->face_centers + 3 * (size_t)g->face);
}

static float turn(CoVec3 n, CoVec3 a, CoVec3 b)
{
    return co_dot(n, co_cross(a, b));
}

// The fan triangle in whose sector around the center p lies, by bisection: right where the polygon
// is star-shaped around its center, for then its vertices go around in order.
static uint32_t find_sector(const CoMesh *mesh, const CoGridPlace *g, CoVec3 n, CoVec3 p)
{
    CoVec3 q[3];
    fan_triangle(mesh, g, 0, q);
    CoVec3 center = q[2], start = co_sub(q[0], center), d = co_sub(p, center);
    bool d_late = turn(n, start, d) < 0.0f;
    uint32_t lo = 0, hi = g->valence; // vertex lo is at or before d, vertex hi after it
    while (hi - lo > 1) {
        uint32_t middle = lo + (hi - lo) / 2;
        fan_triangle(mesh, g, middle, q);
        CoVec3 m = co_sub(q[0], center);
        bool m_late = turn(n, start, m) < 0.0f;
        bool before = m_late == d_late ? turn(n, m, d) >= 0.0f : d_late;
        lo = before ? middle : lo;
        hi = before ? hi : middle;
    }
    return lo;
}

// The fan triangle that holds the point best: found by its sector, else the one that comes nearest.
static void polygon_ptex(const CoMesh *mesh, const CoGridPlace *g, CoSurface *out)
{
    const float slack = -1e-3f;
    CoVec3 n = mesh->shading->left_handed ? co_neg(out->ng) : out->ng;
    float best = -INFINITY, best_b[3] = {1.0f, 0.0f, 0.0f};
    uint32_t first = find_sector(mesh, g, n, out->p), best_k = first;
    for (uint32_t i = 0; i < g->valence && best < slack; i++) {
        uint32_t k = (first + i) % g->valence;
        CoVec3 q[3];
        float b[3];
        fan_triangle(mesh, g, k, q);
        if (!project_barycentric(q, n, out->p, b))
            continue;
        float inside = fminf(b[0], fminf(b[1], b[2]));
        if (inside <= best)
            continue;
        best = inside;
        best_k = k;
        for (int c = 0; c < 3; c++)
            best_b[c] = b[c];
    }
    CoVec3 q[3];
    fan_triangle(mesh, g, best_k, q);
    fan_ptex(q, best_k, g->valence, best_b, out);
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
        bool is_second = tri > 0 && s->tri_face[tri - 1] == g->face;
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

void co_surface_find_ptex(const CoMesh *mesh, const CoGridPlace *g, uint32_t tri, const CoVec3 p[3],
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
    out->ptex_face +=
        s->ptex_face_offset + (s->ptex_first ? s->ptex_first[g->face] : g->face * s->ptex_each);
}
