// Any bytes as a number: never read past the end, and written shortest they mean the same.

#include "fuzz.h"

#include "parse/writer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    double value = 0;
    char text[CO_NUMBER_TEXT + 1];
    if (size < sizeof value)
        return 0;
    memcpy(&value, data, sizeof value);
    size_t length = co_format_double(value, text);
    text[length] = 0;
    if (!isnan(value))
        fuzz_require(strtod(text, NULL) == value);
    float narrow;
    memcpy(&narrow, data, sizeof narrow);
    text[co_format_float(narrow, text)] = 0;
    if (!isnan(narrow))
        fuzz_require(strtof(text, NULL) == narrow);
    co_token((const char *)data, size < 32 ? size : 32);
    return 0;
}
