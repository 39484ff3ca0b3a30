// Cages for the tests of subdivision: tori with and without n-gons, flat grids.

#ifndef TEST_SUBDIVISION_FIXTURE_H
#define TEST_SUBDIVISION_FIXTURE_H

#include "mesh_fixture.h"

#define CAGE_MAX_POINTS 400
#define CAGE_MAX_FACES 400

typedef struct Cage {
    float points[3 * CAGE_MAX_POINTS];
    int32_t counts[CAGE_MAX_FACES];
    int32_t indices[6 * CAGE_MAX_FACES];
    size_t point_count, face_count, index_count;
} Cage;

static inline void cage_face(Cage *cage, int32_t count, const int32_t *vertices)
{
    cage->counts[cage->face_count++] = count;
    for (int32_t k = 0; k < count; k++)
        cage->indices[cage->index_count++] = vertices[k];
}

static inline CohortMeshDesc cage_desc(const Cage *cage, CohortScheme scheme, uint32_t level)
{
    CohortMeshDesc desc = {.path = "/test/mesh",
                           .scheme = scheme,
                           .level = level,
                           .points = cage->points,
                           .point_count = cage->point_count,
                           .face_vertex_counts = cage->counts,
                           .face_count = cage->face_count,
                           .face_vertex_indices = cage->indices,
                           .face_vertex_index_count = cage->index_count};
    return desc;
}

static inline void torus_points(Cage *cage, int32_t nu, int32_t nv)
{
    for (int32_t j = 0; j < nv; j++) {
        for (int32_t i = 0; i < nu; i++) {
            double a = 6.283185307179586 * i / nu, b = 6.283185307179586 * j / nv;
            float *p = cage->points + 3 * cage->point_count++;
            p[0] = (float)((3 + cos(b)) * cos(a));
            p[1] = (float)((3 + cos(b)) * sin(a));
            p[2] = (float)sin(b);
        }
    }
}

// A torus of quads. Mixed: some are two triangles, some pairs are one hexagon. Triangles: all are.
static inline void make_torus(Cage *cage, bool mixed, bool triangles)
{
    enum {
        NU = 12,
        NV = 8
    };
    memset(cage, 0, sizeof *cage);
    torus_points(cage, NU, NV);
    for (int32_t j = 0; j < NV; j++) {
        for (int32_t i = 0; i < NU; i++) {
            int32_t next = (i + 1) % NU, up = (j + 1) % NV;
            int32_t v[4] = {j * NU + i, j * NU + next, up * NU + next, up * NU + i};
            bool hexagon = mixed && j % 3 == 0 && i % 4 == 0;
            if (triangles || (mixed && (i + j) % 5 == 3 && j % 3 != 0)) {
                const int32_t first[] = {v[0], v[1], v[2]}, second[] = {v[0], v[2], v[3]};
                cage_face(cage, 3, first);
                cage_face(cage, 3, second);
            } else if (hexagon) {
                int32_t far = (i + 2) % NU;
                const int32_t hex[] = {v[0], v[1], j * NU + far, up * NU + far, v[2], v[3]};
                cage_face(cage, 6, hex);
                i++;
            } else {
                cage_face(cage, 4, v);
            }
        }
    }
}

// n x n unit quads in the xy plane, or twice as many triangles; face (i, j) row by row.
static inline void make_grid(Cage *cage, int32_t n, bool triangles)
{
    memset(cage, 0, sizeof *cage);
    for (int32_t j = 0; j <= n; j++) {
        for (int32_t i = 0; i <= n; i++) {
            float *p = cage->points + 3 * cage->point_count++;
            p[0] = (float)i;
            p[1] = (float)j;
        }
    }
    for (int32_t j = 0; j < n; j++) {
        for (int32_t i = 0; i < n; i++) {
            int32_t a = j * (n + 1) + i;
            const int32_t v[4] = {a, a + 1, a + n + 2, a + n + 1};
            const int32_t first[] = {v[0], v[1], v[3]}, second[] = {v[1], v[2], v[3]};
            if (triangles) {
                cage_face(cage, 3, first);
                cage_face(cage, 3, second);
            } else {
                cage_face(cage, 4, v);
            }
        }
    }
}

// Compares everything that reaches an image, bit for bit.
static inline void assert_same_mesh(const CoMesh *a, const CoMesh *b)
{
    assert_int_equal(a->point_count, b->point_count);
    assert_int_equal(a->tri_count, b->tri_count);
    assert_memory_equal(a->points, b->points, 3 * sizeof(float) * a->point_count);
    for (uint32_t t = 0; t < a->tri_count; t++) {
        uint32_t of_a[3], of_b[3];
        co_mesh_triangle(a, t, of_a);
        co_mesh_triangle(b, t, of_b);
        assert_memory_equal(of_a, of_b, sizeof of_a);
        CoSurface sa, sb;
        memset(&sa, 0, sizeof sa);
        memset(&sb, 0, sizeof sb);
        co_mesh_surface(a, t, 0.25f, 0.375f, &sa);
        co_mesh_surface(b, t, 0.25f, 0.375f, &sb);
        assert_memory_equal(&sa, &sb, sizeof sa);
    }
}

#endif
