#include "names.h"

#include "cli.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

bool names_frame(const RenderRun *run, const char *pattern, size_t frame, char *path, size_t size,
                 CohortError *err)
{
    char why[512];
    if (frames_path(pattern, run->frames.count ? &run->frames : NULL, frame, path, size, why,
                    sizeof why))
        return true;
    return fail(err, COHORT_ERROR_ARGUMENT, "%s", why);
}

static bool is_same_node(const char *a, const char *b)
{
    struct stat x, y;
    return stat(a, &x) == 0 && stat(b, &y) == 0 && x.st_dev == y.st_dev && x.st_ino == y.st_ino;
}

static const char *file_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static const char *folder_of(const char *path, char *out, size_t size)
{
    int length = (int)(file_of(path) - path);
    snprintf(out, size, "%.*s", length > 1 ? length - 1 : length, path);
    return length ? out : ".";
}

// Whether two names lead to one entry of one folder, however they are written.
static bool is_same_entry(const char *a, const char *b)
{
    char x[4096], y[4096];
    return !strcmp(file_of(a), file_of(b)) &&
           (!strcmp(a, b) || is_same_node(folder_of(a, x, sizeof x), folder_of(b, y, sizeof y)));
}

bool names_check_writable(const char *path, CohortError *err)
{
    struct stat info;
    if (stat(path, &info) == 0 && S_ISDIR(info.st_mode))
        return fail(err, COHORT_ERROR_FILE_WRITE, "cannot write %.200s: it is a folder", path);
    // What stands behind a name for a while, as .film and .partial-PID, must fit as well.
    if (strlen(file_of(path)) > NAME_MAX - 20)
        return fail(err, COHORT_ERROR_FILE_WRITE, "cannot write %.60s...: the name is too long",
                    file_of(path));
    char buffer[4096];
    const char *folder = folder_of(path, buffer, sizeof buffer);
    if (access(folder, W_OK | X_OK) == 0)
        return true;
    return fail(err, COHORT_ERROR_FILE_WRITE, "cannot write into folder %.150s: %s", folder,
                strerror(errno));
}

// Statistics are written in place: into a device, too, or a file whose folder is locked.
static bool check_stats(const RenderRun *run, size_t frame, CohortError *err)
{
    char path[4096], output[4096], film[4200];
    const OptionList *outputs = &run->options.outputs;
    if (!names_frame(run, run->options.stats, frame, path, sizeof path, err))
        return false;
    if (is_same_node(path, run->stage_path))
        return fail(err, COHORT_ERROR_ARGUMENT, "--stats %.150s: that is the stage", path);
    for (size_t i = 0; i < outputs->count; i++) {
        if (!names_frame(run, outputs->items[i], frame, output, sizeof output, err))
            return false;
        snprintf(film, sizeof film, "%s.film", output);
        if (is_same_entry(path, output) || is_same_node(path, output) || is_same_entry(path, film))
            return fail(err, COHORT_ERROR_ARGUMENT,
                        "--stats %.150s: the render writes that file itself", path);
    }
    struct stat info;
    bool is_file = stat(path, &info) == 0 && !S_ISDIR(info.st_mode);
    return (is_file && access(path, W_OK) == 0) || names_check_writable(path, err);
}

static bool check_outputs(const RenderRun *run, size_t frame, CohortError *err)
{
    const OptionList *outputs = &run->options.outputs;
    for (size_t i = 0; i < outputs->count; i++) {
        char path[4000], other[4000]; // with room for what stands behind it for a while
        if (!names_frame(run, outputs->items[i], frame, path, sizeof path, err))
            return false;
        for (size_t k = 0; k < i; k++)
            if (!names_frame(run, outputs->items[k], frame, other, sizeof other, err))
                return false;
            else if (is_same_entry(path, other))
                return fail(err, COHORT_ERROR_ARGUMENT, "%.150s: the output is named twice", path);
        if (is_same_node(path, run->stage_path))
            return fail(err, COHORT_ERROR_ARGUMENT, "-o %.150s: that is the stage", path);
        if (!names_check_writable(path, err))
            return false;
    }
    return true;
}

bool names_check(const RenderRun *run, CohortError *err)
{
    const RenderOptions *o = &run->options;
    for (size_t i = 0; i < o->outputs.count; i++)
        if (!output_is_supported(o->outputs.items[i]))
            return fail(err, COHORT_ERROR_ARGUMENT, "-o \"%.150s\": outputs end in .exr or .png",
                        o->outputs.items[i]);
    for (size_t frame = 0; frame == 0 || frame < run->frames.count; frame++)
        if (!check_outputs(run, frame, err) || (o->stats && !check_stats(run, frame, err)))
            return false;
    return true;
}
