// Nothing in the input, in memory or in the number of readers brings the stage down.

#include "base/memory.h"
#include "base/parallel.h"
#include "usda_loader/stage/usda_stage_fixture.h"

#include <dirent.h>
#include <stdlib.h>
#include <unistd.h>

static size_t visit(const CohortPrim *prim, double time)
{
    size_t seen = strlen(cohort_prim_path(prim)) + strlen(cohort_prim_kind(prim));
    double m[4][4];
    seen += cohort_prim_local_transform(prim, time, m, NULL);
    for (size_t i = 0; i < cohort_prim_property_count(prim); i++) {
        const char *name = cohort_prim_property_name(prim, i);
        CohortValue value;
        const char *const *paths;
        const CohortAsset *assets;
        const double *times;
        if (!name)
            continue;
        seen += cohort_prim_value(prim, name, time, &value) ? value.count : 0;
        seen += cohort_prim_targets(prim, name, &paths);
        seen += cohort_prim_connections(prim, name, &paths);
        seen += cohort_prim_assets(prim, name, time, &assets);
        seen += cohort_prim_time_samples(prim, name, &times);
    }
    for (size_t i = 0; i < cohort_prim_child_count(prim); i++)
        seen += visit(cohort_prim_child(prim, i), time);
    return seen;
}

static size_t open_and_visit(const char *path)
{
    CohortStage *stage = cohort_stage_open(path, NULL, NULL);
    if (!stage)
        return 0;
    size_t seen = visit(cohort_stage_root(stage), 3.5);
    cohort_stage_destroy(stage);
    return seen;
}

static const char *const names[] = {"liverps.usda",  "implied.usda", "times.usda",
                                    "variants.usda", "lists.usda",   "instances.usda",
                                    "broken.usda",   "assets.usda",  "relocates.usda"};
#define NAME_COUNT (sizeof names / sizeof *names)

static void every_allocation_may_fail(void **state)
{
    (void)state;
    for (size_t i = 0; i < NAME_COUNT; i++) {
        char path[1024];
        snprintf(path, sizeof path, DATA "%s", names[i]);
        bool succeeded = false;
        for (uint64_t n = 1; n < 4000 && !succeeded; n++) {
            CohortError err = {0};
            co_memory_fail_after(n);
            CohortStage *stage = cohort_stage_open(path, NULL, &err);
            if (stage)
                visit(cohort_stage_root(stage), 3.5);
            co_memory_fail_after(0);
            if (!stage)
                assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
            succeeded = stage != NULL;
            cohort_stage_destroy(stage);
        }
        assert_true(succeeded);
        // Interned text stays for the life of the process; the stage's own memory must not.
        size_t settled = co_memory_live(CO_MEMORY_USDA);
        open_and_visit(path);
        assert_int_equal(co_memory_live(CO_MEMORY_USDA), settled);
    }
}

// A folder beside which the stages' references still lead somewhere.
static bool make_folder(char *folder)
{
    if (!mkdtemp(folder))
        return false;
    DIR *dir = opendir(DATA);
    for (struct dirent *entry; dir && (entry = readdir(dir));) {
        char from[2048], to[2048];
        snprintf(from, sizeof from, DATA "%s", entry->d_name);
        snprintf(to, sizeof to, "%s/%s", folder, entry->d_name);
        if (entry->d_name[0] != '.' && symlink(from, to) != 0)
            return false;
    }
    if (dir)
        closedir(dir);
    return dir != NULL;
}

static void remove_folder(const char *folder)
{
    DIR *dir = opendir(folder);
    for (struct dirent *entry; dir && (entry = readdir(dir));) {
        char path[2048];
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        unlink(path);
    }
    if (dir)
        closedir(dir);
    rmdir(folder);
}

static void flip_and_open(const char *path, const char *text, size_t size, uint32_t *random)
{
    char flipped[8192];
    memcpy(flipped, text, size);
    for (int k = 0; k < 2; k++) {
        *random = *random * 1664525u + 1013904223u;
        size_t at = (*random >> 8) % size;
        *random = *random * 1664525u + 1013904223u;
        flipped[at] = k ? text[(*random >> 8) % size] : (char)(*random >> 24);
    }
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(flipped, 1, size, file), size);
    fclose(file);
    open_and_visit(path);
}

static void flipped_bytes_are_survived(void **state)
{
    (void)state;
    uint32_t random = 1;
    char folder[] = "/tmp/cohort_flip_XXXXXX", path[1024];
    assert_true(make_folder(folder));
    snprintf(path, sizeof path, "%s/flipped.usda", folder);
    for (size_t i = 0; i < NAME_COUNT; i++) {
        char source[1024], text[8192];
        snprintf(source, sizeof source, DATA "%s", names[i]);
        FILE *file = fopen(source, "rb");
        assert_non_null(file);
        size_t size = fread(text, 1, sizeof text, file);
        fclose(file);
        for (int round = 0; round < 150; round++)
            flip_and_open(path, text, size, &random);
    }
    remove_folder(folder);
}

typedef struct Readers {
    const CohortStage *stage;
    size_t seen[64];
} Readers;

static void read_all(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    Readers *readers = context;
    for (size_t i = begin; i < end; i++)
        readers->seen[i] = visit(cohort_stage_root(readers->stage), (double)(i % 4));
}

static void readers_do_not_disturb_each_other(void **state)
{
    (void)state;
    for (size_t i = 0; i < NAME_COUNT; i++) {
        CohortStage *alone = test_open(names[i], NULL), *shared = test_open(names[i], NULL);
        Readers readers = {.stage = shared};
        co_worker_count_set(8);
        co_parallel_for(64, 1, read_all, &readers);
        for (size_t k = 0; k < 64; k++)
            assert_int_equal(readers.seen[k], visit(cohort_stage_root(alone), (double)(k % 4)));
        cohort_stage_destroy(alone);
        cohort_stage_destroy(shared);
    }
    co_worker_count_set(0);
}

static size_t sweep(const char *folder, size_t *opened)
{
    size_t met = 0;
    DIR *dir = opendir(folder);
    for (struct dirent *entry; dir && (entry = readdir(dir));) {
        char path[2048];
        size_t length = strlen(entry->d_name);
        if (entry->d_name[0] == '.')
            continue;
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        if (entry->d_type == DT_DIR) {
            met += sweep(path, opened);
        } else if (length > 5 && !strcmp(entry->d_name + length - 5, ".usda")) {
            met++;
            *opened += open_and_visit(path) > 0;
        }
    }
    if (dir)
        closedir(dir);
    return met;
}

static void real_stages_open(void **state)
{
    (void)state;
    size_t opened = 0, met = sweep(COHORT_SHARED_DIR "/stages", &opened);
    if (!met)
        skip();
    assert_int_equal(opened, met);
    met = sweep(COHORT_SHARED_DIR "/usd/corpus", &opened);
    assert_true(opened > met / 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(flipped_bytes_are_survived),
        cmocka_unit_test(readers_do_not_disturb_each_other),
        cmocka_unit_test(real_stages_open),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
