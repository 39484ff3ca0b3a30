// Edits of materials: what they touch, and when meshes must look again.

#include "material_fixture.h"
#include "support/faults.h"

#include <math.h>

// A material edit is no geometry edit, unless the material turns into none.
static void test_edits_of_a_bound_material(void **state)
{
    (void)state;
    CohortNodeInput surface[] = {number_input("roughness", 0.25f)};
    CohortMaterialNode nodes[] = {
        {.path = "/m/s", .id = "UsdPreviewSurface", .inputs = surface, .input_count = 1}};
    const CohortMaterialNetwork network = {.nodes = nodes, .node_count = 1};
    host.network = &network;
    host.material = "/m";
    insert_prim(COHORT_PRIM_MESH, "/mesh", NULL, 0);
    insert_prim(COHORT_PRIM_MATERIAL, "/m", NULL, 0);
    sync_index();
    const FakeObject *mesh = &fake.objects[fake.objects[0].instances[0].object];
    assert_int_equal(mesh->material, 0);
    surface[0].value[0] = 0.5f;
    cohort_render_index_mark_dirty(render_index, "/m", COHORT_DIRTY_PARAMS);
    sync_index();
    assert_true(fake.materials[0].roughness.value[0] == 0.5f);
    assert_int_equal(fake.set_mesh_calls, 1);
    nodes[0].id = "PxrDisneyBsdf";
    cohort_render_index_mark_dirty(render_index, "/m", COHORT_DIRTY_RESOURCE);
    sync_index();
    assert_int_equal(mesh->material, COHORT_INVALID_ID);
    assert_non_null(report_of("info:id"));
    nodes[0].id = "UsdPreviewSurface";
    cohort_render_index_mark_dirty(render_index, "/m", COHORT_DIRTY_RESOURCE);
    sync_index();
    assert_int_equal(mesh->material, 0);
    assert_true(cohort_delegate_set_bool(delegate, "enableSceneMaterials", false, NULL));
    sync_index();
    assert_int_equal(mesh->material, COHORT_INVALID_ID);
}

// Meshes are displaced when they are set: another displacement sets those that have it anew.
static void test_displacement_sets_meshes_anew(void **state)
{
    (void)state;
    CohortNodeInput surface[] = {number_input("displacement", 0.0f),
                                 number_input("roughness", 0.5f)};
    CohortMaterialNode nodes[] = {
        {.path = "/m/s", .id = "UsdPreviewSurface", .inputs = surface, .input_count = 2}};
    const CohortMaterialNetwork network = {.nodes = nodes, .node_count = 1};
    host.network = &network;
    host.material = "/m";
    insert_prim(COHORT_PRIM_MESH, "/mesh", NULL, 0);
    insert_prim(COHORT_PRIM_MATERIAL, "/m", NULL, 0);
    insert_prim(COHORT_PRIM_MATERIAL, "/other", NULL, 0);
    sync_index();
    assert_int_equal(fake.set_mesh_calls, 1);
    const struct {
        float displacement, roughness;
        uint64_t sets;
    } edits[] = {{0.25f, 0.5f, 2}, {0.25f, 0.3f, 2}, {0.5f, 0.3f, 3}, {0.0f, 0.3f, 4}};
    for (size_t i = 0; i < sizeof edits / sizeof edits[0]; i++) {
        surface[0].value[0] = edits[i].displacement;
        surface[1].value[0] = edits[i].roughness;
        cohort_render_index_mark_dirty(render_index, "/m", COHORT_DIRTY_PARAMS);
        sync_index();
        assert_int_equal(fake.set_mesh_calls, edits[i].sets);
        assert_true(fake.materials[0].displacement.value[0] == edits[i].displacement);
    }
    // Bound to another material that displaces otherwise.
    surface[0].value[0] = 1.0f;
    cohort_render_index_mark_dirty(render_index, "/other", COHORT_DIRTY_PARAMS);
    sync_index();
    assert_int_equal(fake.set_mesh_calls, 4);
    host.material = "/other";
    cohort_render_index_mark_dirty(render_index, "/mesh", COHORT_DIRTY_MATERIAL_ID);
    sync_index();
    assert_int_equal(fake.set_mesh_calls, 5);
}

static void test_material_without_network(void **state)
{
    (void)state;
    host.material = "/m";
    insert_prim(COHORT_PRIM_MATERIAL, "/m", NULL, 0);
    insert_prim(COHORT_PRIM_MESH, "/mesh", NULL, 0);
    sync_index();
    assert_int_equal(fake.objects[fake.objects[0].instances[0].object].material, COHORT_INVALID_ID);
    assert_non_null(report_of("Material"));
}

// A textured material that is set, or set otherwise, while memory is at an end is there after the
// next sync, with one texture.
static void test_failed_syncs_are_made_good(void **state)
{
    (void)state;
    const CohortNodeInput surface[] = {connection("diffuseColor", 1, "rgb"),
                                       number_input("ior", NAN)};
    const CohortNodeInput file[] = {text_input("file", "/tmp/none.png"),
                                    text_input("wrapS", "no such wrap")};
    const CohortMaterialNode nodes[] = {
        {.path = "/m/s", .id = "UsdPreviewSurface", .inputs = surface, .input_count = 2},
        {.path = "/m/t", .id = "UsdUVTexture", .inputs = file, .input_count = 2}};
    const CohortMaterialNetwork network = {.nodes = nodes, .node_count = 2, .displacement = -1};
    TestFaults faults = {0};
    while (test_faults_next(&faults)) {
        setup_index(state);
        host.network = &network;
        host.material = "/m";
        insert_prim(COHORT_PRIM_MESH, "/mesh", NULL, 0);
        insert_prim(COHORT_PRIM_MATERIAL, "/m", NULL, 0);
        CohortError err = {0};
        test_faults_begin(&faults);
        bool ok = cohort_render_index_sync(render_index, &err);
        test_faults_end(&faults, ok, &err);
        sync_index();
        assert_int_equal(fake.texture_count, 1);
        assert_int_equal(fake.materials[0].diffuse_color.kind, COHORT_INPUT_TEXTURE);
        assert_int_equal(fake.objects[fake.objects[0].instances[0].object].material, 0);
        assert_non_null(report_of("wrapS"));
        assert_non_null(report_of("inputs:ior"));
        teardown_index(state);
    }
    assert_true(faults.count > 10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_edits_of_a_bound_material, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_displacement_sets_meshes_anew, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_material_without_network, setup_index, teardown_index),
        cmocka_unit_test(test_failed_syncs_are_made_good),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
