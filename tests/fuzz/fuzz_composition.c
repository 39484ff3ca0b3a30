// Any bytes as a stage of up to four layers: composed, asked for everything, and flattened.
//
// Each "#usda" that begins a line begins the next layer: root.usda, a.usda, b.usda, c.usda, all in
// one folder, so that they can refer to each other.

#include "fuzz.h"

#include "cohort/usda.h"
#include "parse/layer.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum {
    LAYERS_MAX = 4,
    PRIMS_MAX = 3000
};

#define FOLDER "/cohort-fuzz/"

// The layers of one input: /cohort-fuzz/root.usda and so on.
typedef struct Parts {
    const uint8_t *data[LAYERS_MAX];
    size_t size[LAYERS_MAX];
    int count;
} Parts;

static size_t part_end(const uint8_t *data, size_t begin, size_t size)
{
    for (size_t i = begin + 1; i + 5 <= size; i++)
        if (data[i] == '#' && data[i - 1] == '\n' && !memcmp(data + i, "#usda", 5))
            return i;
    return size;
}

static Parts split(const uint8_t *data, size_t size)
{
    Parts parts = {0};
    size_t begin = 0;
    do {
        size_t end = parts.count + 1 < LAYERS_MAX ? part_end(data, begin, size) : size;
        parts.data[parts.count] = data + begin;
        parts.size[parts.count++] = end - begin;
        begin = end;
    } while (begin < size);
    return parts;
}

static bool open_part(void *cookie, const char *path, CohortBytes *out)
{
    static const char *const names[LAYERS_MAX] = {FOLDER "root.usda", FOLDER "a.usda",
                                                  FOLDER "b.usda", FOLDER "c.usda"};
    const Parts *parts = cookie;
    for (int i = 0; i < parts->count; i++)
        if (!strcmp(path, names[i])) {
            if (out)
                *out = (CohortBytes){.data = parts->data[i], .size = parts->size[i]};
            return true;
        }
    return false;
}

static void ask_property(const CohortPrim *prim, const char *name)
{
    CohortValue value;
    const double *times;
    const char *const *targets, *layer;
    const CohortAsset *assets;
    uint32_t line;
    cohort_prim_value(prim, name, COHORT_TIME_DEFAULT, &value);
    cohort_prim_value(prim, name, 2.5, &value);
    cohort_prim_time_samples(prim, name, &times);
    cohort_prim_targets(prim, name, &targets);
    cohort_prim_connections(prim, name, &targets);
    cohort_prim_assets(prim, name, 1, &assets);
    cohort_prim_origin(prim, name, &layer, &line);
    cohort_prim_attribute_metadata(prim, name, "customData", &value);
    fuzz_require(cohort_prim_has_attribute(prim, name) != cohort_prim_has_relationship(prim, name));
}

static void ask(const CohortPrim *prim, unsigned *budget)
{
    static const char *const keys[] = {"customData", "assetInfo",  "variantSetNames",
                                       "apiSchemas", "references", "documentation"};
    double matrix[4][4];
    bool resets;
    CohortValue value;
    CohortOpinion opinion;
    if (!*budget)
        return;
    --*budget;
    cohort_prim_local_transform(prim, 1, matrix, &resets);
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
        cohort_prim_metadata(prim, keys[i], &value);
    for (size_t i = 0; i < cohort_prim_variant_set_count(prim); i++) {
        const char *set = cohort_prim_variant_set(prim, i);
        fuzz_require(cohort_prim_variant_selection(prim, set) != NULL);
        for (size_t j = 0; j < cohort_prim_variant_count(prim, set); j++)
            fuzz_require(cohort_prim_variant(prim, set, j) != NULL);
    }
    for (size_t i = 0; i < cohort_prim_opinion_count(prim); i++)
        fuzz_require(cohort_prim_opinion(prim, i, &opinion) && opinion.layer && opinion.arc);
    for (size_t i = 0; i < cohort_prim_property_count(prim); i++)
        ask_property(prim, cohort_prim_property_name(prim, i));
    for (size_t i = 0; i < cohort_prim_child_count(prim); i++)
        ask(cohort_prim_child(prim, i), budget);
}

// What is written of a stage is a layer that can be read.
static void flatten(const CohortStage *stage)
{
    char path[64];
    CohortError err = {0};
    snprintf(path, sizeof path, "%s/cohort-fuzz-%ld.usda",
             access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp", (long)getpid());
    bool is_written = cohort_stage_flatten(stage, path, &err);
    CoLayer *flat = is_written ? co_layer_open(path, NULL, NULL, NULL, NULL) : NULL;
    unlink(path);
    fuzz_require(is_written ? flat != NULL : err.code != COHORT_OK);
    co_layer_destroy(flat);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    Parts parts = split(data, size);
    const CohortStageOptions options = {.max_bytes = 1 << 20,
                                        .max_depth = 64,
                                        .max_prims = PRIMS_MAX,
                                        .max_layers = 16,
                                        .max_array_length = 1 << 16,
                                        .no_payloads = size % 16 == 1,
                                        .threads = 1,
                                        .open = open_part,
                                        .open_cookie = &parts};
    CohortError err = {0};
    CohortStage *stage = cohort_stage_open(FOLDER "root.usda", &options, &err);
    fuzz_require(!stage == (err.code != COHORT_OK));
    if (stage) {
        unsigned budget = PRIMS_MAX;
        CohortStageInfo info;
        double earliest;
        cohort_stage_info(stage, &info);
        fuzz_require(cohort_stage_layer(stage, 0) && !cohort_stage_layer(stage, info.layer_count));
        cohort_stage_earliest_time(stage, &earliest);
        ask(cohort_stage_root(stage), &budget);
        if (budget)
            flatten(stage);
    }
    cohort_stage_destroy(stage);
    return 0;
}
