// Paths as text: /Prim{set=choice}Child.namespaced:property[/target].attribute
//
//   path     = "/" | ["/"] prims [properties] | ups ["/" prims] [properties] | properties
//   ups      = ".." ("/" "..")*
//   prims    = name selection* ("/" name selection* | name after a selection)*
//   selection = "{" name "=" [choice] "}"
//   properties = "." name (":" name)* ["[" path "]" ["." name (":" name)*]]

#include "parse/parser.h"

#include <string.h>

enum {
    MAX_TARGET_DEPTH = 16
};

static bool check_path(CoScan *scan, CoPathInfo *info, int depth);

// "{set=choice}"; a choice may begin with '.' and hold '|' and '-' too.
static bool check_selection(CoScan *scan)
{
    CoSlice name;
    if (!co_scan_char(scan, '{'))
        return false;
    co_scan_inline(scan);
    if (!co_scan_identifier(scan, &name))
        return false;
    co_scan_inline(scan);
    if (!co_scan_char(scan, '='))
        return false;
    co_scan_inline(scan);
    co_scan_char(scan, '.');
    for (;;) {
        uint32_t code;
        size_t step = co_utf8_decode(scan->at, scan->end, &code);
        if (!step || !(co_utf8_is_xid_continue(code) || code == '|' || code == '-'))
            break;
        scan->at += step;
    }
    co_scan_inline(scan);
    return co_scan_char(scan, '}');
}

static bool check_prims(CoScan *scan, CoPathInfo *info)
{
    CoSlice name;
    bool any = false;
    while (co_scan_identifier(scan, &name)) {
        any = true;
        info->is_variant = false;
        while (co_scan_peek(scan) == '{') {
            if (!check_selection(scan))
                return false;
            info->has_variant = info->is_variant = true;
        }
        int next = co_scan_peek(scan);
        if (next == '/')
            scan->at++;
        else if (!info->is_variant || next == '.' || next < 0)
            return true;
        if (next == '/' && scan->at >= scan->end)
            return false;
        any = false;
    }
    return any;
}

static bool check_properties(CoScan *scan, CoPathInfo *info, int depth)
{
    CoSlice name;
    bool is_mapper = false;
    if (!co_scan_char(scan, '.') || !co_scan_namespaced(scan, &name))
        return false;
    info->is_property = true;
    if (co_scan_char(scan, '.')) {
        is_mapper = co_scan_word(scan, "mapper");
        if (is_mapper ? co_scan_peek(scan) != '[' : !co_scan_word(scan, "expression"))
            return false;
    }
    while (co_scan_char(scan, '[')) {
        CoPathInfo target = {0};
        if (!check_path(scan, &target, depth + 1) || !co_scan_char(scan, ']'))
            return false;
        info->is_target = !is_mapper;
        if (co_scan_char(scan, '.')) {
            info->is_target = false;
            if (!co_scan_namespaced(scan, &name))
                return false;
        }
    }
    return true;
}

static bool check_path(CoScan *scan, CoPathInfo *info, int depth)
{
    if (depth > MAX_TARGET_DEPTH)
        return false;
    bool more = true;
    if (co_scan_char(scan, '/')) {
        info->is_absolute = true;
        info->is_root = more = scan->at < scan->end && *scan->at != ']';
        info->is_root = !info->is_root;
    } else if (scan->end - scan->at >= 2 && scan->at[0] == '.' && scan->at[1] == '.') {
        do {
            scan->at += 2;
            more = co_scan_char(scan, '/');
        } while (more && scan->end - scan->at >= 2 && scan->at[0] == '.' && scan->at[1] == '.');
        if (!more)
            return co_scan_peek(scan) != '.' || check_properties(scan, info, depth);
    } else if (co_scan_peek(scan) == '.') {
        return check_properties(scan, info, depth);
    }
    if (!more)
        return true;
    if (co_scan_peek(scan) != '.' && !check_prims(scan, info))
        return false;
    if (co_scan_peek(scan) == '.')
        return !(info->is_absolute && scan->at[-1] == '/') && check_properties(scan, info, depth);
    return true;
}

bool co_path_check(CoSlice path, CoPathInfo *info, size_t *bad)
{
    CoScan scan;
    co_scan_init(&scan, path.begin, path.length);
    *info = (CoPathInfo){0};
    bool good = path.length > 0 && check_path(&scan, info, 0) && scan.at == scan.end;
    *bad = (size_t)(scan.at - path.begin);
    return good;
}

// Joins the prim's path, less one name for each leading "..", with what follows.
static bool make_absolute(CoParser *p, const char *at, CoSlice path, const char **out)
{
    size_t base = p->prim_path_length;
    const char *rest = path.begin, *end = path.begin + path.length;
    while (end - rest >= 2 && rest[0] == '.' && rest[1] == '.') {
        if (base <= 1)
            return co_parse_fail(p, at, "found a path that leads above the root: <%.*s>",
                                 (int)path.length, path.begin);
        while (p->prim_path[base - 1] != '/')
            base--;
        base -= base > 1;
        rest += 2;
        if (rest < end && *rest == '/')
            rest++;
    }
    size_t length = base + 1 + (size_t)(end - rest);
    if (!co_parse_scratch(p, length + 1))
        return false;
    char *text = (char *)p->scratch;
    memcpy(text, p->prim_path, base);
    if (rest < end && *rest != '.' && base > 1)
        text[base++] = '/';
    memcpy(text + base, rest, (size_t)(end - rest));
    *out = co_parse_token(p, text, base + (size_t)(end - rest));
    return *out != NULL;
}

bool co_parse_path(CoParser *p, const char **out, CoPathInfo *info)
{
    const char *at = p->scan.at;
    CoSlice path;
    CoScanStatus status = co_scan_path(&p->scan, &path);
    if (status == CO_SCAN_OPEN)
        return co_parse_fail(p, at, "this path has no end; expected its closing '>' on the line");
    if (status != CO_SCAN_OK)
        return co_parse_expected(p, "a path between < and >");
    *info = (CoPathInfo){0};
    if (path.length == 0) {
        *out = p->empty;
        return true;
    }
    size_t bad;
    if (!co_path_check(path, info, &bad))
        return co_parse_fail(p, path.begin + bad, "found <%.*s>, which is no well-formed path",
                             path.length > 100 ? 100 : (int)path.length, path.begin);
    if (!info->is_absolute)
        return make_absolute(p, at, path, out);
    *out = co_parse_token(p, path.begin, path.length);
    return *out != NULL;
}
