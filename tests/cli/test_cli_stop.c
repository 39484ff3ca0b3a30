// Renders that are interrupted, snapshot, killed and resumed.

#include "command.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

// Endless for a test; the signals end it.
static const char endless[] = "render stage.usda -o x.exr --spp 1000000000 --progress alf";

static void remove_outputs(void)
{
    unlink("x.exr");
    unlink("x.exr.film");
}

static void assert_status(const char *status)
{
    FILE *file = fopen("x.exr", "rb");
    char header[8192] = {0}, expected[64];
    assert_non_null(file);
    size_t size = fread(header, 1, sizeof header, file);
    fclose(file);
    int n = snprintf(expected, sizeof expected, "cohort:renderStatus%cstring%c", 0, 0);
    for (size_t i = 0; i + 64 < size; i++)
        if (!memcmp(header + i, expected, (size_t)n)) {
            assert_memory_equal(header + i + n + 4, status, strlen(status));
            return;
        }
    fail_msg("the header has no status");
}

// Signals are caught from before the first line of progress on.
static pid_t start_endless(void)
{
    remove_outputs();
    pid_t pid = command_start(endless);
    assert_true(command_await_output());
    return pid;
}

static void interrupted(void **state)
{
    (void)state;
    static const int signals[] = {SIGINT, SIGTERM};
    for (int i = 0; i < 2; i++) {
        Ran ran;
        pid_t pid = start_endless();
        kill(pid, SIGUSR1);
        assert_true(command_await_file("x.exr"));
        kill(pid, signals[i]);
        command_wait(pid, &ran);
        assert_ran(&ran, 5, "--resume");
        assert_status("interrupted");
        assert_true(file_exists("x.exr.film"));
    }
}

// Who asks again, later, is not kept waiting: here by statistics that nobody reads.
static void asked_twice(void **state)
{
    (void)state;
    Ran ran;
    remove_outputs();
    assert_int_equal(mkfifo("stats.json", 0666), 0);
    pid_t pid = command_start("render stage.usda -o x.exr --spp 1 --stats stats.json");
    assert_true(command_await_file("x.exr"));
    kill(pid, SIGTERM);
    kill(pid, SIGTERM); // at once: the same wish
    sleep(3);
    assert_int_equal(kill(pid, 0), 0);
    kill(pid, SIGTERM);
    command_wait(pid, &ran);
    assert_int_equal(ran.code, 128 + SIGTERM);
    unlink("stats.json");
}

static void a_snapshot_goes_on(void **state)
{
    (void)state;
    Ran ran;
    pid_t pid = start_endless();
    kill(pid, SIGUSR1);
    assert_true(command_await_file("x.exr"));
    assert_status("snapshot");
    assert_true(file_exists("x.exr.film"));
    assert_int_equal(kill(pid, 0), 0);
    kill(pid, SIGINT);
    command_wait(pid, &ran);
    assert_int_equal(ran.code, 5);
}

static const char finite[] = "render stage.usda -q --spp 4096 --size 48x36 --progress alf";

static void assert_resumes_to(const char *whole)
{
    Ran ran;
    command_run(&ran, "%s -o x.exr --resume", finite);
    assert_ran(&ran, 0, "");
    assert_status("complete");
    assert_false(file_exists("x.exr.film"));
    command_run(&ran, "diff x.exr %s", whole);
    if (ran.code)
        fail_msg("%s", ran.out);
}

// The same pixels as if it had never stopped, whichever way it stopped.
static void resumed(void **state)
{
    (void)state;
    static const int signals[] = {SIGINT, SIGKILL};
    Ran ran;
    command_run(&ran, "%s -o whole.exr", finite);
    assert_int_equal(ran.code, 0);
    for (int i = 0; i < 2; i++) {
        remove_outputs();
        char arguments[256];
        snprintf(arguments, sizeof arguments, "%s -o x.exr", finite);
        pid_t pid = command_start(arguments);
        assert_true(command_await_output());
        kill(pid, SIGUSR1);
        assert_true(command_await_file("x.exr.film"));
        kill(pid, signals[i]);
        command_wait(pid, &ran);
        assert_int_equal(ran.code, signals[i] == SIGINT ? 5 : 128 + SIGKILL);
        assert_true(file_exists("x.exr.film"));
        assert_resumes_to("whole.exr");
    }
}

static void resume_refuses_another_picture(void **state)
{
    (void)state;
    static const struct {
        const char *arguments, *said;
    } others[] = {{"--size 32x24", "pixels"},
                  {"--seed 1", "seed"},
                  {"--camera side", "another stage"},
                  {"--aov depth", "other AOVs"},
                  {"--level 1", "without --resume the render begins anew"}};
    Ran ran;
    pid_t pid = start_endless();
    kill(pid, SIGUSR1);
    assert_true(command_await_file("x.exr"));
    kill(pid, SIGINT);
    command_wait(pid, &ran);
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        command_run(&ran, "%s --resume %s", endless, others[i].arguments);
        assert_ran(&ran, 2, others[i].said);
        assert_true(file_exists("x.exr.film"));
    }
    write_text("x.exr.film", "not a film");
    command_run(&ran, "%s --resume", endless);
    assert_ran(&ran, 3, "x.exr.film");
    remove_outputs();
}

// Killed between its last film and its picture, or asked for fewer samples than it has.
static void a_film_with_all_its_samples_becomes_a_picture(void **state)
{
    (void)state;
    Ran ran;
    command_run(&ran, "render stage.usda -q -o whole.exr --spp 1024");
    assert_int_equal(ran.code, 0);
    pid_t pid = start_endless();
    kill(pid, SIGUSR1);
    assert_true(command_await_file("x.exr"));
    kill(pid, SIGINT);
    command_wait(pid, &ran);
    assert_true(file_exists("x.exr.film"));
    command_run(&ran, "render stage.usda -q -o x.exr --spp 1 --resume");
    assert_ran(&ran, 0, "");
    assert_status("complete");
    command_run(&ran, "diff x.exr whole.exr --tolerance 0.05");
    assert_int_equal(ran.code, 0);
}

static void resume_without_a_film_begins(void **state)
{
    (void)state;
    Ran ran;
    remove_outputs();
    command_run(&ran, "render stage.usda -o x.exr --spp 1 --resume");
    assert_ran(&ran, 0, "there is no x.exr.film to resume: the render begins anew");
    assert_true(file_exists("x.exr"));
    command_run(&ran, "render stage.usda -q -o x.exr --spp 1 --resume");
    assert_string_equal(ran.err, "");
}

// A picture that cannot be written at the end leaves the film to go on from.
static void a_failed_write_keeps_the_film(void **state)
{
    (void)state;
    Ran ran;
    remove_outputs();
    pid_t pid = command_start(endless);
    assert_true(command_await_output());
    kill(pid, SIGUSR1);
    assert_true(command_await_file("x.exr"));
    assert_int_equal(unlink("x.exr"), 0);
    assert_int_equal(mkdir("x.exr", 0777), 0);
    kill(pid, SIGTERM);
    command_wait(pid, &ran);
    assert_ran(&ran, 4, "x.exr");
    assert_non_null(strstr(ran.err, "--resume"));
    assert_true(file_exists("x.exr.film"));
    assert_int_equal(rmdir("x.exr"), 0);
}

// A little text that takes long to compose: each prim refers to four of the one before.
static void write_tower(void)
{
    FILE *file = fopen("tower.usda", "w");
    assert_non_null(file);
    fprintf(file, "#usda 1.0\ndef \"L0\"\n{\n    def Cube \"c\"\n    {\n    }\n}\n");
    for (int level = 1; level <= 10; level++) {
        fprintf(file, "def \"L%d\"\n{\n", level);
        for (int i = 0; i < 4; i++)
            fprintf(file, "    def \"x%d\" (\n        references = </L%d>\n    )\n    {\n    }\n",
                    i, level - 1);
        fprintf(file, "}\n");
    }
    assert_int_equal(fclose(file), 0);
}

static void assert_ends_loading(const char *arguments)
{
    Ran ran;
    remove_outputs();
    pid_t pid = command_start(arguments);
    struct timespec begin, end, moment = {0, 300000000};
    nanosleep(&moment, NULL);
    clock_gettime(CLOCK_MONOTONIC, &begin);
    assert_int_equal(kill(pid, SIGINT), 0);
    command_wait(pid, &ran);
    clock_gettime(CLOCK_MONOTONIC, &end);
    assert_ran(&ran, 5, "nothing is written");
    assert_int_equal(line_count(ran.err), 1);
    assert_false(file_exists("x.exr"));
    assert_true(end.tv_sec - begin.tv_sec < 10); // one, on a machine with time
}

// Who is still loading stops, be it between two prims or in the hands of a library.
static void interrupted_while_loading(void **state)
{
    (void)state;
    write_tower();
    assert_ends_loading("render tower.usda -o x.exr --headlight --max-prims 100000000");
    assert_int_equal(mkfifo("pipe.ocio", 0666), 0); // that nobody writes into
    assert_ends_loading("render stage.usda -o x.exr --ocio pipe.ocio");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(interrupted),
        cmocka_unit_test(asked_twice),
        cmocka_unit_test(interrupted_while_loading),
        cmocka_unit_test(a_snapshot_goes_on),
        cmocka_unit_test(resumed),
        cmocka_unit_test(a_film_with_all_its_samples_becomes_a_picture),
        cmocka_unit_test(resume_refuses_another_picture),
        cmocka_unit_test(resume_without_a_film_begins),
        cmocka_unit_test(a_failed_write_keeps_the_film),
    };
    return cmocka_run_group_tests(tests, scratch_enter, scratch_leave);
}
