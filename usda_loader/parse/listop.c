// List operations: add, prepend, append, delete and reorder, or the whole list said outright.

#include "base/hash.h"
#include "parse/parser.h"

#include <string.h>

bool co_scan_list_kind(CoScan *scan, CoListOpKind *kind)
{
    static const struct {
        const char *word;
        CoListOpKind kind;
    } words[] = {
        {"add", CO_LIST_ADDED},      {"prepend", CO_LIST_PREPENDED}, {"append", CO_LIST_APPENDED},
        {"delete", CO_LIST_DELETED}, {"reorder", CO_LIST_ORDERED},
    };
    const char *from = scan->at;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (co_scan_word(scan, words[i].word) && co_scan_gap(scan)) {
            *kind = words[i].kind;
            return true;
        }
    scan->at = from;
    return false;
}

// ---- Duplicates --------------------------------------------------------------------------------

static bool is_text(CohortType type)
{
    return type == COHORT_TYPE_TOKEN_LIST_OP || type == COHORT_TYPE_STRING_LIST_OP ||
           type == COHORT_TYPE_PATH_LIST_OP;
}

static bool is_arc(CohortType type)
{
    return type == COHORT_TYPE_REFERENCE_LIST_OP || type == COHORT_TYPE_PAYLOAD_LIST_OP;
}

static bool same_item(CohortType type, const void *a, const void *b, size_t size)
{
    if (is_text(type)) {
        const CohortString *x = a, *y = b;
        return x->length == y->length && memcmp(x->text, y->text, x->length) == 0;
    }
    if (is_arc(type)) {
        const CoArc *x = a, *y = b;
        return x->asset == y->asset && x->prim == y->prim &&
               memcmp(&x->offset, &y->offset, sizeof x->offset) == 0 &&
               memcmp(&x->scale, &y->scale, sizeof x->scale) == 0 && !x->custom_data &&
               !y->custom_data;
    }
    return memcmp(a, b, size) == 0;
}

static uint64_t hash_item(CohortType type, const void *item, size_t size)
{
    if (is_text(type)) {
        const CohortString *string = item;
        return co_hash_bytes(string->text, string->length, 1);
    }
    if (is_arc(type)) {
        const CoArc *arc = item;
        return co_hash_combine((uint64_t)(uintptr_t)arc->asset, (uint64_t)(uintptr_t)arc->prim);
    }
    return co_hash_bytes(item, size, 1);
}

typedef struct Items {
    const CoListSyntax *syntax;
    unsigned char *list;
    size_t count;
    bool not_empty; // in brackets
} Items;

// Puts items into a table of their numbers, in scratch; *first and *second are the numbers of the
// first two that are alike, from 1, or 0.
static bool find_duplicates(CoParser *p, CohortType type, const Items *list, size_t *first,
                            size_t *second)
{
    const unsigned char *items = list->list;
    size_t count = list->count, size = list->syntax->item_size;
    *first = *second = 0;
    if (count < 2)
        return true;
    size_t capacity = 4;
    while (capacity < count * 2)
        capacity *= 2;
    if (!co_parse_scratch(p, capacity * sizeof(size_t)))
        return false;
    size_t *table = (size_t *)(void *)p->scratch;
    memset(table, 0, capacity * sizeof *table);
    for (size_t i = 0; i < count; i++) {
        const void *item = items + i * size;
        size_t slot = (size_t)hash_item(type, item, size) & (capacity - 1);
        while (table[slot]) {
            if (same_item(type, items + (table[slot] - 1) * size, item, size)) {
                *first = table[slot];
                *second = i + 1;
                return true;
            }
            slot = (slot + 1) & (capacity - 1);
        }
        table[slot] = i + 1;
    }
    return true;
}

// ---- Lists -------------------------------------------------------------------------------------

static bool parse_item(CoParser *p, void *context)
{
    Items *items = context;
    _Alignas(16) unsigned char item[sizeof(CoArc)] = {0};
    if (!items->syntax->item(p, items->syntax->context, item))
        return false;
    void *slot = co_parse_push(p, &items->list, items->count, items->syntax->item_size);
    if (!slot)
        return false;
    items->count++;
    memcpy(slot, item, items->syntax->item_size);
    return true;
}

static bool parse_items(CoParser *p, Items *items)
{
    if (items->syntax->none && co_scan_word(&p->scan, "None"))
        return true;
    if (co_scan_char(&p->scan, '['))
        return co_parse_list(p, ']', items->not_empty, parse_item, items);
    if (!items->syntax->single)
        return co_parse_expected(p, "a list in [ ]");
    return parse_item(p, items);
}

bool co_parse_list_op(CoParser *p, CoSpec *spec, const char *field, CoListOpKind kind,
                      const CoListSyntax *syntax)
{
    const char *at = p->scan.at;
    Items items = {.syntax = syntax, .not_empty = !syntax->none || kind != CO_LIST_EXPLICIT};
    if (!co_parse_assignment(p))
        return false;
    const char *list_at = p->scan.at;
    if (!parse_items(p, &items))
        return false;
    size_t first, second;
    if (!items.count && kind != CO_LIST_EXPLICIT && !syntax->is_metadata)
        return co_parse_fail(p, list_at, "found an empty list, which only the whole list can be");
    if (!find_duplicates(p, syntax->type, &items, &first, &second))
        return false;
    if (second && syntax->is_metadata)
        return true;
    if (second)
        return co_parse_fail(p, list_at, "items %zu and %zu of this list are the same", first,
                             second);
    CoValue *value = co_parse_field(p, spec, field, at);
    if (!value)
        return false;
    CoListOp op;
    memset(&op, 0, sizeof op); // padding too: it is looked for by its bytes
    // The whole list replaces what was said before, and the other forms replace a whole list.
    bool was_list =
        value->type == syntax->type && (value->is_array || syntax->type != COHORT_TYPE_OPAQUE);
    if (was_list && kind != CO_LIST_EXPLICIT) {
        const CoListOp *before = value->data;
        if (!before->is_explicit)
            op = *before;
    }
    op.is_explicit = kind == CO_LIST_EXPLICIT;
    op.list[kind].items = co_parse_keep(p, items.list, items.count * syntax->item_size);
    op.list[kind].count = items.count;
    if (!op.list[kind].items)
        return false;
    co_parse_list_free(p, items.list, items.count, syntax->item_size);
    *value = (CoValue){.type = syntax->type, .count = 1};
    value->data = co_parse_keep(p, &op, sizeof op);
    return value->data != NULL;
}

// ---- Paths, names, arcs ------------------------------------------------------------------------

static bool path_item(CoParser *p, void *context, void *out)
{
    const char *at = p->scan.at, *path;
    const bool *prims_only = context;
    CoPathInfo info;
    CohortString *item = out;
    if (!co_parse_path(p, &path, &info))
        return false;
    if (info.has_variant)
        return co_parse_fail(p, at, "found a path with a variant selection: <%s>", path);
    bool is_root = strcmp(path, "/") == 0;
    if (*prims_only ? info.is_property || is_root || !*path : is_root || !*path || info.is_target)
        return co_parse_fail(p, at, "found <%s>, expected the path of a %s", path,
                             *prims_only ? "prim" : "prim or property");
    *item = (CohortString){path, strlen(path)};
    return true;
}

bool co_parse_path_list(CoParser *p, CoSpec *spec, const char *field, CoListOpKind kind)
{
    bool prims_only = strcmp(field, "inheritPaths") == 0 || strcmp(field, "specializes") == 0;
    CoListSyntax syntax = {
        COHORT_TYPE_PATH_LIST_OP, sizeof(CohortString), path_item, &prims_only, true, true, false};
    return co_parse_list_op(p, spec, field, kind, &syntax);
}

typedef struct Names {
    CohortString *list;
    uint32_t count;
} Names;

static bool name_item(CoParser *p, void *context)
{
    Names *names = context;
    CohortString string, *slot;
    if (!co_parse_string(p, &string))
        return false;
    slot = co_parse_push(p, &names->list, names->count, sizeof *slot);
    if (!slot)
        return false;
    *slot = string;
    names->count++;
    return true;
}

bool co_parse_names(CoParser *p, CoSpec *spec, const char *field)
{
    const char *at = p->scan.at;
    Names names = {0};
    if (!co_parse_assignment(p))
        return false;
    bool good = co_scan_char(&p->scan, '[') ? co_parse_list(p, ']', true, name_item, &names)
                                            : name_item(p, &names);
    CoValue *value = good ? co_parse_field(p, spec, field, at) : NULL;
    if (value)
        *value = (CoValue){COHORT_TYPE_TOKEN, true, names.count, names.list};
    return value != NULL;
}

typedef struct ArcParameters {
    CoArc *arc;
    bool is_payload;
} ArcParameters;

static bool arc_parameter(CoParser *p, void *context)
{
    ArcParameters *parameters = context;
    CoArc *arc = parameters->arc;
    bool found;
    if (!co_parse_layer_offset(p, &arc->offset, &arc->scale, &found))
        return false;
    if (found)
        return true;
    if (parameters->is_payload || !co_scan_word(&p->scan, "customData"))
        return co_parse_expected(p, parameters->is_payload ? "offset or scale"
                                                           : "offset, scale or customData");
    CoValue *value = co_parse_alloc(p, 1, sizeof *value);
    CoDict *dict = co_parse_alloc(p, 1, sizeof *dict);
    if (!value || !dict || !co_parse_assignment(p) || !co_parse_dictionary(p, dict))
        return false;
    *value = (CoValue){.type = COHORT_TYPE_DICTIONARY, .count = 1, .data = dict};
    arc->custom_data = dict->count ? value : NULL;
    return true;
}

static bool arc_path(CoParser *p, CoArc *arc)
{
    const char *at = p->scan.at;
    CoPathInfo info;
    if (!co_parse_path(p, &arc->prim, &info))
        return false;
    if (!*arc->prim)
        return true;
    if (info.has_variant)
        return co_parse_fail(p, at, "found a path with a variant selection: <%s>", arc->prim);
    if (!info.is_absolute || info.is_property || info.is_root)
        return co_parse_fail(p, at, "found a path that is not the absolute path of a prim");
    return true;
}

static bool arc_item(CoParser *p, void *context, void *out)
{
    const bool *is_payload = context;
    const char *at = p->scan.at;
    CoArc *arc = out;
    arc->scale = 1.0;
    arc->line = co_parse_line(p, at);
    arc->asset = arc->prim = p->empty;
    if (co_scan_peek(&p->scan) == '<') {
        if (!arc_path(p, arc))
            return false;
    } else {
        CohortString asset;
        if (!co_parse_asset(p, &asset))
            return false;
        if (!asset.length)
            return co_parse_fail(p, at, "found an empty asset path; leave @@ out for this layer");
        arc->asset = co_parse_token(p, asset.text, asset.length);
        co_scan_inline(&p->scan);
        if (!arc->asset || (co_scan_peek(&p->scan) == '<' && !arc_path(p, arc)))
            return false;
    }
    CoScan ahead = p->scan;
    co_scan_inline(&ahead);
    if (!co_scan_char(&ahead, '('))
        return true;
    p->scan.at = ahead.at;
    ArcParameters parameters = {arc, *is_payload};
    return co_parse_statements(p, ')', arc_parameter, &parameters);
}

bool co_parse_arcs(CoParser *p, CoSpec *spec, bool is_payload, CoListOpKind kind)
{
    CoListSyntax syntax = {is_payload ? COHORT_TYPE_PAYLOAD_LIST_OP : COHORT_TYPE_REFERENCE_LIST_OP,
                           sizeof(CoArc),
                           arc_item,
                           &is_payload,
                           true,
                           true,
                           false};
    return co_parse_list_op(p, spec, is_payload ? "payload" : "references", kind, &syntax);
}
