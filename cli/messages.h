// What the user is told about the input: each thing once, on one line.

#ifndef COHORT_CLI_MESSAGES_H
#define COHORT_CLI_MESSAGES_H

#include "cohort/delegate.h"

enum {
    MESSAGES_SAID = 256
};

// The words of a warning, by their hash, and how often they were printed.
typedef struct MessagesSaid {
    uint64_t hash;
    uint32_t times;
} MessagesSaid;

// The loader reports a layer it cannot read as an error, and then what becomes of it: a failure or
// a warning in the same words. The error is held back until that is known. Of several errors the
// first is also what the failure says.
//
// Warnings in the same words are printed a few times: thousands of prims may name one file. The
// others are counted.
typedef struct Messages {
    CohortError held, first; // first: that was printed
    bool is_quiet;           // errors only
    bool is_verbose;         // all warnings
    MessagesSaid said[MESSAGES_SAID];
    size_t unsaid; // warnings that were not printed
} Messages;

// A CohortStageOptions.report; the cookie is the Messages.
void messages_report(void *cookie, CohortSeverity severity, const char *file, uint32_t line,
                     uint32_t column, const char *prim_path, const char *text);

// Prints what is still held back, how many warnings were not printed, and the failure that ended
// the command, if any.
void messages_end(Messages *messages, const CohortError *err);

// Prints what was not honored, equal things of many prims on one line, and the renderer's warnings.
// A file that cannot be read is one line; verbose, one of each prim that names it.
void messages_not_honored(CohortDelegate *delegate, const CohortRenderIndex *index,
                          bool is_verbose);

#endif
