// What a hit looks like: position bounds, normals, faces.

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(position_is_within_its_bound),
        cmocka_unit_test(position_stays_in_the_plane_of_a_far_triangle),
        cmocka_unit_test(authored_normals_face_outward),
        cmocka_unit_test(faceted_without_normals),
        cmocka_unit_test(holes_keep_numbers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
