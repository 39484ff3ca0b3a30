// Every file again with bytes flipped, cut short, and with each allocation failing: each time a
// layer or a clear error, a stage or a clear error, and nothing left behind.
//
// usage: sweep EVERY VARIANTS FOLDER...: each EVERY-th file below the folders, and of each as many
// cuts and flips. ctest runs a short form; by hand, 1 and 64 or more over the whole corpus.

#include "base/memory.h"
#include "cohort/usda.h"
#include "parse/layer.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

enum {
    FILE_MAX = 1 << 20, // bytes; larger files are left out
    WORK_MAX = 1 << 23, // bytes parsed for cuts and flips of one file
    PRIMS_MAX = 20000
};

typedef struct Sweep {
    size_t every, variants, met;
    size_t files, tries, accepted, failed_allocations, faults;
    const char *path;
    double slowest; // seconds of one try
    char slowest_path[512];
    // What stands in for the file at `path`.
    const char *bytes;
    size_t size;
} Sweep;

static void fault(Sweep *s, const char *what)
{
    fprintf(stderr, "%s: %s\n", s->path, what);
    s->faults++;
}

static bool open_changed(void *cookie, const char *path, CohortBytes *out)
{
    const Sweep *s = cookie;
    if (strcmp(path, s->path) != 0)
        return false;
    if (out)
        *out = (CohortBytes){.data = s->bytes, .size = s->size};
    return true;
}

static void visit(const CohortPrim *prim)
{
    double m[4][4];
    bool resets;
    cohort_prim_local_transform(prim, 1, m, &resets);
    for (size_t i = 0; i < cohort_prim_property_count(prim); i++) {
        const char *name = cohort_prim_property_name(prim, i), *const * paths;
        const CohortAsset *assets;
        CohortValue value;
        if (!name)
            continue; // memory was at an end
        cohort_prim_value(prim, name, 1.5, &value);
        cohort_prim_targets(prim, name, &paths);
        cohort_prim_assets(prim, name, 1, &assets);
    }
    for (size_t i = 0; i < cohort_prim_child_count(prim); i++)
        visit(cohort_prim_child(prim, i));
}

static bool try_layer(Sweep *s, CohortError *err)
{
    CoLayer *layer = co_layer_parse(s->path, s->bytes, s->size, NULL, NULL, NULL, err);
    bool is_read = layer != NULL;
    co_layer_destroy(layer);
    return is_read;
}

static bool try_stage(Sweep *s, CohortError *err)
{
    const CohortStageOptions options = {
        .max_prims = PRIMS_MAX, .threads = 1, .open = open_changed, .open_cookie = s};
    CohortStage *stage = cohort_stage_open(s->path, &options, err);
    bool is_open = stage != NULL;
    if (stage)
        visit(cohort_stage_root(stage));
    cohort_stage_destroy(stage);
    return is_open;
}

typedef bool TryFn(Sweep *s, CohortError *err);

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static bool try_once(Sweep *s, TryFn *fn, CohortErrorCode only)
{
    CohortError err = {0};
    double start = now();
    bool is_good = fn(s, &err);
    double seconds = now() - start;
    if (seconds > s->slowest) {
        s->slowest = seconds;
        snprintf(s->slowest_path, sizeof s->slowest_path, "%s", s->path);
    }
    s->tries++;
    s->accepted += is_good;
    if (is_good != (err.code == COHORT_OK) || (!is_good && !err.message[0]))
        fault(s, "failed without an error, or the other way round");
    if (!is_good && only && err.code != only)
        fault(s, err.message);
    return is_good;
}

// Interned text stays for the life of the process: so the second time nothing may stay.
static void try_twice(Sweep *s, TryFn *fn)
{
    bool first = try_once(s, fn, COHORT_OK);
    size_t live = co_memory_live(CO_MEMORY_USDA);
    if (try_once(s, fn, COHORT_OK) != first)
        fault(s, "two answers to one question");
    if (co_memory_live(CO_MEMORY_USDA) != live)
        fault(s, "memory was left behind");
}

static void fail_allocations(Sweep *s, TryFn *fn)
{
    if (!try_once(s, fn, COHORT_OK))
        return;
    size_t live = co_memory_live(CO_MEMORY_USDA);
    for (uint64_t n = 1;; n++) {
        co_memory_fail_after(n);
        bool is_good = try_once(s, fn, COHORT_ERROR_OUT_OF_MEMORY);
        co_memory_fail_after(0);
        s->failed_allocations++;
        if (co_memory_live(CO_MEMORY_USDA) != live)
            fault(s, "memory was left behind by a failing allocation");
        if (is_good || s->faults > 100)
            return;
        n += n / 16; // long runs of like steps are sampled
    }
}

// The bytes in a block of their own size, so that a sanitizer sees what is read past them.
static void try_bytes(Sweep *s, const char *bytes, size_t size)
{
    char *copy = malloc(size ? size : 1);
    if (!copy)
        abort();
    memcpy(copy, bytes, size);
    s->bytes = copy;
    s->size = size;
    try_twice(s, try_layer);
    try_twice(s, try_stage);
    free(copy);
}

static void sweep_bytes(Sweep *s, char *bytes, size_t size)
{
    uint64_t state = size + 1;
    size_t variants = s->variants;
    while (variants > 2 && variants * size > WORK_MAX)
        variants /= 2;
    s->bytes = bytes;
    s->size = size;
    fail_allocations(s, try_layer);
    fail_allocations(s, try_stage);
    for (size_t i = 0; i < variants && size; i++) {
        try_bytes(s, bytes, size * i / variants);
        state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
        size_t at = (size_t)(state >> 33) % size;
        char flip = (char)(1u << (state >> 30 & 7));
        bytes[at] = (char)(bytes[at] ^ flip);
        try_bytes(s, bytes, size);
        bytes[at] = (char)(bytes[at] ^ flip);
    }
}

static void sweep_file(Sweep *s, const char *path)
{
    char *resolved = realpath(path, NULL);
    FILE *file = resolved ? fopen(resolved, "rb") : NULL;
    char *bytes = malloc(FILE_MAX + 1);
    size_t size = file && bytes ? fread(bytes, 1, FILE_MAX + 1, file) : FILE_MAX + 1;
    if (size <= FILE_MAX) {
        s->path = resolved;
        s->files++;
        sweep_bytes(s, bytes, size);
    }
    if (file)
        fclose(file);
    free(bytes);
    free(resolved);
}

static bool is_layer(const char *name)
{
    const char *dot = strrchr(name, '.');
    return dot && (!strcmp(dot, ".usda") || !strcmp(dot, ".usd"));
}

static int compare_names(const struct dirent **a, const struct dirent **b)
{
    return strcmp((*a)->d_name, (*b)->d_name);
}

static void sweep_folder(Sweep *s, const char *folder)
{
    struct dirent **entries;
    int count = scandir(folder, &entries, NULL, compare_names);
    for (int i = 0; i < count; i++) {
        char path[4096];
        struct stat info;
        const char *name = entries[i]->d_name;
        bool fits = snprintf(path, sizeof path, "%s/%s", folder, name) < (int)sizeof path;
        if (fits && name[0] != '.' && stat(path, &info) == 0) {
            if (S_ISDIR(info.st_mode))
                sweep_folder(s, path);
            else if (is_layer(name) && s->met++ % s->every == 0)
                sweep_file(s, path);
        }
        free(entries[i]);
    }
    if (count >= 0)
        free(entries);
}

int main(int argc, char **argv)
{
    Sweep s = {.every = argc > 2 ? strtoul(argv[1], NULL, 10) : 0,
               .variants = argc > 2 ? strtoul(argv[2], NULL, 10) : 0};
    if (!s.every || argc < 4) {
        fprintf(stderr, "usage: sweep EVERY VARIANTS FOLDER...\n");
        return 2;
    }
    for (int i = 3; i < argc; i++)
        sweep_folder(&s, argv[i]);
    printf("%zu files, %zu tries: %zu accepted, %zu with a failing allocation, %zu faults\n",
           s.files, s.tries, s.accepted, s.failed_allocations, s.faults);
    printf("slowest try %.3f s: %s\n", s.slowest, s.slowest_path);
    return s.faults || !s.files;
}
