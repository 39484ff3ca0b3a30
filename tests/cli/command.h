// Runs the built command in a scratch folder and keeps what it says.

#ifndef COHORT_TESTS_COMMAND_H
#define COHORT_TESTS_COMMAND_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include <cmocka.h>

typedef struct Ran {
    int code; // exit code; 128 + number when a signal ended it
    char out[16384], err[16384];
} Ran;

// Group fixtures: a fresh folder that becomes the working directory, with a small stage in it
// (stage.usda: a lit sphere, camera /World/cam, 24 x 18 pixels, frames 1 to 4), and its removal.
int scratch_enter(void **state);
int scratch_leave(void **state);

// Runs "cohort <arguments>", which are separated by single spaces.
void command_run(Ran *ran, const char *format, ...) __attribute__((format(printf, 2, 3)));

// The same with files limited to so many bytes.
void command_run_limited(Ran *ran, size_t file_bytes, const char *arguments);

// The same in the background; wait ends it and reads what it said.
pid_t command_start(const char *arguments);
void command_wait(pid_t pid, Ran *ran);

// Waits until standard output of the command in the background says something, or a file exists.
bool command_await_output(void);
bool command_await_file(const char *path);

void write_text(const char *path, const char *text);
bool file_exists(const char *path);

// Lines of a text.
int line_count(const char *text);

// Asserts the exit code and that standard error contains a text; shows what was said if not.
void assert_ran(const Ran *ran, int code, const char *said);

#endif
