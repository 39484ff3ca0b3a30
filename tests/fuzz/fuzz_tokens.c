// Any bytes as words and numbers: nothing is read past the end, cursors move as they say they do,
// and numbers mean what the C library says they mean.

#include "fuzz.h"

#include "parse/parser.h"
#include "parse/writer.h"

#include <math.h>
#include <string.h>

static void check_number(const char *begin, const char *end, const CoNumber *number)
{
    char text[512];
    size_t length = (size_t)(end - begin);
    if (length >= sizeof text)
        return;
    memcpy(text, begin, length);
    text[length] = 0;
    double expected = strtod(text, NULL);
    fuzz_require(isnan(expected) ? isnan(number->real) : number->real == expected);
    float narrow = co_number_to_float(number);
    if (!number->is_integer)
        fuzz_require(isnan(narrow) || narrow == (float)expected);
    int64_t whole;
    if (co_number_to_int64(number, INT32_MIN, INT32_MAX, &whole))
        fuzz_require(whole == (int64_t)expected);
}

static void scan_number(CoScan *scan)
{
    const char *begin = scan->at;
    CoNumber number;
    double plain = 0;
    const char *end = scan->safe && begin < scan->safe ? co_number_read(begin, &plain) : NULL;
    CoScanStatus status = co_scan_number(scan, &number);
    fuzz_require(status == CO_SCAN_OK ? scan->at > begin : scan->at == begin);
    if (status == CO_SCAN_OK)
        check_number(begin, scan->at, &number);
    if (end)
        fuzz_require(status == CO_SCAN_OK && end == scan->at && plain == number.real);
}

// What stands between quotes or brackets, in a buffer of just its size.
static void look_inside(CoSlice slice)
{
    char *copy = malloc(slice.length ? slice.length : 1);
    fuzz_require(copy != NULL);
    fuzz_require(co_scan_unescape(slice, copy) <= slice.length);
    if (slice.length)
        memcpy(copy, slice.begin, slice.length);
    CoSlice own = {copy, slice.length};
    CoPathInfo info;
    size_t bad = 0;
    if (!co_path_check(own, &info, &bad))
        fuzz_require(bad <= slice.length);
    bad = 0;
    if (!co_expression_check(copy, slice.length, &bad))
        fuzz_require(bad <= slice.length);
    co_slice_is_identifier(own);
    free(copy);
}

static void scan_text(CoScan *scan)
{
    const char *begin = scan->at;
    CoSlice slice = {begin, 0};
    bool triple;
    CoScanStatus status = co_scan_string(scan, &slice);
    if (status == CO_SCAN_NONE)
        status = co_scan_asset(scan, &slice, &triple);
    if (status == CO_SCAN_NONE)
        status = co_scan_path(scan, &slice);
    fuzz_require(status == CO_SCAN_OK ? scan->at > begin : scan->at == begin);
    if (status == CO_SCAN_OK) {
        fuzz_require(slice.begin > begin && slice.begin + slice.length < scan->at);
        look_inside(slice);
    }
}

static void scan_word(CoScan *scan)
{
    const char *begin = scan->at;
    CoSlice slice;
    if (co_scan_type_name(scan, &slice) || co_scan_namespaced(scan, &slice) ||
        co_scan_identifier(scan, &slice))
        fuzz_require(slice.begin == begin && slice.begin + slice.length == scan->at);
    else
        fuzz_require(scan->at == begin);
}

// Eight bytes as a number: written shortest, they mean the same.
static void format_number(const uint8_t bytes[8])
{
    char text[CO_NUMBER_TEXT + 1];
    double value;
    float narrow;
    memcpy(&value, bytes, sizeof value);
    memcpy(&narrow, bytes, sizeof narrow);
    text[co_format_double(value, text)] = 0;
    fuzz_require(isnan(value) || strtod(text, NULL) == value);
    text[co_format_float(narrow, text)] = 0;
    fuzz_require(isnan(narrow) || strtof(text, NULL) == narrow);
    uint16_t half = co_half_from_float(narrow);
    float back = co_half_to_float(half);
    fuzz_require(isnan(narrow) || co_half_from_float(back) == half);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size >= 8)
        format_number(data);
    if (!size)
        return 0;
    CoScan scan;
    co_scan_init(&scan, (const char *)data, size);
    while (scan.at < scan.end) {
        const char *begin = scan.at;
        scan_number(&scan);
        scan_text(&scan);
        scan_word(&scan);
        co_scan_space(&scan);
        fuzz_require(scan.at >= begin && scan.at <= scan.end);
        scan.at += scan.at == begin;
    }
    uint32_t line, column;
    co_scan_place(&scan, scan.end, &line, &column);
    fuzz_require(line >= 1 && line <= size + 1 && column >= 1 && column <= size + 1);
    look_inside((CoSlice){(const char *)data, size});
    return 0;
}
