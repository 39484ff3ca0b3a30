// Any bytes as the root layer of a stage: composed, asked for everything, and flattened.

#include "fuzz.h"

#include "cohort/usda.h"

#include <math.h>
#include <stdlib.h>
#include <unistd.h>

static void ask(const CohortPrim *prim, unsigned *budget)
{
    double matrix[4][4];
    bool resets;
    if (!*budget)
        return;
    --*budget;
    cohort_prim_local_transform(prim, 1, matrix, &resets);
    for (size_t i = 0; i < cohort_prim_property_count(prim); i++) {
        const char *name = cohort_prim_property_name(prim, i);
        CohortValue value;
        const double *times;
        const char *const *targets;
        const CohortAsset *assets;
        cohort_prim_value(prim, name, COHORT_TIME_DEFAULT, &value);
        cohort_prim_value(prim, name, 2.5, &value);
        cohort_prim_time_samples(prim, name, &times);
        cohort_prim_targets(prim, name, &targets);
        cohort_prim_connections(prim, name, &targets);
        cohort_prim_assets(prim, name, 1, &assets);
    }
    for (size_t i = 0; i < cohort_prim_child_count(prim); i++)
        ask(cohort_prim_child(prim, i), budget);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char path[] = "/tmp/cohort-fuzz-XXXXXX.usda";
    int fd = mkstemps(path, 5);
    fuzz_require(fd >= 0 && write(fd, data, size) == (ssize_t)size);
    close(fd);
    const CohortStageOptions options = {.max_bytes = 1 << 20,
                                        .max_depth = 64,
                                        .max_prims = 5000,
                                        .max_layers = 8,
                                        .max_array_length = 1 << 16};
    CohortError err = {0};
    CohortStage *stage = cohort_stage_open(path, &options, &err);
    fuzz_require(stage || err.code != COHORT_OK);
    if (stage) {
        unsigned budget = 5000;
        ask(cohort_stage_root(stage), &budget);
        if (budget)
            fuzz_require(cohort_stage_flatten(stage, "/dev/null", &err));
    }
    cohort_stage_destroy(stage);
    unlink(path);
    return 0;
}
