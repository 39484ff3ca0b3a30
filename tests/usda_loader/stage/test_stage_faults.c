// Nothing in the input, in memory or in the number of readers brings the stage down.

#include "base/memory.h"
#include "base/parallel.h"
#include "stage/stage_data.h"
#include "support/faults.h"
#include "support/files.h"
#include "usda_loader/stage/usda_stage_fixture.h"

enum {
    FLIPPED = 8192 // bytes of a file that are looked at
};

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

// What a query could not work out it says so of, and the same query says it all the next time: with
// so much room left for answers, or for the paths that targets lead to.
static void run_short(const char *path, bool is_of_paths, size_t *room)
{
    const size_t whole = open_and_visit(path);
    bool is_short = true;
    for (*room = 0; is_short; *room += 112) {
        CohortStage *stage = cohort_stage_open(path, NULL, NULL);
        assert_non_null(stage);
        CoArena *arena = is_of_paths ? stage->composer.paths.arena : &stage->answers_arena;
        size_t limit = arena->limit;
        test_arena_leave(arena, *room);
        size_t seen = visit(cohort_stage_root(stage), 3.5);
        is_short = cohort_stage_ran_short(stage);
        assert_true(is_short || seen == whole);
        assert_false(cohort_stage_ran_short(stage));
        arena->limit = limit;
        assert_int_equal(visit(cohort_stage_root(stage), 3.5), whole);
        assert_false(cohort_stage_ran_short(stage));
        cohort_stage_destroy(stage);
    }
}

static void queries_that_run_short_say_so(void **state)
{
    (void)state;
    for (size_t i = 0; i < NAME_COUNT; i++) {
        char path[1024];
        size_t room;
        snprintf(path, sizeof path, DATA "%s", names[i]);
        run_short(path, false, &room);
        assert_true(room > 1000);
        run_short(path, true, &room);
    }
}

// Beside them the stages' references still lead somewhere.
static void link_data(void)
{
    DIR *dir = opendir(DATA);
    assert_non_null(dir);
    for (struct dirent *entry; (entry = readdir(dir)) != NULL;) {
        char from[2048];
        snprintf(from, sizeof from, DATA "%s", entry->d_name);
        assert_true(entry->d_name[0] == '.' || symlink(from, in_folder(entry->d_name)) == 0);
    }
    closedir(dir);
}

static void flip_and_open(const char *path, const char *text, size_t size, uint32_t *random)
{
    char flipped[FLIPPED];
    memcpy(flipped, text, size);
    for (int k = 0; k < 2; k++) {
        *random = *random * 1664525u + 1013904223u;
        size_t at = (*random >> 8) % size;
        *random = *random * 1664525u + 1013904223u;
        flipped[at] = k ? text[(*random >> 8) % size] : (char)(*random >> 24);
    }
    test_write_file(path, flipped, size);
    open_and_visit(path);
}

static void flipped_bytes_are_survived(void **state)
{
    (void)state;
    uint32_t random = 1;
    link_data();
    for (size_t i = 0; i < NAME_COUNT; i++) {
        char source[1024];
        size_t size;
        snprintf(source, sizeof source, DATA "%s", names[i]);
        char *text = test_read_file(source, &size);
        assert_non_null(text);
        for (int round = 0; round < 150; round++)
            flip_and_open(in_folder("flipped.usda"), text, size < FLIPPED ? size : FLIPPED,
                          &random);
        free(text);
    }
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

typedef struct Sweep {
    size_t met, opened;
} Sweep;

static void open_real(void *context, const char *path)
{
    Sweep *sweep = context;
    if (!test_has_suffix(path, ".usda"))
        return;
    sweep->met++;
    sweep->opened += open_and_visit(path) > 0;
}

static void real_stages_open(void **state)
{
    (void)state;
    Sweep stages = {0}, corpus = {0};
    test_each_file(COHORT_SHARED_DIR "/stages", open_real, &stages);
    if (!stages.met)
        skip();
    assert_int_equal(stages.opened, stages.met);
    test_each_file(COHORT_SHARED_DIR "/usd/corpus", open_real, &corpus);
    assert_true(corpus.opened >= corpus.met / 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(queries_that_run_short_say_so),
        cmocka_unit_test(flipped_bytes_are_survived),
        cmocka_unit_test(readers_do_not_disturb_each_other),
        cmocka_unit_test(real_stages_open),
    };
    return cmocka_run_group_tests(tests, test_folder_make, test_folder_remove);
}
