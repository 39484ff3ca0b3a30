// Numbers as USDA spells them, correctly rounded, and half floats.
//
// number = ["-"] (digits ["." digits*] | "." digits | "inf") [exponent] | "nan"
// The text need not be NUL-terminated: every read stops at CoScan.end.

#ifndef CO_LEX_NUMBER_H
#define CO_LEX_NUMBER_H

#include "lex/scan.h"

#include <string.h>

// Integers that fit keep all their bits; everything else is a double.
typedef struct CoNumber {
    bool is_integer;
    bool is_negative;
    uint64_t magnitude; // of an integer
    double real;        // always set: the nearest double
} CoNumber;

// CO_SCAN_OPEN: it begins like a number but is none ("1e", ".", "-.").
CoScanStatus co_scan_number(CoScan *scan, CoNumber *out);

// ---- The loops of large arrays -----------------------------------------------------------------
// What follows reads from places before CoScan.safe, eight characters at once.

// The digits that stand at `at`, at most eight, as values of bytes in order, the first in the
// lowest; returns how many.
static inline unsigned co_digits_load(const char *at, uint64_t *digits)
{
    uint64_t word;
    memcpy(&word, at, sizeof word);
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    word = __builtin_bswap64(word);
#endif
    word ^= UINT64_C(0x3030303030303030);
    *digits = word;
    // A byte above 9 reaches its top bit, or had it.
    uint64_t other = ((word & UINT64_C(0x7f7f7f7f7f7f7f7f)) + UINT64_C(0x7676767676767676)) | word;
    other &= UINT64_C(0x8080808080808080);
    return other ? (unsigned)__builtin_ctzll(other) / 8 : 8;
}

// The number that the first `count` digits make, count from 1 to 8: pairs, then fours, then all.
static inline uint64_t co_digits_value(uint64_t digits, unsigned count)
{
    const uint64_t mask = UINT64_C(0x000000ff000000ff);
    digits <<= 64 - 8 * count;
    digits = digits * 10 + (digits >> 8);
    return ((digits & mask) * UINT64_C(0x000f424000000064) +
            (digits >> 16 & mask) * UINT64_C(0x0000271000000001)) >>
           32;
}

// 1, 10 ... 10^22: the powers of ten that a double holds exactly.
extern const double co_exact_powers[23];

// Any plain decimal number at `at`; returns its end, or NULL when co_scan_number must judge it.
// Same result as that.
const char *co_number_read_any(const char *at, double *out);

// The same, quick for what meshes hold: up to seven digits, a point, up to eight more.
static inline const char *co_number_read(const char *at, double *out)
{
    uint64_t digits;
    bool negative = *at == '-';
    const char *p = at + negative;
    unsigned whole = co_digits_load(p, &digits);
    if (whole - 1 > 6)
        return co_number_read_any(at, out);
    double value = (double)(int64_t)co_digits_value(digits, whole);
    p += whole;
    if (*p == '.') {
        unsigned more = co_digits_load(++p, &digits);
        if (more == 0)
            return co_number_read_any(at, out);
        // Below 10^15, and one division rounds correctly.
        value = value * co_exact_powers[more] + (double)(int64_t)co_digits_value(digits, more);
        value /= co_exact_powers[more];
        p += more;
    }
    if ((unsigned char)(*p - '0') < 10 || (*p | 32) == 'e')
        return co_number_read_any(at, out);
    *out = negative ? -value : value;
    return p;
}

// A 32-bit integer at `at`; returns its end, or NULL when it is none, or has a fraction or
// exponent.
static inline const char *co_integer_read(const char *at, int32_t *out)
{
    uint64_t digits, value;
    bool negative = *at == '-';
    const char *p = at + negative;
    unsigned count = co_digits_load(p, &digits);
    if (count == 0)
        return NULL;
    value = co_digits_value(digits, count);
    p += count;
    if (count == 8)
        for (; (unsigned char)(*p - '0') < 10 && value <= INT32_MAX; p++)
            value = value * 10 + (uint64_t)(*p - '0');
    if (value > (uint64_t)INT32_MAX + negative || *p == '.' || (*p | 32) == 'e')
        return NULL;
    *out = (int32_t)(negative ? -(int64_t)value : (int64_t)value);
    return p;
}

// ---- Conversions -------------------------------------------------------------------------------

// Range-checked conversions, fractions cut off; false when the value does not fit.
bool co_number_to_int64(const CoNumber *number, int64_t least, int64_t most, int64_t *out);
bool co_number_to_uint64(const CoNumber *number, uint64_t most, uint64_t *out);
// One rounding from the integer, or from the double.
float co_number_to_float(const CoNumber *number);

// IEEE binary16, round to nearest even; overflow gives infinity.
uint16_t co_half_from_float(float value);
float co_half_to_float(uint16_t half);

#endif
