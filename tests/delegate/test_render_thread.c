// The render thread by itself: started, stopped, continued, waited for, asked and destroyed in
// every order, with a renderer that dawdles.

#include "fake_renderer.h"

#include "base/memory.h"
#include "pass/render_thread.h"

#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static CoRenderThread *thread;

static int setup(void **state)
{
    (void)state;
    fake_reset();
    alarm(60); // who waits forever ends the test
    thread = co_render_thread_create(NULL);
    return thread ? 0 : 1;
}

static int teardown(void **state)
{
    (void)state;
    co_render_thread_destroy(thread);
    alarm(0);
    assert_int_equal(fake.renders_live, 0);
    assert_int_equal(fake.rounds_of_the_dead, 0);
    return co_memory_live(CO_MEMORY_DELEGATE) == 0 ? 0 : 1;
}

static void start(uint64_t rounds, long nanoseconds)
{
    fake.rounds_to_do = rounds;
    fake.round_nanoseconds = nanoseconds;
    const CohortRenderSettings settings = {.width = 1, .height = 1};
    CohortRender *render = cohort_render_create(NULL, &settings, NULL);
    assert_true(co_render_thread_start(thread, render, NULL, 0, NULL, NULL, NULL));
}

static void start_endless(void)
{
    start(1u << 30, 1000000);
}

static CoRenderProgress progress(void)
{
    CoRenderProgress p;
    co_render_thread_progress(thread, &p);
    return p;
}

// ---- Down --------------------------------------------------------------------------------------

static void test_down_does_nothing(void **state)
{
    (void)state;
    CohortError err = {0};
    for (int i = 0; i < 2; i++) {
        co_render_thread_stop(thread, false);
        co_render_thread_stop(thread, true);
        assert_true(co_render_thread_continue(thread, &err));
        assert_false(co_render_thread_wait(thread, -1.0));
        assert_false(co_render_thread_has_render(thread));
        assert_false(co_render_thread_is_running(thread));
        assert_false(co_render_thread_is_done(thread));
        assert_false(co_render_thread_error(thread, &err));
        assert_int_equal(err.code, COHORT_OK);
        co_render_thread_drop(thread);
    }
    assert_false(co_render_thread_save(thread, "/film", 1, &err));
    assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
    CoRenderProgress p = progress();
    assert_false(p.has_render);
    assert_true(p.fraction == 0.0 && p.seconds == 0.0);
    co_render_thread_destroy(NULL);
}

// ---- Orders ------------------------------------------------------------------------------------

static void test_stopped_twice(void **state)
{
    (void)state;
    for (int first = 0; first < 2; first++)
        for (int second = 0; second < 2; second++) {
            start_endless();
            co_render_thread_stop(thread, first);
            co_render_thread_stop(thread, second);
            assert_false(co_render_thread_wait(thread, 10.0));
            assert_false(co_render_thread_is_running(thread));
            assert_true(co_render_thread_has_render(thread)); // rests: its film can be had
            assert_true(co_render_thread_save(thread, "/film", 1, NULL));
        }
}

static void test_continued_twice(void **state)
{
    (void)state;
    start_endless();
    assert_true(co_render_thread_continue(thread, NULL)); // runs already
    co_render_thread_stop(thread, true);
    assert_true(co_render_thread_continue(thread, NULL));
    assert_true(co_render_thread_continue(thread, NULL));
    assert_true(co_render_thread_is_running(thread));
    co_render_thread_stop(thread, false);
    fake.round_nanoseconds = 0;
    assert_true(co_render_thread_continue(thread, NULL)); // undoes the stop
    assert_true(co_render_thread_is_running(thread));
}

static void test_what_is_done_stays_done(void **state)
{
    (void)state;
    start(2, 0);
    assert_true(co_render_thread_wait(thread, -1.0));
    co_render_thread_stop(thread, true);
    assert_true(co_render_thread_continue(thread, NULL));
    assert_false(co_render_thread_is_running(thread));
    assert_true(co_render_thread_is_done(thread));
    assert_true(co_render_thread_wait(thread, 0.0));
    CoRenderProgress p = progress();
    assert_true(p.fraction == 1.0);
    assert_int_equal(p.stats.rounds, 2);
    co_render_thread_drop(thread);
    assert_false(co_render_thread_is_done(thread));
    assert_true(progress().fraction == 0.0);
}

static void test_started_over_another(void **state)
{
    (void)state;
    start_endless();
    start(3, 0); // takes the first one down
    assert_int_equal(fake.renders_live, 1);
    assert_true(co_render_thread_wait(thread, 10.0));
    assert_int_equal(progress().stats.rounds, 3);
}

static void test_destroyed_at_any_moment(void **state)
{
    (void)state;
    for (int moment = 0; moment < 6; moment++) {
        if (moment)
            start_endless();
        if (moment == 2)
            co_render_thread_stop(thread, true);
        if (moment == 3)
            co_render_thread_stop(thread, false);
        if (moment == 4) {
            co_render_thread_stop(thread, false);
            co_render_thread_continue(thread, NULL);
        }
        if (moment == 5)
            usleep(3000);
        co_render_thread_destroy(thread);
        assert_int_equal(fake.renders_live, 0);
        thread = co_render_thread_create(NULL);
    }
}

// ---- Waiting -----------------------------------------------------------------------------------

static void test_waits_end_in_time(void **state)
{
    (void)state;
    const double seconds[] = {0.0, -0.0, 1e-9, 0.02};
    start_endless();
    for (size_t i = 0; i < sizeof seconds / sizeof *seconds; i++)
        assert_false(co_render_thread_wait(thread, seconds[i]));
    assert_true(co_render_thread_is_running(thread));
}

static void *stop_soon(void *cookie)
{
    (void)cookie;
    usleep(20000);
    co_render_thread_stop(thread, false);
    return NULL;
}

static void test_a_stop_wakes_who_waits(void **state)
{
    (void)state;
    const double seconds[] = {-1.0, 1e300, (double)INFINITY, (double)NAN};
    for (size_t i = 0; i < sizeof seconds / sizeof *seconds; i++) {
        start_endless();
        pthread_t other;
        assert_int_equal(pthread_create(&other, NULL, stop_soon, NULL), 0);
        assert_false(co_render_thread_wait(thread, seconds[i]));
        pthread_join(other, NULL);
        assert_false(co_render_thread_is_running(thread));
    }
}

// ---- Errors, films, progress -------------------------------------------------------------------

static void test_a_failed_render_rests(void **state)
{
    (void)state;
    CohortError err = {0};
    fake.fail_round = true;
    start(3, 0);
    assert_true(co_render_thread_wait(thread, 10.0)); // whoever polls must not wait forever
    assert_true(co_render_thread_error(thread, &err));
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
    fake.fail_round = false;
    assert_true(co_render_thread_continue(thread, NULL)); // a failure is no pause
    assert_false(co_render_thread_is_running(thread));
    assert_int_equal(progress().error, COHORT_ERROR_FILE_WRITE);
    assert_true(progress().fraction < 1.0);
    start(1, 0);
    assert_true(co_render_thread_wait(thread, 10.0));
    assert_false(co_render_thread_error(thread, &err));
}

static void test_films_while_it_runs(void **state)
{
    (void)state;
    CohortError err = {0};
    start_endless();
    assert_true(co_render_thread_save(thread, "/film", 9, &err));
    assert_int_equal(fake.saved_hash, 9);
    assert_false(co_render_thread_save(thread, "relative", 9, &err));
    assert_int_equal(err.code, COHORT_ERROR_FILE_WRITE);
    assert_true(co_render_thread_is_running(thread));
    co_render_thread_stop(thread, false);
    assert_true(co_render_thread_save(thread, "/film", 10, NULL)); // running or not by now
    assert_int_equal(fake.saved_hash, 10);
}

static void test_progress_never_falls(void **state)
{
    (void)state;
    start(0, 1000000); // none to do: its fraction is no number
    assert_true(co_render_thread_wait(thread, 10.0));
    assert_true(progress().fraction == 1.0);
    start(40, 500000);
    double before = 0.0, seconds = 0.0;
    while (!co_render_thread_is_done(thread)) {
        CoRenderProgress p = progress();
        assert_true(p.fraction >= before && p.fraction <= 1.0);
        assert_true(p.seconds >= seconds);
        before = p.fraction;
        seconds = p.seconds;
        co_render_thread_stop(thread, true);
        assert_true(co_render_thread_continue(thread, NULL));
        co_render_thread_wait(thread, 0.001);
    }
    seconds = progress().seconds;
    usleep(2000);
    assert_true(progress().seconds == seconds); // the clock stands at the end
}

static void test_no_memory_for_a_thread(void **state)
{
    (void)state;
    CohortError err = {0};
    co_memory_fail_after(1);
    CoRenderThread *none = co_render_thread_create(&err);
    co_memory_fail_after(0);
    assert_null(none);
    assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_down_does_nothing, setup, teardown),
        cmocka_unit_test_setup_teardown(test_stopped_twice, setup, teardown),
        cmocka_unit_test_setup_teardown(test_continued_twice, setup, teardown),
        cmocka_unit_test_setup_teardown(test_what_is_done_stays_done, setup, teardown),
        cmocka_unit_test_setup_teardown(test_started_over_another, setup, teardown),
        cmocka_unit_test_setup_teardown(test_destroyed_at_any_moment, setup, teardown),
        cmocka_unit_test_setup_teardown(test_waits_end_in_time, setup, teardown),
        cmocka_unit_test_setup_teardown(test_a_stop_wakes_who_waits, setup, teardown),
        cmocka_unit_test_setup_teardown(test_a_failed_render_rests, setup, teardown),
        cmocka_unit_test_setup_teardown(test_films_while_it_runs, setup, teardown),
        cmocka_unit_test_setup_teardown(test_progress_never_falls, setup, teardown),
        cmocka_unit_test_setup_teardown(test_no_memory_for_a_thread, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
