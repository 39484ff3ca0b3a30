// How commands say that something went wrong.

#include "cli.h"
#include "source_line.h"
#include "stage_options.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

// "cannot open FILE: No such file or directory"
static bool names_file(const char *message, const char *file)
{
    const char *at = strstr(message, file);
    return at && at > message && at[-1] == ' ' && at[strlen(file)] == ':';
}

void print_failure(const char *severity, const CohortError *err)
{
    char text[2 * sizeof err->message];
    bool has_place = err->line || (err->file[0] && !names_file(err->message, err->file));
    fprintf(stderr, "cohort: ");
    if (has_place && err->file[0])
        fprintf(stderr, "%s:", err->file);
    if (err->line)
        fprintf(stderr, "%u:", err->line);
    if (err->line && err->column)
        fprintf(stderr, "%u:", err->column);
    if (has_place)
        fprintf(stderr, " ");
    if (err->prim_path[0])
        fprintf(stderr, "<%s>: ", err->prim_path);
    fprintf(stderr, "%s: %s\n", severity, stage_options_in_flags(err->message, text, sizeof text));
    source_line_print(stderr, err->file, err->line, err->column);
}

int usage_error(const char *command, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    fprintf(stderr, "cohort %s: ", command);
    vfprintf(stderr, format, args);
    fprintf(stderr, "; see cohort %s --help\n", command);
    va_end(args);
    return EXIT_USAGE;
}

bool fail(CohortError *err, CohortErrorCode code, const char *format, ...)
{
    if (err->code != COHORT_OK)
        return false;
    err->code = code;
    va_list args;
    va_start(args, format);
    vsnprintf(err->message, sizeof err->message, format, args);
    va_end(args);
    return false;
}
