// Meshes of a host: levels, materials of subsets, and edits that are less than they say, or more.

#include "index_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

// What the host gives next.
static CohortMeshSource source;
static CohortSubsetDesc subset;
static const char *subset_material;

static bool get_mesh(void *cookie, CohortPull *pull, const char *path, CohortMeshSource *out,
                     CohortError *err)
{
    (void)cookie, (void)pull, (void)path, (void)err;
    *out = source;
    return true;
}

static void open_mesh(void)
{
    static const int32_t counts[] = {3}, indices[] = {0, 1, 2};
    static const float points[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const CohortPointsSample sample = {.points = points};
    source = (CohortMeshSource){.points = &sample, .points_sample_count = 1};
    source.mesh = (CohortMeshDesc){.scheme = COHORT_SCHEME_CATMULL_CLARK,
                                   .point_count = 3,
                                   .face_vertex_counts = counts,
                                   .face_count = 1,
                                   .face_vertex_indices = indices,
                                   .face_vertex_index_count = 3};
    host.scene.get_mesh = get_mesh;
    insert_prim(COHORT_PRIM_MESH, "/mesh", NULL, 0);
}

static const FakeObject *mesh(void)
{
    return &fake.objects[fake.objects[0].instances[0].object];
}

static void sync_dirty(uint32_t bits)
{
    cohort_render_index_mark_dirty(render_index, "/mesh", bits);
    sync_index();
}

// The host's level or the setting, whichever is finer; the setting's edit sets the mesh anew.
static void test_levels(void **state)
{
    (void)state;
    open_mesh();
    assert_true(cohort_delegate_set_int(delegate, "cohort:complexity", 2, NULL));
    sync_index();
    uint64_t calls = fake.set_mesh_calls;
    assert_int_equal(mesh()->level, 2);
    source.mesh.level = 5;
    sync_dirty(COHORT_DIRTY_DISPLAY_STYLE);
    assert_int_equal(mesh()->level, 5);
    assert_int_equal(fake.set_mesh_calls, calls + 1);
    assert_true(cohort_delegate_set_int(delegate, "cohort:complexity", 7, NULL));
    sync_index();
    assert_int_equal(mesh()->level, 7);
}

// Points that are counted but not given are the host's error; the mesh goes, and may come back.
static void test_points_that_are_not_given(void **state)
{
    (void)state;
    open_mesh();
    sync_index();
    assert_int_equal(fake.objects[0].instance_count, 1);
    source.points_sample_count = 0;
    sync_dirty(COHORT_DIRTY_POINTS);
    assert_int_equal(fake.objects[0].instance_count, 0);
    const CohortReportEntry *entries;
    assert_int_equal(cohort_delegate_report(delegate, &entries), 1);
    assert_string_equal(entries[0].prim_path, "/mesh");
    source.points_sample_count = 1;
    sync_dirty(COHORT_DIRTY_POINTS);
    assert_int_equal(fake.objects[0].instance_count, 1);
}

// Another binding is no other mesh; other subsets are, whatever the host's bits say.
static void test_bindings_of_subsets(void **state)
{
    (void)state;
    static const int32_t faces[] = {0};
    const CohortNodeInput none = {.name = "roughness", .source_node = -1, .components = 1};
    const CohortMaterialNode node = {
        .path = "/m/s", .id = "UsdPreviewSurface", .inputs = &none, .input_count = 1};
    const CohortMaterialNetwork network = {.nodes = &node, .node_count = 1, .displacement = -1};
    host.network = &network;
    insert_prim(COHORT_PRIM_MATERIAL, "/a", NULL, 0);
    insert_prim(COHORT_PRIM_MATERIAL, "/b", NULL, 0);
    open_mesh();
    source.material = "/a";
    sync_index();
    assert_int_equal(mesh()->material, 0);
    source.material = "/b";
    sync_dirty(COHORT_DIRTY_MATERIAL_ID);
    assert_int_equal(mesh()->material, 1);
    assert_int_equal(fake.set_mesh_calls, 1);
    subset = (CohortSubsetDesc){faces, 1, 0};
    subset_material = "/a";
    source.mesh.subsets = &subset;
    source.mesh.subset_count = 1;
    source.subset_materials = &subset_material;
    sync_dirty(COHORT_DIRTY_MATERIAL_ID);
    assert_int_equal(fake.set_mesh_calls, 2);
    assert_int_equal(mesh()->subset_material, 0);
    subset_material = "/nowhere";
    sync_dirty(COHORT_DIRTY_TOPOLOGY);
    assert_int_equal(mesh()->subset_material, COHORT_INVALID_ID);
    const CohortReportEntry *entries;
    assert_int_equal(cohort_delegate_report(delegate, &entries), 1);
    assert_string_equal(entries[0].name, "material:binding");
    source.subset_materials = NULL; // none of them has one
    sync_dirty(COHORT_DIRTY_TOPOLOGY);
    assert_int_equal(mesh()->subset_material, COHORT_INVALID_ID);
}

// A move builds nothing.
static void test_moves_build_nothing(void **state)
{
    (void)state;
    open_mesh();
    sync_index();
    host.x = 7.0;
    sync_dirty(COHORT_DIRTY_TRANSFORM);
    host.invisible = true;
    sync_dirty(COHORT_DIRTY_VISIBILITY);
    assert_int_equal(fake.set_mesh_calls, 1);
    assert_true(fake.objects[0].instances[0].transform[3][0] == 7.0);
    assert_true(fake.objects[0].instances[0].hidden);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_levels, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_points_that_are_not_given, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_bindings_of_subsets, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_moves_build_nothing, setup_index, teardown_index),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
