// cohort: from the first word to the sub-command.

#include "cli.h"

#include "cohort/delegate.h"
#include "cohort/image.h"

#include <fcntl.h>
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
