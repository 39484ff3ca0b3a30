// The pass renders in the background, ends by itself, and begins again where something changed.

#include "pass_fixture.h"
#include "support/faults.h"

#include <string.h>

static void test_converges_after_one_execute(void **state)
{
    (void)state;
    execute_pass();
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_true(cohort_render_pass_is_converged(pass));
    assert_true(cohort_render_buffer_is_converged(color));
    const float *pixels = cohort_render_buffer_map(color);
    assert_true(pixels[0] == 302.0f);         // row 0 is the bottom row
    assert_true(pixels[2 * 4 * 4] == 300.0f); // the last is the top
    cohort_render_buffer_unmap(color);
    const int32_t *rows = cohort_render_buffer_map(ids);
    assert_int_equal(rows[0], 2);
    cohort_render_buffer_unmap(ids);
    assert_int_equal(fake.settings.aovs, COHORT_AOV_COLOR | COHORT_AOV_PRIM_ID);
    assert_true(stat_of("percentDone").value.number == 100.0);
    assert_int_equal(stat_of("numCompletedSamples").value.integer, 3);
    assert_string_equal(stat_of("renderProgressAnnotation").value.string, "converged");
    assert_int_equal(stat_of("huskErrorStatus").value.integer, 0);
}

static void test_execute_again_does_nothing(void **state)
{
    (void)state;
    execute_pass();
    assert_true(cohort_render_pass_wait(pass, 10.0));
    for (int i = 0; i < 5; i++) {
        assert_true(cohort_delegate_set_bool(delegate, "domeLightCameraVisibility", true, NULL));
        execute_pass();
    }
    assert_int_equal(fake.renders_made, 1);
    assert_true(cohort_render_pass_is_converged(pass));
}

static void test_edits_restart(void **state)
{
    (void)state;
    fake.round_nanoseconds = 20000000;
    fake.rounds_to_do = 1000;
    execute_pass();
    assert_false(cohort_render_pass_is_converged(pass));
    assert_true(cohort_delegate_set_int(delegate, "cohort:spp", 9, NULL));
    execute_pass();
    assert_int_equal(fake.renders_made, 2);
    assert_int_equal(fake.settings.spp, 9);
    cohort_render_index_mark_dirty(render_index, "/mesh", COHORT_DIRTY_POINTS);
    execute_pass();
    assert_int_equal(fake.renders_made, 3);
    assert_true(cohort_delegate_set_int(delegate, "cohort:batch", 1024, NULL)); // only the schedule
    execute_pass();
    assert_int_equal(fake.renders_made, 3);
    uint64_t cameras = fake.set_camera_calls;
    cohort_render_index_mark_dirty(render_index, "/camera", COHORT_DIRTY_PARAMS);
    host.camera.focal_length = 35.0;
    execute_pass();
    assert_int_equal(fake.renders_made, 4);
    assert_int_equal(fake.set_camera_calls, cameras + 1);
    assert_int_equal(fake.set_mesh_calls, 2);
    cohort_delegate_stop(delegate, true);
}

static void expect_refused(const char *word)
{
    CohortError err = {0};
    assert_false(cohort_render_pass_execute(pass, &pass_state, &err));
    assert_non_null(strstr(err.message, word));
}

static void test_bad_states_are_named(void **state)
{
    (void)state;
    bindings[1].name = "beauty";
    expect_refused("beauty");
    bindings[1].name = "depth"; // another format than the buffer's
    expect_refused("depth");
    bindings[1].name = "primId";
    bindings[1].buffer = NULL;
    expect_refused("primId");
    bindings[1].buffer = ids;
    pass_state.camera = "/mesh";
    expect_refused("/mesh");
    pass_state.camera = NULL;
    expect_refused("camera");
    pass_state.camera = "/camera";
    pass_state.binding_count = 0;
    expect_refused("AOV");
    pass_state.binding_count = 2;
    fake.fail_create = true;
    expect_refused("create");
    fake.fail_create = false;
    execute_pass();
    assert_true(cohort_render_pass_wait(pass, 10.0));
    CohortRenderBuffer *other =
        cohort_render_buffer_create(delegate, 5, 3, COHORT_FORMAT_INT32, NULL);
    bindings[1].buffer = other;
    expect_refused("one size");
}

static void test_buffer_destroyed_while_bound(void **state)
{
    (void)state;
    fake.round_nanoseconds = 5000000;
    fake.rounds_to_do = 1000;
    execute_pass();
    cohort_render_buffer_destroy(ids);
    assert_int_equal(fake.renders_live, 0);
    assert_false(cohort_render_pass_is_converged(pass));
    pass_state.binding_count = 1;
    fake.rounds_to_do = 2;
    execute_pass();
    assert_true(cohort_render_pass_wait(pass, 10.0));
}

static void test_two_passes_take_turns(void **state)
{
    (void)state;
    CohortRenderPass *second = cohort_render_pass_create(render_index, NULL);
    execute_pass();
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_true(cohort_render_pass_execute(second, &pass_state, NULL));
    assert_false(cohort_render_pass_is_converged(pass));
    assert_true(cohort_render_pass_wait(second, 10.0));
    cohort_render_pass_destroy(second);
    assert_int_equal(fake.renders_live, 0);
}

// The level of the mesh once a pass with this edge length and focal length has begun.
static uint32_t diced_level(double edge_length, double focal_length)
{
    assert_true(cohort_delegate_set_double(delegate, "cohort:edgeLength", edge_length, NULL));
    host.camera.focal_length = focal_length;
    cohort_render_index_mark_dirty(render_index, "/camera", COHORT_DIRTY_PARAMS);
    execute_pass();
    uint32_t level = 0;
    for (uint32_t i = 0; i < fake.object_count; i++)
        level = fake.objects[i].is_mesh ? fake.objects[i].level : level;
    return level;
}

static void test_edge_length_decides_levels(void **state)
{
    (void)state;
    double length = 1e5;
    while (diced_level(length, 50.0) == 0)
        length *= 0.5;
    assert_true(length > 1e-3 && length < 1e5);
    assert_int_equal(diced_level(length, 50.0), 1);
    assert_int_equal(diced_level(0.25 * length, 50.0), 3);
    assert_int_equal(diced_level(0.25 * length, 100.0), 4);
    uint64_t calls = fake.set_mesh_calls;
    assert_int_equal(diced_level(0.25 * length, 100.0), 4);
    assert_int_equal(fake.set_mesh_calls, calls); // nothing is seen otherwise
    assert_int_equal(diced_level(1e6, 100.0), 0);
    // What was rendered before does not matter.
    assert_int_equal(diced_level(length, 50.0), 1);
    assert_int_equal(diced_level(0.0, 50.0), 2);
    assert_int_equal(diced_level(1e-6, 50.0), 8); // the finest there is
}

// Of twenty placements the one counts that is seen largest, whichever it is.
static void test_nearest_placement_decides(void **state)
{
    (void)state;
    double length = 1e5;
    while (diced_level(length, 50.0) < 3)
        length *= 0.5;
    FakeObject *root = &fake.objects[0];
    const CohortInstanceDesc near = root->instances[0];
    root->instance_count = 20;
    for (size_t nearest = 0; nearest <= 20; nearest += 5) {
        for (size_t i = 0; i < 20; i++) {
            root->instances[i] = near;
            root->instances[i].transform[3][2] -= i == nearest ? 0.0 : 1e3 + (double)i;
        }
        uint32_t level = diced_level(length, 50.0);
        assert_true(nearest < 20 ? level == 3 : level < 3);
    }
    root->instance_count = 1;
    root->instances[0] = near;
}

static void test_a_pass_needs_memory(void **state)
{
    (void)state;
    TestFaults faults = {0};
    while (test_faults_next(&faults)) {
        CohortError err = {0};
        test_faults_begin(&faults);
        CohortRenderPass *second = cohort_render_pass_create(render_index, &err);
        test_faults_end(&faults, second != NULL, &err);
        cohort_render_pass_destroy(second);
        execute_pass();
    }
    assert_int_equal(faults.count, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_converges_after_one_execute, setup_pass,
                                        teardown_pass),
        cmocka_unit_test_setup_teardown(test_execute_again_does_nothing, setup_pass, teardown_pass),
        cmocka_unit_test_setup_teardown(test_edits_restart, setup_pass, teardown_pass),
        cmocka_unit_test_setup_teardown(test_bad_states_are_named, setup_pass, teardown_pass),
        cmocka_unit_test_setup_teardown(test_buffer_destroyed_while_bound, setup_pass,
                                        teardown_pass),
        cmocka_unit_test_setup_teardown(test_edge_length_decides_levels, setup_pass, teardown_pass),
        cmocka_unit_test_setup_teardown(test_nearest_placement_decides, setup_pass, teardown_pass),
        cmocka_unit_test_setup_teardown(test_two_passes_take_turns, setup_pass, teardown_pass),
        cmocka_unit_test_setup_teardown(test_a_pass_needs_memory, setup_pass, teardown_pass),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
