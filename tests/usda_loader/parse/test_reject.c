// What is refused, where the message points, and that several mistakes are found in one go.
// Also tests known_field.c, parser.c and words.c.

#include "usda_loader/parse/support.h"

#include "base/clock.h"
#include "base/memory.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

typedef struct Case {
    const char *text; // after the header line
    uint32_t line, column;
    const char *says; // part of the message
} Case;

static const Case cases[] = {
    {"def A\n", 2, 6, "name in quotes"},
    {"def \"A\"\n", 3, 1, "the end of the file"},
    {"def \"A\" {} def \"B\" {}\n", 2, 12, "a line end"},
    {"def \"1\" {}\n", 2, 5, "cannot be the name of a prim"},
    {"def \"A\" {}\ndef \"A\" {}\n", 3, 1, "a second time"},
    {"def \"A\" { double a = 1 }\n", 2, 24, "a line end or ';'"},
    {"def \"A\" {\n double a = \n}\n", 3, 13, "the end of the line"},
    {"def \"A\" {\n double a = +1\n}\n", 3, 13, "a number"},
    {"def \"A\" {\n int a = 2147483648\n}\n", 3, 10, "a 32-bit integer"},
    {"def \"A\" {\n uchar a = -1\n}\n", 3, 12, "from 0 to 255"},
    {"def \"A\" {\n float a = 1.0f\n}\n", 3, 15, "a line end"},
    {"def \"A\" {\n double a = \"1\"\n}\n", 3, 13, "a number"},
    {"def \"A\" {\n bool a = maybe\n}\n", 3, 11, "a bool"},
    {"def \"A\" {\n string a = b\n}\n", 3, 13, "a quoted string"},
    {"def \"A\" {\n string a = \"b\n\"\n}\n", 3, 13, "no end"},
    {"def \"A\" {\n asset a = @b\n}\n", 3, 12, "no end"},
    {"def \"A\" {\n asset a = @b\x01@\n}\n", 3, 12, "control character"},
    {"def \"A\" {\n string a = \"b\xff\"\n}\n", 3, 15, "expected text in UTF-8"},
    {"def \"A\" {\n asset a = @\xc3@\n}\n", 3, 13, "expected text in UTF-8"},
    {"def \"A\" {\n float3 a = (1, 2)\n}\n", 3, 13, "a tuple of 2"},
    {"def \"A\" {\n float3 a = (1, 2, 3, 4)\n}\n", 3, 23, "too long"},
    {"def \"A\" {\n float3[] a = [1, 2]\n}\n", 3, 16, "'('"},
    {"def \"A\" {\n int[] a = [[1, 2], [3]]\n}\n", 3, 23, "a row of 1"},
    {"def \"A\" {\n int[] a = [1, [2]]\n}\n", 3, 16, "rows must be alike"},
    {"def \"A\" {\n int[] a = [1 2]\n}\n", 3, 15, "',' or ']'"},
    {"def \"A\" {\n int[] a = [,1]\n}\n", 3, 13, "a 32-bit integer"},
    {"def \"A\" {\n int[] a = [1, 2\n", 4, 1, "the end of the file"},
    {"def \"A\" {\n int[] a = 1\n}\n", 3, 12, "a list in [ ]"},
    {"def \"A\" {\n int a = [1]\n}\n", 3, 10, "a 32-bit integer"},
    {"def \"A\" {\n opaque a = 1\n}\n", 3, 13, "takes no value"},
    {"def \"A\" {\n double a\n float a\n}\n", 4, 2, "was a double on line 3"},
    {"def \"A\" {\n double a\n uniform double a\n}\n", 4, 2, "cannot become uniform"},
    {"def \"A\" {\n double a.mapper = 1\n}\n", 3, 11, "timeSamples, connect or spline"},
    {"def \"A\" {\n double a.timeSamples = { x: 1 }\n}\n", 3, 27, "a time"},
    {"def \"A\" {\n string a.spline = { 0: 1 }\n}\n", 3, 17, "cannot have a spline"},
    {"def \"A\" {\n double a.spline = { loop: (0, 2, 1.5, 1, 5) }\n}\n", 3, 35, "a whole number"},
    {"def \"A\" {\n double a.spline = { pre: linear(2) }\n}\n", 3, 33, "'}'"},
    {"def \"A\" {\n double a.spline = { pre: loop reset(x) }\n}\n", 3, 38, "a number"},
    {"def \"A\" {\n rel a = [</B>, </B>]\n}\n", 3, 10, "are the same"},
    {"def \"A\" {\n rel a = </>\n}\n", 3, 10, "the path of a prim or property"},
    {"def \"A\" {\n rel a = <../../B>\n}\n", 3, 10, "above the root"},
    {"def \"A\" {\n rel a = </B//C>\n}\n", 3, 14, "no well-formed path"},
    {"def \"A\" {\n rel a = </B{v=x}C>\n}\n", 3, 10, "variant selection"},
    {"def \"A\" {\n delete rel a = None\n}\n", 3, 17, "an empty list"},
    {"def \"A\" {\n pathExpression a = \"/a | /b\"\n}\n", 3, 21, "no path expression"},
    {"def \"A\" {\n variantSet \"s\" = { }\n}\n", 3, 21, "a quoted string"},
    {"def \"A\" {\n variantSet \"s s\" = {}\n}\n", 3, 12, "name of a variant"},
    {"def \"A\" ( relocates = {} )\n{}\n", 2, 11, "metadata field"},
    {"def \"A\" ( kind = model )\n{}\n", 2, 18, "a quoted string"},
    {"def \"A\" ( active = \"maybe\" )\n{}\n", 2, 20, "a bool"},
    {"def \"A\" ( active = true hidden = true )\n{}\n", 2, 25, "a line end, ';' or ')'"},
    {"def \"A\" ( permission = some )\n{}\n", 2, 24, "public or private"},
    {"def \"A\" ( primOrder = [\"a\"] )\n{}\n", 2, 11, "cannot be set as metadata"},
    {"def \"A\" ( prepend kind = [\"a\"] )\n{}\n", 2, 19, "the name of a list"},
    {"def \"A\" ( references = @@ )\n{}\n", 2, 24, "empty asset path"},
    {"def \"A\" ( references = </B.c> )\n{}\n", 2, 24, "absolute path of a prim"},
    {"def \"A\" ( payload = @a@ (customData = {}) )\n{}\n", 2, 26, "offset or scale"},
    {"def \"A\" ( customData = { int a = 1, int b = 2 } )\n{}\n", 2, 35, "a line end, ';' or '}'"},
    {"def \"A\" ( customData = { zork a = 1 } )\n{}\n", 2, 26, "the name of a type"},
    {"def \"A\" ( variants = { int a = 1 } )\n{}\n", 2, 22, "expected a string"},
    {"( framesPerSecond = 0 )\n", 2, 3, "not above 0"},
    {"( upAxis = \"Y\" ) )\n", 2, 18, "def, over, class"},
    {"def \"A\" {\n double a = 1 (displayUnit = furlong)\n}\n", 3, 30, "the name of a unit"},
    {"( framesPerSecond = </A> )\n", 2, 21, "a number"},
    {"( unknown = [</A>] )\n", 2, 14, "a value"},
    {"( unknown = (None) )\n", 2, 14, "a value"},
    {"( unknown = ([1]) )\n", 2, 14, "a value"},
    {"( unknown = <a )\n", 2, 13, "no end"},
    {"( add unknown = [None] )\n", 2, 18, "a value"},
    {"def \"A\" ( apiSchemas = {} )\n{}\n", 2, 24, "a list in [ ]"},
    {"def \"A\" ( add apiSchemas = [] )\n{}\n", 2, 29, "a quoted string"},
    {"def \"A\" ( variantSets = [] )\n{}\n", 2, 26, "a quoted string"},
    {"def \"A\" ( variantSets = \"a b\" )\n{}\n", 2, 25, "name of a variant or set"},
    {"def \"A\" ( add variantSets = [\"`a`\"] )\n{}\n", 2, 30, "name of a variant or set"},
    {"def \"A\" {\n zork a.timeSamples = { 0: 1, 1: 2 }\n}\n", 3, 34, "a second value"},
    {"def \"A\" {\n variantSet \"s\" = { \"`a`\" {} }\n}\n", 3, 21, "name of a variant"},
    {"( unknown = [[]] )\n", 2, 15, "a value"},
    {"def \"A\" {\n rel a[</B>] = </C>\n}\n", 3, 14, "a line end"},
    {"def \"A\" {\n rel a[]\n}\n", 3, 7, "a line end"},
    {"def \"A\" {\n rel a = <..>\n}\n", 3, 10, "the path of a prim or property"},
    {"/* no end", 2, 1, "def, over, class"},
};

static void each_mistake_is_found_in_its_place(void **state)
{
    (void)state;
    size_t wrong = 0;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char source[512];
        int length = snprintf(source, sizeof source, "#usda 1.0\n%s", cases[i].text);
        Reports reports;
        CohortError err;
        CoLayer *layer = parse_bytes(source, (size_t)length, NULL, &reports, &err);
        bool good = !layer && reports.line == cases[i].line && reports.column == cases[i].column &&
                    strstr(reports.text, cases[i].says);
        if (!good)
            print_error("%s  reported %u:%u: %s\n  expected %u:%u: %s\n", cases[i].text,
                        reports.line, reports.column, reports.text, cases[i].line, cases[i].column,
                        cases[i].says);
        wrong += !good || err.code != COHORT_ERROR_USDA_SYNTAX || err.line != cases[i].line;
        co_layer_destroy(layer);
    }
    assert_int_equal(wrong, 0);
}

static void headers(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        bool good;
    } headers[] = {
        {"#usda 1.0\n", true},
        {"#usda 1.0", true},
        {"#usda 1.4\r\n", true},
        {"#usda 1.0 x\n", true},
        {"#usda 1.0\r\n(\r\n)\r\n", true},
        {"", false},
        {" \n", false},
        {"#usda 1.5\n", false},
        {"#usda 2.0\n", false},
        {"#usda 1\n", false},
        {"#usda 1.0\r(\r)\r", false},
        {"\xef\xbb\xbf#usda 1.0\n", false},
        {"\n#usda 1.0\n", false},
        {"#sdf 1.4\n", false},
    };
    for (size_t i = 0; i < sizeof headers / sizeof *headers; i++) {
        Reports reports;
        CohortError err;
        CoLayer *layer =
            parse_bytes(headers[i].text, strlen(headers[i].text), NULL, &reports, &err);
        assert_true((layer != NULL) == headers[i].good);
        co_layer_destroy(layer);
    }
}

static void one_file_yields_several_errors(void **state)
{
    (void)state;
    static const char source[] = "#usda 1.0\n"
                                 "def \"A\" (\n    active = 7x\n    kind = model\n)\n{\n"
                                 "    double a = x\n    double b = 1\n    int c = 1e99\n}\n"
                                 "def \"B\" { double d = y\n}\n";
    Reports reports;
    CohortError err;
    assert_null(parse_bytes(source, sizeof source - 1, NULL, &reports, &err));
    assert_true(reports.count >= 5);
    assert_int_equal(reports.line, 3);
    assert_string_equal(reports.prim, "/A");
    assert_string_equal(err.prim_path, "/A");
}

static void limits_hold(void **state)
{
    (void)state;
    static const char deep[] = "#usda 1.0\ndef \"A\" { def \"B\" { def \"C\" {}\n}\n}\n";
    static const char data[] = "#usda 1.0\ndef \"A\" (a = [[[[1]]]]) {}\n";
    static const char array[] = "#usda 1.0\ndef \"A\" { int[] a = [1, 2, 3, 4]\n}\n";
    Reports reports;
    CohortError err;
    CohortStageOptions options = {.max_depth = 2};
    assert_null(parse_bytes(deep, sizeof deep - 1, &options, &reports, &err));
    assert_int_equal(err.code, COHORT_ERROR_LIMIT);
    assert_null(parse_bytes(data, sizeof data - 1, &options, &reports, &err));
    assert_int_equal(err.code, COHORT_ERROR_LIMIT);
    options = (CohortStageOptions){.max_array_length = 3};
    assert_null(parse_bytes(array, sizeof array - 1, &options, &reports, &err));
    assert_int_equal(err.code, COHORT_ERROR_LIMIT);
    options = (CohortStageOptions){.max_prims = 2};
    assert_null(parse_bytes(deep, sizeof deep - 1, &options, &reports, &err));
    assert_int_equal(err.code, COHORT_ERROR_LIMIT);
    options = (CohortStageOptions){.max_bytes = 20};
    assert_null(parse_bytes(array, sizeof array - 1, &options, &reports, &err));
    assert_int_equal(err.code, COHORT_ERROR_LIMIT);
    options = (CohortStageOptions){.max_depth = COHORT_NO_LIMIT, .max_array_length = 4};
    CoLayer *layer = parse_bytes(array, sizeof array - 1, &options, &reports, &err);
    assert_non_null(layer);
    co_layer_destroy(layer);
}

// A megabyte of one thing over and over: refused, and in no time.
static void hostile_repeats_are_refused_quickly(void **state)
{
    (void)state;
    static const char *const repeats[][2] = {
        {"def \"a\" {", "def \"a\" {"},
        {"def \"a\" (x = {dictionary d = {", "dictionary d = {"},
        {"def \"a\" (x = [", "["},
        {"def \"a\" (x = (", "("},
        {"def \"a\" {\nint[] a = [", "["},
        {"def \"a\" {\nrel a = </a", "[/a"},
        {"def \"a\" {\nrel a = <", "../"},
        {"def \"a\" {\npathExpression e = \"", "(~"},
        {"def \"a\" {\npathExpression e = \"/a{", "(not "},
        {"", "/*"},
        {"", "\"\"\"\\"},
        {"", "\"\\"},
        {"x", "'''\\'"},
        {"x ", "@@@ "},
        {"x ", "<"},
        {"", "x\n"},
        {"def \"a\" {\n", "variantSet \"s\" = {\"v\" {"},
        {"def \"a\" {\ndouble a = ", "1"},
        {"def \"a\" {\ndouble[] a = [", "1.5e-7"},
        {"def \"a\" {\ndouble[] a = [1", " "},
        {"def \"a\" {\ndouble[] a = [1,", "/**/"},
    };
    enum {
        CAPACITY = 1000000
    };
    char *source = malloc(CAPACITY + 64);
    assert_non_null(source);
    for (size_t k = 0; k < sizeof repeats / sizeof *repeats; k++) {
        size_t length = (size_t)sprintf(source, "#usda 1.0\n%s", repeats[k][0]);
        while (length < CAPACITY)
            length += (size_t)sprintf(source + length, "%s", repeats[k][1]);
        Reports reports;
        CohortError err;
        double start = co_clock_seconds();
        assert_null(parse_bytes(source, length, NULL, &reports, &err));
        assert_true(co_clock_seconds() - start < 5.0);
        assert_true(err.code == COHORT_ERROR_LIMIT || err.code == COHORT_ERROR_USDA_SYNTAX);
        assert_true(reports.count > 0 && reports.count <= 100);
    }
    free(source);
}

static void files_that_are_no_text(void **state)
{
    (void)state;
    static const struct {
        const char *bytes;
        size_t size;
        CohortErrorCode code;
    } files[] = {
        {"PXR-USDC\0\0\0\0", 12, COHORT_ERROR_USD_BINARY},
        {"PK\3\4rest", 8, COHORT_ERROR_USD_BINARY},
        {"", 0, COHORT_ERROR_USDA_SYNTAX},
    };
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char path[] = "/tmp/cohort-test-XXXXXX";
        int fd = mkstemp(path);
        FILE *file = fd >= 0 ? fdopen(fd, "wb") : NULL;
        assert_non_null(file);
        fwrite(files[i].bytes, 1, files[i].size, file);
        fclose(file);
        Reports reports = {0};
        CohortError err = {0};
        assert_null(co_layer_open(path, NULL, keep_report, &reports, &err));
        assert_int_equal(err.code, files[i].code);
        assert_int_equal(reports.count, 1);
        assert_int_equal(reports.line, 1);
        remove(path);
    }
    CohortError err = {0};
    assert_null(co_layer_open("/tmp", NULL, NULL, NULL, &err));
    assert_int_equal(err.code, COHORT_ERROR_FILE_READ);
    err = (CohortError){0};
    assert_null(co_layer_open("/nowhere/at/all.usda", NULL, NULL, NULL, &err));
    assert_int_equal(err.code, COHORT_ERROR_FILE_NOT_FOUND);
    assert_null(co_layer_open("/nowhere/at/all.usda", NULL, NULL, NULL, NULL));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_mistake_is_found_in_its_place),
        cmocka_unit_test(headers),
        cmocka_unit_test(one_file_yields_several_errors),
        cmocka_unit_test(limits_hold),
        cmocka_unit_test(hostile_repeats_are_refused_quickly),
        cmocka_unit_test(files_that_are_no_text),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
