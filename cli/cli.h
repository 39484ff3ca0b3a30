// The cohort command: what its sub-commands share.

#ifndef COHORT_CLI_H
#define COHORT_CLI_H

#include "cohort/base.h"

// Exit codes, documented in --help.
enum {
    EXIT_WRITTEN = 0,
    EXIT_DIFFERENT = 1, // cohort diff; cohort check: something was found
    EXIT_USAGE = 2,
    EXIT_LOAD = 3,
    EXIT_WRITE = 4,
    EXIT_INTERRUPTED = 5
};

typedef struct Command {
    const char *name, *summary;
    int (*run)(int argc, char **argv); // argv[0] is the sub-command
} Command;

int command_render(int argc, char **argv);
int command_cat(int argc, char **argv);
int command_tree(int argc, char **argv);
int command_check(int argc, char **argv);
int command_diff(int argc, char **argv);

// Prints one line: "cohort: file:line:column: error: message".
void print_failure(const char *severity, const CohortError *err);

// Prints a usage error with a pointer to --help and returns EXIT_USAGE.
int usage_error(const char *command, const char *format, ...) __attribute__((format(printf, 2, 3)));

// Fills in an error that has none yet; returns false.
bool fail(CohortError *err, CohortErrorCode code, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
