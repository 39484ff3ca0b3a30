// How far tessellated points are from OpenSubdiv's other evaluation, and how often edges are used.

#ifndef TEST_LIMIT_CHECK_H
#define TEST_LIMIT_CHECK_H

#include "limit_shapes.h"

#include "geometry/far_reference.h"
#include "geometry/grid.h"

static inline double box_size(const CoMesh *mesh)
{
    CoVec3 d = co_sub(mesh->box_max, mesh->box_min);
    return (double)fmaxf(d.x, fmaxf(d.y, d.z));
}

// Where corner c of a triangle lies on its face, as Ptex counts.
static inline void corner_place(const CoMesh *mesh, uint32_t tri, int c, uint32_t *face,
                                uint32_t *sub, double uv[2])
{
    CoGridPlace g = co_grid_place(mesh->shading, tri);
    *face = g.face;
    *sub = g.sub;
    if (g.n) {
        uv[0] = (double)g.i[c] / g.n;
        uv[1] = (double)g.j[c] / g.n;
        return;
    }
    *sub = c == 1 ? (g.sub + 1) % g.valence : g.sub;
    uv[0] = uv[1] = c == 2 ? 1.0 : 0.0;
}

// The largest distance of `count` random points of a mesh from the reference.
static inline double worst_distance(const CoMesh *mesh, const FarReference *reference, size_t count,
                                    uint64_t *seed)
{
    double worst = 0.0;
    for (size_t k = 0; k < count; k++) {
        *seed = *seed * 6364136223846793005u + 1442695040888963407u;
        uint32_t tri = (uint32_t)((*seed >> 33) % mesh->tri_count), face, sub;
        int c = (int)(*seed >> 20 & 0xffff) % 3;
        double uv[2], want[3];
        corner_place(mesh, tri, c, &face, &sub, uv);
        assert_true(far_reference_limit(reference, face, sub, uv[0], uv[1], want));
        CoVec3 p = mesh_point(mesh, tri, (size_t)c);
        double dx = (double)p.x - want[0], dy = (double)p.y - want[1], dz = (double)p.z - want[2];
        worst = fmax(worst, sqrt(dx * dx + dy * dy + dz * dz));
    }
    return worst;
}

typedef struct EdgeCount {
    uint64_t key;
    uint32_t uses;
} EdgeCount;

typedef struct EdgeTable {
    EdgeCount *slots;
    size_t count;
} EdgeTable;

static inline EdgeTable edge_table(size_t edges)
{
    EdgeTable t = {.count = 16};
    while (t.count < 4 * edges)
        t.count *= 2;
    t.slots = co_alloc_zero(CO_MEMORY_BASE, t.count * sizeof *t.slots);
    assert_non_null(t.slots);
    return t;
}

// How often an edge was added.
static inline uint32_t *edge_uses(EdgeTable *t, uint32_t a, uint32_t b)
{
    uint64_t key = 1 + ((uint64_t)(a < b ? a : b) << 32 | (a < b ? b : a));
    size_t slot = (size_t)(key * 0x9e3779b97f4a7c15u >> 20) & (t->count - 1);
    while (t->slots[slot].key && t->slots[slot].key != key)
        slot = (slot + 1) & (t->count - 1);
    t->slots[slot].key = key;
    return &t->slots[slot].uses;
}

static inline void edge_add(EdgeTable *t, uint32_t a, uint32_t b)
{
    ++*edge_uses(t, a, b);
}

static inline void edge_table_free(EdgeTable *t)
{
    co_free(CO_MEMORY_BASE, t->slots, t->count * sizeof *t->slots);
}

// How many edges are used 1, 3, 4 ... times.
static inline void edge_histogram(EdgeTable *t, size_t out[8])
{
    memset(out, 0, 8 * sizeof *out);
    for (size_t k = 0; k < t->count; k++)
        if (t->slots[k].uses != 0 && t->slots[k].uses != 2)
            out[t->slots[k].uses < 8 ? t->slots[k].uses : 0]++;
    edge_table_free(t);
}

#endif
