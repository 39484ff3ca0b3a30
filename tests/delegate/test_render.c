// The whole way with the real renderer: stage, adapter, delegate, pixels.

#include "cohort/stage_adapter.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

enum {
    WIDTH = 24,
    HEIGHT = 18,
    PIXELS = WIDTH * HEIGHT
};

static const char stage_text[] =
    "#usda 1.0\n"
    "def Camera \"Cam\"\n{\n    double3 xformOp:translate = (0, 0, 6)\n"
    "    uniform token[] xformOpOrder = [\"xformOp:translate\"]\n}\n"
    "def Mesh \"Floor\"\n{\n    int[] faceVertexCounts = [4]\n"
    "    int[] faceVertexIndices = [0, 1, 2, 3]\n"
    "    point3f[] points = [(-5,-5,-1), (5,-5,-1), (5,0,-1), (-5,0,-1)]\n"
    "    uniform token subdivisionScheme = \"none\"\n"
    "    color3f[] primvars:displayColor = [(0.8, 0.2, 0.2)]\n}\n"
    "def Sphere \"Ball\"\n{\n    double radius = 0.5\n}\n"
    "def DistantLight \"Sun\"\n{\n    float inputs:intensity = 50000\n}\n";

typedef struct Host {
    char path[64];
    CohortDelegate *delegate;
    CohortRenderIndex *index;
    CohortAdapter *adapter;
    CohortRenderPass *pass;
    CohortRenderBuffer *color, *ids;
    CohortAovBinding bindings[2];
    CohortRenderPassState state;
} Host;

static Host host;

static int setup(void **state)
{
    (void)state;
    CohortError err = {0};
    memset(&host, 0, sizeof host);
    strcpy(host.path, "/tmp/cohort_render_XXXXXX.usda");
    FILE *file = fdopen(mkstemps(host.path, 5), "w");
    fputs(stage_text, file);
    fclose(file);
    host.delegate = cohort_delegate_create(&err);
    host.index = cohort_render_index_create(host.delegate, &err);
    host.adapter = cohort_adapter_open(host.delegate, host.path, NULL, &err);
    cohort_delegate_set_int(host.delegate, "cohort:spp", 8, &err);
    cohort_adapter_populate(host.adapter, &err);
    host.pass = cohort_render_pass_create(host.index, &err);
    host.color =
        cohort_render_buffer_create(host.delegate, WIDTH, HEIGHT, COHORT_FORMAT_FLOAT32_VEC4, &err);
    host.ids = cohort_render_buffer_create(host.delegate, WIDTH, HEIGHT, COHORT_FORMAT_INT32, &err);
    host.bindings[0] = (CohortAovBinding){"color", host.color};
    host.bindings[1] = (CohortAovBinding){"primId", host.ids};
    host.state = cohort_adapter_pass_state(host.adapter);
    host.state.bindings = host.bindings;
    host.state.binding_count = 2;
    return err.code == COHORT_OK ? 0 : 1;
}

static int teardown(void **state)
{
    (void)state;
    cohort_adapter_destroy(host.adapter);
    cohort_delegate_destroy(host.delegate);
    unlink(host.path);
    return 0;
}

static void execute(void)
{
    CohortError err = {0};
    if (!cohort_render_pass_execute(host.pass, &host.state, &err))
        fail_msg("%s", err.message);
}

static void render(float pixels[PIXELS * 4])
{
    CohortError err = {0};
    execute();
    assert_true(cohort_render_pass_wait(host.pass, 60.0));
    if (cohort_render_pass_error(host.pass, &err))
        fail_msg("%s", err.message);
    memcpy(pixels, cohort_render_buffer_map(host.color), PIXELS * 4 * sizeof *pixels);
    cohort_render_buffer_unmap(host.color);
}

static void test_image_is_upright(void **state)
{
    (void)state;
    static float pixels[PIXELS * 4];
    render(pixels);
    const float *bottom = pixels + 4 * (WIDTH / 2), *top = pixels + 4 * (PIXELS - WIDTH / 2);
    assert_true(bottom[0] > 2.0f * bottom[1] && bottom[3] > 0.9f); // the red floor, below
    assert_true(top[3] == 0.0f);                                   // nothing above
    const int32_t *ids = cohort_render_buffer_map(host.ids);
    assert_string_equal(cohort_render_index_prim_path(host.index, ids[WIDTH / 2]), "/Floor");
    assert_string_equal(
        cohort_render_index_prim_path(host.index, ids[WIDTH * (HEIGHT / 2) + WIDTH / 2]), "/Ball");
    assert_int_equal(ids[PIXELS - WIDTH / 2], -1);
    cohort_render_buffer_unmap(host.ids);
}

static void test_pausing_changes_no_pixel(void **state)
{
    (void)state;
    static float through[PIXELS * 4], broken[PIXELS * 4];
    render(through);
    assert_true(cohort_delegate_restart(host.delegate));
    for (int i = 0; i < 4; i++) {
        assert_true(cohort_delegate_pause(host.delegate));
        assert_true(cohort_delegate_resume(host.delegate));
    }
    render(broken);
    assert_memory_equal(through, broken, sizeof through);
}

static void test_edits_rebuild_only_what_changed(void **state)
{
    (void)state;
    static float first[PIXELS * 4], again[PIXELS * 4];
    CohortSyncCounts before, after;
    render(first);
    cohort_render_index_counts(host.index, &before);
    cohort_render_index_mark_dirty(host.index, "/Sun", COHORT_DIRTY_PARAMS);
    cohort_render_index_mark_dirty(host.index, "/Cam", COHORT_DIRTY_PARAMS);
    host.state.pixel_aspect_ratio = 1.5;
    render(again);
    cohort_render_index_counts(host.index, &after);
    assert_int_equal(after.scene.mesh_builds, before.scene.mesh_builds);
    assert_int_equal(after.scene.group_builds, before.scene.group_builds);
    assert_true(after.scene.camera_builds > before.scene.camera_builds);
    assert_true(memcmp(first, again, sizeof first) != 0);
    host.state.pixel_aspect_ratio = 1.0;
    render(again);
    assert_memory_equal(first, again, sizeof first);
}

static void test_statistics_add_up(void **state)
{
    (void)state;
    static float pixels[PIXELS * 4];
    render(pixels);
    CohortRenderStats stats;
    assert_true(cohort_delegate_render_stats(host.delegate, &stats));
    assert_int_equal(stats.samples_per_pixel, 8);
    assert_int_equal(stats.rays_made, stats.rays_traced);
    assert_int_equal(stats.rays_camera, PIXELS * 8);
    CohortStat list[4];
    assert_true(cohort_delegate_stats(host.delegate, list, 4) > 4);
    assert_true(list[0].value.number == 100.0);
}

static void test_film_goes_on(void **state)
{
    (void)state;
    static float whole[PIXELS * 4], resumed[PIXELS * 4];
    char film[80];
    snprintf(film, sizeof film, "%s.film", host.path);
    render(whole);
    assert_true(cohort_delegate_set_int(host.delegate, "cohort:spp", 2, NULL));
    render(resumed);
    assert_true(cohort_render_pass_save(host.pass, film, host.state.stage_hash, NULL));
    assert_true(cohort_delegate_set_int(host.delegate, "cohort:spp", 8, NULL));
    host.state.resume_file = film;
    render(resumed);
    assert_memory_equal(whole, resumed, sizeof whole);
    host.state.stage_hash++;
    CohortError err = {0};
    assert_false(cohort_render_pass_execute(host.pass, &host.state, &err));
    unlink(film);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_image_is_upright, setup, teardown),
        cmocka_unit_test_setup_teardown(test_pausing_changes_no_pixel, setup, teardown),
        cmocka_unit_test_setup_teardown(test_edits_rebuild_only_what_changed, setup, teardown),
        cmocka_unit_test_setup_teardown(test_statistics_add_up, setup, teardown),
        cmocka_unit_test_setup_teardown(test_film_goes_on, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
