// edit [append 5; write 7 to [0]; insert [2] at [1]; erase [-1]; minsize 4 fill 9; ...]

#include "parse/parser.h"

typedef struct Edit {
    CohortType type;
    CoArrayEdit *edit;
} Edit;

static bool parse_integer(CoParser *p, int64_t *out)
{
    CoNumber number;
    const char *at = p->scan.at;
    if (co_scan_number(&p->scan, &number) == CO_SCAN_OK && number.is_integer &&
        co_number_to_int64(&number, INT64_MIN, INT64_MAX, out))
        return true;
    p->scan.at = at;
    return co_parse_expected(p, "an integer");
}

static bool parse_index(CoParser *p, int64_t *out)
{
    if (!co_parse_char(p, '['))
        return false;
    co_scan_inline(&p->scan);
    if (!parse_integer(p, out))
        return false;
    co_scan_inline(&p->scan);
    return co_parse_char(p, ']');
}

static bool parse_literal(CoParser *p, CohortType type, CoArrayEditItem *item)
{
    item->literal = co_parse_alloc(p, 1, sizeof *item->literal);
    return item->literal && co_parse_value(p, type, false, item->literal);
}

static bool parse_words(CoParser *p, const char *word)
{
    co_scan_inline(&p->scan);
    if (!co_scan_word(&p->scan, word)) {
        char what[16] = "'to'";
        if (word[0] == 'a')
            what[1] = 'a', what[2] = 't';
        return co_parse_expected(p, what);
    }
    co_scan_inline(&p->scan);
    return true;
}

static bool parse_operands(CoParser *p, CohortType type, CoArrayEditItem *item)
{
    co_scan_inline(&p->scan);
    if (item->kind == CO_EDIT_ERASE)
        return parse_index(p, &item->at_or_size);
    if (item->kind >= CO_EDIT_MINSIZE) {
        if (!parse_integer(p, &item->at_or_size))
            return false;
        if (item->at_or_size < 0)
            return co_parse_fail(p, p->scan.at, "found a negative size");
        // A few bytes of text could ask for any amount of memory.
        if (item->kind != CO_EDIT_MAXSIZE && (uint64_t)item->at_or_size > p->max_edit_size)
            return co_parse_stop(p, p->scan.at, COHORT_ERROR_LIMIT,
                                 "found a size above %llu; raise max_array_length to read it",
                                 (unsigned long long)p->max_edit_size);
        CoScan ahead = p->scan;
        co_scan_inline(&ahead);
        if (item->kind == CO_EDIT_MAXSIZE || !co_scan_word(&ahead, "fill"))
            return true;
        co_scan_inline(&ahead);
        p->scan.at = ahead.at;
        return parse_literal(p, type, item);
    }
    bool good = co_scan_peek(&p->scan) == '[' ? parse_index(p, &item->source)
                                              : parse_literal(p, type, item);
    if (!good || item->kind == CO_EDIT_APPEND || item->kind == CO_EDIT_PREPEND)
        return good;
    return parse_words(p, item->kind == CO_EDIT_WRITE ? "to" : "at") &&
           parse_index(p, &item->at_or_size);
}

static bool parse_item(CoParser *p, void *context)
{
    static const char *const names[] = {
        [CO_EDIT_WRITE] = "write",     [CO_EDIT_INSERT] = "insert", [CO_EDIT_PREPEND] = "prepend",
        [CO_EDIT_APPEND] = "append",   [CO_EDIT_ERASE] = "erase",   [CO_EDIT_MINSIZE] = "minsize",
        [CO_EDIT_MAXSIZE] = "maxsize", [CO_EDIT_RESIZE] = "resize",
    };
    const Edit *edit = context;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (!co_scan_word(&p->scan, names[i]))
            continue;
        CoArrayEditItem item = {.kind = (CoArrayEditKind)i};
        if (!parse_operands(p, edit->type, &item))
            return false;
        CoArrayEditItem *slot =
            co_parse_push(p, &edit->edit->items, edit->edit->count, sizeof *slot);
        if (!slot)
            return false;
        *slot = item;
        edit->edit->count++;
        return true;
    }
    return co_parse_expected(p,
                             "write, insert, prepend, append, erase, minsize, maxsize or resize");
}

bool co_parse_array_edit(CoParser *p, CohortType type, CoValue *out)
{
    Edit edit = {type, co_parse_alloc(p, 1, sizeof *edit.edit)};
    if (!edit.edit || !co_parse_char(p, '[') || !co_parse_statements(p, ']', parse_item, &edit))
        return false;
    *out =
        (CoValue){.type = COHORT_TYPE_ARRAY_EDIT, .is_array = true, .count = 1, .data = edit.edit};
    return true;
}
