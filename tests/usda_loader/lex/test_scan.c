// White space, words, strings, asset and path references, places.

#include "lex/scan.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static CoScan scan_of(const char *text)
{
    CoScan scan;
    co_scan_init(&scan, text, strlen(text));
    return scan;
}

static void padding_stops_where_it_should(void **state)
{
    (void)state;
    CoScan scan = scan_of(" \t/* a\n b */ # c\n // d\n\r x");
    assert_true(co_scan_inline(&scan));
    assert_int_equal(co_scan_peek(&scan), '#');
    assert_true(co_scan_line(&scan));
    assert_int_equal(co_scan_peek(&scan), '\n');
    assert_true(co_scan_space(&scan));
    assert_int_equal(co_scan_peek(&scan), 'x');
    assert_false(co_scan_space(&scan));
}

static void a_comment_without_end_is_no_padding(void **state)
{
    (void)state;
    CoScan scan = scan_of("/* a *");
    assert_false(co_scan_space(&scan));
    scan = scan_of("/*/");
    assert_false(co_scan_inline(&scan));
    scan = scan_of("/**/x");
    assert_true(co_scan_inline(&scan));
    assert_int_equal(co_scan_peek(&scan), 'x');
}

static void a_gap_needs_a_blank(void **state)
{
    (void)state;
    CoScan scan = scan_of("/*a*/x");
    assert_false(co_scan_gap(&scan));
    assert_int_equal(co_scan_peek(&scan), '/');
    scan = scan_of("/*a*/ x");
    assert_true(co_scan_gap(&scan));
    assert_int_equal(co_scan_peek(&scan), 'x');
}

static void words_end_at_their_end(void **state)
{
    (void)state;
    CoScan scan = scan_of("define");
    assert_false(co_scan_word(&scan, "def"));
    assert_true(co_scan_word(&scan, "define"));
    assert_false(co_scan_word(&scan, "x"));
    scan = scan_of("a:b::c");
    CoSlice slice;
    assert_true(co_scan_namespaced(&scan, &slice));
    assert_int_equal(slice.length, 3);
    scan = scan_of("1a");
    assert_false(co_scan_identifier(&scan, &slice));
    scan = scan_of("caf\xc3\xa9!");
    assert_true(co_scan_identifier(&scan, &slice));
    assert_int_equal(slice.length, 5);
    scan = scan_of("a\xe2\x88\xab"); // an integral sign is no letter
    assert_true(co_scan_identifier(&scan, &slice));
    assert_int_equal(slice.length, 1);
}

static void strings_in_four_forms(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        CoScanStatus status;
        size_t length;
    } cases[] = {
        {"\"a\"", CO_SCAN_OK, 1},     {"'a'", CO_SCAN_OK, 1},
        {"\"\"", CO_SCAN_OK, 0},      {"\"\"\"a\nb\"\"\"", CO_SCAN_OK, 3},
        {"'''a'b'''", CO_SCAN_OK, 3}, {"\"a\\\"b\"", CO_SCAN_OK, 4},
        {"\"a\\\\\"", CO_SCAN_OK, 3}, {"\"a\n\"", CO_SCAN_OPEN, 0},
        {"\"a", CO_SCAN_OPEN, 0},     {"\"\"\"a\"\"", CO_SCAN_OPEN, 0},
        {"\"\\", CO_SCAN_OPEN, 0},    {"a", CO_SCAN_NONE, 0},
        {"", CO_SCAN_NONE, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        CoScan scan = scan_of(cases[i].text);
        CoSlice slice = {NULL, 0};
        assert_int_equal(co_scan_string(&scan, &slice), cases[i].status);
        assert_int_equal(slice.length, cases[i].length);
        assert_true((scan.at == scan.end) == (cases[i].status == CO_SCAN_OK || !*cases[i].text));
    }
}

static void escapes_are_undone(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        {"a\\tb\\n", "a\tb\n"}, {"\\x41\\x4a", "AJ"}, {"\\101\\60", "A0"}, {"\\q\\\\", "q\\"},
        {"\\\"\\'", "\"'"},     {"\\", "\\"},         {"\\d", "d"},        {"\\8", "8"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char out[32] = {0};
        CoSlice slice = {cases[i][0], strlen(cases[i][0])};
        size_t length = co_scan_unescape(slice, out);
        assert_int_equal(length, strlen(cases[i][1]));
        assert_string_equal(out, cases[i][1]);
    }
}

static void assets_and_paths(void **state)
{
    (void)state;
    CoSlice slice;
    bool triple;
    CoScan scan = scan_of("@a b@x");
    assert_int_equal(co_scan_asset(&scan, &slice, &triple), CO_SCAN_OK);
    assert_false(triple);
    assert_int_equal(slice.length, 3);
    scan = scan_of("@@@a@b@@@@@");
    assert_int_equal(co_scan_asset(&scan, &slice, &triple), CO_SCAN_OK);
    assert_true(triple);
    assert_int_equal(slice.length, 5);
    assert_ptr_equal(scan.at, scan.end);
    scan = scan_of("@@@a\\@@@b@@@");
    assert_int_equal(co_scan_asset(&scan, &slice, &triple), CO_SCAN_OK);
    assert_int_equal(slice.length, 6);
    scan = scan_of("@a\n@");
    assert_int_equal(co_scan_asset(&scan, &slice, &triple), CO_SCAN_OPEN);
    scan = scan_of("</a.b>c");
    assert_int_equal(co_scan_path(&scan, &slice), CO_SCAN_OK);
    assert_int_equal(slice.length, 4);
    scan = scan_of("<a");
    assert_int_equal(co_scan_path(&scan, &slice), CO_SCAN_OPEN);
}

static void places_count_lines_and_columns(void **state)
{
    (void)state;
    CoScan scan = scan_of("a\nbc\n\nd");
    uint32_t line, column;
    co_scan_place(&scan, scan.begin + 3, &line, &column);
    assert_int_equal(line, 2);
    assert_int_equal(column, 2);
    co_scan_place(&scan, scan.end, &line, &column);
    assert_int_equal(line, 4);
    assert_int_equal(column, 2);
    co_scan_place(&scan, scan.begin, &line, &column); // backwards too
    assert_int_equal(line, 1);
    assert_int_equal(column, 1);
}

static void ill_formed_utf8_has_no_length(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "\x80", "\xc0\x80",     "\xe0\x80\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80",
        "\xc3", "\xf0\x9f\x98", "\xff"};
    uint32_t code;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(co_utf8_decode(bad[i], bad[i] + strlen(bad[i]), &code), 0);
    const char *smile = "\xf0\x9f\x98\x80";
    assert_int_equal(co_utf8_decode(smile, smile + 4, &code), 4);
    assert_int_equal(code, 0x1f600);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(padding_stops_where_it_should),
        cmocka_unit_test(a_comment_without_end_is_no_padding),
        cmocka_unit_test(a_gap_needs_a_blank),
        cmocka_unit_test(words_end_at_their_end),
        cmocka_unit_test(strings_in_four_forms),
        cmocka_unit_test(escapes_are_undone),
        cmocka_unit_test(assets_and_paths),
        cmocka_unit_test(places_count_lines_and_columns),
        cmocka_unit_test(ill_formed_utf8_has_no_length),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
