// Ptex coordinates of polygon meshes: numbering of sub-faces, coordinates, derivatives.

#include "mesh_fixture.h"

// The point of a Ptex sub-face at (u, v) of a flat polygon.
static CoVec3 sub_face_point(const float *points, uint32_t n, uint32_t k, float u, float v)
{
    CoVec3 center = {0, 0, 0};
    for (uint32_t m = 0; m < n; m++)
        center = co_add(center, co_scale(co_vec3_load(points + 3 * m), 1.0f / (float)n));
    CoVec3 p = co_vec3_load(points + 3 * k);
    CoVec3 next = co_scale(co_add(p, co_vec3_load(points + 3 * ((k + 1) % n))), 0.5f);
    CoVec3 previous = co_scale(co_add(p, co_vec3_load(points + 3 * ((k + n - 1) % n))), 0.5f);
    // Split along (0,0) - (1,1), as the tessellation of sub-faces does.
    if (u >= v)
        return co_add(p, co_add(co_scale(co_sub(next, p), u), co_scale(co_sub(center, next), v)));
    return co_add(p,
                  co_add(co_scale(co_sub(center, previous), u), co_scale(co_sub(previous, p), v)));
}

static void check_polygon_ptex(const float *points, int32_t n)
{
    const int32_t indices[] = {0, 1, 2, 3, 4, 5, 6};
    CohortMeshDesc desc = {.scheme = COHORT_SCHEME_NONE,
                           .path = "/p",
                           .points = points,
                           .point_count = (size_t)n,
                           .face_vertex_counts = &n,
                           .face_count = 1,
                           .face_vertex_indices = indices,
                           .face_vertex_index_count = (size_t)n,
                           .ptex_face_offset = 100};
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    assert_int_equal(mesh.ptex_face_count, n == 4 ? 1 : n);
    bool seen[7] = {0};
    for (uint32_t k = 0; k < 200 * mesh.tri_count; k++) {
        float u = (float)((k * 61) % 200) / 200.0f, v = (1 - u) * (float)((k * 17) % 97) / 97.0f;
        CoSurface s;
        co_mesh_surface(&mesh, k % mesh.tri_count, u, v, &s);
        uint32_t sub = s.ptex_face - 100;
        assert_true(sub < mesh.ptex_face_count);
        seen[sub] = true;
        assert_true(s.ptex_u >= -1e-6f && s.ptex_u <= 1 + 1e-6f);
        assert_true(s.ptex_v >= -1e-6f && s.ptex_v <= 1 + 1e-6f);
        CoVec3 p = sub_face_point(points, (uint32_t)n, sub, s.ptex_u, s.ptex_v);
        assert_vec_near(p, (double)s.p.x, (double)s.p.y, (double)s.p.z, 1e-5);
        float h = 0.01f; // stay in the same half of the sub-face
        CoVec3 moved = sub_face_point(points, (uint32_t)n, sub, s.ptex_u + h, s.ptex_v - h);
        CoVec3 step = co_scale(co_sub(s.ptex_dpdu, s.ptex_dpdv), h);
        if (s.ptex_u > s.ptex_v + 1e-3f)
            assert_vec_near(co_sub(moved, p), (double)step.x, (double)step.y, (double)step.z, 1e-5);
    }
    for (uint32_t sub = 0; sub < mesh.ptex_face_count; sub++)
        assert_true(seen[sub]);
    co_mesh_destroy(&mesh);
}

static void ptex_coordinates_of_polygons(void **state)
{
    (void)state;
    const float triangle[] = {0, 0, 1, 2, 0, 2, 0, 3, 0};
    const float pentagon[] = {0, 0, 1, 2, -1, 1, 3, 1, 1, 1, 3, 1, -1, 1, 1};
    const float dented[] = {0, 0, 0, 4, 0, 0, 4, 4, 0, 2, 3, 0, 0, 4, 0};
    check_polygon_ptex(triangle, 3);
    check_polygon_ptex(pentagon, 5);
    check_polygon_ptex(dented, 5);
    // Not in the plane of two axes, and seen from its other side.
    const float tilted[] = {0, 0, 0, 0, 2, -2, 1, 3, -2, 2, 2, 0, 2, 0, 2, 1, -1, 2};
    check_polygon_ptex(tilted, 6);
}

static void ptex_coordinates_of_quads(void **state)
{
    (void)state;
    // u = x, v = y
    const float points[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 2, 0, 0, 2, 1, 0};
    const int32_t counts[] = {4, 4}, indices[] = {0, 1, 2, 3, 1, 4, 5, 2};
    CohortMeshDesc desc = {.scheme = COHORT_SCHEME_NONE};
    SET_TOPOLOGY(desc, points, counts, indices);
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    for (uint32_t t = 0; t < 4; t++) {
        CoSurface s;
        co_mesh_surface(&mesh, t, 0.2f, 0.7f, &s);
        assert_int_equal(s.ptex_face, t / 2);
        assert_near((double)s.ptex_u, (double)s.p.x - (t / 2), 1e-6);
        assert_near((double)s.ptex_v, (double)s.p.y, 1e-6);
        assert_vec_near(s.ptex_dpdu, 1, 0, 0, 1e-6);
        assert_vec_near(s.ptex_dpdv, 0, 1, 0, 1e-6);
    }
    co_mesh_destroy(&mesh);
}

static void ptex_numbering_counts_ngons(void **state)
{
    (void)state;
    const float points[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 2, 0, 0, 2, 1, 0, 3, 0.5f, 0};
    const int32_t counts[] = {3, 4, 5}, indices[] = {0, 1, 2, 1, 4, 5, 2, 4, 6, 5, 2, 1};
    CohortMeshDesc desc = {.scheme = COHORT_SCHEME_NONE};
    SET_TOPOLOGY(desc, points, counts, indices);
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    assert_int_equal(mesh.ptex_face_count, 9);
    uint32_t lowest[3] = {99, 99, 99};
    for (uint32_t t = 0; t < mesh.tri_count; t++) {
        for (int k = 0; k < 64; k++) {
            CoSurface s;
            float u = (float)(k % 8) / 8.0f, v = (1 - u) * (float)(k / 8) / 8.0f;
            co_mesh_surface(&mesh, t, u, v, &s);
            if (s.ptex_face < lowest[s.face])
                lowest[s.face] = s.ptex_face;
        }
    }
    assert_int_equal(lowest[0], 0);
    assert_int_equal(lowest[1], 3);
    assert_int_equal(lowest[2], 4);
    co_mesh_destroy(&mesh);
}

// Hits of a large regular polygon lie in the sub-face their angle says.
static void sectors_of_a_large_polygon(void **state)
{
    (void)state;
    enum {
        N = 1000
    };
    static float points[3 * N];
    static int32_t indices[N];
    for (int k = 0; k < N; k++) {
        points[3 * k] = (float)cos(6.283185307179586 * k / N);
        points[3 * k + 1] = (float)sin(6.283185307179586 * k / N);
        indices[k] = k;
    }
    const int32_t counts[] = {N};
    for (int left = 0; left < 2; left++) {
        CohortMeshDesc desc = {.scheme = COHORT_SCHEME_NONE, .left_handed = left};
        SET_TOPOLOGY(desc, points, counts, indices);
        CoMesh mesh;
        make_mesh(&desc, &mesh);
        for (uint32_t t = 0; t < mesh.tri_count; t++) {
            CoSurface s;
            co_mesh_surface(&mesh, t, 0.31f, 0.33f, &s);
            double turns = atan2((double)s.p.y, (double)s.p.x) / 6.283185307179586;
            double off = (turns < 0 ? turns + 1 : turns) * N - s.ptex_face;
            off = off > N / 2 ? off - N : off;
            assert_true(off > -0.51 && off < 0.51);
        }
        co_mesh_destroy(&mesh);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ptex_coordinates_of_polygons),
        cmocka_unit_test(ptex_coordinates_of_quads),
        cmocka_unit_test(ptex_numbering_counts_ngons),
        cmocka_unit_test(sectors_of_a_large_polygon),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
