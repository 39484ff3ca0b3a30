// Input made to exhaust: deep, circular, doubling, endless. Each is refused or cut down in bounded
// time and memory, with one message that says what and where.

#include "base/memory.h"
#include "usda_loader/stage/usda_stage_fixture.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define HEAD "#usda 1.0\n"
#define SECONDS_MAX 60.0 // under sanitizers, on a slow machine; a few otherwise
#define BYTES_MAX ((size_t)1 << 30)

// ---- Text --------------------------------------------------------------------------------------

typedef struct Text {
    char *bytes;
    size_t length, capacity;
} Text;

static void add(Text *text, const char *more)
{
    size_t length = strlen(more);
    if (text->length + length >= text->capacity) {
        text->capacity = 2 * (text->capacity + length) + 64;
        text->bytes = realloc(text->bytes, text->capacity);
        assert_non_null(text->bytes);
    }
    memcpy(text->bytes + text->length, more, length + 1);
    text->length += length;
}

static void repeat(Text *text, const char *more, size_t count)
{
    for (size_t i = 0; i < count; i++)
        add(text, more);
}

static void __attribute__((format(printf, 2, 3))) add_format(Text *text, const char *format, ...)
{
    char line[512];
    va_list args;
    va_start(args, format);
    vsnprintf(line, sizeof line, format, args);
    va_end(args);
    add(text, line);
}

// ---- Opening -----------------------------------------------------------------------------------

typedef struct Outcome {
    bool is_open;
    size_t prims, reports;
    CohortError err;
    char said[1024]; // the first report
    char prim[512];
} Outcome;

static const Text *opened; // the layer at /hostile/root.usda

static bool open_text(void *cookie, const char *path, CohortBytes *out)
{
    (void)cookie;
    if (strcmp(path, "/hostile/root.usda") != 0)
        return false;
    if (out)
        *out = (CohortBytes){.data = opened->bytes, .size = opened->length};
    return true;
}

static void hear(void *cookie, CohortSeverity severity, const char *file, uint32_t line,
                 uint32_t column, const char *prim, const char *text)
{
    Outcome *outcome = cookie;
    (void)severity;
    (void)file;
    (void)column;
    if (outcome->reports++)
        return;
    snprintf(outcome->said, sizeof outcome->said, "%u: %s", line, text);
    snprintf(outcome->prim, sizeof outcome->prim, "%s", prim);
}

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static Outcome open_hostile(Text *text, const CohortStageOptions *limits)
{
    Outcome outcome = {0};
    CohortStageOptions options = limits ? *limits : (CohortStageOptions){0};
    options.open = open_text;
    options.report = hear;
    options.cookie = &outcome;
    opened = text;
    double start = seconds();
    CohortStage *stage = cohort_stage_open("/hostile/root.usda", &options, &outcome.err);
    assert_true(seconds() - start < SECONDS_MAX);
    assert_true(co_memory_peak(CO_MEMORY_USDA) < BYTES_MAX);
    outcome.is_open = stage != NULL;
    if (stage) {
        CohortStageInfo info;
        cohort_stage_info(stage, &info);
        outcome.prims = info.prim_count;
    }
    cohort_stage_destroy(stage);
    free(text->bytes);
    *text = (Text){0};
    return outcome;
}

static void assert_refused(Text *text, const char *why)
{
    Outcome outcome = open_hostile(text, NULL);
    assert_false(outcome.is_open);
    assert_int_equal(outcome.reports, 1);
    if (!strstr(outcome.said, why))
        fail_msg("\"%s\" does not say \"%s\"", outcome.said, why);
    assert_true(outcome.err.line > 0);
}

// ---- Deep --------------------------------------------------------------------------------------

static void nests(void **state)
{
    (void)state;
    static const struct {
        const char *begin, *open, *close, *end, *why;
    } cases[] = {
        {"", "def \"a\" {\n", "}\n", "", "nested deeper than 512 levels"},
        {"def \"a\" (\n customData = {\n", "dictionary d = {\n", "}\n", "}\n)\n{\n}\n",
         "nested deeper than 512 levels"},
        {"def \"a\" {\n int[] x = ", "[", "]", "\n}\n", "deeper than"},
        {"def \"a\" {\n float3 x = ", "(", ")", "\n}\n", "expected a number"},
        {"def \"a\" (\n foo = ", "[", "]", "\n)\n{\n}\n", "nested deeper than 512 levels"},
        {"def \"a\" {\n", "variantSet \"v\" = {\n\"x\" {\n", "}\n}\n", "}\n",
         "nested deeper than 512 levels"},
        {"def \"a\" {\n rel r = </a.b", "[/a.b", "]", ">\n}\n", "no well-formed path"},
        {"def \"a\" {\n pathExpression r = \"", "(", ")", "\"\n}\n", "no path expression"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        Text text = {0};
        add(&text, HEAD);
        add(&text, cases[i].begin);
        repeat(&text, cases[i].open, 100000);
        repeat(&text, cases[i].close, 100000);
        add(&text, cases[i].end);
        assert_refused(&text, cases[i].why);
    }
}

static void a_variable_expression_nests(void **state)
{
    (void)state;
    Text text = {0};
    add(&text, "#usda 1.0\n(\n subLayers = [@`");
    repeat(&text, "if(", 100000);
    add(&text, "`@]\n)\n");
    Outcome outcome = open_hostile(&text, NULL);
    assert_true(outcome.is_open);
    assert_int_equal(outcome.reports, 1);
}

// ---- Endless -----------------------------------------------------------------------------------

static void lengths(void **state)
{
    (void)state;
    Text text = {0};
    add(&text, HEAD "def \"a\" {\n string s = \"");
    repeat(&text, "0123456789abcdef", 1 << 20);
    add(&text, "\"\n}\n");
    assert_true(open_hostile(&text, NULL).is_open);
    add(&text, HEAD "def \"a\" {\n string s = \"");
    repeat(&text, "0123456789abcdef", 1 << 18);
    add(&text, "\"\n}\n");
    Outcome outcome = open_hostile(&text, &(CohortStageOptions){.max_bytes = 1 << 20});
    assert_int_equal(outcome.err.code, COHORT_ERROR_LIMIT);
    assert_non_null(strstr(outcome.err.message, "1048576"));
    add(&text, HEAD "def \"a\" {\n int[] x = [");
    repeat(&text, "1, ", 100000);
    add(&text, "]\n}\n");
    outcome = open_hostile(&text, &(CohortStageOptions){.max_array_length = 1000});
    assert_int_equal(outcome.err.code, COHORT_ERROR_LIMIT);
    assert_int_equal(outcome.err.line, 3);
}

static void claims_of_arrays(void **state)
{
    (void)state;
    static const char *const edits[] = {"resize 1000000000", "minsize 1000000000",
                                        "minsize 1000000000 fill 7", "resize 4000000000 fill 7"};
    for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
        Text text = {0};
        add_format(&text, HEAD "def \"a\" {\n int[] x = edit [%s]\n}\n", edits[i]);
        assert_refused(&text, "found a size above 16777216; raise max_array_length");
    }
    Text text = {0};
    add(&text, HEAD "def \"a\" {\n int[] x = edit [resize 10; insert 1 at [1000000000]; "
                    "maxsize 1000000000]\n}\n");
    assert_true(open_hostile(&text, NULL).is_open);
}

// ---- In circles --------------------------------------------------------------------------------

static void circles(void **state)
{
    (void)state;
    static const char *const arcs[] = {"references", "payload", "inherits", "specializes"};
    for (size_t i = 0; i < sizeof arcs / sizeof *arcs; i++) {
        Text text = {0};
        add(&text, HEAD);
        for (char name = 'a'; name <= 'c'; name++) {
            add_format(&text, "def \"%c\" (\n %s = </%c>\n)\n{\n}\n", name, arcs[i],
                       name == 'c' ? 'a' : name + 1);
        }
        Outcome outcome = open_hostile(&text, NULL);
        assert_true(outcome.is_open);
        assert_int_equal(outcome.prims, 3);
        assert_int_equal(outcome.reports, 3);
        assert_non_null(strstr(outcome.said, "leads back to itself"));
        assert_string_equal(outcome.prim, "/a");
    }
}

static void a_layer_in_itself(void **state)
{
    (void)state;
    Text text = {0};
    add(&text, "#usda 1.0\n(\n defaultPrim = \"a\"\n subLayers = [@root.usda@]\n)\n"
               "def \"a\" {\n def \"b\" (\n references = @root.usda@\n) {\n}\n}\n");
    Outcome outcome = open_hostile(&text, NULL);
    assert_true(outcome.is_open);
    // Twice the sublayer, of the stage and of what the reference leads to.
    assert_int_equal(outcome.reports, 3);
    assert_non_null(strstr(outcome.said, "leads back to itself"));
}

static void variants_in_circles(void **state)
{
    (void)state;
    Text text = {0};
    add(&text, HEAD "def \"a\" (\n variants = {\n string v = \"x\"\n}\n"
                    " prepend variantSets = \"v\"\n)\n{\n variantSet \"v\" = {\n"
                    " \"x\" (\n variants = {\n string v = \"y\"\n}\n) {\n}\n"
                    " \"y\" (\n variants = {\n string v = \"x\"\n}\n references = </a>\n) {\n}\n"
                    "}\n}\n");
    Outcome outcome = open_hostile(&text, NULL);
    assert_true(outcome.is_open);
    assert_int_equal(outcome.prims, 1);
}

// ---- Doubling ----------------------------------------------------------------------------------

static void prims_explode(void **state)
{
    (void)state;
    Text text = {0};
    add(&text, HEAD);
    for (int i = 0; i < 10; i++) {
        add_format(&text, "def \"L%d\" {\n", i);
        for (int k = 0; k < 10; k++)
            add_format(&text, " def \"c%d\" (\n references = </L%d>\n) {\n}\n", k, i + 1);
        add(&text, "}\n");
    }
    add(&text, "def \"L10\" {\n}\n");
    Outcome outcome = open_hostile(&text, &(CohortStageOptions){.max_prims = 100000});
    assert_false(outcome.is_open);
    assert_int_equal(outcome.err.code, COHORT_ERROR_LIMIT);
    assert_non_null(strstr(outcome.err.message, "more prims and arcs"));
    assert_non_null(strstr(outcome.err.message, "limit of 100000; raise max_prims"));
}

static void arcs_explode(void **state)
{
    (void)state;
    static const char *const arcs[] = {"references", "payload", "inherits", "specializes"};
    for (size_t a = 0; a < sizeof arcs / sizeof *arcs; a++) {
        Text text = {0};
        add(&text, HEAD);
        for (int i = 0; i < 30; i++)
            for (char name = 'C'; name <= 'D'; name++)
                add_format(&text, "def \"%c%d\" (\n %s = [</C%d>, </D%d>]\n) {\n}\n", name, i,
                           arcs[a], i + 1, i + 1);
        add(&text, "def \"C30\" {\n}\ndef \"D30\" {\n}\n");
        Outcome outcome = open_hostile(&text, NULL);
        assert_true(outcome.is_open);
        assert_int_equal(outcome.prims, 62);
        // Classes meet again where they have been; references and payloads are cut off.
        if (outcome.reports) {
            assert_non_null(strstr(outcome.said, "arcs are left out: more than 32767"));
            assert_string_equal(outcome.prim, "/C0");
        }
    }
}

static void sublayers_explode(void **state)
{
    (void)state;
    Text text = {0};
    CohortStageOptions options = {.max_layers = 1000};
    add(&text, "#usda 1.0\n(\n subLayers = [");
    for (int i = 0; i < 3000; i++)
        add_format(&text, "@l%d.usda@, ", i);
    add(&text, "]\n)\n");
    Outcome outcome = open_hostile(&text, &options);
    assert_int_equal(outcome.err.code, COHORT_ERROR_LIMIT);
    assert_non_null(strstr(outcome.err.message, "raise max_layers"));
}

static void long_lists(void **state)
{
    (void)state;
    Text text = {0};
    add(&text, HEAD "def \"a\" (\n customData = {\n");
    for (int i = 0; i < 50000; i++)
        add_format(&text, "int i%d = 1\n", i);
    add(&text, "}\n)\n{\n int x.timeSamples = {\n");
    for (int i = 50000; i > 0; i--)
        add_format(&text, "%d: 1,\n", i);
    add(&text, "}\n double y.spline = {\n");
    for (int i = 50000; i > 0; i--)
        add_format(&text, "%d: 1,\n", i);
    add(&text, "}\n rel r = [");
    for (int i = 0; i < 50000; i++)
        add_format(&text, "</p%d>, ", i);
    add(&text, "]\n");
    for (int i = 0; i < 50000; i++)
        add_format(&text, "int j%d = 1\n", i);
    add(&text, "}\n");
    assert_true(open_hostile(&text, NULL).is_open);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nests),
        cmocka_unit_test(a_variable_expression_nests),
        cmocka_unit_test(lengths),
        cmocka_unit_test(claims_of_arrays),
        cmocka_unit_test(circles),
        cmocka_unit_test(a_layer_in_itself),
        cmocka_unit_test(variants_in_circles),
        cmocka_unit_test(prims_explode),
        cmocka_unit_test(arcs_explode),
        cmocka_unit_test(sublayers_explode),
        cmocka_unit_test(long_lists),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
