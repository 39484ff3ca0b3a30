#define _GNU_SOURCE // fallocate, which writes nothing where it is not known
#include "texture/converted.h"

#include "base/error.h"
#include "base/hash.h"
#include "base/mapped_file.h"
#include "base/memory.h"
#include "base/parallel.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdatomic.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <time.h>
#include <unistd.h>

#define FORMAT_VERSION 1 // raised when converted files change

char *co_path_copy(const char *path)
{
    size_t size = strlen(path) + 1;
    char *copy = co_alloc(CO_MEMORY_TEXTURE, size);
    if (copy)
        memcpy(copy, path, size);
    return copy;
}

void co_path_free(char *path)
{
    if (path)
        co_free(CO_MEMORY_TEXTURE, path, strlen(path) + 1);
}

// x^(1/5) for x in (0, 2): Newton's iteration on exact double arithmetic, so that no libm and no
// instruction set decides a bit. From above it falls monotonically; for x above 0.06, which is all
// that the curve asks for, 10 steps reach double precision.
static double fifth_root(double x)
{
    double root = x < 1 ? 1 : x;
    for (int i = 0; i < 10; i++) {
        double square = root * root;
        root -= (root - x / (square * square)) / 5;
    }
    return root;
}

float co_srgb_decode(float encoded)
{
    double x = fabs((double)encoded), linear;
    if (x <= 0.04045) {
        linear = x / 12.92;
    } else {
        // Beyond 2 the root's argument is scaled by a power of 32, whose fifth root is exact.
        double base = (x + 0.055) / 1.055, scale = 1, rest = base;
        while (rest > 2) {
            rest /= 32;
            scale *= 2;
        }
        double root = fifth_root(rest) * scale;
        linear = base * base * root * root; // base^2.4
    }
    return (float)copysign(linear, (double)encoded);
}

static bool convert_rgba(const CoTextureColor *color, float *rgba, size_t count, CohortError *err)
{
    const CoTexturesOptions *options = color->options;
    if (options->to_rendering)
        return options->to_rendering(options->cookie, color->space, rgba, count, err);
    CO_CHECK(strcmp(color->space, "sRGB") == 0, err, COHORT_ERROR_COLOR,
             "no color config is in use, so color space %s is not known", color->space);
    for (size_t i = 0; i < count; i++)
        for (size_t c = 0; c < 3; c++)
            rgba[4 * i + c] = co_srgb_decode(rgba[4 * i + c]);
    return true;
}

typedef struct Linearizing {
    const CoTextureColor *color;
    float *pixels;
    uint32_t channels;
    atomic_bool has_failed;
    CohortError err; // of the block that failed first
} Linearizing;

#define BLOCK 256 // pixels converted at a time

static void linearize(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    Linearizing *work = context;
    uint32_t channels = work->channels, colors = channels < 3 ? 1 : 3;
    float rgba[4 * BLOCK];
    for (size_t first = begin; first < end; first += BLOCK) {
        size_t n = end - first < BLOCK ? end - first : BLOCK;
        float *part = work->pixels + first * channels;
        for (size_t i = 0; i < n; i++) {
            for (uint32_t c = 0; c < 3; c++)
                rgba[4 * i + c] = part[i * channels + (c < colors ? c : 0)];
            rgba[4 * i + 3] = 1;
        }
        CohortError err = {0};
        if (!convert_rgba(work->color, rgba, n, &err)) {
            if (!atomic_exchange(&work->has_failed, true))
                work->err = err;
            return;
        }
        for (size_t i = 0; i < n; i++)
            for (uint32_t c = 0; c < colors; c++)
                part[i * channels + c] = isfinite(rgba[4 * i + c]) ? rgba[4 * i + c] : 0;
    }
}

CoTextureColor co_texture_named(const CoTexturesOptions *options, const char *space)
{
    return (CoTextureColor){
        .space = space, .is_raw = strcmp(space, "raw") == 0, .options = options};
}

bool co_texture_ruled(const CoTexturesOptions *options, const char *path, CoTextureColor *out)
{
    const char *space = NULL;
    if (options->space_of_file)
        space = options->space_of_file(options->cookie, path);
    if (space)
        *out = co_texture_named(options, space);
    return space != NULL;
}

CoTextureColor co_texture_color(const CoTexturesOptions *options, const CohortTextureDesc *desc,
                                bool auto_is_raw)
{
    CoTextureColor color = {.space = "sRGB", .options = options};
    switch (desc->color_space) {
    case COHORT_COLOR_RAW:
        color.is_raw = true;
        break;
    case COHORT_COLOR_SRGB:
        break;
    case COHORT_COLOR_NAMED:
        color = co_texture_named(options, desc->color_space_name ? desc->color_space_name : "");
        break;
    case COHORT_COLOR_AUTO:
        color.is_raw = auto_is_raw;
        break;
    }
    return color;
}

bool co_texture_to_linear(const CoTextureColor *color, float *pixels, size_t count,
                          uint32_t channels, CohortError *err)
{
    for (size_t i = 0; i < count * channels; i++)
        pixels[i] = isfinite(pixels[i]) ? pixels[i] : 0;
    if (color->is_raw)
        return true;
    Linearizing work = {.color = color, .pixels = pixels, .channels = channels};
    co_parallel_for(count, 64 * BLOCK, linearize, &work);
    if (!atomic_load(&work.has_failed))
        return true;
    if (err && err->code == COHORT_OK)
        *err = work.err;
    return false;
}

// What a conversion does to colors is known by doing it: names say little.
static bool hash_conversion(const CoTextureColor *color, uint64_t *hash, CohortError *err)
{
    float probes[] = {0, 0, 0, 1, 1,    1,   .18f, .18f, .18f, 1,   0, 0, 0, 1,
                      0, 0, 0, 1, .02f, .3f, .7f,  .9f,  .5f,  .1f, 4, 2, 8};
    if (!co_texture_to_linear(color, probes, sizeof probes / sizeof *probes / 3, 3, err))
        return false;
    *hash = co_hash_bytes(probes, sizeof probes, color->is_raw);
    return true;
}

static bool make_folder(char *path, CohortError *err)
{
    for (char *at = strchr(path + 1, '/');; at = strchr(at + 1, '/')) {
        if (at)
            *at = 0;
        int cause = mkdir(path, 0777) ? errno : 0;
        struct stat info;
        if (cause && (stat(path, &info) || !S_ISDIR(info.st_mode)))
            return CO_FAIL(err, COHORT_ERROR_FILE_WRITE,
                           "cannot make folder %s for converted textures: %s; name another one "
                           "with --converted",
                           path, strerror(cause));
        if (!at)
            return true;
        *at = '/';
    }
}

static bool print_folder(const CoTexturesOptions *options, char *out, size_t size)
{
    const char *folder = options->converted_folder, *cache = getenv("XDG_CACHE_HOME");
    const char *home = getenv("HOME"), *temporary = getenv("TMPDIR");
    int length;
    if (folder && folder[0])
        length = snprintf(out, size, "%s", folder);
    else if (cache && cache[0] == '/')
        length = snprintf(out, size, "%s/cohort", cache);
    else if (home && home[0] == '/')
        length = snprintf(out, size, "%s/.cache/cohort", home);
    else
        length = snprintf(out, size, "%s/cohort-%ld",
                          temporary && temporary[0] ? temporary : "/tmp", (long)getuid());
    return length > 0 && (size_t)length < size;
}

bool co_converted_path(const CoTextureColor *color, const char *source, uint64_t settings,
                       const char *extension, char **out, CohortError *err)
{
    CoMappedFile bytes;
    uint64_t conversion;
    if (!hash_conversion(color, &conversion, err) || !co_mapped_file_open(source, &bytes, err))
        return false;
    settings = co_hash_combine(co_hash_combine(FORMAT_VERSION, settings), conversion);
    uint64_t high = co_hash_bytes(bytes.data, bytes.size, settings);
    uint64_t low = co_hash_bytes(bytes.data, bytes.size, ~high);
    co_mapped_file_close(&bytes);
    char folder[3900], path[4096];
    CO_CHECK(print_folder(color->options, folder, sizeof folder), err, COHORT_ERROR_LIMIT,
             "the path of the folder for converted textures is too long");
    if (!make_folder(folder, err))
        return false;
    snprintf(path, sizeof path, "%s/%016llx%016llx%s", folder, (unsigned long long)high,
             (unsigned long long)low, extension);
    *out = co_path_copy(path);
    CO_CHECK_MEMORY(*out, err);
    return true;
}

// Whether the file system gives so many bytes when asked for them: quotas are told no other way.
static bool can_allocate(const char *folder, size_t bytes)
{
    char name[4200];
    snprintf(name, sizeof name, "%s/room-XXXXXX", folder);
    int file = mkstemp(name);
    if (file < 0)
        return true; // for other reasons, which writing will name
    unlink(name);
    int cause = fallocate(file, 0, 0, (off_t)bytes) ? errno : 0;
    close(file);
    return cause != ENOSPC && cause != EDQUOT && cause != EFBIG;
}

bool co_converted_room(const char *path, size_t bytes, CohortError *err)
{
    char folder[4096];
    snprintf(folder, sizeof folder, "%.*s", (int)(strrchr(path, '/') - path), path);
    struct statvfs disk;
    struct rlimit limit;
    bool fits = getrlimit(RLIMIT_FSIZE, &limit) || limit.rlim_cur >= bytes;
    // A file system that says it has no blocks does not say how many are free.
    if (fits && statvfs(folder, &disk) == 0 && disk.f_blocks > 0 && disk.f_frsize > 0)
        fits = disk.f_bavail >= bytes / disk.f_frsize + 1;
    fits = fits && can_allocate(folder, bytes);
    CO_CHECK(fits, err, COHORT_ERROR_FILE_WRITE,
             "its converted form may need %zu MB in %s, more than there is; name another folder "
             "with --converted",
             bytes / 1000000 + 1, folder);
    return true;
}

#define STALE_SECONDS 3600 // since it was last written to

// Removes what processes that were killed have left: files of ours that are written no more. A name
// is HASH-PID-NANOSECONDS and an extension; OpenImageIO puts one of its own before that.
static void sweep(const char *path)
{
    char folder[4096], name[4400];
    snprintf(folder, sizeof folder, "%.*s", (int)(strrchr(path, '/') - path), path);
    DIR *files = opendir(folder);
    time_t now = time(NULL);
    for (struct dirent *e = files ? readdir(files) : NULL; e; e = readdir(files)) {
        struct stat info;
        if (strspn(e->d_name, "0123456789abcdef") != 32 || e->d_name[32] != '-')
            continue;
        snprintf(name, sizeof name, "%s/%s", folder, e->d_name);
        if (stat(name, &info) == 0 && now - info.st_mtime > STALE_SECONDS)
            unlink(name);
    }
    if (files)
        closedir(files);
}

// By making it, which alone knows of rights, quotas and file systems that are read alone.
static bool check_creation(const char *name, CohortError *err)
{
    int file = open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    CO_CHECK(file >= 0, err, COHORT_ERROR_FILE_WRITE,
             "cannot write into folder %.*s for converted textures: %s; name another one with "
             "--converted",
             (int)(strrchr(name, '/') - name), name, strerror(errno));
    close(file);
    unlink(name);
    return true;
}

bool co_converted_temporary(const char *path, char **out, CohortError *err)
{
    sweep(path);
    char name[4200];
    const char *extension = strrchr(path, '.'); // kept: writers choose their format by it
    struct timespec now; // folders are shared between machines, and a process may have two scenes
    clock_gettime(CLOCK_REALTIME, &now);
    int length = snprintf(name, sizeof name, "%.*s-%ld-%09ld%s", (int)(extension - path), path,
                          (long)getpid(), now.tv_nsec, extension);
    CO_CHECK(length > 0 && (size_t)length < sizeof name, err, COHORT_ERROR_LIMIT,
             "path too long: %s", path);
    if (!check_creation(name, err))
        return false;
    *out = co_path_copy(name);
    CO_CHECK_MEMORY(*out, err);
    return true;
}

bool co_converted_publish(const char *temporary, const char *path, CohortError *err)
{
    if (rename(temporary, path) == 0)
        return true;
    int cause = errno;
    unlink(temporary);
    return CO_FAIL(err, COHORT_ERROR_FILE_WRITE, "cannot write %s: %s", path, strerror(cause));
}
