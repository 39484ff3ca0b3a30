// Which material a face has: the mesh's, or that of the first subset which names it.

#include "mesh_fixture.h"

static void the_first_subset_counts(void **state)
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
        assert_int_equal(co_mesh_face_material(&mesh, co_mesh_tri_face(&mesh, t)), want[t / 2]);
    }
    co_mesh_destroy(&mesh);
}

// Without subsets, and with subsets of nothing, all faces are the mesh's own.
static void without_faces_nothing_changes(void **state)
{
    (void)state;
    const CohortSubsetDesc none = {NULL, 0, 40};
    for (size_t count = 0; count < 2; count++) {
        CohortMeshDesc desc = cube_desc(COHORT_SCHEME_NONE, 0);
        desc.subsets = &none;
        desc.subset_count = count;
        CoMesh mesh;
        assert_int_equal(make_mesh(&desc, &mesh), 0);
        for (uint32_t face = 0; face < 6; face++)
            assert_int_equal(co_mesh_face_material(&mesh, face), 7);
        co_mesh_destroy(&mesh);
    }
}

// One subset may name a face twice, and two that agree may share one: neither is worth a word.
static void agreeing_subsets_are_silent(void **state)
{
    (void)state;
    const int32_t faces[] = {2, 2, 4};
    const CohortSubsetDesc subsets[] = {{faces, 3, 40}, {faces + 2, 1, 40}};
    CohortMeshDesc desc = cube_desc(COHORT_SCHEME_NONE, 0);
    desc.subsets = subsets;
    desc.subset_count = 2;
    CoMesh mesh;
    assert_int_equal(make_mesh(&desc, &mesh), 0);
    assert_int_equal(co_mesh_face_material(&mesh, 2), 40);
    assert_int_equal(co_mesh_face_material(&mesh, 3), 7);
    co_mesh_destroy(&mesh);
}

// Triangles of a subdivided face have the material of their face.
static void subdivided_faces_keep_theirs(void **state)
{
    (void)state;
    const int32_t face = 5;
    const CohortSubsetDesc subset = {&face, 1, 40};
    CohortMeshDesc desc = cube_desc(COHORT_SCHEME_CATMULL_CLARK, 2);
    desc.subsets = &subset;
    desc.subset_count = 1;
    CoMesh mesh;
    make_mesh(&desc, &mesh);
    uint32_t found = 0;
    for (uint32_t t = 0; t < mesh.tri_count; t++) {
        uint32_t material = co_mesh_face_material(&mesh, co_mesh_tri_face(&mesh, t));
        assert_int_equal(material, co_mesh_tri_face(&mesh, t) == 5 ? 40 : 7);
        found += material == 40;
    }
    assert_int_equal(found, mesh.tri_count / 6);
    co_mesh_destroy(&mesh);
}

static void missing_arrays_are_errors(void **state)
{
    (void)state;
    const CohortSubsetDesc lacking = {NULL, 3, 40};
    CohortMeshDesc desc = cube_desc(COHORT_SCHEME_NONE, 0);
    desc.subset_count = 1;
    for (int k = 0; k < 2; k++) {
        CoMesh mesh;
        CohortError err = {0};
        desc.subsets = k ? &lacking : NULL;
        assert_false(co_mesh_create(&desc, &mesh, NULL, NULL, &err));
        assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_first_subset_counts),
        cmocka_unit_test(without_faces_nothing_changes),
        cmocka_unit_test(agreeing_subsets_are_silent),
        cmocka_unit_test(subdivided_faces_keep_theirs),
        cmocka_unit_test(missing_arrays_are_errors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
