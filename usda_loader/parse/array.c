// Arrays, straight into packed storage. Nested brackets flatten when they are square.

#include "parse/parser.h"

#include <string.h>

enum {
    MAX_RANK = 16
};

typedef struct Array {
    const CoTypeInfo *info;
    size_t element; // bytes
    size_t count;
    unsigned rank, leaf_rank; // brackets open now; at the first element (0: none yet)
    size_t shape[MAX_RANK];   // items of the first list at each rank, 0 until it closed
} Array;

static bool too_long(CoParser *p)
{
    return co_parse_stop(p, p->scan.at, COHORT_ERROR_LIMIT,
                         "an array is longer than %llu elements; raise max_array_length to read it",
                         (unsigned long long)p->max_array_length);
}

static bool room(CoParser *p, const Array *array)
{
    if (array->count >= p->max_array_length)
        return too_long(p);
    return co_parse_scratch(p, (array->count + 1) * array->element);
}

// ---- The fast loop
// ------------------------------------------------------------------------------- Numbers and flat
// tuples of them with blanks, commas and line ends between: all of a mesh. Anything else (comments,
// nan, odd separators, errors) stops it before the element and is left to the general reader, which
// judges it.

static const char *skip_white(const char *p)
{
    while (*p == ' ' || *p == '\n' || *p == '\t' || *p == '\r')
        p++;
    return p;
}

static const char *skip_blank(const char *p)
{
    while (*p == ' ' || *p == '\t')
        p++;
    return p;
}

// A 32-bit integer without exponent, or NULL.
static const char *read_int(const char *p, int32_t *out)
{
    bool negative = *p == '-';
    p += negative;
    const char *first = p;
    uint64_t value = 0;
    while ((unsigned char)(*p - '0') < 10)
        value = value * 10 + (uint64_t)(*p++ - '0');
    if (p == first || p - first > 10 || value > (uint64_t)INT32_MAX + negative || *p == '.' ||
        (*p | 32) == 'e')
        return NULL;
    *out = (int32_t)(negative ? -(int64_t)value : (int64_t)value);
    return p;
}

static const char *read_component(const char *p, CoScalar scalar, unsigned char *out)
{
    if (scalar == CO_SCALAR_INT) {
        int32_t value;
        p = read_int(p, &value);
        if (p)
            memcpy(out, &value, sizeof value);
        return p;
    }
    double real;
    p = co_number_read(p, &real);
    if (!p)
        return NULL;
    if (scalar == CO_SCALAR_FLOAT) {
        float value = (float)real;
        memcpy(out, &value, sizeof value);
    } else if (scalar == CO_SCALAR_DOUBLE) {
        memcpy(out, &real, sizeof real);
    } else {
        uint16_t half = co_half_from_float((float)real);
        memcpy(out, &half, sizeof half);
    }
    return p;
}

// One element at p, or NULL.
static inline const char *read_fast(const char *p, CoScalar scalar, unsigned width, size_t size,
                                    unsigned char *out, const char *safe)
{
    if (!width)
        return read_component(p, scalar, out);
    if (*p++ != '(')
        return NULL;
    for (unsigned i = 0; i < width; i++) {
        if (p > safe || (p = skip_white(p)) >= safe)
            return NULL;
        p = read_component(p, scalar, out + i * size);
        if (!p)
            return NULL;
        p = skip_blank(p);
        if (i + 1 < width && *p++ != ',')
            return NULL;
    }
    return *p == ')' ? p + 1 : NULL;
}

// Reads elements as long as each is plain and followed by a comma; the last one is left.
static bool fast_loop(CoParser *p, Array *array)
{
    const CoTypeInfo *info = array->info;
    if (info->rows || info->is_quaternion ||
        !(info->scalar == CO_SCALAR_INT || info->scalar == CO_SCALAR_FLOAT ||
          info->scalar == CO_SCALAR_DOUBLE || info->scalar == CO_SCALAR_HALF))
        return true;
    size_t size = co_scalar_size(info->scalar);
    const char *at = p->scan.at;
    for (;;) {
        size_t capacity = p->scratch_size / array->element;
        if (array->count >= capacity) {
            p->scan.at = at;
            if (!room(p, array))
                return false;
            capacity = p->scratch_size / array->element;
        }
        capacity = capacity < p->max_array_length ? capacity : p->max_array_length;
        unsigned char *out = p->scratch + array->count * array->element;
        for (; array->count < capacity; array->count++, out += array->element) {
            if (at >= p->scan.safe)
                break;
            const char *next = read_fast(at, info->scalar, info->columns, size, out, p->scan.safe);
            if (!next || next > p->scan.safe)
                break;
            next = skip_blank(next);
            if (next >= p->scan.safe || *next != ',')
                break;
            at = skip_white(next + 1);
        }
        p->scan.at = at;
        if (array->count < capacity || array->count >= p->max_array_length)
            return true;
    }
}

// ---- The general reader ------------------------------------------------------------------------

static bool parse_list(CoParser *p, Array *array);

static bool parse_leaf(CoParser *p, Array *array)
{
    if (!array->leaf_rank)
        array->leaf_rank = array->rank;
    if (array->rank != array->leaf_rank)
        return co_parse_fail(p, p->scan.at, "found an element beside a list; rows must be alike");
    if (!room(p, array))
        return false;
    // Scratch may move or be used for paths while the element is read.
    _Alignas(16) unsigned char element[CO_ELEMENT_BYTES];
    if (!co_parse_element(p, array->info, element))
        return false;
    memcpy(p->scratch + array->count * array->element, element, array->element);
    array->count++;
    return true;
}

static bool close_list(CoParser *p, Array *array, size_t items)
{
    size_t *expected = &array->shape[array->rank - 1];
    if (*expected && *expected != items)
        return co_parse_fail(p, p->scan.at - 1, "found a row of %zu, expected %zu as in the first",
                             items, *expected);
    *expected = items;
    array->rank--;
    return true;
}

static bool parse_items(CoParser *p, Array *array)
{
    size_t items = 0;
    co_scan_space(&p->scan);
    for (;;) {
        if (!array->leaf_rank || array->leaf_rank == array->rank) {
            size_t before = array->count;
            if (!fast_loop(p, array))
                return false;
            items += array->count - before;
            if (array->count > before)
                array->leaf_rank = array->rank;
            co_scan_space(&p->scan);
            if (array->count > before && co_scan_char(&p->scan, ']'))
                return close_list(p, array, items);
        }
        bool nested = co_scan_peek(&p->scan) == '[';
        if (nested && array->leaf_rank && array->rank >= array->leaf_rank)
            return co_parse_fail(p, p->scan.at, "found a list beside elements; rows must be alike");
        if (nested ? !parse_list(p, array) : !parse_leaf(p, array))
            return false;
        items++;
        co_scan_inline(&p->scan);
        bool comma = co_scan_char(&p->scan, ',');
        co_scan_space(&p->scan);
        if (co_scan_char(&p->scan, ']'))
            return close_list(p, array, items);
        if (!comma)
            return co_parse_expected(p, "',' or ']'");
    }
}

static bool parse_list(CoParser *p, Array *array)
{
    if (!co_parse_char(p, '['))
        return false;
    if (array->rank >= MAX_RANK)
        return co_parse_fail(p, p->scan.at, "found lists nested deeper than %d", MAX_RANK);
    array->rank++;
    return parse_items(p, array);
}

bool co_parse_array(CoParser *p, CohortType type, CoValue *out)
{
    Array array = {.info = co_type_info(type), .element = co_type_size(type)};
    if (co_scan_peek(&p->scan) != '[')
        return co_parse_expected(p, "a list in [ ]");
    CoScan ahead = p->scan;
    ahead.at++;
    co_scan_inline(&ahead);
    if (co_scan_char(&ahead, ']'))
        p->scan.at = ahead.at;
    else if (!parse_list(p, &array))
        return false;
    *out = (CoValue){.type = type, .is_array = true, .count = (uint32_t)array.count};
    out->data = co_parse_keep(p, p->scratch, array.count * array.element);
    return out->data != NULL;
}
