// Pause, stop, resume and restart, one after another and by several threads at once.

#include "pass_fixture.h"

#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

enum {
    MEDDLER_TURNS = 600
};

static void rest(long milliseconds)
{
    struct timespec pause = {.tv_nsec = milliseconds * 1000000L};
    nanosleep(&pause, NULL);
}

static void test_pause_keeps_complete_rounds(void **state)
{
    (void)state;
    fake.round_nanoseconds = 5000000;
    fake.rounds_to_do = 100; // not done by the time a busy machine comes to pause
    execute_pass();
    rest(20);
    assert_true(cohort_delegate_pause(delegate));
    int64_t done = stat_of("numCompletedSamples").value.integer;
    double percent = stat_of("percentDone").value.number;
    rest(20);
    assert_int_equal(stat_of("numCompletedSamples").value.integer, done);
    assert_false(cohort_render_pass_is_converged(pass));
    assert_string_equal(stat_of("renderProgressAnnotation").value.string, "stopped");
    execute_pass(); // does not start it
    rest(10);
    assert_int_equal(stat_of("numCompletedSamples").value.integer, done);
    assert_true(cohort_delegate_resume(delegate));
    assert_true(stat_of("percentDone").value.number >= percent);
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_int_equal(fake.renders_made, 1);
    assert_int_equal(stat_of("numCompletedSamples").value.integer, 100);
}

static void test_stop_is_quick_and_restart_starts_over(void **state)
{
    (void)state;
    fake.round_nanoseconds = 900000000;
    execute_pass();
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
    execute_pass();
    for (int i = 0; i < 40; i++) {
        cohort_delegate_stop(delegate, i % 2 == 0);
        assert_true(cohort_delegate_resume(delegate));
        rest(i % 3);
    }
    assert_true(cohort_render_pass_wait(pass, 10.0));
    assert_int_equal(stat_of("numCompletedSamples").value.integer, 30);
}

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
    execute_pass();
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
    execute_pass();
    meddle(restart_often);
    assert_int_equal(fake.renders_live, 1);
    assert_int_equal(fake.rounds_of_the_dead, 0);
    finish();
}

static void test_errors_of_the_thread_are_kept(void **state)
{
    (void)state;
    fake.fail_round = true;
    execute_pass();
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_pause_keeps_complete_rounds, setup_pass,
                                        teardown_pass),
        cmocka_unit_test_setup_teardown(test_stop_is_quick_and_restart_starts_over, setup_pass,
                                        teardown_pass),
        cmocka_unit_test_setup_teardown(test_many_stops_and_resumes, setup_pass, teardown_pass),
        cmocka_unit_test_setup_teardown(test_threads_stop_and_resume, setup_pass, teardown_pass),
        cmocka_unit_test_setup_teardown(test_threads_stop_and_resume_what_restarts, setup_pass,
                                        teardown_pass),
        cmocka_unit_test_setup_teardown(test_errors_of_the_thread_are_kept, setup_pass,
                                        teardown_pass),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
