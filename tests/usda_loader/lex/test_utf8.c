// UTF-8: what the standard allows, all of it, and nothing else; what names may begin with.

#include "lex/scan.h"

#include <string.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static size_t encode(uint32_t code, char out[4])
{
    if (code < 0x80) {
        out[0] = (char)code;
        return 1;
    }
    size_t length = code < 0x800 ? 2 : code < 0x10000 ? 3 : 4;
    for (size_t i = length; i-- > 1; code >>= 6)
        out[i] = (char)(0x80 | (code & 0x3f));
    out[0] = (char)((0xf0u << (4 - length)) | code);
    return length;
}

static void every_code_is_read_back(void **state)
{
    (void)state;
    for (uint32_t code = 0; code < 0x110000; code++) {
        char bytes[4];
        uint32_t got = ~0u;
        size_t length = encode(code, bytes);
        bool is_surrogate = code >= 0xd800 && code < 0xe000;
        assert_int_equal(co_utf8_decode(bytes, bytes + length, &got), is_surrogate ? 0 : length);
        if (!is_surrogate)
            assert_int_equal(got, code);
        for (size_t cut = 0; cut < length; cut++)
            assert_int_equal(co_utf8_decode(bytes, bytes + cut, &got), 0);
    }
}

static void nothing_else_is_read(void **state)
{
    (void)state;
    const struct {
        const char *bytes;
        size_t length;
    } bad[] = {
        {"\x80", 1}, // goes on with nothing
        {"\xbf", 1},
        {"\xc0\x80", 2},         // 0 in two bytes
        {"\xc1\xbf", 2},         // 0x7f in two
        {"\xe0\x9f\xbf", 3},     // 0x7ff in three
        {"\xf0\x8f\xbf\xbf", 4}, // 0xffff in four
        {"\xf4\x90\x80\x80", 4}, // beyond the last
        {"\xf5\x80\x80\x80", 4},
        {"\xff", 1},
        {"\xfe\x80\x80\x80", 4},
        {"\xc3(", 2},
        {"\xe2\x82(", 3},
        {"\xf0\x9f\x98(", 4},
        {"\xe2(\xac", 3},
        {"\xf0(\x8c\xbc", 4},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        uint32_t code = 7;
        assert_int_equal(co_utf8_decode(bad[i].bytes, bad[i].bytes + bad[i].length, &code), 0);
        assert_int_equal(code, 7);
    }
}

// What two bytes may be: decoded if and only if they are a code below 0x800 in its shortest form.
static void all_pairs_of_bytes(void **state)
{
    (void)state;
    for (uint32_t pair = 0; pair < 0x10000; pair++) {
        char bytes[2] = {(char)(pair >> 8), (char)pair}, back[4];
        uint32_t code = 0;
        size_t length = co_utf8_decode(bytes, bytes + 2, &code);
        if (length)
            assert_true(encode(code, back) == length && memcmp(back, bytes, length) == 0);
        else
            assert_true(pair >= 0x8000);
    }
}

static void names_begin_with_letters(void **state)
{
    (void)state;
    for (uint32_t code = 0; code < 0x80; code++) {
        bool is_letter =
            (code >= 'a' && code <= 'z') || (code >= 'A' && code <= 'Z') || code == '_';
        bool is_digit = code >= '0' && code <= '9';
        assert_int_equal(co_utf8_is_xid_start(code), is_letter);
        assert_int_equal(co_utf8_is_xid_continue(code), is_letter || is_digit);
    }
    const uint32_t letters[] = {0xe9, 0x3b1, 0x416, 0x5d0, 0x4e2d, 0x10400, 0x20000};
    for (size_t i = 0; i < sizeof letters / sizeof *letters; i++)
        assert_true(co_utf8_is_xid_start(letters[i]) && co_utf8_is_xid_continue(letters[i]));
    const uint32_t marks[] = {0x300, 0x660, 0xb7}; // an accent, a digit, the middle dot
    for (size_t i = 0; i < sizeof marks / sizeof *marks; i++)
        assert_true(!co_utf8_is_xid_start(marks[i]) && co_utf8_is_xid_continue(marks[i]));
    const uint32_t others[] = {0x20ac, 0x2028, 0x1f600, 0xd800, 0xffff, 0x10ffff, UINT32_MAX};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        assert_true(!co_utf8_is_xid_start(others[i]) && !co_utf8_is_xid_continue(others[i]));
    // What may begin a name may go on in it.
    for (uint32_t code = 0; code < 0x110000; code++)
        assert_true(!co_utf8_is_xid_start(code) || co_utf8_is_xid_continue(code));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_code_is_read_back),
        cmocka_unit_test(nothing_else_is_read),
        cmocka_unit_test(all_pairs_of_bytes),
        cmocka_unit_test(names_begin_with_letters),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
