// Arrays, straight into packed storage. Nested brackets flatten when they are square.

#include "parse/array.h"

#include <string.h>

static bool too_long(CoParser *p)
{
    return co_parse_stop(p, p->scan.at, COHORT_ERROR_LIMIT,
                         "an array is longer than %llu elements; raise max_array_length to read it",
                         (unsigned long long)p->max_array_length);
}

bool co_array_reserve(CoParser *p, CoArray *array)
{
    if (array->count >= p->max_array_length)
        return too_long(p);
    if (array->count < array->capacity)
        return true;
    if (!co_parse_scratch(p, (array->count + 1) * array->element))
        return false;
    if (array->is_final)
        memcpy(p->scratch, array->data, array->count * array->element);
    array->is_final = false;
    array->data = p->scratch;
    array->capacity = p->scratch_size / array->element;
    return true;
}

// Reads elements as long as each is plain and followed by a comma; the last one is left.
static bool read_plain(CoParser *p, CoArray *array)
{
    if (!co_plain_type(array->info))
        return true;
    if (!co_parse_bulk(p, array))
        return false;
    while (array->count < p->max_array_length) {
        if (!co_array_reserve(p, array))
            return false;
        size_t capacity =
            array->capacity < p->max_array_length ? array->capacity : p->max_array_length;
        CoPlainRun run = {.at = p->scan.at,
                          .stop = p->scan.safe,
                          .out = array->data + array->count * array->element,
                          .most = capacity - array->count};
        co_plain_read(array->info, p->scan.safe, &run);
        array->count += run.count;
        p->scan.at = run.at;
        if (array->count < capacity)
            break;
    }
    return true;
}

// ---- The general reader ------------------------------------------------------------------------

static bool parse_list(CoParser *p, CoArray *array);

static bool parse_leaf(CoParser *p, CoArray *array)
{
    if (!array->leaf_rank)
        array->leaf_rank = array->rank;
    if (array->rank != array->leaf_rank)
        return co_parse_fail(p, p->scan.at, "found an element beside a list; rows must be alike");
    if (!co_array_reserve(p, array))
        return false;
    _Alignas(16) unsigned char element[CO_ELEMENT_BYTES];
    if (!co_parse_element(p, array->info, element))
        return false;
    // Scratch may have moved meanwhile.
    array->data = array->is_final ? array->data : p->scratch;
    memcpy(array->data + array->count * array->element, element, array->element);
    array->count++;
    return true;
}

static bool close_list(CoParser *p, CoArray *array, size_t items)
{
    size_t *expected = &array->shape[array->rank - 1];
    if (*expected && *expected != items)
        return co_parse_fail(p, p->scan.at - 1, "found a row of %zu, expected %zu as in the first",
                             items, *expected);
    *expected = items;
    array->rank--;
    return true;
}

static bool parse_items(CoParser *p, CoArray *array)
{
    size_t items = 0;
    co_scan_space(&p->scan);
    for (;;) {
        if (!array->leaf_rank || array->leaf_rank == array->rank) {
            size_t before = array->count;
            if (!read_plain(p, array))
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

static bool parse_list(CoParser *p, CoArray *array)
{
    if (!co_parse_char(p, '['))
        return false;
    if (array->rank >= CO_MAX_RANK)
        return co_parse_fail(p, p->scan.at, "found lists nested deeper than %d", CO_MAX_RANK);
    array->rank++;
    return parse_items(p, array);
}

bool co_parse_array(CoParser *p, CohortType type, CoValue *out)
{
    CoArray array = {.info = co_type_info(type), .element = co_type_size(type)};
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
    out->data =
        array.is_final ? array.data : co_parse_keep(p, array.data, array.count * array.element);
    return out->data != NULL;
}
