// Prims, what stands between their braces, and variants.

#include "parse/parser.h"

#include "base/stop.h"

#include <string.h>

// What must follow a statement: blanks and comments, then a line end, or ';' where that is allowed.
static bool end_statement(CoParser *p, bool semicolon, bool at_end)
{
    co_scan_line(&p->scan);
    int c = co_scan_peek(&p->scan);
    if (c == '\r' || c == '\n' || (semicolon && c == ';')) {
        p->scan.at++;
        return true;
    }
    if (c < 0 && at_end)
        return true;
    return co_parse_expected(p, semicolon ? "a line end or ';'" : "a line end");
}

// ---- Names -------------------------------------------------------------------------------------

static bool push_path(CoParser *p, const char *name, size_t length)
{
    size_t needed = p->prim_path_length + length + 2;
    if (needed > p->prim_path_capacity) {
        size_t capacity = needed * 2;
        char *grown = co_realloc(CO_MEMORY_USDA, p->prim_path, p->prim_path_capacity, capacity);
        if (!grown)
            return co_parse_stop(p, p->scan.at, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
        p->prim_path = grown;
        p->prim_path_capacity = capacity;
    }
    if (p->prim_path_length > 1)
        p->prim_path[p->prim_path_length++] = '/';
    memcpy(p->prim_path + p->prim_path_length, name, length + 1);
    p->prim_path_length += length;
    return true;
}

bool co_parse_set_prim_path(CoParser *p, const char *path, size_t length)
{
    p->prim_path_length = 0;
    return push_path(p, path, length);
}

static void pop_path(CoParser *p, size_t length)
{
    p->prim_path_length = length;
    p->prim_path[length] = '\0';
}

static bool parse_prim_name(CoParser *p, const char **name)
{
    const char *at = p->scan.at;
    CohortString string;
    if (!co_parse_string(p, &string))
        return false;
    // Up to a NUL, as the keys of dictionaries.
    CoSlice slice = {string.text, strlen(string.text)};
    if (!co_slice_is_identifier(slice))
        return co_parse_fail(p, at, "found '%.100s', which cannot be the name of a prim",
                             string.text);
    *name = co_parse_token(p, slice.begin, slice.length);
    return *name != NULL;
}

// A type, dots between its parts allowed; then a blank.
static bool parse_type(CoParser *p, const char **type)
{
    const char *from = p->scan.at;
    CoSlice part;
    if (!co_scan_type_name(&p->scan, &part)) {
        *type = p->empty;
        return true;
    }
    const char *stop = p->scan.at;
    while (co_scan_char(&p->scan, '.') && co_scan_type_name(&p->scan, &part))
        stop = p->scan.at;
    p->scan.at = stop;
    *type = co_parse_token(p, from, (size_t)(stop - from));
    if (!*type)
        return false;
    return co_scan_gap(&p->scan) || co_parse_expected(p, "a blank and the prim's name in quotes");
}

// ---- Variants ----------------------------------------------------------------------------------

static CoSpec *find_set(CoParser *p, CoSpec *owner, const CohortString *name, const char *at)
{
    const char *token = co_parse_token(p, name->text, name->length);
    if (!token)
        return NULL;
    CoSpec *known = co_parse_variant_set(owner, token);
    return known ? known : co_parse_spec(p, owner, CO_SPEC_VARIANT_SET, token, at);
}

static CoSpec *find_variant(CoParser *p, CoSpec *set, const CohortString *name, const char *at)
{
    const char *token = co_parse_token(p, name->text, name->length);
    if (!token)
        return NULL;
    CoSpec *known = co_parse_child(set, token);
    return known ? known : co_parse_spec(p, set, CO_SPEC_VARIANT, token, at);
}

static bool parse_variant(CoParser *p, CoSpec *set)
{
    const char *at = p->scan.at;
    CohortString name;
    if (!co_parse_string(p, &name) || !co_variant_name_check(p, at, &name))
        return false;
    CoSpec *variant = find_variant(p, set, &name, at);
    if (!variant)
        return false;
    co_scan_space(&p->scan);
    if (co_scan_peek(&p->scan) == '(') {
        if (!co_parse_metadata(p, variant))
            return false;
        co_scan_space(&p->scan);
    }
    return co_parse_char(p, '{') && co_parse_contents(p, variant);
}

static bool parse_variant_set(CoParser *p, CoSpec *owner)
{
    const char *at = p->scan.at;
    CohortString name;
    if (!co_scan_gap(&p->scan))
        return co_parse_expected(p, "a blank and the variant set's name in quotes");
    if (!co_parse_string(p, &name) || !co_variant_name_check(p, at, &name))
        return false;
    co_scan_inline(&p->scan);
    if (!co_parse_char(p, '='))
        return false;
    CoSpec *set = find_set(p, owner, &name, at);
    co_scan_space(&p->scan);
    if (!set || !co_parse_char(p, '{'))
        return false;
    co_parse_clear_children(set);
    // "{}" may stand for no variants, but not with anything between.
    bool done = co_scan_char(&p->scan, '}');
    while (!done) {
        co_scan_space(&p->scan);
        if (!parse_variant(p, set))
            return false;
        co_scan_space(&p->scan);
        done = co_scan_char(&p->scan, '}');
    }
    return true;
}

// ---- Prims -------------------------------------------------------------------------------------

// Its number, or -1.
static int scan_specifier(CoScan *scan)
{
    static const char *const words[] = {"def", "over", "class"};
    for (int i = 0; i < 3; i++)
        if (co_scan_word(scan, words[i]))
            return i;
    return -1;
}

bool co_prim_begins(const CoScan *scan)
{
    CoScan ahead = *scan;
    return scan_specifier(&ahead) >= 0;
}

bool co_parse_prim(CoParser *p, CoSpec *parent, bool *found)
{
    const char *at = p->scan.at, *type = NULL, *name = NULL;
    int specifier = scan_specifier(&p->scan);
    *found = specifier >= 0;
    if (!*found)
        return true;
    if (co_is_stopped(p->stop))
        return co_parse_give_up(p);
    if (!co_scan_gap(&p->scan))
        return co_parse_expected(p, "a blank and a type or a name in quotes");
    if (!parse_type(p, &type) || !parse_prim_name(p, &name))
        return false;
    const CoSpec *before = co_spec_child(parent, name);
    if (before)
        return co_parse_fail(p, at, "prim '%s' stands here a second time; the first is on line %u",
                             name, before->line);
    if (++p->prim_count > p->max_prims)
        return co_parse_stop(p, at, COHORT_ERROR_LIMIT,
                             "more than %llu prims; raise max_prims to read it",
                             (unsigned long long)p->max_prims);
    CoSpec *prim = co_parse_spec(p, parent, CO_SPEC_PRIM, name, at);
    size_t length = p->prim_path_length;
    if (!prim || !push_path(p, name, strlen(name)))
        return false;
    prim->specifier = (CohortSpecifier)specifier;
    prim->type_name = type;
    co_scan_space(&p->scan);
    bool good = true;
    if (co_scan_peek(&p->scan) == '(') {
        good = co_parse_metadata(p, prim);
        co_scan_space(&p->scan);
    }
    if (!p->stopped && (good || co_scan_peek(&p->scan) == '{'))
        good = co_parse_char(p, '{') && co_parse_contents(p, prim) && good;
    pop_path(p, length);
    return good;
}

bool co_parse_prims(CoParser *p, CoSpec *parent)
{
    while (p->scan.at < p->scan.end) {
        bool found;
        if (!co_parse_prim(p, parent, &found) || !found || !end_statement(p, false, false))
            return false;
        co_scan_space(&p->scan);
    }
    return true;
}

// reorder nameChildren = [...], reorder properties = [...]
static bool parse_order(CoParser *p, CoSpec *spec, bool *found)
{
    CoScan ahead = p->scan;
    *found = false;
    if (!co_scan_word(&ahead, "reorder") || !co_scan_gap(&ahead))
        return true;
    bool children = co_scan_word(&ahead, "nameChildren");
    if (!children && !co_scan_word(&ahead, "properties"))
        return true;
    co_scan_inline(&ahead);
    if (co_scan_peek(&ahead) != '=')
        return true;
    *found = true;
    p->scan.at = ahead.at;
    return co_parse_names(p, spec, children ? "primOrder" : "propertyOrder");
}

static bool parse_item(CoParser *p, CoSpec *spec)
{
    bool found;
    if (!parse_order(p, spec, &found))
        return false;
    if (found)
        return end_statement(p, true, false);
    if (!co_parse_prim(p, spec, &found))
        return false;
    if (found)
        return end_statement(p, false, false);
    if (co_scan_word(&p->scan, "variantSet"))
        return parse_variant_set(p, spec) && end_statement(p, false, false);
    if (!co_parse_property(p, spec, &found))
        return false;
    if (!found)
        return co_parse_expected(p, "a property, a prim, a variant set or '}'");
    return end_statement(p, true, false);
}

bool co_parse_contents(CoParser *p, CoSpec *spec)
{
    bool good = true;
    if (!co_parse_deeper(p, p->scan.at))
        return false;
    for (;;) {
        co_scan_space(&p->scan);
        if (co_scan_char(&p->scan, '}'))
            break;
        if (p->scan.at >= p->scan.end) {
            good = co_parse_expected(p, "'}'");
            break;
        }
        const char *before = p->scan.at;
        if (co_parse_siblings(p, spec) || (!p->stopped && parse_item(p, spec)))
            continue;
        good = false;
        if (p->stopped)
            break;
        co_parse_recover(p);
        if (p->scan.at == before || co_scan_peek(&p->scan) == ';' || co_scan_peek(&p->scan) == ')')
            p->scan.at += p->scan.at < p->scan.end && *p->scan.at != '}';
    }
    p->depth--;
    return good;
}
