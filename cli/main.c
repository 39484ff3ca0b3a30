// cohort: from the first word to the sub-command.

#include "cli.h"
#include "source_line.h"
#include "stage_options.h"

#include "cohort/delegate.h"
#include "cohort/image.h"

#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const Command commands[] = {
    {"render", "render a USD stage to EXR and PNG", command_render},
    {"cat", "print a layer, or the composed stage, as USDA", command_cat},
    {"tree", "print the prims of a stage and where they come from", command_tree},
    {"check", "say what is broken in a stage, for people or CI", command_check},
    {"diff", "compare two EXR images", command_diff},
};
enum {
    COMMAND_COUNT = sizeof commands / sizeof commands[0]
};

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

static int print_help(void)
{
    printf("cohort: a path tracer for USD stages\n\n");
    for (int i = 0; i < COMMAND_COUNT; i++)
        printf("  cohort %-8s %s\n", commands[i].name, commands[i].summary);
    printf("\nEach has --help. cohort --version says what it was built with.\n");
    return EXIT_WRITTEN;
}

static int print_version(void)
{
    CohortLibraryVersions v;
    cohort_library_versions(&v);
    printf("cohort %s\n", cohort_version());
    printf("instruction set %s\n", v.isa);
    printf("OpenSubdiv %s, OpenImageIO %s, OpenColorIO %s, OpenEXR %s\n", v.opensubdiv,
           v.openimageio, v.opencolorio, v.openexr);
    return EXIT_WRITTEN;
}

// Files opened later must not take the place of a standard stream that is closed, and be written
// into: what stands there instead fails as the closed one would.
static void fill_standard_streams(void)
{
    for (int fd = 0; fd <= STDERR_FILENO; fd++)
        if (fcntl(fd, F_GETFD) < 0)
            (void)!open("/dev/null", fd == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

static int run(int argc, char **argv)
{
    if (argc < 2) {
        print_help();
        return EXIT_USAGE;
    }
    if (!strcmp(argv[1], "--help") || !strcmp(argv[1], "-h") || !strcmp(argv[1], "help"))
        return print_help();
    if (!strcmp(argv[1], "--version"))
        return print_version();
    for (int i = 0; i < COMMAND_COUNT; i++)
        if (!strcmp(argv[1], commands[i].name))
            return commands[i].run(argc - 1, argv + 1);
    fprintf(stderr, "cohort: there is no command \"%s\"; see cohort --help\n", argv[1]);
    return EXIT_USAGE;
}

int main(int argc, char **argv)
{
    fill_standard_streams();
    int code = run(argc, argv);
    if (fflush(stdout) == 0 && !ferror(stdout))
        return code;
    if (code == EXIT_WRITTEN) {
        fprintf(stderr, "cohort: error: not all of standard output could be written\n");
        code = EXIT_WRITE;
    }
    return code;
}
