// Values of types that Cohort does not know are kept as the text they stand in.

#include "parse/parser.h"

#include <string.h>

static bool skip_in_list(CoParser *p, void *context);
static bool skip_in_tuple(CoParser *p, void *context);

static bool skip_nested(CoParser *p, char close)
{
    const char *at = p->scan.at++;
    if (!co_parse_deeper(p, at))
        return false;
    bool good = co_parse_list(p, close, true, close == ']' ? skip_in_list : skip_in_tuple, NULL);
    p->depth--;
    return good;
}

// Numbers, words, text, asset paths, and tuples of them.
static bool skip_in_tuple(CoParser *p, void *context)
{
    CohortString ignored;
    CoSlice word;
    CoNumber number;
    (void)context;
    int c = co_scan_peek(&p->scan);
    if (c == '"' || c == '\'')
        return co_parse_string(p, &ignored);
    if (c == '@')
        return co_parse_asset(p, &ignored);
    if (c == '(')
        return skip_nested(p, ')');
    if (co_scan_number(&p->scan, &number) == CO_SCAN_OK || co_scan_type_name(&p->scan, &word))
        return true;
    return co_parse_expected(p, "a value");
}

static bool skip_in_list(CoParser *p, void *context)
{
    return co_scan_peek(&p->scan) == '[' ? skip_nested(p, ']') : skip_in_tuple(p, context);
}

// It is kept as it stands: a relative one may lead anywhere.
static bool skip_path(CoParser *p)
{
    const char *at = p->scan.at;
    CoPathInfo info;
    CoSlice path;
    size_t bad;
    if (co_scan_path(&p->scan, &path) != CO_SCAN_OK)
        return co_parse_fail(p, at, "this path has no end; expected its closing '>' on the line");
    return !path.length || co_path_check(path, &info, &bad) ||
           co_parse_fail(p, path.begin + bad, "found <%.*s>, which is no well-formed path",
                         path.length > 100 ? 100 : (int)path.length, path.begin);
}

static bool skip_empty_list(CoParser *p)
{
    CoScan ahead = p->scan;
    if (!co_scan_char(&ahead, '['))
        return false;
    co_scan_inline(&ahead);
    if (!co_scan_char(&ahead, ']'))
        return false;
    p->scan.at = ahead.at;
    return true;
}

// Only the whole can be a path, None, or a list of nothing.
static bool skip_value(CoParser *p)
{
    if (co_scan_peek(&p->scan) == '<')
        return skip_path(p);
    return skip_empty_list(p) || co_scan_word(&p->scan, "None") || skip_in_list(p, NULL);
}

static bool keep_as_text(CoParser *p, const char *from, CoValue *out)
{
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

bool co_parse_opaque(CoParser *p, CoValue *out)
{
    const char *from = p->scan.at;
    return skip_value(p) && keep_as_text(p, from, out);
}

bool co_parse_opaque_item(CoParser *p, CoValue *out)
{
    const char *from = p->scan.at;
    return skip_in_list(p, NULL) && keep_as_text(p, from, out);
}
