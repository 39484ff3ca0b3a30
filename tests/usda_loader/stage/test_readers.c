// Four threads ask one stage everything at once: each gets what one alone gets. Also tests
// answers.c.

#include "usda_loader/stage/usda_stage_fixture.h"

#include "base/hash.h"

#include <pthread.h>

#define READERS 4

typedef struct Reader {
    const CohortStage *stage;
    pthread_barrier_t *start;
    uint64_t hash; // of all answers
    uint32_t prims;
} Reader;

static void add_text(Reader *reader, const char *text)
{
    reader->hash = co_hash_bytes(text, strlen(text), reader->hash);
}

static void add_paths(Reader *reader, size_t count, const char *const *paths)
{
    for (size_t i = 0; i < count; i++)
        add_text(reader, paths[i]);
}

static void ask_property(Reader *reader, const CohortPrim *prim, const char *name)
{
    static const double times[] = {0, 1.5, 3.25, (double)NAN};
    add_text(reader, name);
    for (size_t i = 0; i < sizeof times / sizeof *times; i++) {
        CohortValue value;
        double numbers[16] = {0};
        if (!cohort_prim_value(prim, name, times[i], &value))
            continue;
        reader->hash = co_hash_combine(reader->hash, (uint64_t)value.type << 32 | value.count);
        cohort_prim_numbers(prim, name, times[i], numbers, 16);
        reader->hash = co_hash_bytes(numbers, sizeof numbers, reader->hash);
    }
    const double *samples;
    size_t count = cohort_prim_time_samples(prim, name, &samples);
    reader->hash = co_hash_bytes(count ? samples : NULL, count * sizeof *samples, reader->hash);
    const char *const *paths;
    count = cohort_prim_targets(prim, name, &paths);
    add_paths(reader, count, paths);
    count = cohort_prim_connections(prim, name, &paths);
    add_paths(reader, count, paths);
    const CohortAsset *assets;
    count = cohort_prim_assets(prim, name, 0, &assets);
    for (size_t i = 0; i < count; i++)
        add_text(reader, assets[i].anchored);
}

static void ask_prim(Reader *reader, const CohortPrim *prim)
{
    reader->prims++;
    const char *path = cohort_prim_path(prim);
    add_text(reader, path);
    add_text(reader, cohort_prim_kind(prim));
    if (cohort_prim_parent(prim))
        assert_non_null(cohort_stage_prim(reader->stage, path));
    double matrix[4][4];
    bool resets = false;
    cohort_prim_local_transform(prim, 1.5, matrix, &resets);
    reader->hash = co_hash_bytes(matrix, sizeof matrix, reader->hash);
    CohortValue value;
    if (cohort_prim_metadata(prim, "customData", &value))
        reader->hash = co_hash_combine(reader->hash, value.count);
    if (cohort_prim_metadata(prim, "apiSchemas", &value))
        reader->hash = co_hash_combine(reader->hash, value.count);
    for (size_t i = 0; i < cohort_prim_variant_set_count(prim); i++)
        add_text(reader, cohort_prim_variant_set(prim, i));
    for (size_t i = 0; i < cohort_prim_property_count(prim); i++)
        ask_property(reader, prim, cohort_prim_property_name(prim, i));
    for (size_t i = 0; i < cohort_prim_child_count(prim); i++)
        ask_prim(reader, cohort_prim_child(prim, i));
}

static void *read_all(void *argument)
{
    Reader *reader = argument;
    pthread_barrier_wait(reader->start);
    ask_prim(reader, cohort_stage_root(reader->stage));
    CohortStageInfo info;
    cohort_stage_info(reader->stage, &info);
    double earliest = 0;
    cohort_stage_earliest_time(reader->stage, &earliest);
    reader->hash = co_hash_combine(reader->hash, info.hash ^ (uint64_t)earliest);
    return NULL;
}

static uint64_t ask_from(const char *name, uint32_t count)
{
    CohortStage *stage = test_open(name, NULL);
    Reader readers[READERS];
    pthread_t threads[READERS];
    pthread_barrier_t start;
    assert_int_equal(pthread_barrier_init(&start, NULL, count), 0);
    for (uint32_t i = 0; i < count; i++) {
        readers[i] = (Reader){.stage = stage, .start = &start};
        assert_int_equal(pthread_create(&threads[i], NULL, read_all, &readers[i]), 0);
    }
    for (uint32_t i = 0; i < count; i++)
        assert_int_equal(pthread_join(threads[i], NULL), 0);
    pthread_barrier_destroy(&start);
    for (uint32_t i = 0; i < count; i++) {
        assert_true(readers[i].prims > 1);
        assert_true(readers[i].hash == readers[0].hash);
    }
    cohort_stage_destroy(stage);
    return readers[0].hash;
}

static void readers_do_not_disturb_each_other(void **state)
{
    (void)state;
    static const char *const stages[] = {"share.usda",     "liverps.usda", "lists.usda",
                                         "instances.usda", "times.usda",   "assets.usda",
                                         "clip_sets.usda"};
    for (size_t i = 0; i < sizeof stages / sizeof *stages; i++)
        assert_true(ask_from(stages[i], 1) == ask_from(stages[i], READERS));
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(readers_do_not_disturb_each_other)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
