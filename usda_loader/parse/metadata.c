// The blocks in parentheses of layers, prims and properties.

#include "parse/parser.h"

#include <string.h>

static bool is_list_op(CohortType type)
{
    return type >= COHORT_TYPE_TOKEN_LIST_OP && type <= COHORT_TYPE_UINT64_LIST_OP;
}

// ---- List operations of metadata ---------------------------------------------------------------

static bool scalar_item(CoParser *p, void *context, void *out)
{
    const CoScalar *scalar = context;
    return co_parse_scalar(p, *scalar, out);
}

static bool parse_known_list(CoParser *p, CoSpec *spec, const CoKnownField *known,
                             CoListOpKind kind)
{
    CoScalar scalar = known->type == COHORT_TYPE_TOKEN_LIST_OP    ? CO_SCALAR_TOKEN
                      : known->type == COHORT_TYPE_STRING_LIST_OP ? CO_SCALAR_STRING
                      : known->type == COHORT_TYPE_INT64_LIST_OP  ? CO_SCALAR_INT64
                                                                  : CO_SCALAR_INT;
    CoListSyntax syntax = {known->type, co_scalar_size(scalar), scalar_item, &scalar, false, true,
                           true};
    return co_parse_list_op(p, spec, known->name, kind, &syntax);
}

static bool opaque_item(CoParser *p, void *context, void *out)
{
    (void)context;
    CoValue value;
    if (!co_parse_opaque_item(p, &value))
        return false;
    memcpy(out, value.data, sizeof(CohortString));
    return true;
}

static bool set_item(CoParser *p, void *context, void *out)
{
    const char *at = p->scan.at;
    CohortString *name = out;
    (void)context;
    if (!co_parse_string(p, name))
        return false;
    return co_variant_name_check(p, at, name);
}

static bool parse_list_metadata(CoParser *p, CoSpec *spec, CoListOpKind kind)
{
    const char *at = p->scan.at;
    CoSlice word;
    if (spec->kind == CO_SPEC_PRIM || spec->kind == CO_SPEC_VARIANT) {
        if (co_scan_word(&p->scan, "references"))
            return co_parse_arcs(p, spec, false, kind);
        if (co_scan_word(&p->scan, "payload"))
            return co_parse_arcs(p, spec, true, kind);
        if (co_scan_word(&p->scan, "inherits"))
            return co_parse_path_list(p, spec, "inheritPaths", kind);
        if (co_scan_word(&p->scan, "specializes"))
            return co_parse_path_list(p, spec, "specializes", kind);
        if (co_scan_word(&p->scan, "variantSets")) {
            CoListSyntax syntax = {COHORT_TYPE_STRING_LIST_OP,
                                   sizeof(CohortString),
                                   set_item,
                                   NULL,
                                   true,
                                   false,
                                   false};
            return co_parse_list_op(p, spec, "variantSetNames", kind, &syntax);
        }
    }
    if (!co_scan_type_name(&p->scan, &word))
        return co_parse_expected(p, "the name of a list");
    const CoKnownField *known = co_known_field(word, spec->kind);
    if (known && !is_list_op(known->type))
        return co_parse_fail(p, at, "'%s' holds no list that could be edited", known->name);
    if (known)
        return parse_known_list(p, spec, known, kind);
    const char *name = co_parse_token(p, word.begin, word.length);
    if (!name)
        return false;
    CoListSyntax syntax = {
        COHORT_TYPE_OPAQUE, sizeof(CohortString), opaque_item, NULL, false, true, true};
    if (!co_parse_list_op(p, spec, name, kind, &syntax))
        return false;
    CoValue *value = co_parse_field(p, spec, name, at);
    if (value)
        value->is_array = true;
    return value != NULL;
}

// ---- Items with a syntax of their own ----------------------------------------------------------

static bool set_text(CoParser *p, CoSpec *spec, const char *field, CohortType type, const char *at,
                     const char *text, size_t length)
{
    CoValue *value = co_parse_field(p, spec, field, at);
    CohortString string = {co_parse_token(p, text, length), length};
    if (!value || !string.text)
        return false;
    *value = (CoValue){.type = type, .count = 1};
    value->data = co_parse_keep(p, &string, sizeof string);
    return value->data != NULL;
}

static bool parse_string_field(CoParser *p, CoSpec *spec, const char *field, CohortType type)
{
    const char *at = p->scan.at;
    CohortString string;
    return co_parse_assignment(p) && co_parse_string(p, &string) &&
           set_text(p, spec, field, type, at, string.text, string.length);
}

// An identifier out of a list of words; `words` NULL takes any, and none at all.
static bool parse_word_field(CoParser *p, CoSpec *spec, const char *field, const char *const *words)
{
    const char *at = p->scan.at;
    CoSlice word = {at, 0};
    if (!co_parse_assignment(p))
        return false;
    const char *word_at = p->scan.at;
    if (!co_scan_type_name(&p->scan, &word) && words)
        return co_parse_expected(p, "a word");
    bool known = !words;
    for (size_t i = 0; words && words[i]; i++)
        known |= co_slice_is(word, words[i]);
    if (!known) {
        p->scan.at = word_at;
        return co_parse_expected(p, field[0] == 'p' ? "public or private" : "the name of a unit");
    }
    return set_text(p, spec, field, COHORT_TYPE_TOKEN, at, word.begin, word.length);
}

static bool substitution_item(CoParser *p, void *context)
{
    CohortString key, *text = co_parse_alloc(p, 1, sizeof *text);
    CoValue *value = co_parse_alloc(p, 1, sizeof *value);
    if (!text || !value || !co_parse_string(p, &key))
        return false;
    co_scan_inline(&p->scan);
    if (!co_parse_char(p, ':'))
        return false;
    co_scan_inline(&p->scan);
    if (!co_parse_string(p, text))
        return false;
    *value = (CoValue){.type = COHORT_TYPE_STRING, .count = 1, .data = text};
    const char *token = co_parse_token(p, key.text, key.length);
    return token && co_dict_push(p, context, token, value);
}

static bool parse_substitutions(CoParser *p, CoSpec *spec, const char *field)
{
    const char *at = p->scan.at;
    CoDict *dict = co_parse_alloc(p, 1, sizeof *dict);
    if (!dict || !co_parse_assignment(p) || !co_parse_char(p, '{') ||
        !co_parse_list(p, '}', false, substitution_item, dict) || !co_dict_sort(p, dict))
        return false;
    CoValue *value = co_parse_field(p, spec, field, at);
    if (value)
        *value = (CoValue){.type = COHORT_TYPE_DICTIONARY, .count = 1, .data = dict};
    return value != NULL;
}

static bool is_variant_name(const CohortString *name)
{
    const char *at = name->text, *end = at + name->length;
    at += at < end && *at == '.';
    while (at < end) {
        uint32_t code;
        size_t step = co_utf8_decode(at, end, &code);
        if (!step || !(co_utf8_is_xid_continue(code) || code == '|' || code == '-'))
            return false;
        at += step;
    }
    return true;
}

static bool parse_selection(CoParser *p, CoSpec *spec)
{
    const char *at = p->scan.at;
    CoDict chosen;
    if (!co_parse_assignment(p))
        return false;
    const char *list_at = p->scan.at;
    if (!co_parse_dictionary(p, &chosen))
        return false;
    for (size_t i = 0; i < chosen.count; i++) {
        const CoValue *value = chosen.entries[i].value;
        if (value->type != COHORT_TYPE_STRING || value->is_array)
            return co_parse_fail(p, list_at, "variant set '%s' is given a %s, expected a string",
                                 chosen.entries[i].key, co_type_name(value->type));
        const CohortString *name = value->data;
        // An expression is judged when it is evaluated.
        bool is_expression =
            name->length >= 2 && name->text[0] == '`' && name->text[name->length - 1] == '`';
        if (!is_expression && !is_variant_name(name))
            return co_parse_fail(
                p, list_at, "found '%.100s', which cannot be the name of a variant", name->text);
    }
    CoValue *value = co_parse_field(p, spec, "variantSelection", at);
    if (!value)
        return false;
    CoDict *dict = co_parse_alloc(p, 1, sizeof *dict);
    if (!dict)
        return false;
    // A later dictionary adds to an earlier one.
    if (value->data)
        *dict = *(const CoDict *)value->data;
    *value = (CoValue){.type = COHORT_TYPE_VARIANT_SELECTION, .count = 1, .data = dict};
    for (size_t i = 0; i < chosen.count; i++)
        if (!co_dict_push(p, dict, chosen.entries[i].key, chosen.entries[i].value))
            return false;
    return co_dict_sort(p, dict);
}

// ---- name = value ------------------------------------------------------------------------------

static bool parse_dictionary_field(CoParser *p, CoSpec *spec, const char *name, const char *at)
{
    CoDict *dict = co_parse_alloc(p, 1, sizeof *dict);
    if (!dict || !co_parse_dictionary(p, dict))
        return false;
    CoValue *value = co_parse_field(p, spec, name, at);
    if (value)
        *value = (CoValue){.type = COHORT_TYPE_DICTIONARY, .count = 1, .data = dict};
    return value != NULL;
}

static bool parse_known(CoParser *p, CoSpec *spec, const CoKnownField *known, const char *at)
{
    if (is_list_op(known->type))
        return parse_known_list(p, spec, known, CO_LIST_EXPLICIT);
    if (!co_parse_assignment(p))
        return false;
    // Dictionaries and paths are taken as they are, whatever the type; only this one is looked at.
    bool is_rate = strcmp(known->name, "framesPerSecond") == 0;
    bool is_path = !is_rate && co_scan_peek(&p->scan) == '<';
    bool is_dictionary = !is_rate && co_scan_peek(&p->scan) == '{';
    if (is_dictionary || (known->type == COHORT_TYPE_DICTIONARY && !is_path))
        return parse_dictionary_field(p, spec, known->name, at);
    CoValue parsed;
    if (is_path ? !co_parse_opaque(p, &parsed)
                : !co_parse_value(p, known->type, known->is_array, &parsed))
        return false;
    if (is_rate && !(*(const double *)parsed.data > 0.0))
        return co_parse_fail(p, at, "found a framesPerSecond that is not above 0");
    CoValue *value = co_parse_field(p, spec, known->name, at);
    if (value)
        *value = parsed;
    return value != NULL;
}

static bool parse_type_name(CoParser *p, CoSpec *prim)
{
    CohortString text;
    if (!co_parse_assignment(p) || !co_parse_string(p, &text))
        return false;
    prim->type_name = co_parse_token(p, text.text, text.length);
    return prim->type_name != NULL;
}

static bool parse_generic(CoParser *p, CoSpec *spec)
{
    const char *at = p->scan.at;
    CoSlice word;
    bool named = co_scan_type_name(&p->scan, &word);
    if (!named && spec->kind != CO_SPEC_LAYER) {
        named = co_scan_identifier(&p->scan, &word) &&
                (co_slice_is(word, "customData") || co_slice_is(word, "symmetryArguments"));
        if (!named)
            p->scan.at = at;
    }
    if (!named)
        return co_parse_expected(p, "the name of a metadata field");
    // A prim's type may be said here as well, as a string.
    if (spec->kind == CO_SPEC_PRIM && co_slice_is(word, "typeName"))
        return parse_type_name(p, spec);
    const char *structural = co_structural_field(word, spec->kind);
    if (structural)
        return co_parse_fail(p, at, "'%s' cannot be set as metadata", structural);
    const CoKnownField *known = co_known_field(word, spec->kind);
    if (known)
        return parse_known(p, spec, known, at);
    const char *name = co_parse_token(p, word.begin, word.length);
    if (!name || !co_parse_assignment(p))
        return false;
    if (co_scan_peek(&p->scan) == '{')
        return parse_dictionary_field(p, spec, name, at);
    CoValue parsed;
    if (!co_parse_opaque(p, &parsed))
        return false;
    CoValue *value = co_parse_field(p, spec, name, at);
    if (value)
        *value = parsed;
    return value != NULL;
}

// ---- Blocks ------------------------------------------------------------------------------------

static const char *const permissions[] = {"public", "private", NULL};
static const char *const units[] = {"mm", "cm", "dm",  "m",   "km",      "in",      "ft",
                                    "yd", "mi", "deg", "rad", "percent", "default", NULL};

static bool parse_layer_item(CoParser *p, CoSpec *spec)
{
    if (co_scan_word(&p->scan, "subLayers"))
        return co_parse_sublayers(p, spec);
    if (co_scan_word(&p->scan, "relocates"))
        return co_parse_relocates(p, spec);
    return parse_generic(p, spec);
}

static bool parse_prim_item(CoParser *p, CoSpec *spec)
{
    if (co_scan_word(&p->scan, "kind"))
        return parse_string_field(p, spec, "kind", COHORT_TYPE_TOKEN);
    if (co_scan_word(&p->scan, "variants"))
        return parse_selection(p, spec);
    if (co_scan_word(&p->scan, "prefixSubstitutions"))
        return parse_substitutions(p, spec, "prefixSubstitutions");
    if (co_scan_word(&p->scan, "suffixSubstitutions"))
        return parse_substitutions(p, spec, "suffixSubstitutions");
    CoScan ahead = p->scan;
    CoSlice word;
    if (co_scan_identifier(&ahead, &word)) {
        static const char *const lists[] = {"references", "payload", "inherits", "specializes",
                                            "variantSets"};
        for (size_t i = 0; i < sizeof lists / sizeof *lists; i++)
            if (co_slice_is(word, lists[i]))
                return parse_list_metadata(p, spec, CO_LIST_EXPLICIT);
    }
    return parse_generic(p, spec);
}

static bool metadata_item(CoParser *p, void *context)
{
    CoSpec *spec = context;
    const char *at = p->scan.at;
    CoListOpKind kind;
    int c = co_scan_peek(&p->scan);
    if (c == '"' || c == '\'') {
        CohortString comment;
        return co_parse_string(p, &comment) &&
               set_text(p, spec, "comment", COHORT_TYPE_STRING, at, comment.text, comment.length);
    }
    if (co_scan_list_kind(&p->scan, &kind))
        return parse_list_metadata(p, spec, kind);
    if (co_scan_word(&p->scan, "doc"))
        return parse_string_field(p, spec, "documentation", COHORT_TYPE_STRING);
    if (spec->kind == CO_SPEC_LAYER)
        return parse_layer_item(p, spec);
    if (co_scan_word(&p->scan, "permission"))
        return parse_word_field(p, spec, "permission", permissions);
    if (co_scan_word(&p->scan, "symmetryFunction"))
        return parse_word_field(p, spec, "symmetryFunction", NULL);
    if (spec->kind == CO_SPEC_ATTRIBUTE && co_scan_word(&p->scan, "displayUnit"))
        return parse_word_field(p, spec, "displayUnit", units);
    if (spec->kind == CO_SPEC_PRIM || spec->kind == CO_SPEC_VARIANT)
        return parse_prim_item(p, spec);
    return parse_generic(p, spec);
}

bool co_parse_metadata(CoParser *p, CoSpec *spec)
{
    return co_parse_char(p, '(') && co_parse_statements(p, ')', metadata_item, spec);
}

bool co_variant_name_check(CoParser *p, const char *at, const CohortString *name)
{
    if (is_variant_name(name))
        return true;
    return co_parse_fail(p, at, "found '%.100s', which cannot be the name of a variant or set",
                         name->text);
}
