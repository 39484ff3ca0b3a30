// The pass renders in the background, ends by itself, and pauses, resumes, stops and restarts.

#include "index_fixture.h"

#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

static CohortRenderPass *pass;
static CohortRenderBuffer *color, *ids;
static CohortAovBinding bindings[2];
static CohortRenderPassState pass_state;

static int setup(void **state)
{
    if (setup_index(state) != 0)
        return 1;
    pass = cohort_render_pass_create(render_index, NULL);
    color = cohort_render_buffer_create(delegate, 4, 3, COHORT_FORMAT_FLOAT32_VEC4, NULL);
    ids = cohort_render_buffer_create(delegate, 4, 3, COHORT_FORMAT_INT32, NULL);
    bindings[0] = (CohortAovBinding){"color", color};
    bindings[1] = (CohortAovBinding){"primId", ids};
    pass_state =
        (CohortRenderPassState){.camera = "/camera", .bindings = bindings, .binding_count = 2};
    return !cohort_render_index_insert(render_index, COHORT_PRIM_CAMERA, "/camera", &host.scene,
                                       NULL, 0, NULL) ||
           !cohort_render_index_insert(render_index, COHORT_PRIM_MESH, "/mesh", &host.scene, NULL,
                                       0, NULL);
}

static int teardown(void **state)
{
    int failures = teardown_index(state);
    assert_int_equal(fake.renders_live, 0);
    assert_int_equal(fake.edits_during_render, 0);
    return failures;
}

static void execute(void)
{
    CohortError err = {0};
    assert_true(cohort_render_pass_execute(pass, &pass_state, &err));
}

static void rest(long milliseconds)
{
    struct timespec pause = {.tv_nsec = milliseconds * 1000000L};
    nanosleep(&pause, NULL);
}

static CohortStat stat_of(const char *key)
{
    CohortStat stats[32];
    size_t count = cohort_delegate_stats(delegate, stats, 32);
    for (size_t i = 0; i < count; i++)
        if (strcmp(stats[i].key, key) == 0)
            return stats[i];
    fail_msg("no statistic %s", key);
    return stats[0];
}

static void test_converges_after_one_execute(void **state)
{
    (void)state;
    execute();
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
    execute();
    assert_true(cohort_render_pass_wait(pass, 10.0));
    for (int i = 0; i < 5; i++) {
        assert_true(cohort_delegate_set_bool(delegate, "domeLightCameraVisibility", true, NULL));
        execute();
    }
    assert_int_equal(fake.renders_made, 1);
    assert_true(cohort_render_pass_is_converged(pass));
}

static void test_edits_restart(void **state)
{
    (void)state;
    fake.round_nanoseconds = 20000000;
    fake.rounds_to_do = 1000;
    execute();
    assert_false(cohort_render_pass_is_converged(pass));
    assert_true(cohort_delegate_set_int(delegate, "cohort:spp", 9, NULL));
    execute();
    assert_int_equal(fake.renders_made, 2);
    assert_int_equal(fake.settings.spp, 9);
    cohort_render_index_mark_dirty(render_index, "/mesh", COHORT_DIRTY_POINTS);
    execute();
    assert_int_equal(fake.renders_made, 3);
    assert_true(cohort_delegate_set_int(delegate, "cohort:batch", 1024, NULL)); // only the schedule
    execute();
    assert_int_equal(fake.renders_made, 3);
    uint64_t cameras = fake.set_camera_calls;
    cohort_render_index_mark_dirty(render_index, "/camera", COHORT_DIRTY_PARAMS);
    host.camera.focal_length = 35.0;
    execute();
    assert_int_equal(fake.renders_made, 4);
    assert_int_equal(fake.set_camera_calls, cameras + 1);
    assert_int_equal(fake.set_mesh_calls, 2);
    cohort_delegate_stop(delegate, true);
}

static void test_pause_keeps_complete_rounds(void **state)
{
    (void)state;
    fake.round_nanoseconds = 5000000;
    fake.rounds_to_do = 12;
    execute();
    rest(20);
    assert_true(cohort_delegate_pause(delegate));
    int64_t done = stat_of("numCompletedSamples").value.integer;
    double percent = stat_of("percentDone").value.number;
    rest(20);
    assert_int_equal(stat_of("numCompletedSamples").value.integer, done);
    assert_false(cohort_render_pass_is_converged(pass));
    assert_string_equal(stat_of("renderProgressAnnotation").value.string, "stopped");
    execute(); // does not start it
    rest(10);
    assert_int_equal(stat_of("numCompletedSamples").value.integer, done);
    assert_true(cohort_delegate_resume(delegate));
    assert_true(stat_of("percentDone").value.number >= percent);
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_int_equal(fake.renders_made, 1);
    assert_int_equal(stat_of("numCompletedSamples").value.integer, 12);
}

static void test_stop_is_quick_and_restart_starts_over(void **state)
{
    (void)state;
    fake.round_nanoseconds = 900000000;
    execute();
    rest(10);
    struct timespec begin, end;
    clock_gettime(CLOCK_MONOTONIC, &begin);
    cohort_delegate_stop(delegate, false);
    cohort_delegate_stop(delegate, true);
    clock_gettime(CLOCK_MONOTONIC, &end);
    double seconds =
        (double)(end.tv_sec - begin.tv_sec) + 1e-9 * (double)(end.tv_nsec - begin.tv_nsec);
    assert_true(seconds < 0.5);
    assert_false(cohort_render_pass_wait(pass, 0.01));
    fake.round_nanoseconds = 0;
    assert_true(cohort_delegate_restart(delegate));
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_int_equal(fake.renders_made, 2);
}

static void test_many_stops_and_resumes(void **state)
{
    (void)state;
    fake.round_nanoseconds = 1000000;
    fake.rounds_to_do = 30;
    execute();
    for (int i = 0; i < 40; i++) {
        cohort_delegate_stop(delegate, i % 2 == 0);
        assert_true(cohort_delegate_resume(delegate));
        rest(i % 3);
    }
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_int_equal(stat_of("numCompletedSamples").value.integer, 30);
}

enum {
    MEDDLER_TURNS = 600
};

static void *stop_often(void *cookie)
{
    (void)cookie;
    for (int i = 0; i < MEDDLER_TURNS; i++)
        cohort_delegate_stop(delegate, i % 8 != 7);
    return NULL;
}

static void *resume_often(void *cookie)
{
    (void)cookie;
    bool ok = true;
    for (int i = 0; i < MEDDLER_TURNS; i++)
        ok = cohort_delegate_resume(delegate) && ok;
    return ok ? NULL : cookie;
}

// Two stop and one resumes, as threads of a host would, while `meanwhile` runs here.
static void meddle(void (*meanwhile)(void))
{
    alarm(60); // who waits forever ends the test
    pthread_t threads[3];
    int failure = 0;
    for (int i = 0; i < 3; i++)
        assert_int_equal(
            pthread_create(&threads[i], NULL, i < 2 ? stop_often : resume_often, &failure), 0);
    if (meanwhile)
        meanwhile();
    void *result;
    for (int i = 0; i < 3; i++) {
        assert_int_equal(pthread_join(threads[i], &result), 0);
        assert_null(result);
    }
    alarm(0);
}

// Lets the endless render that threads meddled with come to its end.
static void finish(void)
{
    cohort_delegate_stop(delegate, true);
    fake.rounds_to_do = (uint64_t)stat_of("numCompletedSamples").value.integer + 3;
    assert_true(cohort_delegate_resume(delegate));
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_int_equal(stat_of("numCompletedSamples").value.integer, fake.rounds_to_do);
}

static void test_threads_stop_and_resume(void **state)
{
    (void)state;
    fake.round_nanoseconds = 1000000;
    fake.rounds_to_do = 1u << 30;
    execute();
    meddle(NULL);
    finish();
    assert_int_equal(fake.renders_made, 1);
}

static void restart_often(void)
{
    for (int i = 0; i < 60; i++)
        assert_true(cohort_delegate_restart(delegate));
}

static void test_threads_stop_and_resume_what_restarts(void **state)
{
    (void)state;
    fake.round_nanoseconds = 1000000;
    fake.rounds_to_do = 1u << 30;
    execute();
    meddle(restart_often);
    assert_int_equal(fake.renders_live, 1);
    assert_int_equal(fake.rounds_of_the_dead, 0);
    finish();
}

static void test_errors_of_the_thread_are_kept(void **state)
{
    (void)state;
    fake.fail_round = true;
    execute();
    cohort_render_pass_wait(pass, 10.0);
    assert_true(cohort_render_pass_is_converged(pass)); // a host that polls must not hang
    CohortError err = {0};
    assert_true(cohort_render_pass_error(pass, &err));
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
    assert_int_equal(stat_of("huskErrorStatus").value.integer, COHORT_ERROR_FILE_WRITE);
    assert_true(stat_of("percentDone").value.number < 100.0);
    fake.fail_round = false;
    assert_true(cohort_delegate_restart(delegate));
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_false(cohort_render_pass_error(pass, &err));
}

static atomic_int rounds_seen, done_seen;
static bool saved_from_callback;

static void on_round(void *cookie, const CohortRoundInfo *info)
{
    (void)cookie;
    atomic_fetch_add(&rounds_seen, 1);
    if (info->is_done)
        atomic_fetch_add(&done_seen, 1);
    const float *pixels = cohort_render_buffer_map(color);
    if (pixels[0] != 2.0f + 100.0f * (float)info->round)
        atomic_fetch_add(&done_seen, 100);
    cohort_render_buffer_unmap(color);
    if (info->round == 2)
        saved_from_callback = cohort_render_pass_save(pass, "/film", 7, NULL);
}

static void test_round_callback(void **state)
{
    (void)state;
    atomic_store(&rounds_seen, 0);
    atomic_store(&done_seen, 0);
    saved_from_callback = false;
    cohort_delegate_set_round_callback(delegate, on_round, NULL);
    execute();
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_int_equal(atomic_load(&rounds_seen), 3);
    assert_int_equal(atomic_load(&done_seen), 1);
    assert_true(saved_from_callback);
}

static void test_save_and_resume_from_file(void **state)
{
    (void)state;
    CohortError err = {0};
    assert_false(cohort_render_pass_save(pass, "/film", 7, &err));
    fake.round_nanoseconds = 10000000;
    execute();
    assert_true(cohort_render_pass_save(pass, "/film", 7, NULL)); // waits for the round
    assert_false(cohort_render_pass_save(pass, "film", 7, &err));
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_true(cohort_render_pass_save(pass, "/film", 7, NULL));
    assert_int_equal(fake.saves, 2);
    pass_state.resume_file = "/film";
    pass_state.stage_hash = 6;
    err = (CohortError){0};
    assert_false(cohort_render_pass_execute(pass, &pass_state, &err));
    assert_int_equal(err.code, COHORT_ERROR_SCENE);
    pass_state.stage_hash = 7;
    execute();
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_int_equal(fake.resumes, 1);
}

static bool goes_on(void)
{
    bool ok = cohort_render_pass_execute(pass, &pass_state, NULL);
    cohort_render_pass_wait(pass, 10.0);
    return ok;
}

static void test_films_of_other_settings_are_refused(void **state)
{
    (void)state;
    execute();
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_true(cohort_render_pass_save(pass, "/film", 0, NULL));
    pass_state.resume_file = "/film";
    assert_true(goes_on());
    const struct {
        const char *key;
        int64_t other, same;
    } numbers[] = {{"cohort:complexity", 3, 2},
                   {"cohort:ptexReductionsAuthored", 1, 0},
                   {"enableSceneLights", 0, 1}};
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
        assert_true(cohort_delegate_set_int(delegate, numbers[i].key, numbers[i].other, NULL));
        assert_false(goes_on());
        assert_true(cohort_delegate_set_int(delegate, numbers[i].key, numbers[i].same, NULL));
        assert_true(goes_on());
    }
    const char *const texts[] = {"cohort:renderingColorSpace", "cohort:ocioConfig"};
    for (size_t i = 0; i < 2; i++) {
        assert_true(cohort_delegate_set_string(delegate, texts[i], "other", NULL));
        assert_false(goes_on());
        assert_true(cohort_delegate_set_string(delegate, texts[i], "", NULL));
        assert_true(goes_on());
    }
    pass_state.conform = COHORT_CONFORM_CROP_APERTURE;
    assert_false(goes_on());
    pass_state.conform = COHORT_CONFORM_EXPAND_APERTURE;
    pass_state.pixel_aspect_ratio = 2.0;
    assert_false(goes_on());
    pass_state.pixel_aspect_ratio = 0.0;
    pass_state.disable_depth_of_field = true;
    assert_false(goes_on());
    pass_state.disable_depth_of_field = false;
    // When to stop, and how, is not in the film.
    assert_true(cohort_delegate_set_int(delegate, "cohort:spp", 99, NULL));
    assert_true(cohort_delegate_set_double(delegate, "cohort:noise", 0.5, NULL));
    assert_true(cohort_delegate_set_double(delegate, "cohort:timeLimit", 9.0, NULL));
    assert_true(cohort_delegate_set_int(delegate, "cohort:batch", 1024, NULL));
    assert_true(goes_on());
}

static void test_mapped_pixels_stay(void **state)
{
    (void)state;
    fake.round_nanoseconds = 3000000;
    execute();
    const float *pixels = cohort_render_buffer_map(color);
    float before = pixels[0];
    assert_true(cohort_render_buffer_is_mapped(color));
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_true(pixels[0] == before);
    assert_ptr_equal(cohort_render_buffer_map(color), pixels); // nested: still the same image
    cohort_render_buffer_unmap(color);
    cohort_render_buffer_unmap(color);
    cohort_render_buffer_unmap(color); // one too many is harmless
    cohort_render_buffer_resolve(color);
    pixels = cohort_render_buffer_map(color);
    assert_true(pixels[0] == 302.0f);
    cohort_render_buffer_unmap(color);
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
    execute();
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
    execute();
    cohort_render_buffer_destroy(ids);
    assert_int_equal(fake.renders_live, 0);
    assert_false(cohort_render_pass_is_converged(pass));
    pass_state.binding_count = 1;
    fake.rounds_to_do = 2;
    execute();
    assert_true(cohort_render_pass_wait(pass, 10.0));
}

static void test_two_passes_take_turns(void **state)
{
    (void)state;
    CohortRenderPass *second = cohort_render_pass_create(render_index, NULL);
    execute();
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
    execute();
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_converges_after_one_execute, setup, teardown),
        cmocka_unit_test_setup_teardown(test_execute_again_does_nothing, setup, teardown),
        cmocka_unit_test_setup_teardown(test_edits_restart, setup, teardown),
        cmocka_unit_test_setup_teardown(test_pause_keeps_complete_rounds, setup, teardown),
        cmocka_unit_test_setup_teardown(test_stop_is_quick_and_restart_starts_over, setup,
                                        teardown),
        cmocka_unit_test_setup_teardown(test_many_stops_and_resumes, setup, teardown),
        cmocka_unit_test_setup_teardown(test_threads_stop_and_resume, setup, teardown),
        cmocka_unit_test_setup_teardown(test_threads_stop_and_resume_what_restarts, setup,
                                        teardown),
        cmocka_unit_test_setup_teardown(test_errors_of_the_thread_are_kept, setup, teardown),
        cmocka_unit_test_setup_teardown(test_round_callback, setup, teardown),
        cmocka_unit_test_setup_teardown(test_save_and_resume_from_file, setup, teardown),
        cmocka_unit_test_setup_teardown(test_films_of_other_settings_are_refused, setup, teardown),
        cmocka_unit_test_setup_teardown(test_mapped_pixels_stay, setup, teardown),
        cmocka_unit_test_setup_teardown(test_bad_states_are_named, setup, teardown),
        cmocka_unit_test_setup_teardown(test_buffer_destroyed_while_bound, setup, teardown),
        cmocka_unit_test_setup_teardown(test_edge_length_decides_levels, setup, teardown),
        cmocka_unit_test_setup_teardown(test_nearest_placement_decides, setup, teardown),
        cmocka_unit_test_setup_teardown(test_two_passes_take_turns, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
