// The syntax of path expressions: "/World//chair*{kind:prop} - %_ & ~(/a + //b.c)".
//
//   expression = term ((" " | "+" | "-" | "&") term)*
//   term       = "~" term | "(" expression ")" | "%" [path] ":" name | "%_" | pattern
//   pattern    = ["/" | "//" | ".." ("/" "..")*] element (("/" | "//") element)* ["//"] [property]
//   element    = glob ["{" predicate "}"] | "{" predicate "}"
//   predicate  = calls joined by "and", "or" and blanks, "not" and brackets
//   call       = name [":" argument ("," argument)* | "(" arguments ")"]

#include "parse/parser.h"

enum {
    MAX_DEPTH = 64
};

static bool check_expression(CoScan *scan, int depth);
static bool check_predicate(CoScan *scan, int depth);

static bool skip_white(CoScan *scan)
{
    const char *from = scan->at;
    while (scan->at < scan->end && (*scan->at == ' ' || *scan->at == '\t' || *scan->at == '\n'))
        scan->at++;
    return scan->at > from;
}

static bool is_name_char(int c)
{
    return (unsigned)(c | 32) - 'a' < 26 || c == '_' || (unsigned)c - '0' < 10;
}

// ---- Predicates --------------------------------------------------------------------------------

static bool check_argument(CoScan *scan)
{
    CoNumber number;
    CoSlice slice;
    CoScanStatus status = co_scan_string(scan, &slice);
    if (status == CO_SCAN_NONE)
        status = co_scan_number(scan, &number);
    return status == CO_SCAN_OK || (status == CO_SCAN_NONE && co_scan_identifier(scan, &slice));
}

static bool check_arguments(CoScan *scan)
{
    CoSlice name;
    skip_white(scan);
    while (!co_scan_char(scan, ')')) {
        CoScan ahead = *scan;
        if (co_scan_identifier(&ahead, &name)) {
            skip_white(&ahead);
            if (co_scan_char(&ahead, '=')) {
                skip_white(&ahead);
                scan->at = ahead.at;
            }
        }
        if (!check_argument(scan))
            return false;
        skip_white(scan);
        if (!co_scan_char(scan, ',') && co_scan_peek(scan) != ')')
            return false;
        skip_white(scan);
    }
    return true;
}

static bool check_call(CoScan *scan, int depth)
{
    CoSlice name;
    while (co_scan_word(scan, "not"))
        skip_white(scan);
    if (co_scan_char(scan, '(')) {
        skip_white(scan);
        return check_predicate(scan, depth + 1) && co_scan_char(scan, ')');
    }
    if (!co_scan_identifier(scan, &name))
        return false;
    if (co_scan_char(scan, '('))
        return check_arguments(scan);
    if (!co_scan_char(scan, ':'))
        return true;
    skip_white(scan);
    if (!check_argument(scan))
        return true;
    while (co_scan_char(scan, ','))
        if (!check_argument(scan))
            return false;
    return true;
}

static bool check_predicate(CoScan *scan, int depth)
{
    if (depth > MAX_DEPTH)
        return false;
    for (;;) {
        if (!check_call(scan, depth))
            return false;
        bool gap = skip_white(scan);
        int c = co_scan_peek(scan);
        if (c == ')' || c == '}')
            return true;
        if (!gap)
            return false;
        if (co_scan_word(scan, "and") || co_scan_word(scan, "or"))
            skip_white(scan);
    }
}

// ---- Patterns ----------------------------------------------------------------------------------

static bool check_glob(CoScan *scan, bool namespaces)
{
    for (;;) {
        int c = co_scan_peek(scan);
        if (is_name_char(c) || c == '*' || c == '?' || (namespaces && c == ':')) {
            scan->at++;
        } else if (c == '[') {
            const char *open = scan->at;
            while (co_scan_peek(scan) >= 0 && co_scan_peek(scan) != ']')
                scan->at++;
            if (!co_scan_char(scan, ']') || scan->at - open < 3)
                return false;
        } else {
            return true;
        }
    }
}

// One or more characters, and perhaps a predicate; *found is false when nothing of that stands
// here.
static bool check_element(CoScan *scan, bool namespaces, bool *found)
{
    const char *from = scan->at;
    if (!check_glob(scan, namespaces))
        return false;
    if (co_scan_char(scan, '{')) {
        skip_white(scan);
        if (!check_predicate(scan, 0) || !co_scan_char(scan, '}'))
            return false;
    }
    *found = scan->at > from;
    return true;
}

static bool scan_separator(CoScan *scan, bool *stretch)
{
    if (!co_scan_char(scan, '/'))
        return false;
    *stretch = co_scan_char(scan, '/');
    return true;
}

static bool scan_ups(CoScan *scan)
{
    const char *from = scan->at;
    while (scan->end - scan->at >= 2 && scan->at[0] == '.' && scan->at[1] == '.') {
        scan->at += 2;
        if (scan->end - scan->at < 3 || scan->at[0] != '/' || scan->at[1] != '.' ||
            scan->at[2] != '.')
            break;
        scan->at++;
    }
    return scan->at > from;
}

static bool check_pattern(CoScan *scan)
{
    bool found, stretch = false;
    bool ups = scan_ups(scan);
    if (!ups && co_scan_char(scan, '.'))
        return true;
    bool separated = scan_separator(scan, &stretch);
    if (!ups && separated && !stretch) {
        // "/" alone is the root.
        if (!check_element(scan, false, &found))
            return false;
        if (!found)
            return co_scan_peek(scan) != '.' && co_scan_peek(scan) != '/';
    } else if (!ups || separated) {
        if (!check_element(scan, false, &found))
            return false;
        if (!found)
            return stretch && co_scan_peek(scan) != '.' && co_scan_peek(scan) != '/';
    }
    while (scan_separator(scan, &stretch)) {
        if (!check_element(scan, false, &found))
            return false;
        if (!found)
            return stretch && co_scan_peek(scan) != '.' && co_scan_peek(scan) != '/';
    }
    if (!co_scan_char(scan, '.'))
        return true;
    return check_element(scan, true, &found) && found;
}

// ---- Expressions -------------------------------------------------------------------------------

// "%_", "%:name", "%/path:name", "%../path:name"
static bool check_reference(CoScan *scan)
{
    CoSlice name;
    if (co_scan_word(scan, "_"))
        return true;
    scan_ups(scan);
    while (co_scan_char(scan, '/'))
        if (!co_scan_identifier(scan, &name))
            return false;
    return co_scan_char(scan, ':') && co_scan_identifier(scan, &name);
}

static bool check_term(CoScan *scan, int depth)
{
    if (co_scan_char(scan, '~'))
        skip_white(scan);
    if (co_scan_char(scan, '(')) {
        skip_white(scan);
        return check_expression(scan, depth + 1) && co_scan_char(scan, ')');
    }
    return co_scan_char(scan, '%') ? check_reference(scan) : check_pattern(scan);
}

static bool check_expression(CoScan *scan, int depth)
{
    if (depth > MAX_DEPTH)
        return false;
    for (;;) {
        if (!check_term(scan, depth))
            return false;
        bool gap = skip_white(scan);
        int c = co_scan_peek(scan);
        if (c < 0 || c == ')')
            return true;
        if (c == '+' || c == '-' || c == '&') {
            scan->at++;
            skip_white(scan);
        } else if (!gap) {
            return false;
        }
    }
}

bool co_expression_check(const char *text, size_t length, size_t *bad)
{
    CoScan scan;
    co_scan_init(&scan, text, length);
    skip_white(&scan);
    bool good = length == 0 || (check_expression(&scan, 0) && scan.at == scan.end);
    *bad = (size_t)(scan.at - text);
    return good;
}
