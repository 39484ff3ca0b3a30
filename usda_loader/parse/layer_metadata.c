// What only the block of a layer holds: sublayers and relocates.

#include "parse/parser.h"

#include <string.h>

bool co_parse_layer_offset(CoParser *p, double *offset, double *scale, bool *found)
{
    bool is_scale = co_scan_word(&p->scan, "scale");
    *found = is_scale || co_scan_word(&p->scan, "offset");
    if (!*found)
        return true;
    if (!co_parse_assignment(p))
        return false;
    CoNumber number;
    if (co_scan_number(&p->scan, &number) != CO_SCAN_OK)
        return co_parse_expected(p, "a number");
    *(is_scale ? scale : offset) = number.real;
    return true;
}

static bool sublayer_parameter(CoParser *p, void *context)
{
    CoArc *arc = context;
    bool found;
    if (!co_parse_layer_offset(p, &arc->offset, &arc->scale, &found))
        return false;
    return found || co_parse_expected(p, "offset or scale");
}

typedef struct ItemList {
    void *items;
    uint32_t count;
} ItemList;

static bool sublayer_item(CoParser *p, void *context)
{
    ItemList *list = context;
    CohortString asset;
    CoArc arc = {.prim = p->empty, .scale = 1.0, .line = co_parse_line(p, p->scan.at)};
    if (!co_parse_asset(p, &asset))
        return false;
    arc.asset = co_parse_token(p, asset.text, asset.length);
    if (!arc.asset)
        return false;
    CoScan ahead = p->scan;
    co_scan_inline(&ahead);
    if (co_scan_char(&ahead, '(')) {
        p->scan.at = ahead.at;
        if (!co_parse_statements(p, ')', sublayer_parameter, &arc))
            return false;
    }
    CoArc *slot = co_parse_push(p, &list->items, list->count, sizeof *slot);
    if (!slot)
        return false;
    *slot = arc;
    list->count++;
    return true;
}

bool co_parse_sublayers(CoParser *p, CoSpec *spec)
{
    const char *at = p->scan.at;
    ItemList list = {0};
    if (!co_parse_assignment(p) || !co_parse_char(p, '[') ||
        !co_parse_list(p, ']', false, sublayer_item, &list))
        return false;
    CoValue *value = co_parse_field(p, spec, "subLayers", at);
    if (value)
        *value = (CoValue){.type = COHORT_TYPE_SUBLAYERS,
                           .is_array = true,
                           .count = list.count,
                           .data = list.items};
    return value != NULL;
}

// A target above the root is none.
static bool leads_above_root(const CoScan *scan)
{
    CoScan ahead = *scan;
    CoSlice path;
    CoPathInfo info;
    size_t bad;
    return co_scan_path(&ahead, &path) == CO_SCAN_OK && path.length >= 2 &&
           memcmp(path.begin, "..", 2) == 0 && co_path_check(path, &info, &bad);
}

static bool relocate_path(CoParser *p, bool may_be_empty, const char **out)
{
    const char *at = p->scan.at;
    CoPathInfo info;
    if (may_be_empty && leads_above_root(&p->scan)) {
        CoSlice ignored;
        *out = p->empty;
        return co_scan_path(&p->scan, &ignored) == CO_SCAN_OK;
    }
    if (!co_parse_path(p, out, &info))
        return false;
    bool good = **out ? !info.is_root && !info.is_property && !info.has_variant : may_be_empty;
    return good || co_parse_fail(p, at, "found <%s>, expected the path of a prim", *out);
}

static bool relocate_item(CoParser *p, void *context)
{
    ItemList *list = context;
    CoRelocate relocate;
    if (!relocate_path(p, false, &relocate.source))
        return false;
    co_scan_inline(&p->scan);
    if (!co_parse_char(p, ':'))
        return false;
    co_scan_inline(&p->scan);
    if (!relocate_path(p, true, &relocate.target))
        return false;
    CoRelocate *slot = co_parse_push(p, &list->items, list->count, sizeof *slot);
    if (!slot)
        return false;
    *slot = relocate;
    list->count++;
    return true;
}

bool co_parse_relocates(CoParser *p, CoSpec *spec)
{
    const char *at = p->scan.at;
    ItemList list = {0};
    if (!co_parse_assignment(p) || !co_parse_char(p, '{') ||
        !co_parse_list(p, '}', false, relocate_item, &list))
        return false;
    CoValue *value = co_parse_field(p, spec, "relocates", at);
    if (value)
        *value = (CoValue){.type = COHORT_TYPE_RELOCATES,
                           .is_array = true,
                           .count = list.count,
                           .data = list.items};
    return value != NULL;
}
