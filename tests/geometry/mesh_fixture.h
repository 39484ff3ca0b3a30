// Small meshes and checks shared by the tests of geometry.

#ifndef TEST_MESH_FIXTURE_H
#define TEST_MESH_FIXTURE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/memory.h"
#include "base/parallel.h"
#include "geometry/mesh.h"
#include "support/faults.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define COUNT(a) (sizeof(a) / sizeof *(a))

// Fills the topology of a description from arrays.
#define SET_TOPOLOGY(desc, p, counts, indices) \
    do { \
        (desc).path = "/test/mesh"; \
        (desc).points = (p); \
        (desc).point_count = COUNT(p) / 3; \
        (desc).face_vertex_counts = (counts); \
        (desc).face_count = COUNT(counts); \
        (desc).face_vertex_indices = (indices); \
        (desc).face_vertex_index_count = COUNT(indices); \
    } while (0)

typedef struct Warnings {
    int count;
    char last[256];
} Warnings;

static inline void count_warning(void *cookie, const char *text)
{
    Warnings *w = cookie;
    w->count++;
    snprintf(w->last, sizeof w->last, "%s", text);
}

// Creates a mesh that must succeed; returns the number of warnings.
static inline int make_mesh(const CohortMeshDesc *desc, CoMesh *mesh)
{
    Warnings warnings = {0};
    CohortError err = {0};
    if (!co_mesh_create(desc, mesh, count_warning, &warnings, &err))
        fail_msg("%s", err.message);
    return warnings.count;
}

// Makes a mesh with each of its allocations refused: an error each time, nothing leaks. Returns how
// many there are.
static inline uint64_t refuse_allocations(const CohortMeshDesc *desc)
{
    TestFaults faults = {0};
    while (test_faults_next(&faults)) {
        CoMesh mesh;
        CohortError err = {0};
        test_faults_begin(&faults);
        bool is_made = co_mesh_create(desc, &mesh, NULL, NULL, &err);
        test_faults_end(&faults, is_made, &err);
        if (!is_made)
            continue;
        assert_int_equal(co_memory_live(CO_MEMORY_GEOMETRY), mesh.bytes);
        co_mesh_destroy(&mesh);
    }
    assert_int_equal(co_memory_live(CO_MEMORY_GEOMETRY), 0);
    return faults.count;
}

static inline CoVec3 mesh_point(const CoMesh *mesh, uint32_t tri, size_t corner)
{
    uint32_t point[3];
    co_mesh_triangle(mesh, tri, point);
    return co_vec3_load(mesh->points + 3 * (size_t)point[corner]);
}

// Whether two corners of a triangle are one point.
static inline bool tri_collapses(const CoMesh *mesh, uint32_t tri)
{
    uint32_t p[3];
    co_mesh_triangle(mesh, tri, p);
    return p[0] == p[1] || p[1] == p[2] || p[2] == p[0];
}

static inline double tri_area(const CoMesh *mesh, uint32_t tri)
{
    CoVec3 p = mesh_point(mesh, tri, 0);
    CoVec3 e1 = co_sub(mesh_point(mesh, tri, 1), p), e2 = co_sub(mesh_point(mesh, tri, 2), p);
    return 0.5 * (double)co_length(co_cross(e1, e2));
}

static inline double mesh_area(const CoMesh *mesh)
{
    double area = 0.0;
    for (uint32_t t = 0; t < mesh->tri_count; t++)
        area += tri_area(mesh, t);
    return area;
}

// Six times the signed volume, by the winding of the triangles.
static inline double mesh_volume6(const CoMesh *mesh)
{
    double volume = 0.0;
    for (uint32_t t = 0; t < mesh->tri_count; t++)
        volume += (double)co_dot(mesh_point(mesh, t, 0),
                                 co_cross(mesh_point(mesh, t, 1), mesh_point(mesh, t, 2)));
    return volume;
}

// Number of directed edges whose reverse does not occur exactly as often: 0 for a closed mesh whose
// neighbors share points by index.
static inline size_t open_edges(const CoMesh *mesh)
{
    size_t slots = 1;
    while (slots < 12 * (size_t)mesh->tri_count + 16)
        slots *= 2;
    struct Slot {
        uint64_t key;
        int balance;
    } *table = co_alloc_zero(CO_MEMORY_BASE, slots * sizeof *table);
    assert_non_null(table);
    for (size_t k = 0; k < 3 * (size_t)mesh->tri_count; k++) {
        uint32_t point[3];
        co_mesh_triangle(mesh, (uint32_t)(k / 3), point);
        uint32_t a = point[k % 3], b = point[(k + 1) % 3];
        uint64_t key = 1 + ((uint64_t)(a < b ? a : b) << 32 | (a < b ? b : a));
        size_t slot = (size_t)(key * 0x9e3779b97f4a7c15u) & (slots - 1);
        if (a == b) // of a triangle that has collapsed; its other edges are one, back and forth
            continue;
        while (table[slot].key && table[slot].key != key)
            slot = (slot + 1) & (slots - 1);
        table[slot].key = key;
        table[slot].balance += a < b ? 1 : -1;
    }
    size_t open = 0;
    for (size_t k = 0; k < slots; k++)
        open += table[k].balance != 0;
    co_free(CO_MEMORY_BASE, table, slots * sizeof *table);
    return open;
}

static inline void assert_near(double a, double b, double tolerance)
{
    if (!(fabs(a - b) <= tolerance))
        fail_msg("%.9g is not within %g of %.9g", a, tolerance, b);
}

static inline void assert_vec_near(CoVec3 a, double x, double y, double z, double tolerance)
{
    if (!(fabs((double)a.x - x) <= tolerance && fabs((double)a.y - y) <= tolerance &&
          fabs((double)a.z - z) <= tolerance))
        fail_msg("(%g, %g, %g) is not within %g of (%g, %g, %g)", (double)a.x, (double)a.y,
                 (double)a.z, tolerance, x, y, z);
}

static const float cube_points[] = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1,
                                    -1, -1, 1,  1, -1, 1,  1, 1, 1,  -1, 1, 1};
static const int32_t cube_counts[] = {4, 4, 4, 4, 4, 4};
static const int32_t cube_indices[] = {0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4,
                                       2, 3, 7, 6, 0, 4, 7, 3, 1, 2, 6, 5};

static inline CohortMeshDesc cube_desc(CohortScheme scheme, uint32_t level)
{
    CohortMeshDesc desc = {.scheme = scheme, .level = level, .material = 7};
    SET_TOPOLOGY(desc, cube_points, cube_counts, cube_indices);
    return desc;
}

#endif
