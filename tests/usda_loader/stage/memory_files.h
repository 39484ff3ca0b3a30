// Layers from memory: what a stage opens, without a file system.

#ifndef TEST_MEMORY_FILES_H
#define TEST_MEMORY_FILES_H

#include "usda_loader/stage/usda_stage_fixture.h"

typedef struct MemoryFile {
    const char *path, *text;
} MemoryFile;

typedef struct MemoryFiles {
    const MemoryFile *items;
    size_t count;
    int opened, released;
} MemoryFiles;

static inline bool memory_open(void *cookie, const char *path, CohortBytes *out)
{
    MemoryFiles *files = cookie;
    for (size_t i = 0; i < files->count; i++) {
        if (strcmp(files->items[i].path, path) != 0)
            continue;
        if (out) {
            *out = (CohortBytes){files->items[i].text, strlen(files->items[i].text), NULL};
            files->opened++;
        }
        return true;
    }
    return false;
}

static inline void memory_release(void *cookie, const CohortBytes *bytes)
{
    assert_non_null(bytes->data);
    ((MemoryFiles *)cookie)->released++;
}

// Opens the first file; `options` may be NULL.
static inline CohortStage *memory_stage(MemoryFiles *files, const CohortStageOptions *options,
                                        Reports *reports)
{
    CohortStageOptions all = options ? *options : (CohortStageOptions){0};
    all.open = memory_open;
    all.release = memory_release;
    all.open_cookie = files;
    all.threads = 1;
    all.report = test_report;
    all.cookie = reports;
    CohortError err = {0};
    CohortStage *stage = cohort_stage_open(files->items[0].path, &all, &err);
    if (!stage)
        print_error("%s\n", err.message);
    return stage;
}

#define FILES(list) ((MemoryFiles){.items = list, .count = sizeof list / sizeof *list})

#endif
