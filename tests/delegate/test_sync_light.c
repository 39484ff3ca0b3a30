// Lights of a host: when they are pulled, what hides them, and hosts that give none.

#include "index_fixture.h"

#include "base/memory.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static void open_light(void)
{
    host.x = 3.0;
    insert_prim(COHORT_PRIM_LIGHT, "/light", NULL, 0);
    sync_index();
}

static void sync_dirty(uint32_t bits)
{
    cohort_render_index_mark_dirty(render_index, "/light", bits);
    sync_index();
}

// The host gives the light, the index its path and its place.
static void test_a_light_has_its_place(void **state)
{
    (void)state;
    open_light();
    const CohortLightDesc *light = &fake.lights[0];
    assert_int_equal(light->type, COHORT_LIGHT_RECT);
    assert_true(light->intensity == 5.0f && light->transform[3][0] == 3.0);
    assert_false(light->hidden);
    host.x = 4.0;
    sync_dirty(COHORT_DIRTY_TRANSFORM);
    assert_true(light->transform[3][0] == 4.0);
    assert_int_equal(host.light_pulls, 2);
    sync_dirty(COHORT_DIRTY_TRANSFORM); // to where it is
    assert_int_equal(host.light_pulls, 2);
    assert_int_equal(fake.set_light_calls, 2);
}

static void test_what_hides_a_light(void **state)
{
    (void)state;
    open_light();
    host.invisible = true;
    sync_dirty(COHORT_DIRTY_VISIBILITY);
    assert_true(fake.lights[0].hidden);
    host.invisible = false;
    sync_dirty(COHORT_DIRTY_VISIBILITY);
    assert_false(fake.lights[0].hidden);
    host.x = (double)NAN;
    sync_dirty(COHORT_DIRTY_TRANSFORM);
    assert_true(fake.lights[0].hidden);
    host.x = 0.0;
    sync_dirty(COHORT_DIRTY_TRANSFORM);
    assert_false(fake.lights[0].hidden);
    assert_true(cohort_delegate_set_bool(delegate, "enableSceneLights", false, NULL));
    sync_index();
    assert_true(fake.lights[0].hidden);
    assert_true(cohort_delegate_set_bool(delegate, "enableSceneLights", true, NULL));
    assert_true(cohort_delegate_set_bool(delegate, "enableShadows", false, NULL));
    sync_index();
    assert_true(fake.lights[0].no_shadow && !fake.lights[0].hidden);
}

static bool refuse(void *cookie, CohortPull *pull, const char *path, CohortLightDesc *out,
                   CohortError *err)
{
    (void)cookie, (void)pull, (void)path;
    out->intensity = 1e9f;
    err->code = COHORT_ERROR_SCENE;
    strcpy(err->message, "no light today");
    return false;
}

// Without a light the old one goes dark, and the host's reason is told; later it may come back.
static void test_a_host_without_a_light(void **state)
{
    (void)state;
    open_light();
    bool (*const get_light)(void *, CohortPull *, const char *, CohortLightDesc *, CohortError *) =
        host.scene.get_light;
    for (int i = 0; i < 2; i++) {
        host.scene.get_light = i == 0 ? refuse : NULL;
        sync_dirty(COHORT_DIRTY_PARAMS);
        assert_true(fake.lights[0].hidden);
        assert_true(fake.lights[0].intensity == 1.0f); // nothing of what was refused
    }
    const CohortReportEntry *entries;
    assert_int_equal(cohort_delegate_report(delegate, &entries), 2);
    assert_string_equal(entries[0].prim_path, "/light");
    assert_string_equal(entries[0].action, "left out: no light today");
    host.scene.get_light = get_light;
    sync_dirty(COHORT_DIRTY_PARAMS);
    assert_true(!fake.lights[0].hidden && fake.lights[0].intensity == 5.0f);
}

// A light that moves while memory is at an end is there after the next sync.
static void test_a_failed_move_is_made_up_for(void **state)
{
    (void)state;
    open_light();
    bool ok = false;
    int failures = 0;
    for (uint64_t n = 1; n < 50 && !ok; n++) {
        host.x = 100.0 * (double)n;
        cohort_render_index_mark_dirty(render_index, "/light", COHORT_DIRTY_TRANSFORM);
        co_memory_fail_after(n);
        ok = cohort_render_index_sync(render_index, NULL);
        co_memory_fail_after(0);
        failures += !ok;
        sync_index();
        assert_true(fake.lights[0].transform[3][0] == host.x);
    }
    assert_true(ok && failures > 0);
}

// The same when it is the host that finds no memory.
static bool run_out(void *cookie, CohortPull *pull, const char *path, CohortLightDesc *out,
                    CohortError *err)
{
    (void)cookie, (void)pull, (void)path, (void)out;
    err->code = COHORT_ERROR_OUT_OF_MEMORY;
    return false;
}

static void test_a_host_out_of_memory(void **state)
{
    (void)state;
    open_light();
    bool (*const get_light)(void *, CohortPull *, const char *, CohortLightDesc *, CohortError *) =
        host.scene.get_light;
    host.scene.get_light = run_out;
    host.x = 9.0;
    CohortError err = {0};
    cohort_render_index_mark_dirty(render_index, "/light", COHORT_DIRTY_TRANSFORM);
    assert_false(cohort_render_index_sync(render_index, &err));
    assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
    host.scene.get_light = get_light;
    sync_index();
    assert_true(fake.lights[0].transform[3][0] == 9.0 && !fake.lights[0].hidden);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_a_light_has_its_place, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_what_hides_a_light, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_a_host_without_a_light, setup_index, teardown_index),
        cmocka_unit_test_setup_teardown(test_a_failed_move_is_made_up_for, setup_index,
                                        teardown_index),
        cmocka_unit_test_setup_teardown(test_a_host_out_of_memory, setup_index, teardown_index),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
