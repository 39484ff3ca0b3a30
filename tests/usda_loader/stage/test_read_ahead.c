// Layers read by several threads: the same stage, the same messages in the same order.

#include "support/files.h"
#include "usda_loader/stage/usda_stage_fixture.h"

#include "base/memory.h"

typedef struct Opened {
    char messages[16384]; // all of them, in order
    size_t length;
    char layers[4096];
    char *text; // flattened
} Opened;

static void note(void *cookie, CohortSeverity severity, const char *file, uint32_t line,
                 uint32_t column, const char *prim, const char *text)
{
    Opened *out = cookie;
    int n = snprintf(out->messages + out->length, sizeof out->messages - out->length,
                     "%d %s:%u:%u %s %s\n", (int)severity, file, line, column, prim, text);
    assert_true(n > 0 && (size_t)n < sizeof out->messages - out->length);
    out->length += (size_t)n;
}

static void open_with(Opened *out, const char *name, uint32_t threads)
{
    char path[1024], flat[1024];
    memset(out, 0, sizeof *out);
    snprintf(path, sizeof path, DATA "%s", name);
    snprintf(flat, sizeof flat, "read_ahead_%u.usda", threads);
    CohortError err = {0};
    CohortStageOptions options = {.report = note, .cookie = out, .threads = threads};
    CohortStage *stage = cohort_stage_open(path, &options, &err);
    assert_non_null(stage);
    const char *layer;
    for (size_t i = 0; (layer = cohort_stage_layer(stage, i)); i++) {
        strncat(out->layers, strrchr(layer, '/'), sizeof out->layers - strlen(out->layers) - 2);
        strcat(out->layers, "\n");
    }
    assert_true(cohort_stage_flatten(stage, flat, &err));
    size_t size;
    out->text = test_read_file(flat, &size);
    assert_non_null(out->text);
    remove(flat);
    cohort_stage_destroy(stage);
}

static void threads_make_no_difference(void **state)
{
    (void)state;
    static const char *const stages[] = {"ahead.usda", "share.usda", "liverps.usda",
                                         "instances.usda"};
    static const uint32_t threads[] = {2, 4};
    for (size_t i = 0; i < 4; i++) {
        Opened one, many;
        open_with(&one, stages[i], 1);
        for (size_t j = 0; j < 2; j++) {
            open_with(&many, stages[i], threads[j]);
            assert_string_equal(one.messages, many.messages);
            assert_string_equal(one.layers, many.layers);
            assert_string_equal(one.text, many.text);
            free(many.text);
        }
        free(one.text);
    }
}

static void what_nobody_asks_for_is_not_there(void **state)
{
    (void)state;
    Opened opened;
    open_with(&opened, "ahead.usda", 2);
    // In order of first use; neither that of an inactive prim's child nor the other variant's.
    assert_string_equal(opened.layers, "/ahead.usda\n/ahead_sub.usda\n/ahead_leaf.usda\n"
                                       "/share_chair.usda\n/share_set.usda\n");
    assert_non_null(strstr(opened.messages, "ahead_broken.usda:5:"));
    assert_non_null(strstr(opened.messages, "ahead_missing.usda"));
    // Found once, reported once.
    const char *first = strstr(opened.messages, "ahead_broken.usda:5:");
    assert_null(strstr(first + 1, "ahead_broken.usda:5:"));
    free(opened.text);
}

static void failing_memory_is_survived(void **state)
{
    (void)state;
    size_t before = co_memory_live(CO_MEMORY_USDA);
    int failures = 0;
    for (uint64_t i = 1; i < 400; i++) {
        CohortError err = {0};
        CohortStageOptions options = {.threads = 2};
        co_memory_fail_after(i);
        CohortStage *stage = cohort_stage_open(DATA "ahead.usda", &options, &err);
        co_memory_fail_after(0);
        failures += !stage;
        assert_true(stage || err.code == COHORT_ERROR_OUT_OF_MEMORY);
        cohort_stage_destroy(stage);
        if (stage && i > 100)
            break;
    }
    assert_true(failures > 0);
    // Tokens stay for the life of the process; nothing else does.
    assert_true(co_memory_live(CO_MEMORY_USDA) - before < (1 << 20));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_make_no_difference),
        cmocka_unit_test(what_nobody_asks_for_is_not_there),
        cmocka_unit_test(failing_memory_is_survived),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
