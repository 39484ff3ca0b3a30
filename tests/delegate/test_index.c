// The index pulls what is dirty, edits the scene no more than that needs, and counts both.

#include "index_fixture.h"

#include "support/faults.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static size_t report_count(void)
{
    const CohortReportEntry *entries;
    return cohort_delegate_report(delegate, &entries);
}

static void test_mesh_reaches_the_root_group(void **state)
{
    (void)state;
    host.x = 4.0;
    insert_prim(COHORT_PRIM_MESH, "/a", NULL, 0);
    insert_prim(COHORT_PRIM_MESH, "/b", NULL, 0);
    sync_index();
    const FakeObject *root = &fake.objects[0];
    assert_int_equal(root->instance_count, 2);
    assert_int_equal(root->instances[0].prim_id, 0);
    assert_int_equal(root->instances[1].prim_id, 1);
    assert_true(root->instances[0].transform[3][0] == 4.0); // the sample at time 0
    const FakeObject *mesh = &fake.objects[root->instances[0].object];
    assert_string_equal(mesh->path, "/a");
    assert_true(mesh->first_point[0] == 1.0f); // the sample at time 0, not the first
    assert_int_equal(mesh->level, 2);
    assert_string_equal(cohort_render_index_prim_path(render_index, 1), "/b");
    assert_null(cohort_render_index_prim_path(render_index, 2));
    assert_null(cohort_render_index_prim_path(render_index, -1));
}

static void test_clean_index_pulls_nothing(void **state)
{
    (void)state;
    insert_prim(COHORT_PRIM_MESH, "/a", NULL, 0);
    sync_index();
    assert_int_equal(cohort_render_index_dirty_bits(render_index, "/a"), 0);
    uint64_t pulls = host.mesh_pulls, commits = fake.commits;
    sync_index();
    assert_int_equal(host.mesh_pulls, pulls);
    assert_int_equal(fake.commits, commits);
}

static void test_transform_moves_without_rebuilding(void **state)
{
    (void)state;
    insert_prim(COHORT_PRIM_MESH, "/a", NULL, 0);
    sync_index();
    host.x = 3.0;
    cohort_render_index_mark_dirty(render_index, "/a", COHORT_DIRTY_TRANSFORM);
    sync_index();
    assert_int_equal(fake.set_mesh_calls, 1);
    assert_int_equal(host.mesh_pulls, 1);
    assert_true(fake.objects[0].instances[0].transform[3][0] == 3.0);
    // The same value again is no edit at all.
    uint64_t groups = fake.set_group_calls, commits = fake.commits;
    cohort_render_index_mark_dirty(render_index, "/a", COHORT_DIRTY_TRANSFORM);
    sync_index();
    assert_int_equal(fake.set_group_calls, groups);
    assert_int_equal(fake.commits, commits);
}

static void test_camera_and_light_edits_leave_geometry(void **state)
{
    (void)state;
    insert_prim(COHORT_PRIM_MESH, "/mesh", NULL, 0);
    insert_prim(COHORT_PRIM_LIGHT, "/light", NULL, 0);
    insert_prim(COHORT_PRIM_CAMERA, "/camera", NULL, 0);
    sync_index();
    CohortSyncCounts before, after;
    cohort_render_index_counts(render_index, &before);
    cohort_render_index_mark_dirty(render_index, "/light", COHORT_DIRTY_PARAMS);
    cohort_render_index_mark_dirty(render_index, "/camera", COHORT_DIRTY_TRANSFORM);
    host.x = 1.0;
    sync_index();
    cohort_render_index_counts(render_index, &after);
    assert_int_equal(after.scene.mesh_builds, before.scene.mesh_builds);
    assert_int_equal(after.scene.group_builds, before.scene.group_builds);
    assert_int_equal(after.lights_set, before.lights_set + 1);
    assert_int_equal(after.by_bit[COHORT_PRIM_LIGHT][10], before.by_bit[COHORT_PRIM_LIGHT][10] + 1);
    assert_int_equal(after.by_bit[COHORT_PRIM_CAMERA][0], before.by_bit[COHORT_PRIM_CAMERA][0] + 1);
    assert_int_equal(after.by_bit[COHORT_PRIM_MESH][4], before.by_bit[COHORT_PRIM_MESH][4]);
    assert_int_equal(host.mesh_pulls, 1);
}

// Every bit of every type, marked alone, is counted alone and pulls only what it needs.
static void test_each_bit_is_counted_alone(void **state)
{
    (void)state;
    static const struct {
        const char *path;
        CohortPrimType type;
        uint32_t bits, rebuilds;
    } prims[] = {{"/mesh", COHORT_PRIM_MESH, 0xff, 0xf8},
                 {"/instancer", COHORT_PRIM_INSTANCER, 0x303, 0},
                 {"/camera", COHORT_PRIM_CAMERA, 0x401, 0},
                 {"/light", COHORT_PRIM_LIGHT, 0xc03, 0},
                 {"/material", COHORT_PRIM_MATERIAL, 0xc00, 0}};
    for (size_t i = 0; i < 5; i++)
        insert_prim(prims[i].type, prims[i].path, NULL, 0);
    sync_index();
    for (size_t i = 0; i < 5; i++)
        for (uint32_t bit = 0; bit < COHORT_DIRTY_BIT_COUNT; bit++) {
            CohortSyncCounts before, after;
            cohort_render_index_counts(render_index, &before);
            cohort_render_index_mark_dirty(render_index, prims[i].path, 1u << bit);
            sync_index();
            cohort_render_index_counts(render_index, &after);
            uint64_t meant = (prims[i].bits >> bit) & 1, rebuilt = (prims[i].rebuilds >> bit) & 1;
            before.by_bit[prims[i].type][bit] += meant;
            assert_memory_equal(before.by_bit, after.by_bit, sizeof before.by_bit);
            assert_int_equal(after.scene.mesh_builds, before.scene.mesh_builds + rebuilt);
        }
}

// A binding edit gives the mesh another material, builds nothing and pulls the mesh once.
static void test_rebinding_builds_nothing(void **state)
{
    (void)state;
    static const CohortMaterialNode surface = {.path = "/one/S", .id = "UsdPreviewSurface"};
    static const CohortMaterialNetwork network = {&surface, 1, 0, -1};
    host.network = &network;
    host.material = "/one";
    insert_prim(COHORT_PRIM_MATERIAL, "/one", NULL, 0);
    insert_prim(COHORT_PRIM_MATERIAL, "/two", NULL, 0);
    insert_prim(COHORT_PRIM_MESH, "/mesh", NULL, 0);
    sync_index();
    uint32_t object = fake.objects[0].instances[0].object;
    assert_int_equal(fake.objects[object].material, 0);
    host.material = "/two";
    uint64_t groups = fake.set_group_calls;
    cohort_render_index_mark_dirty(render_index, "/mesh", COHORT_DIRTY_MATERIAL_ID);
    sync_index();
    CohortSyncCounts counts;
    cohort_render_index_counts(render_index, &counts);
    assert_int_equal(fake.objects[object].material, 1);
    assert_int_equal(fake.set_mesh_calls, 1);
    assert_int_equal(fake.set_group_calls, groups);
    assert_int_equal(counts.bindings_set, 1);
    assert_int_equal(counts.meshes_set, 1);
    assert_int_equal(counts.scene.material_binds, 1);
    // Materials that turn plain or back are bindings too.
    cohort_delegate_set_bool(delegate, "enableSceneMaterials", false, NULL);
    sync_index();
    assert_int_equal(fake.objects[object].material, COHORT_INVALID_ID);
    assert_int_equal(fake.set_mesh_calls, 1);
}

static void test_shadows_are_a_light_s_or_the_host_s(void **state)
{
    (void)state;
    insert_prim(COHORT_PRIM_LIGHT, "/light", NULL, 0);
    insert_prim(COHORT_PRIM_MESH, "/mesh", NULL, 0);
    sync_index();
    assert_false(fake.lights[0].no_shadow);
    cohort_delegate_set_bool(delegate, "enableShadows", false, NULL);
    sync_index();
    assert_true(fake.lights[0].no_shadow);
    assert_int_equal(fake.set_mesh_calls, 1);
    cohort_delegate_set_bool(delegate, "enableShadows", true, NULL);
    sync_index();
    assert_false(fake.lights[0].no_shadow);
}

static void test_visibility_hides(void **state)
{
    (void)state;
    insert_prim(COHORT_PRIM_MESH, "/a", NULL, 0);
    insert_prim(COHORT_PRIM_LIGHT, "/l", NULL, 0);
    sync_index();
    assert_false(fake.objects[0].instances[0].hidden);
    host.invisible = true;
    cohort_render_index_mark_all_dirty(render_index, COHORT_PRIM_MESH, COHORT_DIRTY_VISIBILITY);
    cohort_render_index_mark_all_dirty(render_index, COHORT_PRIM_LIGHT, COHORT_DIRTY_VISIBILITY);
    sync_index();
    assert_true(fake.objects[0].instances[0].hidden);
    assert_true(fake.lights[0].hidden);
    assert_int_equal(fake.set_mesh_calls, 1);
}

static void test_remove_empties_the_scene(void **state)
{
    (void)state;
    insert_prim(COHORT_PRIM_MESH, "/a", NULL, 0);
    insert_prim(COHORT_PRIM_LIGHT, "/l", NULL, 0);
    sync_index();
    uint32_t object = fake.objects[0].instances[0].object;
    cohort_render_index_remove(render_index, "/a");
    cohort_render_index_remove(render_index, "/l");
    cohort_render_index_remove(render_index, "/nowhere");
    sync_index();
    assert_int_equal(fake.objects[0].instance_count, 0);
    assert_false(fake.objects[object].is_mesh);
    assert_true(fake.lights[0].hidden);
    assert_int_equal(cohort_render_index_prim_count(render_index, COHORT_PRIM_MESH), 0);
    assert_null(cohort_render_index_prim_path(render_index, 0));
    insert_prim(COHORT_PRIM_MESH, "/a", NULL, 0); // the path is free again
    sync_index();
    assert_int_equal(fake.objects[0].instances[0].prim_id, 1);
}

// 16 parts in a prototype, 700 placements: one group of 16, one of 700, 16 meshes.
static void test_prototype_exists_once(void **state)
{
    (void)state;
    static double transforms[700][4][4];
    for (int i = 0; i < 700; i++)
        for (int k = 0; k < 4; k++)
            transforms[i][k][k] = 1.0;
    transforms[1][3][0] = 10.0;
    CohortInstancesSample sample = {.transforms = (const double(*)[4][4])transforms};
    float colors[700 * 3] = {0.25f, 0.5f, 0.75f};
    uint8_t hidden[700] = {0, 0, 1};
    host.instancer = (CohortInstancerSource){.instance_count = 700,
                                             .samples = &sample,
                                             .sample_count = 1,
                                             .hidden = hidden,
                                             .display_colors = colors};
    host.x = 1.0;
    insert_prim(COHORT_PRIM_INSTANCER, "/i", NULL, 0);
    for (int i = 0; i < 16; i++) {
        char path[16];
        snprintf(path, sizeof path, "/i/p%d", i);
        insert_prim(COHORT_PRIM_MESH, path, "/i", 0);
    }
    sync_index();
    const FakeObject *root = &fake.objects[0];
    assert_int_equal(fake.set_mesh_calls, 16);
    assert_int_equal(root->instance_count, 700);
    assert_int_equal(root->instances[0].prim_id, -1);
    assert_true(root->instances[1].transform[3][0] == 11.0); // placement, then the instancer's own
    assert_true(root->instances[2].hidden);
    assert_true(root->colors[0][1] == 0.5f);
    const FakeObject *prototype = &fake.objects[root->instances[0].object];
    assert_true(prototype->is_group);
    assert_int_equal(prototype->instance_count, 16);
    assert_int_equal(prototype->instances[15].prim_id, 15);
    assert_true(fake.object_count < 24);
    assert_int_equal(root->instances[699 % 64].object, root->instances[0].object);
}

static void test_instancer_inserted_after_its_parts(void **state)
{
    (void)state;
    static const double transforms[2][4][4] = {
        {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}},
        {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
    CohortInstancesSample sample = {.transforms = transforms};
    const uint32_t prototypes[2] = {1, 5};
    host.instancer = (CohortInstancerSource){
        .instance_count = 2, .prototypes = prototypes, .samples = &sample, .sample_count = 1};
    insert_prim(COHORT_PRIM_MESH, "/i/p", "/i", 1);
    sync_index();
    assert_int_equal(fake.objects[0].instance_count, 0);
    insert_prim(COHORT_PRIM_INSTANCER, "/i", NULL, 0);
    sync_index();
    assert_int_equal(fake.objects[0].instance_count, 1); // prototype 5 is empty
}

static void test_nested_instancers(void **state)
{
    (void)state;
    static const double transforms[1][4][4] = {
        {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
    CohortInstancesSample sample = {.transforms = transforms};
    host.instancer =
        (CohortInstancerSource){.instance_count = 1, .samples = &sample, .sample_count = 1};
    insert_prim(COHORT_PRIM_INSTANCER, "/outer", NULL, 0);
    insert_prim(COHORT_PRIM_INSTANCER, "/outer/inner", "/outer", 0);
    insert_prim(COHORT_PRIM_MESH, "/outer/inner/mesh", "/outer/inner", 0);
    sync_index();
    const FakeObject *outer = &fake.objects[fake.objects[0].instances[0].object];
    assert_int_equal(outer->instance_count, 1);
    const FakeObject *inner = &fake.objects[outer->instances[0].object];
    assert_int_equal(inner->instance_count, 1);
    assert_true(fake.objects[inner->instances[0].object].is_mesh);
    // An edit of the mesh's place stays inside its prototype.
    uint64_t groups = fake.set_group_calls;
    host.x = 2.0;
    cohort_render_index_mark_dirty(render_index, "/outer/inner/mesh", COHORT_DIRTY_TRANSFORM);
    sync_index();
    assert_int_equal(fake.set_group_calls, groups + 1);
}

static void test_bad_prims_are_reported_and_left_out(void **state)
{
    (void)state;
    insert_prim(COHORT_PRIM_MESH, "/a", NULL, 0);
    host.fail_mesh = true;
    sync_index();
    assert_int_equal(report_count(), 1);
    assert_int_equal(fake.objects[0].instance_count, 0);
    host.fail_mesh = false;
    fake.fail_set_mesh = true;
    cohort_render_index_mark_dirty(render_index, "/a", COHORT_DIRTY_POINTS);
    sync_index();
    assert_int_equal(report_count(), 2);
    fake.fail_set_mesh = false;
    cohort_render_index_mark_dirty(render_index, "/a", COHORT_DIRTY_POINTS);
    sync_index();
    assert_int_equal(fake.objects[0].instance_count, 1); // back again
    host.x = (double)NAN;
    cohort_render_index_mark_dirty(render_index, "/a", COHORT_DIRTY_TRANSFORM);
    sync_index();
    assert_int_equal(report_count(), 3);
    assert_true(isfinite(fake.objects[0].instances[0].transform[3][0]));
    CohortInstancesSample none = {0};
    host.instancer =
        (CohortInstancerSource){.instance_count = 1, .samples = &none, .sample_count = 1};
    insert_prim(COHORT_PRIM_INSTANCER, "/i", NULL, 0);
    host.x = 0.0;
    sync_index();
    assert_int_equal(report_count(), 4);
}

static void test_arguments_are_checked(void **state)
{
    (void)state;
    CohortError err = {0};
    insert_prim(COHORT_PRIM_MESH, "/a", NULL, 0);
    assert_false(cohort_render_index_insert(render_index, COHORT_PRIM_LIGHT, "/a", &host.scene,
                                            NULL, 0, &err));
    assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
    assert_false(
        cohort_render_index_insert(render_index, COHORT_PRIM_MESH, "", &host.scene, NULL, 0, NULL));
    assert_false(
        cohort_render_index_insert(render_index, COHORT_PRIM_MESH, "/b", NULL, NULL, 0, NULL));
    assert_false(cohort_render_index_insert(render_index, COHORT_PRIM_MESH, "/b", &host.scene, "/i",
                                            UINT32_MAX, NULL));
    assert_null(cohort_render_index_create(delegate, &err));
    fake.fail_commit = true;
    err = (CohortError){0};
    assert_false(cohort_render_index_sync(render_index, &err));
    assert_int_equal(err.code, COHORT_ERROR_SCENE);
}

static void test_settings_reach_prims(void **state)
{
    (void)state;
    insert_prim(COHORT_PRIM_MESH, "/a", NULL, 0);
    insert_prim(COHORT_PRIM_LIGHT, "/l", NULL, 0);
    sync_index();
    assert_true(cohort_delegate_set_int(delegate, "cohort:complexity", 3, NULL));
    assert_true(cohort_delegate_set_bool(delegate, "enableSceneLights", false, NULL));
    sync_index();
    assert_int_equal(fake.objects[fake.objects[0].instances[0].object].level, 3);
    assert_true(fake.lights[0].hidden);
    uint64_t commits = fake.commits;
    assert_true(cohort_delegate_set_string(delegate, "cohort:ocioConfig", "x.ocio", NULL));
    sync_index();
    assert_int_equal(fake.commits, commits + 1);
}

// As many prototypes as make every list grow, and names that do not fit beside each other.
static bool fill_index(CohortRenderIndex *index, CohortError *err)
{
    static char path[30000];
    bool ok = true;
    for (uint32_t i = 0; ok && i < 40; i++) {
        size_t length = i % 4 ? 4 : sizeof path - 1;
        memset(path, 'a' + (int)(i % 26), length);
        snprintf(path, 4, "/%02u", i);
        path[3] = 'x';
        path[length] = '\0';
        ok = cohort_render_index_insert(index, COHORT_PRIM_MESH, path, &host.scene, path, i, err);
    }
    return ok && cohort_render_index_sync(index, err);
}

static void test_allocation_failures(void **state)
{
    (void)state;
    TestFaults faults = {0};
    while (test_faults_next(&faults)) {
        CohortError err = {0};
        fake_reset();
        test_faults_begin(&faults);
        CohortDelegate *d = cohort_delegate_create(&err);
        CohortRenderIndex *i = d ? cohort_render_index_create(d, &err) : NULL;
        bool ok = i && fill_index(i, &err);
        test_faults_end(&faults, ok, &err);
        assert_true(!ok || fake.set_mesh_calls == 40);
        cohort_delegate_destroy(d);
    }
    assert_true(faults.count > 200);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_mesh_reaches_the_root_group, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_clean_index_pulls_nothing, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_transform_moves_without_rebuilding, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_camera_and_light_edits_leave_geometry, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_each_bit_is_counted_alone, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_rebinding_builds_nothing, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_shadows_are_a_light_s_or_the_host_s, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_visibility_hides, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_remove_empties_the_scene, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_prototype_exists_once, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_instancer_inserted_after_its_parts, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_nested_instancers, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_bad_prims_are_reported_and_left_out, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_arguments_are_checked, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_settings_reach_prims, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_allocation_failures, setup_index, teardown_index),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
