// Where a triangle lies in its cage face: inverse of the numbering the tessellator uses.
//
// Quad face at level L: n = 2^L squares a side, triangles as patch.h has them. An n-gon: its
// sub-quads one after the other, each with 2^(L-1) squares a side; at level 0 a fan (v[k], v[k+1],
// center).
// Loop triangle: rows j of points (i, j), i + j <= n, which is (i + j, j) in patch.h; a row
// alternates (i,j) (i+1,j) (i,j+1) and (i+1,j) (i+1,j+1) (i,j+1).
// Corner elements: points of these grids row by row, sub-quads one after the other and not shared;
// a fan: its vertices, then its center; polygons: face-vertices.

#ifndef CO_GEOMETRY_GRID_H
#define CO_GEOMETRY_GRID_H

#include "geometry/mesh_internal.h"

static inline uint32_t co_grid_valence(const CoMeshShading *s, uint32_t face)
{
    if (s->grid == CO_GRID_TRIANGLE)
        return 3;
    uint32_t n = s->ptex_first ? s->ptex_first[face + 1] - s->ptex_first[face] : s->ptex_each;
    return n == 1 ? 4 : n;
}

static inline uint32_t co_grid_patch_face(const CoPatchTable *table, uint32_t patch)
{
    if (table->per_face == 0)
        return table->face[patch];
    return table->per_face == 1 ? patch : patch / table->per_face;
}

static inline uint32_t co_grid_face(const CoMeshShading *s, uint32_t tri)
{
    if (s->patches)
        return co_grid_patch_face(s->patches, co_patch_of(s->patches, tri));
    return s->tri_face[tri];
}

static inline CoGridPlace co_grid_place_patch(const CoMeshShading *s, uint32_t tri)
{
    const CoPatchTable *table = s->patches;
    CoGridPlace p = {.patch = co_patch_of(table, tri)};
    p.face = co_grid_patch_face(table, p.patch);
    p.valence = co_grid_valence(s, p.face);
    if (s->face_patch)
        p.sub = p.patch - s->face_patch[p.face];
    else if (table->per_face > 1)
        p.sub = p.patch - p.face * table->per_face;
    uint32_t room[CO_PATCH_WORDS];
    const uint32_t *words = co_patch_words(table, p.patch, room);
    if (co_patch_is_fan(table, words) && !table->is_triangular)
        return p;
    p.n = 1u << co_patch_shift(table, words);
    co_patch_corners(table, words, tri - co_patch_first_tri(table, p.patch), p.i, p.j);
    for (int c = 0; table->is_triangular && c < 3; c++)
        p.i[c] -= p.j[c];
    return p;
}

static inline CoGridPlace co_grid_place(const CoMeshShading *s, uint32_t tri)
{
    if (s->patches)
        return co_grid_place_patch(s, tri);
    CoGridPlace p = {.face = co_grid_face(s, tri)};
    p.valence = co_grid_valence(s, p.face);
    return p;
}

// The level of a face that has triangles.
static inline uint32_t co_grid_level(const CoMeshShading *s, uint32_t face)
{
    if (!s->patches || !s->patches->is_mixed)
        return s->level;
    uint32_t room[CO_PATCH_WORDS];
    const uint32_t *words = co_patch_words(s->patches, s->face_patch[face], room);
    return co_patch_shift(s->patches, words) + (co_patch_inner(s->patches, words) >> 31);
}

// Number of corner elements of a face.
static inline uint64_t co_grid_corner_count(CoGridKind grid, uint32_t level, uint32_t valence)
{
    uint64_t n = 1ull << level;
    if (grid == CO_GRID_POLYGON)
        return valence;
    if (grid == CO_GRID_TRIANGLE)
        return (n + 1) * (n + 2) / 2;
    if (valence == 4)
        return (n + 1) * (n + 1);
    return level == 0 ? valence + 1ull : valence * (n / 2 + 1) * (n / 2 + 1);
}

// Number of triangles of a face.
static inline uint64_t co_grid_tri_count(CoGridKind grid, uint32_t level, uint32_t valence)
{
    uint64_t n = 1ull << level;
    if (grid == CO_GRID_POLYGON)
        return valence - 2ull;
    if (grid == CO_GRID_TRIANGLE)
        return n * n;
    if (valence == 4)
        return 2 * n * n;
    return level == 0 ? valence : valence * (n / 2) * (n / 2) * 2;
}

static inline bool co_grid_has_corners(const CoMeshShading *s)
{
    return s->corner_first || s->corners_each;
}

// First corner element of a face, where there are any.
static inline uint32_t co_grid_corner_first(const CoMeshShading *s, uint32_t face)
{
    return s->corner_first ? s->corner_first[face] : face * s->corners_each;
}

// Place of grid point (i, j) among the points of one loop triangle.
static inline uint32_t co_grid_triangle_point(uint32_t n, uint32_t i, uint32_t j)
{
    return j * (2 * n + 3 - j) / 2 + i;
}

// Corner element of corner c of a triangle.
static inline uint32_t co_grid_corner(const CoMeshShading *s, const CoGridPlace *p, uint32_t tri,
                                      int c)
{
    if (s->grid == CO_GRID_POLYGON)
        return s->tri_corners[3 * (size_t)tri + (size_t)c];
    uint32_t first = co_grid_corner_first(s, p->face);
    if (s->grid == CO_GRID_TRIANGLE)
        return first + co_grid_triangle_point(p->n, p->i[c], p->j[c]);
    if (p->n == 0) // fan
        return first + (c == 2 ? p->valence : (p->sub + (uint32_t)c) % p->valence);
    uint32_t side = p->n + 1;
    return first + p->sub * side * side + p->j[c] * side + p->i[c];
}

// ptex_coord.c: fills the Ptex part of *out, whose p and ng are set. p[]: the triangle's corners.
void co_surface_find_ptex(const CoMesh *mesh, const CoGridPlace *g, uint32_t tri, const CoVec3 p[3],
                          float u, float v, CoSurface *out);

#endif
