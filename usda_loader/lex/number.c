#include "lex/number.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// Powers of ten that a double, and an 80-bit extended double, hold exactly.
const double co_exact_powers[23] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                    1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                    1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
#if LDBL_MANT_DIG == 64
static const long double wide_powers[] = {1e0L,  1e1L,  1e2L,  1e3L,  1e4L,  1e5L,  1e6L,
                                          1e7L,  1e8L,  1e9L,  1e10L, 1e11L, 1e12L, 1e13L,
                                          1e14L, 1e15L, 1e16L, 1e17L, 1e18L, 1e19L, 1e20L,
                                          1e21L, 1e22L, 1e23L, 1e24L, 1e25L, 1e26L, 1e27L};
#endif

static inline bool is_digit(char c)
{
    return (unsigned char)(c - '0') < 10;
}

// mantissa * 10^exponent when one correctly rounded operation gives it (Clinger 1990): both
// operands are exact. The second step does the same in 64 bits of mantissa and gives up where
// rounding twice could differ from rounding once.
static inline bool scale_exactly(uint64_t mantissa, int exponent, double *out)
{
    if (mantissa >> 53 == 0 && exponent >= -22 && exponent <= 22) {
        double value = (double)mantissa;
        *out =
            exponent < 0 ? value / co_exact_powers[-exponent] : value * co_exact_powers[exponent];
        return true;
    }
#if LDBL_MANT_DIG == 64
    if (mantissa && exponent >= -27 && exponent <= 27) {
        long double value = (long double)mantissa;
        value = exponent < 0 ? value / wide_powers[-exponent] : value * wide_powers[exponent];
        uint64_t bits;
        memcpy(&bits, &value, sizeof bits);
        if ((bits & 0x7ff) != 0x400) {
            *out = (double)value;
            return true;
        }
    }
#endif
    return false;
}

// Any decimal: hands the significant digits to strtod as an integer with an exponent, so that no
// locale's decimal point comes in. Digits past 800 can only break a tie, which a last 1 does too.
static double scale_slowly(const char *at, const char *stop, int64_t exponent)
{
    char text[840];
    size_t length = 0;
    bool more = false, in_fraction = false;
    for (; at < stop && *at != 'e' && *at != 'E'; at++) {
        if (*at == '.') {
            in_fraction = true;
            continue;
        }
        exponent -= in_fraction;
        if (length == 0 && *at == '0')
            continue;
        if (length < 800) {
            text[length++] = *at;
        } else {
            more |= *at != '0';
            exponent++;
        }
    }
    if (length == 0)
        return 0.0;
    if (more) {
        text[length++] = '1';
        exponent--;
    }
    exponent = exponent > 99999 ? 99999 : exponent < -99999 ? -99999 : exponent;
    text[length++] = 'e';
    if (exponent < 0)
        text[length++] = '-';
    unsigned rest = (unsigned)(exponent < 0 ? -exponent : exponent);
    for (unsigned unit = 10000; unit; unit /= 10)
        text[length++] = (char)('0' + rest / unit % 10);
    text[length] = '\0';
    return strtod(text, NULL);
}

typedef struct Decimal {
    const char *digits; // past the sign
    const char *stop;
    uint64_t mantissa; // wrong past 19 digits
    size_t digit_count;
    int64_t exponent; // of the mantissa
    int64_t written;  // exponent as written
    double real;      // set where the text does not outlive the decimal
    bool negative, is_integer;
} Decimal;

// Digits, point, digits; then an exponent. False when no number stands here.
static inline bool read_decimal(const char *p, Decimal *out)
{
    out->negative = *p == '-';
    p += out->negative;
    out->digits = p;
    uint64_t mantissa = 0;
    while (*p == '0')
        p++;
    const char *first = p;
    while (is_digit(*p))
        mantissa = mantissa * 10 + (uint64_t)(*p++ - '0');
    size_t whole = (size_t)(p - out->digits);
    size_t significant = (size_t)(p - first);
    int64_t exponent = 0;
    out->is_integer = *p != '.';
    if (*p == '.') {
        const char *fraction = ++p;
        while (!mantissa && *p == '0')
            p++;
        first = p;
        while (is_digit(*p))
            mantissa = mantissa * 10 + (uint64_t)(*p++ - '0');
        exponent = -(p - fraction);
        significant += (size_t)(p - first);
        if (!whole && p == fraction)
            return false;
    } else if (!whole) {
        return false;
    }
    out->written = 0;
    if (*p == 'e' || *p == 'E') {
        out->is_integer = false;
        bool down = *++p == '-';
        p += *p == '-' || *p == '+';
        if (!is_digit(*p))
            return false;
        for (; is_digit(*p); p++)
            if (out->written < 1000000)
                out->written = out->written * 10 + (*p - '0');
        if (down)
            out->written = -out->written;
    }
    out->stop = p;
    out->mantissa = mantissa;
    out->digit_count = significant;
    out->exponent = exponent + out->written;
    return true;
}

static inline double decimal_value(const Decimal *decimal)
{
    double value;
    bool exact = decimal->digit_count <= 19 && decimal->exponent >= -64 &&
                 decimal->exponent <= 64 &&
                 scale_exactly(decimal->mantissa, (int)decimal->exponent, &value);
    if (!exact)
        value = scale_slowly(decimal->digits, decimal->stop, decimal->written);
    return decimal->negative ? -value : value;
}

const char *co_number_read_any(const char *at, double *out)
{
    // Most often a few whole digits, a point, and up to 16 more.
    const char *p = at;
    bool negative = *p == '-';
    p += negative;
    uint64_t mantissa = 0;
    const char *first = p;
    while (is_digit(*p))
        mantissa = mantissa * 10 + (uint64_t)(*p++ - '0');
    size_t count = (size_t)(p - first);
    int exponent = 0;
    if (*p == '.') {
        const char *fraction = ++p;
        while (is_digit(*p))
            mantissa = mantissa * 10 + (uint64_t)(*p++ - '0');
        exponent = -(int)(p - fraction);
        count += (size_t)(p - fraction);
    }
    // Whole numbers past 2^53 keep their bits only in co_scan_number.
    if (exponent == 0 && mantissa >> 53)
        return NULL;
    if (count - 1 < 19 && *p != 'e' && *p != 'E') {
        double value;
        if (scale_exactly(mantissa, exponent, &value)) {
            *out = negative ? -value : value;
            return p;
        }
    }
    Decimal decimal;
    if (!read_decimal(at, &decimal))
        return NULL;
    *out = decimal_value(&decimal);
    return decimal.stop;
}

// Reads a number that may reach the end of the text, from a copy with a NUL behind it.
static bool read_last(const CoScan *scan, const char *p, Decimal *out)
{
    char copy[512] = {0};
    size_t left = (size_t)(scan->end - p);
    size_t length = left < sizeof copy ? left : sizeof copy - 1;
    memcpy(copy, p, length);
    if (!read_decimal(copy, out) || out->stop == copy + sizeof copy - 1)
        return false;
    out->real = decimal_value(out);
    out->digits = p + (out->digits - copy);
    out->stop = p + (out->stop - copy);
    return true;
}

CoScanStatus co_scan_number(CoScan *scan, CoNumber *out)
{
    const char *p = scan->at;
    *out = (CoNumber){0};
    if (p >= scan->end)
        return CO_SCAN_NONE;
    if (co_scan_word(scan, "nan")) {
        out->real = (double)NAN;
        return CO_SCAN_OK;
    }
    out->is_negative = *p == '-';
    scan->at += out->is_negative;
    if (co_scan_word(scan, "inf")) {
        out->real = out->is_negative ? -(double)INFINITY : (double)INFINITY;
        return CO_SCAN_OK;
    }
    const char *digits = scan->at;
    scan->at = p;
    bool begins = digits < scan->end && (is_digit(*digits) || *digits == '.');
    if (!begins)
        return out->is_negative ? CO_SCAN_OPEN : CO_SCAN_NONE;
    Decimal decimal;
    if (p >= scan->safe ? !read_last(scan, p, &decimal) : !read_decimal(p, &decimal))
        return CO_SCAN_OPEN;
    out->real = p >= scan->safe ? decimal.real : decimal_value(&decimal);
    bool is_minus_zero = decimal.negative && decimal.mantissa == 0;
    bool fits =
        decimal.digit_count <= 19 || (decimal.digit_count == 20 && decimal.is_integer &&
                                      memcmp(decimal.stop - 20, "18446744073709551615", 20) <= 0);
    out->is_integer = decimal.is_integer && fits && !is_minus_zero;
    out->magnitude = decimal.mantissa;
    scan->at = decimal.stop;
    return CO_SCAN_OK;
}

// ---- Conversions -------------------------------------------------------------------------------

bool co_number_to_int64(const CoNumber *number, int64_t least, int64_t most, int64_t *out)
{
    int64_t value;
    if (number->is_integer) {
        if (number->magnitude > (uint64_t)INT64_MAX + number->is_negative)
            return false;
        value = number->is_negative ? -(int64_t)(number->magnitude - 1) - 1
                                    : (int64_t)number->magnitude;
        if (number->is_negative && number->magnitude == 0)
            value = 0;
    } else {
        if (!(number->real > -9223372036854775809.0 && number->real < 9223372036854775808.0))
            return false;
        value = (int64_t)number->real;
    }
    if (value < least || value > most)
        return false;
    *out = value;
    return true;
}

bool co_number_to_uint64(const CoNumber *number, uint64_t most, uint64_t *out)
{
    uint64_t value;
    if (number->is_integer) {
        if (number->is_negative && number->magnitude)
            return false;
        value = number->magnitude;
    } else {
        if (!(number->real > -1.0 && number->real < 18446744073709551616.0))
            return false;
        value = (uint64_t)number->real;
    }
    if (value > most)
        return false;
    *out = value;
    return true;
}

float co_number_to_float(const CoNumber *number)
{
    if (!number->is_integer)
        return (float)number->real;
    float value = (float)number->magnitude;
    return number->is_negative ? -value : value;
}

uint16_t co_half_from_float(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    uint32_t sign = bits >> 16 & 0x8000u, magnitude = bits & 0x7fffffffu;
    if (magnitude > 0x7f800000u)
        return (uint16_t)(sign | 0x7e00u);
    if (magnitude >= 0x477ff000u) // from 65520 on rounding reaches infinity
        return (uint16_t)(sign | 0x7c00u);
    uint32_t half, dropped;
    unsigned shift;
    if (magnitude >= 0x38800000u) {
        shift = 13;
        half = (magnitude >> 13) - (112u << 10);
        dropped = magnitude & 0x1fffu;
    } else {
        unsigned exponent = magnitude >> 23;
        if (exponent < 102)
            return (uint16_t)sign;
        uint32_t mantissa = (magnitude & 0x7fffffu) | 0x800000u;
        shift = 126 - exponent;
        half = mantissa >> shift;
        dropped = mantissa & ((1u << shift) - 1);
    }
    uint32_t tie = 1u << (shift - 1);
    half += dropped > tie || (dropped == tie && (half & 1));
    return (uint16_t)(sign | half);
}

float co_half_to_float(uint16_t half)
{
    uint32_t sign = (uint32_t)(half & 0x8000u) << 16, exponent = half >> 10 & 31u;
    uint32_t mantissa = half & 0x3ffu, bits;
    if (exponent == 31) {
        bits = sign | 0x7f800000u | mantissa << 13;
    } else if (exponent) {
        bits = sign | (exponent + 112) << 23 | mantissa << 13;
    } else {
        float value = (float)mantissa * 0x1p-24f;
        memcpy(&bits, &value, sizeof bits);
        bits |= sign;
    }
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}
