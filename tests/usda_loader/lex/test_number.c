// Numbers: correct rounding against the C library, edges of every type, what is no number, halves.

#include "lex/number.h"

#include "base/hash.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static CoScanStatus read_text(const char *text, CoNumber *out, size_t *used)
{
    CoScan scan;
    co_scan_init(&scan, text, strlen(text));
    CoScanStatus status = co_scan_number(&scan, out);
    *used = (size_t)(scan.at - text);
    return status;
}

// All of the text is one number, and the nearest double to it, whichever way it is read.
static void check_real(const char *text)
{
    CoNumber number;
    size_t used;
    assert_int_equal(read_text(text, &number, &used), CO_SCAN_OK);
    assert_int_equal(used, strlen(text));
    double expected = strtod(text, NULL), fast = 0.0;
    assert_memory_equal(&number.real, &expected, sizeof expected);
    char copy[2048 + CO_SCAN_AHEAD] = {0};
    assert_true(used < sizeof copy - CO_SCAN_AHEAD);
    memcpy(copy, text, used);
    const char *(*const readers[])(const char *, double *) = {co_number_read, co_number_read_any};
    for (int i = 0; i < 2; i++) {
        const char *stop = readers[i](copy, &fast);
        if (stop) {
            assert_ptr_equal(stop, copy + used);
            assert_memory_equal(&fast, &expected, sizeof expected);
        }
    }
}

static void known_cases_round_correctly(void **state)
{
    (void)state;
    static const char *const cases[] = {
        "0",
        "-0.0",
        "1",
        "0.1",
        "0.3",
        "1e22",
        "1e23",
        "9007199254740993",
        "9007199254740993.0000000000000000000000001",
        "9007199254740992.9999999999999999999999999",
        "2.2250738585072011e-308",
        "2.2250738585072014e-308",
        "4.9406564584124654e-324",
        "2.4703282292062327e-324",
        "2.4703282292062328e-324",
        "1.7976931348623157e308",
        "1.7976931348623159e308",
        "1e400",
        "1e-400",
        "123456789012345678901234567890",
        "0.000000000000000000000000000001234567890123456789",
        "6.0221407e+23",
        ".5",
        "5.",
        "5.e2",
        "007",
        "3.14159265358979323846264338327950288",
        "1.00000000000000011102230246251565404",
        "1.00000000000000011102230246251565405",
        "179769313486231580793e289",
        "0e99999999999",
        "1e99999999999",
        "1e-99999999999",
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        check_real(cases[i]);
}

static void random_decimals_round_correctly(void **state)
{
    (void)state;
    char text[64];
    for (uint64_t i = 0; i < 60000; i++) {
        uint64_t bits = co_hash64(i);
        double value;
        memcpy(&value, &bits, sizeof value);
        if (isfinite(value)) {
            snprintf(text, sizeof text, "%.*g", 1 + (int)(i % 20), value);
            if (!strchr(text, 'n'))
                check_real(text);
        }
        double mesh = ((double)(bits >> 40) - 8388608.0) / 10000.0;
        snprintf(text, sizeof text, "%.*f", (int)(i % 18), mesh);
        check_real(text);
    }
}

static void a_tie_far_behind_the_point_is_seen(void **state)
{
    (void)state;
    // 2^53 + 1 lies midway; a single digit a thousand places on decides.
    char text[1200];
    size_t length = (size_t)snprintf(text, sizeof text, "9007199254740993.");
    memset(text + length, '0', 1000);
    strcpy(text + length + 1000, "1");
    CoNumber number;
    size_t used;
    CoScan scan;
    char whole[1300];
    snprintf(whole, sizeof whole, "%s}", text);
    co_scan_init(&scan, whole, strlen(whole));
    assert_int_equal(co_scan_number(&scan, &number), CO_SCAN_OK);
    assert_true(number.real == 9007199254740994.0);
    assert_int_equal(read_text("9007199254740993.0", &number, &used), CO_SCAN_OK);
    assert_true(number.real == 9007199254740992.0);
}

static void what_is_no_number_is_left(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        CoScanStatus status;
    } cases[] = {
        {"", CO_SCAN_NONE},         {"+1", CO_SCAN_NONE},  {"x", CO_SCAN_NONE},
        {"NaN", CO_SCAN_NONE},      {"Inf", CO_SCAN_NONE}, {"nano", CO_SCAN_NONE},
        {"infinity", CO_SCAN_NONE}, {"-", CO_SCAN_OPEN},   {".", CO_SCAN_OPEN},
        {"-.", CO_SCAN_OPEN},       {"1e", CO_SCAN_OPEN},  {"1e+", CO_SCAN_OPEN},
        {"-nan", CO_SCAN_OPEN},     {"- 1", CO_SCAN_OPEN},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        CoNumber number;
        size_t used;
        assert_int_equal(read_text(cases[i].text, &number, &used), cases[i].status);
        assert_int_equal(used, 0);
    }
}

static void infinities_and_nan_are_words(void **state)
{
    (void)state;
    CoNumber number;
    size_t used;
    assert_int_equal(read_text("inf", &number, &used), CO_SCAN_OK);
    assert_true(isinf(number.real) && number.real > 0);
    assert_int_equal(read_text("-inf,", &number, &used), CO_SCAN_OK);
    assert_true(isinf(number.real) && number.real < 0);
    assert_int_equal(used, 4);
    assert_int_equal(read_text("nan", &number, &used), CO_SCAN_OK);
    assert_true(isnan(number.real));
}

static void integers_keep_their_bits(void **state)
{
    (void)state;
    CoNumber number;
    size_t used;
    int64_t s;
    uint64_t u;
    read_text("18446744073709551615", &number, &used);
    assert_true(co_number_to_uint64(&number, UINT64_MAX, &u));
    assert_true(u == UINT64_MAX);
    assert_false(co_number_to_int64(&number, INT64_MIN, INT64_MAX, &s));
    read_text("18446744073709551616", &number, &used);
    assert_false(co_number_to_uint64(&number, UINT64_MAX, &u));
    read_text("-9223372036854775808", &number, &used);
    assert_true(co_number_to_int64(&number, INT64_MIN, INT64_MAX, &s));
    assert_true(s == INT64_MIN);
    read_text("-9223372036854775809", &number, &used);
    assert_false(co_number_to_int64(&number, INT64_MIN, INT64_MAX, &s));
    read_text("2147483648", &number, &used);
    assert_false(co_number_to_int64(&number, INT32_MIN, INT32_MAX, &s));
    read_text("-1.9", &number, &used);
    assert_true(co_number_to_int64(&number, INT32_MIN, INT32_MAX, &s));
    assert_int_equal(s, -1);
    assert_false(co_number_to_uint64(&number, UINT32_MAX, &u));
    read_text("-0.5", &number, &used);
    assert_true(co_number_to_uint64(&number, 255, &u));
    assert_int_equal(u, 0);
    read_text("256", &number, &used);
    assert_false(co_number_to_uint64(&number, 255, &u));
    read_text("inf", &number, &used);
    assert_false(co_number_to_int64(&number, INT64_MIN, INT64_MAX, &s));
    read_text("nan", &number, &used);
    assert_false(co_number_to_uint64(&number, UINT64_MAX, &u));
    read_text("16777217", &number, &used);
    assert_true(co_number_to_float(&number) == 16777216.0f);
}

static void every_half_survives(void **state)
{
    (void)state;
    for (uint32_t bits = 0; bits < 0x10000; bits++) {
        float value = co_half_to_float((uint16_t)bits);
        uint16_t back = co_half_from_float(value);
        if (isnan(value))
            assert_true((back & 0x7c00) == 0x7c00 && (back & 0x3ff));
        else
            assert_int_equal(back, bits);
    }
}

static void halves_round_to_even(void **state)
{
    (void)state;
    for (uint32_t bits = 0; bits < 0x7bff; bits++) {
        float low = co_half_to_float((uint16_t)bits), high = co_half_to_float((uint16_t)(bits + 1));
        float middle = 0.5f * (low + high);
        assert_int_equal(co_half_from_float(middle), bits & 1 ? bits + 1 : bits);
        assert_int_equal(co_half_from_float(nextafterf(middle, 0.0f)), bits);
        assert_int_equal(co_half_from_float(nextafterf(middle, 1e6f)), bits + 1);
    }
    assert_int_equal(co_half_from_float(65519.996f), 0x7bff);
    assert_int_equal(co_half_from_float(65520.0f), 0x7c00);
    assert_int_equal(co_half_from_float(-FLT_MAX), 0xfc00);
    assert_int_equal(co_half_from_float(FLT_MIN), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_cases_round_correctly),
        cmocka_unit_test(random_decimals_round_correctly),
        cmocka_unit_test(a_tie_far_behind_the_point_is_seen),
        cmocka_unit_test(what_is_no_number_is_left),
        cmocka_unit_test(infinities_and_nan_are_words),
        cmocka_unit_test(integers_keep_their_bits),
        cmocka_unit_test(every_half_survives),
        cmocka_unit_test(halves_round_to_even),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
