// Numbers as USDA spells them, correctly rounded, and half floats.
//
// number = ["-"] (digits ["." digits*] | "." digits | "inf") [exponent] | "nan"
// The text need not be NUL-terminated: every read stops at CoScan.end.

#ifndef CO_LEX_NUMBER_H
#define CO_LEX_NUMBER_H

#include "lex/scan.h"

// Integers that fit keep all their bits; everything else is a double.
typedef struct CoNumber {
    bool is_integer;
    bool is_negative;
    uint64_t magnitude; // of an integer
    double real;        // always set: the nearest double
} CoNumber;

// CO_SCAN_OPEN: it begins like a number but is none ("1e", ".", "-.").
CoScanStatus co_scan_number(CoScan *scan, CoNumber *out);

// The loop of large arrays: reads the plain decimal number at `at`, which lies before CoScan.safe,
// and returns its end; NULL when co_scan_number must judge it. Same result as that.
const char *co_number_read(const char *at, double *out);

// Range-checked conversions, fractions cut off; false when the value does not fit.
bool co_number_to_int64(const CoNumber *number, int64_t least, int64_t most, int64_t *out);
bool co_number_to_uint64(const CoNumber *number, uint64_t most, uint64_t *out);
// One rounding from the integer, or from the double.
float co_number_to_float(const CoNumber *number);

// IEEE binary16, round to nearest even; overflow gives infinity.
uint16_t co_half_from_float(float value);
float co_half_to_float(uint16_t half);

#endif
