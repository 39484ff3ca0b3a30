// Descriptions that are wrong, broken or empty, and memory that runs out. Also tests mesh.c.

#include "mesh_fixture.h"

static CohortErrorCode create_fails(const CohortMeshDesc *desc)
{
    CohortError err = {0};
    CoMesh mesh = {.tri_count = 77};
    assert_false(co_mesh_create(desc, &mesh, NULL, NULL, &err));
    assert_int_equal(mesh.tri_count, 77);
    assert_non_null(strstr(err.message, "/test/mesh"));
    assert_string_equal(err.prim_path, "/test/mesh");
    assert_int_equal(co_memory_live(CO_MEMORY_GEOMETRY), 0);
    return err.code;
}

static void structural_faults_are_errors(void **state)
{
    (void)state;
    for (int scheme = 0; scheme <= COHORT_SCHEME_NONE; scheme++) {
        CohortMeshDesc good = cube_desc((CohortScheme)scheme, 1), d = good;
        d.point_count = 7;
        assert_int_equal(create_fails(&d), COHORT_ERROR_SCENE);
        d = good;
        d.face_vertex_index_count--;
        assert_int_equal(create_fails(&d), COHORT_ERROR_SCENE);
        d = good;
        d.face_count--;
        assert_int_equal(create_fails(&d), COHORT_ERROR_SCENE);
        const int32_t negative_count[] = {4, 4, 4, 4, 4, -4}, huge[] = {4, 4, 4, 4, 4, INT32_MAX};
        d = good;
        d.face_vertex_counts = negative_count;
        assert_int_equal(create_fails(&d), COHORT_ERROR_SCENE);
        d.face_vertex_counts = huge;
        assert_int_equal(create_fails(&d), COHORT_ERROR_SCENE);
        int32_t indices[24];
        memcpy(indices, cube_indices, sizeof indices);
        indices[5] = -1;
        d = good;
        d.face_vertex_indices = indices;
        assert_int_equal(create_fails(&d), COHORT_ERROR_SCENE);
        d = good;
        d.points = NULL;
        assert_int_equal(create_fails(&d), COHORT_ERROR_ARGUMENT);
        d = good;
        d.level = 11;
        if (scheme != COHORT_SCHEME_NONE)
            assert_int_equal(create_fails(&d), COHORT_ERROR_ARGUMENT);
        d = good;
        d.point_count = (size_t)1 << 40;
        assert_int_equal(create_fails(&d), COHORT_ERROR_LIMIT);
        float nowhere[24];
        for (int k = 0; k < 24; k++)
            nowhere[k] = k % 3 ? 0.0f : NAN;
        d = good;
        d.points = nowhere;
        assert_int_equal(create_fails(&d), COHORT_ERROR_SCENE);
    }
    CohortMeshDesc d = cube_desc((CohortScheme)8, 1);
    assert_int_equal(create_fails(&d), COHORT_ERROR_ARGUMENT);
}

static void empty_meshes_are_fine(void **state)
{
    (void)state;
    for (int scheme = 0; scheme <= COHORT_SCHEME_NONE; scheme++) {
        CohortMeshDesc desc = {.scheme = (CohortScheme)scheme, .level = 2};
        CoMesh mesh;
        assert_int_equal(make_mesh(&desc, &mesh), 0);
        assert_int_equal(mesh.tri_count, 0);
        co_mesh_destroy(&mesh);
        desc = cube_desc((CohortScheme)scheme, 2);
        desc.face_count = desc.face_vertex_index_count = 0;
        assert_int_equal(make_mesh(&desc, &mesh), 0);
        assert_int_equal(mesh.tri_count, 0);
        co_mesh_destroy(&mesh);
        co_mesh_destroy(&mesh); // a destroyed mesh is an empty one
    }
}

static void broken_points_drop_their_faces(void **state)
{
    (void)state;
    float points[24];
    memcpy(points, cube_points, sizeof points);
    points[7] = INFINITY; // point 2: three faces
    CohortMeshDesc desc = cube_desc(COHORT_SCHEME_NONE, 0);
    desc.points = points;
    CoMesh mesh;
    assert_int_equal(make_mesh(&desc, &mesh), 1);
    assert_int_equal(mesh.tri_count, 6);
    for (uint32_t k = 0; k < 3 * mesh.point_count; k++)
        assert_true(isfinite(mesh.points[k]));
    co_mesh_destroy(&mesh);
}

// What is too far away for areas to be floats is named, and dropped as if it were at infinity.
static void points_out_of_reach_drop_their_faces(void **state)
{
    (void)state;
    for (int scheme = 0; scheme <= COHORT_SCHEME_NONE; scheme++) {
        if (scheme == COHORT_SCHEME_LOOP)
            continue; // quads
        float points[24];
        memcpy(points, cube_points, sizeof points);
        CohortMeshDesc desc = cube_desc((CohortScheme)scheme, 1);
        desc.points = points;
        CoMesh whole, cut;
        points[7] = -1e30f;
        assert_int_equal(make_mesh(&desc, &whole), 0);
        points[7] = INFINITY;
        assert_int_equal(make_mesh(&desc, &cut) > 0, 1);
        uint32_t left = cut.tri_count;
        co_mesh_destroy(&cut);
        points[7] = -3e38f;
        assert_int_equal(make_mesh(&desc, &cut) > 0, 1);
        assert_int_equal(cut.tri_count, left);
        assert_true(left < whole.tri_count);
        co_mesh_destroy(&cut);
        co_mesh_destroy(&whole);
        for (int i = 0; i < 24; i++)
            points[i] *= 1e38f;
        assert_int_equal(create_fails(&desc), COHORT_ERROR_SCENE);
    }
}

static void small_faces_are_dropped(void **state)
{
    (void)state;
    const int32_t counts[] = {2, 0, 4, 1, 3}, indices[] = {0, 1, 0, 1, 2, 3, 5, 4, 5, 6};
    CohortMeshDesc desc = {.scheme = COHORT_SCHEME_NONE};
    SET_TOPOLOGY(desc, cube_points, counts, indices);
    CoMesh mesh;
    assert_int_equal(make_mesh(&desc, &mesh), 1);
    assert_int_equal(mesh.tri_count, 3);
    CoSurface s;
    co_mesh_surface(&mesh, 2, 0.1f, 0.1f, &s);
    assert_int_equal(s.face, 4);
    assert_int_equal(mesh.ptex_face_count, 2 + 0 + 1 + 1 + 3);
    co_mesh_destroy(&mesh);
}

static void allocation_failures(void **state)
{
    (void)state;
    const float st[16] = {0}, corner[24] = {0};
    const int32_t corner_indices[24] = {0};
    const int32_t faces[] = {1};
    const CohortSubsetDesc subset = {faces, 1, 3};
    const CohortPrimvarDesc primvars[] = {
        {"st", COHORT_INTERPOLATION_VERTEX, 2, st, 8, NULL, 0},
        {"f", COHORT_INTERPOLATION_FACE_VARYING, 1, corner, 24, corner_indices, 24},
    };
    for (int scheme = 0; scheme <= COHORT_SCHEME_NONE; scheme++) {
        if (scheme == COHORT_SCHEME_LOOP)
            continue; // quads
        CohortMeshDesc desc = cube_desc((CohortScheme)scheme, 2);
        desc.primvars = primvars;
        desc.primvar_count = 2;
        desc.subsets = &subset;
        desc.subset_count = 1;
        assert_true(refuse_allocations(&desc) > 9);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(structural_faults_are_errors),
        cmocka_unit_test(empty_meshes_are_fine),
        cmocka_unit_test(broken_points_drop_their_faces),
        cmocka_unit_test(points_out_of_reach_drop_their_faces),
        cmocka_unit_test(small_faces_are_dropped),
        cmocka_unit_test(allocation_failures),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
