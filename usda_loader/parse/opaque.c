// Values of types that Cohort does not know are kept as the text they stand in.

#include "parse/parser.h"

#include <string.h>

static bool skip_value(CoParser *p);

static bool skip_item(CoParser *p, void *context)
{
    (void)context;
    return skip_value(p);
}

static bool skip_nested(CoParser *p, char close)
{
    const char *at = p->scan.at++;
    CoScan ahead = p->scan;
    co_scan_inline(&ahead);
    if (close == ']' && co_scan_char(&ahead, close)) {
        p->scan.at = ahead.at;
        return true;
    }
    if (!co_parse_deeper(p, at))
        return false;
    bool good = co_parse_list(p, close, true, skip_item, NULL);
    p->depth--;
    return good;
}

static bool skip_value(CoParser *p)
{
    CohortString ignored;
    CoSlice word;
    CoNumber number;
    CoPathInfo info;
    const char *path;
    int c = co_scan_peek(&p->scan);
    if (c == '"' || c == '\'')
        return co_parse_string(p, &ignored);
    if (c == '@')
        return co_parse_asset(p, &ignored);
    if (c == '<')
        return co_parse_path(p, &path, &info);
    if (c == '(')
        return skip_nested(p, ')');
    if (c == '[')
        return skip_nested(p, ']');
    if (co_scan_number(&p->scan, &number) == CO_SCAN_OK || co_scan_word(&p->scan, "None") ||
        co_scan_type_name(&p->scan, &word))
        return true;
    return co_parse_expected(p, "a value");
}

bool co_parse_opaque(CoParser *p, CoValue *out)
{
    const char *from = p->scan.at;
    if (!skip_value(p))
        return false;
    size_t length = (size_t)(p->scan.at - from);
    CohortString *text = co_parse_alloc(p, 1, sizeof *text);
    char *copy = co_parse_alloc(p, length + 1, 1);
    if (!text || !copy)
        return false;
    memcpy(copy, from, length);
    *text = (CohortString){copy, length};
    *out = (CoValue){.type = COHORT_TYPE_OPAQUE, .count = 1, .data = text};
    return true;
}
