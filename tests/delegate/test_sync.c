// Syncs that go wrong: places that are none, prims that go away while others name them, placements
// of what is not there, hosts that refuse.

#include "index_fixture.h"

#include "base/memory.h"
#include "prims/sync.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

static bool is_reported(const char *path, const char *name)
{
    const CohortReportEntry *entries;
    size_t count = cohort_delegate_report(delegate, &entries);
    for (size_t i = 0; i < count; i++)
        if (strcmp(entries[i].prim_path, path) == 0 && strcmp(entries[i].name, name) == 0)
            return true;
    return false;
}

// ---- Samples -----------------------------------------------------------------------------------

static void test_the_nearest_sample_is_taken(void **state)
{
    (void)state;
    const double times[] = {-2.0, -0.5, 0.5, 3.0}, exact[] = {-1.0, 0.0, 1e-300};
    const double odd[] = {(double)NAN, (double)INFINITY, 7.0};
    assert_int_equal(co_sync_nearest(times, 4, sizeof *times), 1); // the earlier of two as near
    assert_int_equal(co_sync_nearest(exact, 3, sizeof *exact), 1);
    assert_int_equal(co_sync_nearest(odd, 3, sizeof *odd), 2);
    assert_int_equal(co_sync_nearest(odd, 1, sizeof *odd), 0);
}

// ---- Places that are none ----------------------------------------------------------------------

static void test_what_has_no_place_is_not_drawn(void **state)
{
    (void)state;
    const double nowhere[] = {(double)NAN, (double)INFINITY, -(double)INFINITY};
    insert_prim(COHORT_PRIM_MESH, "/mesh", NULL, 0);
    insert_prim(COHORT_PRIM_LIGHT, "/light", NULL, 0);
    for (size_t i = 0; i < 3; i++) {
        host.x = nowhere[i];
        cohort_render_index_mark_dirty(render_index, "/mesh", COHORT_DIRTY_TRANSFORM);
        cohort_render_index_mark_dirty(render_index, "/light", COHORT_DIRTY_TRANSFORM);
        sync_index();
        assert_true(is_reported("/mesh", "transform"));
        assert_true(is_reported("/light", "transform"));
        assert_int_equal(fake.objects[0].instance_count, 0);
        assert_true(fake.lights[0].hidden);
        host.x = 1.0 + (double)i;
        cohort_render_index_mark_dirty(render_index, "/mesh", COHORT_DIRTY_TRANSFORM);
        cohort_render_index_mark_dirty(render_index, "/light", COHORT_DIRTY_TRANSFORM);
        sync_index();
        assert_int_equal(fake.objects[0].instance_count, 1);
        assert_true(fake.objects[0].instances[0].transform[3][0] == host.x);
        assert_false(fake.lights[0].hidden);
        assert_true(fake.lights[0].transform[3][0] == host.x);
    }
}

static bool refuse_transform(void *cookie, CohortPull *pull, const char *path,
                             const CohortTransformSample **out, size_t *count, CohortError *err)
{
    (void)cookie, (void)pull, (void)path, (void)out, (void)count;
    err->code = COHORT_ERROR_SCENE;
    return false;
}

static void test_an_instancer_without_place_places_nothing(void **state)
{
    (void)state;
    const double identity[1][4][4] = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
    const CohortInstancesSample sample = {.transforms = identity};
    host.instancer =
        (CohortInstancerSource){.instance_count = 1, .samples = &sample, .sample_count = 1};
    host.scene.get_transform = refuse_transform;
    insert_prim(COHORT_PRIM_INSTANCER, "/instancer", NULL, 0);
    insert_prim(COHORT_PRIM_MESH, "/mesh", "/instancer", 0);
    sync_index();
    assert_int_equal(fake.objects[0].instance_count, 0);
    assert_true(is_reported("/instancer", "transform"));
}

static void test_a_camera_without_place_is_none(void **state)
{
    (void)state;
    insert_prim(COHORT_PRIM_CAMERA, "/camera", NULL, 0);
    insert_prim(COHORT_PRIM_MESH, "/mesh", NULL, 0);
    CohortRenderPass *pass = cohort_render_pass_create(render_index, NULL);
    CohortAovBinding binding = {
        "color", cohort_render_buffer_create(delegate, 2, 2, COHORT_FORMAT_FLOAT32_VEC4, NULL)};
    CohortRenderPassState view = {.camera = "/camera", .bindings = &binding, .binding_count = 1};
    host.x = (double)NAN;
    CohortError err = {0};
    assert_false(cohort_render_pass_execute(pass, &view, &err));
    assert_int_equal(err.code, COHORT_ERROR_SCENE);
    assert_non_null(strstr(err.message, "/camera"));
    host.x = 2.0;
    cohort_render_index_mark_dirty(render_index, "/camera", COHORT_DIRTY_TRANSFORM);
    assert_true(cohort_render_pass_execute(pass, &view, NULL));
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_true(fake.camera.transform[3][0] == 2.0);
}

// ---- What others name --------------------------------------------------------------------------

static const CohortNodeInput red = {
    .name = "diffuseColor", .source_node = -1, .components = 3, .value = {1.0f, 0.0f, 0.0f}};
static const CohortMaterialNode node = {
    .path = "/red/s", .id = "UsdPreviewSurface", .inputs = &red, .input_count = 1};
static const CohortMaterialNetwork network = {.nodes = &node, .node_count = 1, .surface = 0};

static const FakeObject *the_mesh(void)
{
    return &fake.objects[fake.objects[0].instances[0].object];
}

static void test_a_material_goes_and_comes_back(void **state)
{
    (void)state;
    host.material = "/red";
    host.network = &network;
    insert_prim(COHORT_PRIM_MATERIAL, "/red", NULL, 0);
    insert_prim(COHORT_PRIM_MESH, "/mesh", NULL, 0);
    sync_index();
    assert_int_equal(the_mesh()->material, 0);
    uint64_t built = fake.set_mesh_calls;
    cohort_render_index_remove(render_index, "/red");
    sync_index();
    assert_int_equal(the_mesh()->material, COHORT_INVALID_ID);
    assert_true(is_reported("/mesh", "material:binding"));
    insert_prim(COHORT_PRIM_MATERIAL, "/red", NULL, 0);
    sync_index();
    assert_int_equal(the_mesh()->material, 1); // the new one, in a place of its own
    assert_int_equal(fake.set_mesh_calls, built);
    // One that nobody missed makes nobody look.
    uint64_t pulls = host.mesh_pulls;
    insert_prim(COHORT_PRIM_MATERIAL, "/blue", NULL, 0);
    sync_index();
    assert_int_equal(host.mesh_pulls, pulls);
}

static void test_a_material_comes_after_its_mesh(void **state)
{
    (void)state;
    host.material = "/red";
    host.network = &network;
    insert_prim(COHORT_PRIM_MESH, "/mesh", NULL, 0);
    sync_index();
    assert_int_equal(the_mesh()->material, COHORT_INVALID_ID);
    insert_prim(COHORT_PRIM_MATERIAL, "/red", NULL, 0);
    sync_index();
    assert_int_equal(the_mesh()->material, 0);
    assert_int_equal(fake.set_mesh_calls, 1);
}

static void test_the_camera_of_a_pass_is_removed(void **state)
{
    (void)state;
    insert_prim(COHORT_PRIM_CAMERA, "/camera", NULL, 0);
    CohortRenderPass *pass = cohort_render_pass_create(render_index, NULL);
    CohortAovBinding binding = {
        "color", cohort_render_buffer_create(delegate, 2, 2, COHORT_FORMAT_FLOAT32_VEC4, NULL)};
    CohortRenderPassState view = {.camera = "/camera", .bindings = &binding, .binding_count = 1};
    fake.round_nanoseconds = 2000000;
    fake.rounds_to_do = 1u << 30;
    assert_true(cohort_render_pass_execute(pass, &view, NULL));
    cohort_render_index_remove(render_index, "/camera");
    assert_int_equal(fake.renders_live, 0);
    CohortError err = {0};
    assert_false(cohort_render_pass_execute(pass, &view, &err));
    assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
    insert_prim(COHORT_PRIM_CAMERA, "/camera", NULL, 0);
    fake.rounds_to_do = 1;
    assert_true(cohort_render_pass_execute(pass, &view, NULL));
    assert_true(cohort_render_pass_wait(pass, 10.0));
}

static void test_prototypes_and_instancers_go(void **state)
{
    (void)state;
    const double two[2][4][4] = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}},
                                 {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {5, 0, 0, 1}}};
    const CohortInstancesSample sample = {.transforms = two};
    host.instancer =
        (CohortInstancerSource){.instance_count = 2, .samples = &sample, .sample_count = 1};
    insert_prim(COHORT_PRIM_INSTANCER, "/instancer", NULL, 0);
    insert_prim(COHORT_PRIM_MESH, "/mesh", "/instancer", 0);
    sync_index();
    assert_int_equal(fake.objects[0].instance_count, 2);
    uint32_t group = fake.objects[0].instances[0].object;
    assert_int_equal(fake.objects[group].instance_count, 1);
    cohort_render_index_remove(render_index, "/mesh");
    sync_index();
    assert_int_equal(fake.objects[group].instance_count, 0); // placed, but nothing stands in it
    insert_prim(COHORT_PRIM_MESH, "/other", "/instancer", 0);
    sync_index();
    assert_int_equal(fake.objects[group].instance_count, 1);
    cohort_render_index_remove(render_index, "/instancer");
    sync_index();
    assert_int_equal(fake.objects[0].instance_count, 0);
    assert_int_equal(cohort_render_index_prim_count(render_index, COHORT_PRIM_MESH), 1);
}

// ---- Instancers --------------------------------------------------------------------------------

static void test_prototypes_that_are_not_there(void **state)
{
    (void)state;
    const double four[4][4][4] = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}},
                                  {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {1, 0, 0, 1}},
                                  {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {2, 0, 0, 1}},
                                  {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {3, 0, 0, 1}}};
    const CohortInstancesSample sample = {.transforms = four};
    const uint32_t prototypes[] = {UINT32_MAX, 0, 1, (1u << 24) - 1};
    host.instancer = (CohortInstancerSource){
        .instance_count = 4, .prototypes = prototypes, .samples = &sample, .sample_count = 1};
    insert_prim(COHORT_PRIM_INSTANCER, "/instancer", NULL, 0);
    insert_prim(COHORT_PRIM_MESH, "/mesh", "/instancer", 0);
    size_t peak = co_memory_peak(CO_MEMORY_DELEGATE);
    sync_index();
    assert_int_equal(fake.objects[0].instance_count, 1);
    assert_true(fake.objects[0].instances[0].transform[3][0] == 1.0);
    assert_true(co_memory_peak(CO_MEMORY_DELEGATE) - peak < 1u << 20); // no table of all numbers
}

static void test_instancers_without_transforms(void **state)
{
    (void)state;
    const CohortInstancesSample none = {.transforms = NULL};
    const CohortInstancerSource sources[] = {
        {.instance_count = 3},
        {.instance_count = 3, .samples = &none, .sample_count = 1},
    };
    insert_prim(COHORT_PRIM_INSTANCER, "/instancer", NULL, 0);
    insert_prim(COHORT_PRIM_MESH, "/mesh", "/instancer", 0);
    for (size_t i = 0; i < sizeof sources / sizeof *sources; i++) {
        cohort_delegate_report_clear(delegate);
        host.instancer = sources[i];
        cohort_render_index_mark_dirty(render_index, "/instancer", COHORT_DIRTY_INSTANCER);
        sync_index();
        assert_int_equal(fake.objects[0].instance_count, 0);
        assert_true(is_reported("/instancer", "PointInstancer"));
    }
    host.instancer = (CohortInstancerSource){0}; // none at all is no mistake
    cohort_delegate_report_clear(delegate);
    cohort_render_index_mark_dirty(render_index, "/instancer", COHORT_DIRTY_INSTANCE_INDEX);
    sync_index();
    assert_false(is_reported("/instancer", "PointInstancer"));
}

// ---- Hosts that give nothing -------------------------------------------------------------------

static void test_a_host_without_callbacks(void **state)
{
    (void)state;
    static const struct {
        CohortPrimType type;
        const char *path, *name;
    } prims[] = {{COHORT_PRIM_MESH, "/mesh", "Mesh"},
                 {COHORT_PRIM_INSTANCER, "/instancer", "PointInstancer"},
                 {COHORT_PRIM_CAMERA, "/camera", "Camera"},
                 {COHORT_PRIM_LIGHT, "/light", "Light"},
                 {COHORT_PRIM_MATERIAL, "/material", "Material"}};
    const size_t count = sizeof prims / sizeof *prims;
    host.scene = (CohortSceneDelegate){.cookie = NULL};
    for (size_t i = 0; i < count; i++)
        insert_prim(prims[i].type, prims[i].path, NULL, 0);
    sync_index();
    for (size_t i = 0; i < count; i++) {
        assert_true(is_reported(prims[i].path, prims[i].name));
        assert_int_equal(cohort_render_index_dirty_bits(render_index, prims[i].path), 0);
        cohort_render_index_remove(render_index, prims[i].path);
        cohort_render_index_remove(render_index, prims[i].path); // once more is harmless
    }
    sync_index();
    assert_int_equal(fake.objects[0].instance_count, 0);
    assert_true(fake.lights[0].hidden);
}

// What is no prim, or no bit of its type, marks nothing.
static void test_bits_that_mean_nothing(void **state)
{
    (void)state;
    insert_prim(COHORT_PRIM_LIGHT, "/light", NULL, 0);
    insert_prim(COHORT_PRIM_CAMERA, "/camera", NULL, 0);
    sync_index();
    cohort_render_index_mark_dirty(render_index, "/light",
                                   COHORT_DIRTY_POINTS | COHORT_DIRTY_INSTANCER | 1u << 31);
    cohort_render_index_mark_dirty(render_index, "/camera", ~COHORT_DIRTY_ALL);
    cohort_render_index_mark_dirty(render_index, "/nothing", COHORT_DIRTY_ALL);
    cohort_render_index_mark_dirty(render_index, NULL, COHORT_DIRTY_ALL);
    cohort_render_index_mark_all_dirty(render_index, COHORT_PRIM_MESH, COHORT_DIRTY_ALL);
    assert_int_equal(cohort_render_index_dirty_bits(render_index, "/light"), 0);
    assert_int_equal(cohort_render_index_dirty_bits(render_index, "/camera"), 0);
    assert_int_equal(cohort_render_index_dirty_bits(render_index, NULL), 0);
    uint64_t commits = fake.commits;
    sync_index();
    assert_int_equal(fake.commits, commits);
}

// ---- Stops -------------------------------------------------------------------------------------

static volatile int stop;

static bool get_mesh_once(void *cookie, CohortPull *pull, const char *path, CohortMeshSource *out,
                          CohortError *err)
{
    (void)cookie;
    stop = 1;
    FakeHost own;
    fake_host_init(&own);
    return own.scene.get_mesh(&own, pull, path, out, err);
}

static void test_a_stopped_sync_goes_on(void **state)
{
    (void)state;
    cohort_delegate_set_stop_flag(delegate, &stop);
    host.scene.get_mesh = get_mesh_once;
    insert_prim(COHORT_PRIM_MESH, "/a", NULL, 0);
    insert_prim(COHORT_PRIM_MESH, "/b", NULL, 0);
    insert_prim(COHORT_PRIM_LIGHT, "/light", NULL, 0);
    for (uint64_t meshes = 1; meshes <= 2; meshes++) { // one mesh a time, and then what is left
        CohortError err = {0};
        stop = 0;
        assert_false(cohort_render_index_sync(render_index, &err));
        assert_int_equal(err.code, COHORT_ERROR_CANCELLED);
        assert_int_equal(fake.set_mesh_calls, meshes);
        assert_int_equal(fake.set_light_calls, 0);
        assert_int_equal(fake.commits, 0);
    }
    stop = 0;
    sync_index();
    assert_int_equal(fake.set_mesh_calls, 2);
    assert_int_equal(fake.set_light_calls, 1);
    assert_int_equal(fake.commits, 1);
    assert_false(is_reported("/a", "Mesh"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_nearest_sample_is_taken),
        cmocka_unit_test_setup_teardown(test_what_has_no_place_is_not_drawn, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_an_instancer_without_place_places_nothing, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_a_camera_without_place_is_none, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_a_material_goes_and_comes_back, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_a_material_comes_after_its_mesh, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_the_camera_of_a_pass_is_removed, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_prototypes_and_instancers_go, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_prototypes_that_are_not_there, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_instancers_without_transforms, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_a_host_without_callbacks, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_bits_that_mean_nothing, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_a_stopped_sync_goes_on, setup_index, teardown_index),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
