// Subdivided meshes for tests of their leaves: of all kinds and levels, and the same triangles
// loose.

#ifndef TESTS_ACCEL_GRID_SCENES_H
#define TESTS_ACCEL_GRID_SCENES_H

#include "accel_scene.h"
#include "base/hash.h"
#include "geometry/subdivision_fixture.h"

// The same triangles with indices.
static inline TestMesh loosen(const CoMesh *mesh)
{
    TestMesh loose = mesh_alloc(mesh->point_count, mesh->tri_count);
    memcpy(loose.points, mesh->points, 12 * (size_t)mesh->point_count);
    for (uint32_t tri = 0; tri < mesh->tri_count; tri++)
        co_mesh_triangle(mesh, tri, loose.indices + 3 * (size_t)tri);
    loose.mesh.box_min = mesh->box_min;
    loose.mesh.box_max = mesh->box_max;
    return loose;
}

// The hits of a placed mesh by the scalar kernel, which those of all others must be.
static inline CoHitBatch trace_placed(const CoMesh *mesh, const CoRayBatch *rays,
                                      CoTraverseStats *stats)
{
    TestScene s = {0};
    TestMesh m = {.mesh = *mesh};
    scene_add_mesh(&s, &m);
    // Twice, or the loose ones would be baked.
    const CoVec3 scale = co_vec3(1.0f, 1.25f, 1.0f);
    CoInstance instances[2] = {place(0, matrix(0.3, scale, co_vec3(0.1f, 0, 0))),
                               place(0, matrix(0.3, scale, co_vec3(20.0f, 0, 0)))};
    scene_add_group(&s, instances, 2);
    CoHitBatch hits = hits_alloc(rays->count);
    traverse_all(&s.scene, rays, NULL, &hits, stats);
    scene_clear(&s);
    return hits;
}

// The hits of a mesh are those of its triangles loose, every bit. Returns how many there are.
static inline size_t compare_with_loose(const CoMesh *mesh, const TestMesh *loose,
                                        const CoRayBatch *rays)
{
    CoTraverseStats a = {0}, b = {0};
    CoHitBatch want = trace_placed(&loose->mesh, rays, &a), got = trace_placed(mesh, rays, &b);
    assert_true(same_bits(want.t, got.t, rays->count));
    assert_true(same_bits(want.tri, got.tri, rays->count));
    assert_true(same_bits(want.u, got.u, rays->count));
    assert_true(same_bits(want.v, got.v, rays->count));
    size_t found = 0;
    for (size_t i = 0; i < rays->count; i++)
        found += got.tri[i] != COHORT_INVALID_ID;
    hits_free(&want);
    hits_free(&got);
    return found;
}

// Quads, with other faces among them, triangles, of either scheme; uniform, and edges of all levels
// up to that.
enum {
    MESHES = 6 * 8
};

static inline void make_number(uint32_t k, CoMesh *mesh)
{
    static Cage cage;
    static uint8_t levels[6 * CAGE_MAX_FACES];
    uint32_t level = k / 8, cage_kind = k % 4;
    bool is_mixed = k / 4 % 2;
    make_torus(&cage, cage_kind == 1, cage_kind >= 2);
    CohortScheme scheme = cage_kind == 2 ? COHORT_SCHEME_LOOP : COHORT_SCHEME_CATMULL_CLARK;
    CohortMeshDesc desc = cage_desc(&cage, scheme, is_mixed ? 0 : level);
    for (uint32_t e = 0; e < COUNT(levels); e++)
        levels[e] = (uint8_t)(co_hash32(e + k) % (level + 1));
    desc.edge_levels = is_mixed ? levels : NULL;
    make_mesh(&desc, mesh);
    assert_non_null(mesh->patches);
}

#endif
