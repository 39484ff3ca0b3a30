// What a hit looks like: position bounds, normals, materials, Ptex coordinates.

#include "mesh_fixture.h"

static void position_is_within_its_bound(void **state)
{
    (void)state;
    const float points[] = {1e6f, 0.1f, -3, 1e6f + 1, 0.7f, 5, 1e6f, 77.7f, 0.3f};
    const int32_t counts[] = {3}, indices[] = {0, 1, 2};
    CohortMeshDesc desc = {.scheme = COHORT_SCHEME_NONE};
    SET_TOPOLOGY(desc, points, counts, indices);
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    for (int k = 0; k <= 1000; k++) {
        float u = (float)((k * 373) % 1001) / 1001.0f, v = (1.0f - u) * (float)k / 1000.0f;
        CoSurface s;
        co_mesh_surface(&mesh, 0, u, v, &s);
        double exact[3];
        for (int c = 0; c < 3; c++)
            exact[c] = (1.0 - (double)u - (double)v) * (double)points[c] +
                       (double)u * (double)points[3 + c] + (double)v * (double)points[6 + c];
        assert_true(fabs((double)s.p.x - exact[0]) <= (double)s.p_error.x);
        assert_true(fabs((double)s.p.y - exact[1]) <= (double)s.p_error.y);
        assert_true(fabs((double)s.p.z - exact[2]) <= (double)s.p_error.z);
        assert_true(s.p_error.x < 0.07f); // half a unit in the last place of 1e6
    }
    co_mesh_destroy(&mesh);
}

static void position_stays_in_the_plane_of_a_far_triangle(void **state)
{
    (void)state;
    // Corner 0 is far off, the hit next to corners 1 and 2, where its weight is tiny.
    const float points[] = {1e7f, 1e7f, 1e7f, 1, 0, 0, 0, 1, 0};
    const int32_t counts[] = {3}, indices[] = {0, 1, 2};
    CohortMeshDesc desc = {.scheme = COHORT_SCHEME_NONE};
    SET_TOPOLOGY(desc, points, counts, indices);
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    for (int k = 0; k < 1000; k++) {
        float u = (float)k / 1001.0f, v = nextafterf(1.0f - u, 0.0f);
        CoSurface s;
        co_mesh_surface(&mesh, 0, u, v, &s);
        double z = (1.0 - (double)u - (double)v) * 1e7;
        assert_true(fabs((double)s.p.z - z) <= (double)s.p_error.z);
        assert_true(s.p_error.z < 1e-6f);
    }
    co_mesh_destroy(&mesh);
}

static void authored_normals_face_outward(void **state)
{
    (void)state;
    const float points[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const int32_t counts[] = {3}, indices[] = {0, 1, 2};
    const float normals[] = {1, 0, 1, -1, 0, 1, 0, 0, -1};
    const CohortPrimvarDesc primvar = {
        "normals", COHORT_INTERPOLATION_FACE_VARYING, 3, normals, 3, NULL, 0};
    CohortMeshDesc desc = {.scheme = COHORT_SCHEME_NONE, .primvars = &primvar, .primvar_count = 1};
    SET_TOPOLOGY(desc, points, counts, indices);
    CoMesh mesh;
    CoSurface s;
    make_mesh(&desc, &mesh);
    co_mesh_surface(&mesh, 0, 0, 0, &s);
    assert_vec_near(s.ns, sqrt(0.5), 0, sqrt(0.5), 1e-6);
    co_mesh_surface(&mesh, 0, 0.5f, 0, &s);
    assert_vec_near(s.ns, 0, 0, 1, 1e-6);
    co_mesh_surface(&mesh, 0, 0, 1, &s); // authored against the winding
    assert_vec_near(s.ns, 0, 0, 1, 1e-6);
    co_mesh_surface(&mesh, 0, 0.25f, 0.5f, &s); // they cancel
    assert_near((double)co_length(s.ns), 1, 1e-6);
    co_mesh_destroy(&mesh);

    desc.left_handed = true;
    make_mesh(&desc, &mesh);
    co_mesh_surface(&mesh, 0, 0, 0, &s);
    assert_vec_near(s.ng, 0, 0, -1, 0);
    assert_vec_near(s.ns, -sqrt(0.5), 0, -sqrt(0.5), 1e-6);
    co_mesh_destroy(&mesh);
}

static void faceted_without_normals(void **state)
{
    (void)state;
    CohortMeshDesc desc = cube_desc(COHORT_SCHEME_NONE, 0);
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    for (uint32_t t = 0; t < mesh.tri_count; t++) {
        CoSurface s;
        co_mesh_surface(&mesh, t, 0.1f, 0.2f, &s);
        assert_memory_equal(&s.ns, &s.ng, sizeof s.ns);
        assert_true(co_dot(s.ng, s.p) > 0.0f);
    }
    co_mesh_destroy(&mesh);
}

static void subsets_choose_materials(void **state)
{
    (void)state;
    const int32_t first[] = {1, 3, -2}, second[] = {3, 5, 6};
    const CohortSubsetDesc subsets[] = {{first, 3, 40}, {second, 3, 50}};
    CohortMeshDesc desc = cube_desc(COHORT_SCHEME_NONE, 0);
    desc.subsets = subsets;
    desc.subset_count = 2;
    CoMesh mesh;
    assert_int_equal(make_mesh(&desc, &mesh), 2); // out of range; twice
    const uint32_t want[] = {7, 40, 7, 40, 7, 50};
    for (uint32_t t = 0; t < mesh.tri_count; t++) {
        CoSurface s;
        co_mesh_surface(&mesh, t, 0.1f, 0.2f, &s);
        assert_int_equal(s.face, t / 2);
        assert_int_equal(s.material, want[t / 2]);
    }
    co_mesh_destroy(&mesh);
}

static void holes_keep_numbers(void **state)
{
    (void)state;
    const int32_t holes[] = {2, 0, 99};
    CohortMeshDesc desc = cube_desc(COHORT_SCHEME_NONE, 0);
    desc.hole_indices = holes;
    desc.hole_count = 3;
    CoMesh mesh;
    assert_int_equal(make_mesh(&desc, &mesh), 1);
    assert_int_equal(mesh.tri_count, 8);
    assert_int_equal(mesh.ptex_face_count, 6);
    const uint32_t want[] = {1, 3, 4, 5};
    for (uint32_t t = 0; t < 8; t++) {
        CoSurface s;
        co_mesh_surface(&mesh, t, 0.1f, 0.2f, &s);
        assert_int_equal(s.face, want[t / 2]);
        assert_int_equal(s.ptex_face, want[t / 2]);
    }
    co_mesh_destroy(&mesh);
}

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(position_is_within_its_bound),
        cmocka_unit_test(position_stays_in_the_plane_of_a_far_triangle),
        cmocka_unit_test(authored_normals_face_outward),
        cmocka_unit_test(faceted_without_normals),
        cmocka_unit_test(subsets_choose_materials),
        cmocka_unit_test(holes_keep_numbers),
        cmocka_unit_test(ptex_coordinates_of_polygons),
        cmocka_unit_test(ptex_coordinates_of_quads),
        cmocka_unit_test(ptex_numbering_counts_ngons),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
