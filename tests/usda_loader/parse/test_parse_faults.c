// Nothing that a file holds, and no failing allocation, does more than make the parse fail.

#include "usda_loader/parse/support.h"

#include "base/hash.h"
#include "base/memory.h"

static void each_failing_allocation_is_reported(void **state)
{
    (void)state;
    size_t size;
    char *text = read_data("everything.usda", &size);
    // Tokens stay for good, so all of them are interned first.
    co_layer_destroy(co_layer_parse("t.usda", text, size, NULL, NULL, NULL, NULL));
    size_t live = co_memory_live(CO_MEMORY_USDA);
    bool done = false;
    uint64_t step = 1;
    for (; !done; step++) {
        Reports reports = {0};
        CohortError err = {0};
        co_memory_fail_after(step);
        CoLayer *layer = co_layer_parse("t.usda", text, size, NULL, keep_report, &reports, &err);
        co_memory_fail_after(0);
        done = layer != NULL;
        if (!layer)
            assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
        co_layer_destroy(layer);
        assert_int_equal(co_memory_live(CO_MEMORY_USDA), live);
    }
    assert_true(step > 3);
    free(text);
}

static void truncation_never_crashes(void **state)
{
    (void)state;
    size_t size;
    char *text = read_data("everything.usda", &size);
    Reports reports;
    CohortError err;
    size_t accepted = 0;
    for (size_t cut = 0; cut < size; cut++) {
        CoLayer *layer = parse_bytes(text, cut, NULL, &reports, &err);
        assert_true((layer != NULL) == (err.code == COHORT_OK));
        accepted += layer != NULL;
        co_layer_destroy(layer);
    }
    assert_true(accepted > 0 && accepted < 64);
    free(text);
}

static void changed_bytes_never_crash(void **state)
{
    (void)state;
    size_t size;
    char *text = read_data("everything.usda", &size);
    static const char interesting[] = "\0\n\r\"'@<>()[]{}=:;,.#/*\\-e9\x80\xff";
    Reports reports;
    CohortError err;
    for (uint64_t i = 0; i < 6000; i++) {
        uint64_t random = co_hash64(i);
        size_t at = (size_t)(random % size);
        char old = text[at];
        text[at] = interesting[(random >> 40) % (sizeof interesting - 1)];
        CoLayer *layer = parse_bytes(text, size, NULL, &reports, &err);
        assert_true((layer != NULL) == (err.code == COHORT_OK));
        assert_true(layer || reports.line > 0);
        co_layer_destroy(layer);
        text[at] = old;
    }
    free(text);
}

// ---- The corpus --------------------------------------------------------------------------------

typedef struct Sweep {
    size_t files, read, refused;
} Sweep;

static void read_one(void *context, const char *path)
{
    Sweep *sweep = context;
    if (!test_has_suffix(path, ".usda") && !test_has_suffix(path, ".usd"))
        return;
    CohortError err = {0};
    Reports reports = {0};
    CoLayer *layer = co_layer_open(path, NULL, keep_report, &reports, &err);
    sweep->files++;
    sweep->read += layer != NULL;
    sweep->refused += layer == NULL;
    assert_true((layer != NULL) == (err.code == COHORT_OK));
    assert_true(layer || reports.line > 0);
    co_layer_destroy(layer);
}

static void the_whole_corpus_is_read_or_refused(void **state)
{
    (void)state;
    Sweep sweep = {0};
    test_each_file(COHORT_SHARED_DIR "/usd/corpus", read_one, &sweep);
    if (!sweep.files)
        skip();
    print_message("%zu files: %zu read, %zu refused\n", sweep.files, sweep.read, sweep.refused);
    assert_true(sweep.read > 1500);
    assert_true(sweep.refused > 250);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_failing_allocation_is_reported),
        cmocka_unit_test(truncation_never_crashes),
        cmocka_unit_test(changed_bytes_never_crash),
        cmocka_unit_test(the_whole_corpus_is_read_or_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
