// What JSON readers must be able to take, whatever bytes a name has.

#include "cli/json_text.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static void assert_printed(const char *text, const char *expected)
{
    char out[256] = {0};
    FILE *file = fmemopen(out, sizeof out, "w");
    assert_non_null(file);
    json_print_text(text, file);
    fclose(file);
    assert_string_equal(out, expected);
}

static void plain_text_stays(void **state)
{
    (void)state;
    assert_printed("a/b.usda", "\"a/b.usda\"");
    assert_printed("", "\"\"");
    assert_printed(NULL, "\"\"");
    assert_printed("caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x8d\x8e",
                   "\"caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x8d\x8e\"");
    assert_printed("\xed\x9f\xbf\xf4\x8f\xbf\xbf", "\"\xed\x9f\xbf\xf4\x8f\xbf\xbf\"");
}

static void quotes_and_controls_are_escaped(void **state)
{
    (void)state;
    assert_printed("a\"b\\c", "\"a\\\"b\\\\c\"");
    assert_printed("a\nb\t\x01\x1f", "\"a\\u000ab\\u0009\\u0001\\u001f\"");
}

static void what_is_no_utf8_is_replaced(void **state)
{
    (void)state;
    assert_printed("\xe9", "\"\\ufffd\""); // Latin-1
    assert_printed("caf\xe9!", "\"caf\\ufffd!\"");
    assert_printed("\xff\x80", "\"\\ufffd\\ufffd\"");
    assert_printed("\xc0\x80", "\"\\ufffd\\ufffd\""); // longer than need be
    assert_printed("\xe0\x9f\xbf", "\"\\ufffd\\ufffd\\ufffd\"");
    assert_printed("\xf0\x8f\xbf\xbf", "\"\\ufffd\\ufffd\\ufffd\\ufffd\"");
    assert_printed("\xed\xa0\x80", "\"\\ufffd\\ufffd\\ufffd\""); // a surrogate
    assert_printed("\xf4\x90\x80\x80", "\"\\ufffd\\ufffd\\ufffd\\ufffd\"");
    assert_printed("\xe2\x82", "\"\\ufffd\\ufffd\""); // cut short
    assert_printed("\xe2\"", "\"\\ufffd\\\"\"");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plain_text_stays),
        cmocka_unit_test(quotes_and_controls_are_escaped),
        cmocka_unit_test(what_is_no_utf8_is_replaced),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
