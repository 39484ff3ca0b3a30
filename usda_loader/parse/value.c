// Scalars and tuples of a known type, and what a value as a whole may be.

#include "parse/parser.h"

#include <math.h>
#include <string.h>

static bool wrong(CoParser *p, const char *at, CoScalar scalar)
{
    static const char *const names[] = {
        [CO_SCALAR_NONE] = "nothing: this type takes no value",
        [CO_SCALAR_BOOL] = "a bool",
        [CO_SCALAR_UCHAR] = "a whole number from 0 to 255",
        [CO_SCALAR_INT] = "a 32-bit integer",
        [CO_SCALAR_UINT] = "a 32-bit unsigned integer",
        [CO_SCALAR_INT64] = "a 64-bit integer",
        [CO_SCALAR_UINT64] = "a 64-bit unsigned integer",
        [CO_SCALAR_HALF] = "a number",
        [CO_SCALAR_FLOAT] = "a number",
        [CO_SCALAR_DOUBLE] = "a number",
        [CO_SCALAR_STRING] = "a quoted string",
        [CO_SCALAR_TOKEN] = "a quoted string",
        [CO_SCALAR_ASSET] = "an asset path between @",
        [CO_SCALAR_PATH_EXPRESSION] = "a quoted path expression",
    };
    p->scan.at = at;
    return co_parse_expected(p, names[scalar]);
}

static bool equals_folded(CoSlice slice, const char *word)
{
    if (slice.length != strlen(word))
        return false;
    for (size_t i = 0; i < slice.length; i++)
        if ((slice.begin[i] | 32) != word[i])
            return false;
    return true;
}

// Numbers, the words yes/no/true/false in any case, and the same (or 0 and 1) in quotes.
static bool parse_bool(CoParser *p, bool *out)
{
    const char *at = p->scan.at;
    CoNumber number;
    CoSlice word;
    CoScanStatus status = co_scan_number(&p->scan, &number);
    if (status == CO_SCAN_OK) {
        *out = number.real != 0.0;
        return true;
    }
    if (status == CO_SCAN_NONE &&
        (co_scan_string(&p->scan, &word) == CO_SCAN_OK || co_scan_identifier(&p->scan, &word))) {
        *out = equals_folded(word, "true") || equals_folded(word, "yes") || co_slice_is(word, "1");
        if (*out || equals_folded(word, "false") || equals_folded(word, "no") ||
            co_slice_is(word, "0"))
            return true;
    }
    return wrong(p, at, CO_SCALAR_BOOL);
}

static bool parse_number(CoParser *p, CoScalar scalar, CoNumber *out)
{
    const char *at = p->scan.at;
    CoScanStatus status = co_scan_number(&p->scan, out);
    if (status == CO_SCAN_OK)
        return true;
    CoSlice word;
    bool floating =
        scalar == CO_SCALAR_HALF || scalar == CO_SCALAR_FLOAT || scalar == CO_SCALAR_DOUBLE;
    if (status == CO_SCAN_NONE && floating && co_scan_string(&p->scan, &word) == CO_SCAN_OK) {
        *out = (CoNumber){0};
        bool minus = word.length == 4 && word.begin[0] == '-';
        if (co_slice_is(word, "nan"))
            out->real = (double)NAN;
        else if (co_slice_is(word, "inf") || co_slice_is(word, "-inf"))
            out->real = minus ? -(double)INFINITY : (double)INFINITY;
        if (out->real != 0.0)
            return true;
    }
    return wrong(p, at, scalar);
}

static bool store_number(CoScalar scalar, const CoNumber *number, void *out)
{
    int64_t s = 0;
    uint64_t u = 0;
    bool fits = true;
    if (scalar == CO_SCALAR_DOUBLE) {
        memcpy(out, &number->real, sizeof number->real);
    } else if (scalar == CO_SCALAR_FLOAT) {
        float value = co_number_to_float(number);
        memcpy(out, &value, sizeof value);
    } else if (scalar == CO_SCALAR_HALF) {
        uint16_t half = co_half_from_float(co_number_to_float(number));
        memcpy(out, &half, sizeof half);
    } else if (scalar == CO_SCALAR_INT) {
        fits = co_number_to_int64(number, INT32_MIN, INT32_MAX, &s);
        int32_t value = (int32_t)s;
        memcpy(out, &value, sizeof value);
    } else if (scalar == CO_SCALAR_INT64) {
        fits = co_number_to_int64(number, INT64_MIN, INT64_MAX, &s);
        memcpy(out, &s, sizeof s);
    } else if (scalar == CO_SCALAR_UINT) {
        fits = co_number_to_uint64(number, UINT32_MAX, &u);
        uint32_t value = (uint32_t)u;
        memcpy(out, &value, sizeof value);
    } else if (scalar == CO_SCALAR_UINT64) {
        fits = co_number_to_uint64(number, UINT64_MAX, &u);
        memcpy(out, &u, sizeof u);
    } else {
        fits = co_number_to_uint64(number, UINT8_MAX, &u);
        *(unsigned char *)out = (unsigned char)u;
    }
    return fits;
}

// Asset paths may be written as strings.
static bool parse_text(CoParser *p, CoScalar scalar, CohortString *out)
{
    int c = co_scan_peek(&p->scan);
    if (scalar == CO_SCALAR_ASSET && c == '@')
        return co_parse_asset(p, out);
    if (c != '"' && c != '\'')
        return wrong(p, p->scan.at, scalar);
    const char *at = p->scan.at;
    if (!co_parse_string(p, out))
        return false;
    if (scalar == CO_SCALAR_ASSET && !co_asset_check(p, at, out))
        return false;
    size_t bad;
    if (scalar == CO_SCALAR_PATH_EXPRESSION && !co_expression_check(out->text, out->length, &bad))
        return co_parse_fail(p, at,
                             "found '%.100s', which is no path expression from character %zu on",
                             out->text, bad + 1);
    return true;
}

bool co_parse_scalar(CoParser *p, CoScalar scalar, void *out)
{
    const char *at = p->scan.at;
    if (scalar == CO_SCALAR_NONE)
        return wrong(p, at, scalar);
    if (scalar == CO_SCALAR_BOOL)
        return parse_bool(p, out);
    if (scalar >= CO_SCALAR_STRING) {
        CohortString string;
        if (!parse_text(p, scalar, &string))
            return false;
        memcpy(out, &string, sizeof string);
        return true;
    }
    CoNumber number;
    if (!parse_number(p, scalar, &number))
        return false;
    return store_number(scalar, &number, out) || wrong(p, at, scalar);
}

typedef struct Tuple {
    const CoTypeInfo *info;
    unsigned levels; // brackets still to come below this one
    unsigned count, wanted;
    unsigned char *out;
} Tuple;

static bool tuple_item(CoParser *p, void *context);

static bool parse_tuple(CoParser *p, Tuple *tuple)
{
    const char *at = p->scan.at;
    if (!co_parse_char(p, '(') || !co_parse_list(p, ')', true, tuple_item, tuple))
        return false;
    if (tuple->count != tuple->wanted)
        return co_parse_fail(p, at, "found a tuple of %u, expected one of %u", tuple->count,
                             tuple->wanted);
    return true;
}

static bool tuple_item(CoParser *p, void *context)
{
    Tuple *tuple = context;
    if (tuple->count++ >= tuple->wanted)
        return co_parse_fail(p, p->scan.at, "found a tuple that is too long, expected %u items",
                             tuple->wanted);
    size_t size = co_scalar_size(tuple->info->scalar);
    if (tuple->levels) {
        Tuple inner = {tuple->info, 0, 0, tuple->info->columns, tuple->out};
        tuple->out += size * tuple->info->columns;
        return parse_tuple(p, &inner);
    }
    bool good = co_parse_scalar(p, tuple->info->scalar, tuple->out);
    tuple->out += size;
    return good;
}

bool co_parse_element(CoParser *p, const CoTypeInfo *info, void *out)
{
    if (!info->columns)
        return co_parse_scalar(p, info->scalar, out);
    Tuple tuple = {info, info->rows ? 1 : 0, 0, info->rows ? info->rows : info->columns, out};
    if (!parse_tuple(p, &tuple))
        return false;
    if (info->is_quaternion) {
        unsigned char real[8], *bytes = out;
        size_t size = co_scalar_size(info->scalar);
        memcpy(real, bytes, size);
        memmove(bytes, bytes + size, 3 * size);
        memcpy(bytes + 3 * size, real, size);
    }
    return true;
}

bool co_parse_value(CoParser *p, CohortType type, bool is_array, CoValue *out)
{
    if (is_array) {
        if (co_scan_word(&p->scan, "edit")) {
            co_scan_inline(&p->scan);
            return co_parse_array_edit(p, type, out);
        }
        return co_parse_array(p, type, out);
    }
    _Alignas(16) unsigned char element[CO_ELEMENT_BYTES];
    if (!co_parse_element(p, co_type_info(type), element))
        return false;
    *out = (CoValue){.type = type, .count = 1};
    out->data = co_parse_keep(p, element, co_type_size(type));
    return out->data != NULL;
}
