// Shortest decimals. DIG digits of a decimal always survive the way into a float and back, so the
// shortest text is that with DIG digits, less its trailing zeros, unless it takes one of the few
// longer ones to tell the value from its neighbors. Subnormal values have less precision and are
// tried from one digit on.

#include "parse/writer.h"

#include "lex/number.h"

#include <float.h>
#include <math.h>
#include <string.h>

size_t co_format_integer(bool negative, uint64_t magnitude, char out[CO_NUMBER_TEXT])
{
    char reversed[24];
    size_t count = 0, length = 0;
    do
        reversed[count++] = (char)('0' + magnitude % 10);
    while (magnitude /= 10);
    if (negative)
        out[length++] = '-';
    while (count)
        out[length++] = reversed[--count];
    out[length] = '\0';
    return length;
}

// Writes sign, digits and exponent (value = 0.d1d2d3... * 10^point) the way %g does.
static size_t compose(bool negative, const char *digits, int count, int point, char *out)
{
    char *p = out;
    if (negative)
        *p++ = '-';
    while (count > 1 && digits[count - 1] == '0')
        count--;
    if (point > -4 && point <= 17) {
        if (point <= 0)
            *p++ = '0';
        for (int i = 0; i < point; i++)
            *p++ = i < count ? digits[i] : '0';
        if (count > point) {
            *p++ = '.';
            for (int i = point; i < 0; i++)
                *p++ = '0';
            for (int i = point > 0 ? point : 0; i < count; i++)
                *p++ = digits[i];
        }
        *p = '\0';
        return (size_t)(p - out);
    }
    *p++ = digits[0];
    if (count > 1) {
        *p++ = '.';
        memcpy(p, digits + 1, (size_t)count - 1);
        p += count - 1;
    }
    return (size_t)(p - out) + (size_t)snprintf(p, 8, "e%d", point - 1);
}

static size_t special(double value, char *out)
{
    const char *text = isnan(value) ? "nan" : value < 0 ? "-inf" : "inf";
    strcpy(out, text);
    return strlen(text);
}

static const double powers[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

// Up to 15 digits by scaling to a whole number. `back` receives what the text reads back as: whole
// number and power are exact, so that is one correctly rounded operation, as in the reader. Returns
// 0 for sizes that need another way.
static size_t format_scaled(double value, int digits, char *out, double *back)
{
    double size = fabs(value);
    if (!(size >= 1e-6 && size < 1e15))
        return 0;
    int point = size < 1.0 ? -5 : 1; // decimal places before the point
    while (point <= 0 ? size * powers[-point] >= 1.0 : size >= powers[point])
        point++;
    int shift = digits - point;
    double scaled = shift < 0 ? size / powers[-shift] : size * powers[shift];
    uint64_t whole = (uint64_t)(scaled + 0.5);
    double read = shift < 0 ? (double)whole * powers[-shift] : (double)whole / powers[shift];
    *back = value < 0 ? -read : read;
    char plain[CO_NUMBER_TEXT];
    int count = (int)co_format_integer(false, whole, plain);
    return compose(value < 0, plain, count, count - shift, out);
}

// `digits` significant digits of any finite value, the slow way.
static size_t format_digits(double value, int digits, char *out)
{
    // The locale's decimal point stands between the first digit and the rest, and is skipped.
    char text[64], plain[32];
    snprintf(text, sizeof text, "%.*e", digits - 1, fabs(value));
    int count = 0, exponent = 0;
    const char *p = text;
    for (; *p && *p != 'e'; p++)
        if (*p >= '0' && *p <= '9')
            plain[count++] = *p;
    if (*p == 'e') {
        bool down = p[1] == '-';
        for (p += 2; *p; p++)
            exponent = exponent * 10 + (*p - '0');
        exponent = down ? -exponent : exponent;
    }
    return compose(signbit(value) != 0, plain, count, exponent + 1, out);
}

static double read_back(const char *text)
{
    double value = 0.0;
    co_number_read_any(text, &value);
    return value;
}

// Whole numbers that any of the types holds exactly, without trying digits.
static size_t format_small_integer(double value, char *out)
{
    if (!(fabs(value) < 1e6) || value != floor(value) || (value == 0.0 && signbit(value)))
        return 0;
    return co_format_integer(value < 0, (uint64_t)fabs(value), out);
}

size_t co_format_double(double value, char out[CO_NUMBER_TEXT])
{
    if (!isfinite(value))
        return special(value, out);
    size_t length = format_small_integer(value, out);
    double back = 0.0;
    if (!length && (length = format_scaled(value, DBL_DIG, out, &back)) && back != value)
        length = 0;
    for (int digits = fabs(value) < DBL_MIN ? 1 : DBL_DIG; !length; digits++) {
        length = format_digits(value, digits, out);
        if (digits < DBL_DECIMAL_DIG && read_back(out) != value)
            length = 0;
    }
    return length;
}

size_t co_format_float(float value, char out[CO_NUMBER_TEXT])
{
    if (!isfinite(value))
        return special((double)value, out);
    size_t length = format_small_integer((double)value, out);
    double back = 0.0;
    for (int digits = FLT_DIG; !length && digits <= FLT_DECIMAL_DIG; digits++) {
        length = format_scaled((double)value, digits, out, &back);
        if (!length)
            break;
        if ((float)back != value)
            length = 0;
    }
    for (int digits = fabsf(value) < FLT_MIN ? 1 : FLT_DIG; !length; digits++) {
        length = format_digits((double)value, digits, out);
        if (digits < FLT_DECIMAL_DIG && (float)read_back(out) != value)
            length = 0;
    }
    return length;
}

size_t co_format_half(uint16_t half, char out[CO_NUMBER_TEXT])
{
    enum {
        HALF_DIG = 3,
        HALF_DECIMAL_DIG = 5
    };
    float value = co_half_to_float(half);
    if (!isfinite(value))
        return special((double)value, out);
    size_t length = format_small_integer((double)value, out);
    for (int digits = fabsf(value) < 0x1p-14f ? 1 : HALF_DIG; !length; digits++) {
        length = format_digits((double)value, digits, out);
        if (digits < HALF_DECIMAL_DIG && co_half_from_float((float)read_back(out)) != half)
            length = 0;
    }
    return length;
}
