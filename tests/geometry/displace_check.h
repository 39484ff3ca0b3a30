// Displacement that tears at every seam, and what must hold of a mesh nevertheless.

#ifndef TEST_DISPLACE_CHECK_H
#define TEST_DISPLACE_CHECK_H

#include "base/hash.h"
#include "geometry/displace.h"
#include "mesh_fixture.h"

// A CoDisplaceFn; *cookie: the most, a float. Another amount for every triangle and corner, as
// behind a seam at every edge.
static inline bool at_random(void *cookie, const CoDisplacePoint *points, size_t count,
                             float *amounts, CohortError *err)
{
    (void)err;
    for (size_t k = 0; k < count; k++) {
        uint32_t key = 3 * points[k].tri + (points[k].u > 0 ? 1 : points[k].v > 0 ? 2 : 0);
        amounts[k] = *(const float *)cookie * (float)(co_hash32(key) >> 8) * 0x1p-24f;
    }
    return true;
}

// Each point has moved once, by no more than `most`, and some by more than half of it.
static inline void check_moved_once(const CoMesh *rest, const CoMesh *mesh, float most)
{
    float farthest = 0.0f;
    assert_true(co_mesh_same_topology(rest, mesh));
    for (size_t p = 0; p < mesh->point_count; p++) {
        CoVec3 from = co_vec3_load(rest->points + 3 * p);
        float way = co_length(co_sub(co_vec3_load(mesh->points + 3 * p), from));
        assert_true(way <= most * 1.0001f);
        farthest = fmaxf(farthest, way);
    }
    assert_true(farthest > 0.5f * most);
}

// Shading normals are of unit length and on the side of the triangle.
static inline void check_shading_normals(const CoMesh *mesh)
{
    for (uint32_t t = 0; t < mesh->tri_count; t++) {
        CoSurface s;
        co_mesh_surface(mesh, t, 0.3f, 0.3f, &s);
        assert_near((double)co_length(s.ns), 1.0, 1e-5);
        assert_true(co_dot(s.ns, s.ng) >= 0.0f);
    }
}

#endif
