// Dictionaries: { type key = value; ... }, nested, sorted by key.

#include "parse/parser.h"

#include <stdlib.h>
#include <string.h>

typedef struct Numbered {
    CoDictEntry entry;
    size_t number;
} Numbered;

static int by_key(const void *a, const void *b)
{
    const Numbered *x = a, *y = b;
    int order = strcmp(x->entry.key, y->entry.key);
    return order ? order : x->number < y->number ? -1 : 1;
}

bool co_dict_sort(CoParser *p, CoDict *dict)
{
    bool sorted = true;
    for (size_t i = 1; i < dict->count && sorted; i++)
        sorted = strcmp(dict->entries[i - 1].key, dict->entries[i].key) < 0;
    if (sorted)
        return true;
    if (!co_parse_scratch(p, dict->count * sizeof(Numbered)))
        return false;
    Numbered *numbered = (Numbered *)(void *)p->scratch;
    for (size_t i = 0; i < dict->count; i++)
        numbered[i] = (Numbered){dict->entries[i], i};
    qsort(numbered, dict->count, sizeof *numbered, by_key);
    size_t kept = 0;
    for (size_t i = 0; i < dict->count; i++) {
        bool again = i + 1 < dict->count && numbered[i].entry.key == numbered[i + 1].entry.key;
        if (!again)
            dict->entries[kept++] = numbered[i].entry;
    }
    dict->count = kept;
    return true;
}

bool co_dict_push(CoParser *p, CoDict *dict, const char *key, CoValue *value)
{
    CoDictEntry *entry = co_parse_push(p, &dict->entries, dict->count, sizeof *entry);
    if (!entry)
        return false;
    *entry = (CoDictEntry){key, value};
    dict->count++;
    return true;
}

static bool parse_key(CoParser *p, const char **key)
{
    CoSlice word;
    int c = co_scan_peek(&p->scan);
    if (c == '"' || c == '\'') {
        CohortString string;
        if (!co_parse_string(p, &string))
            return false;
        // Keys are known by their text up to a NUL, here as everywhere.
        *key = co_parse_token(p, string.text, strlen(string.text));
        return *key != NULL;
    }
    if (!co_scan_identifier(&p->scan, &word))
        return co_parse_expected(p, "a key: a name or a quoted string");
    *key = co_parse_token(p, word.begin, word.length);
    return *key != NULL;
}

static bool parse_typed(CoParser *p, const char **key, CoValue *value)
{
    const char *at = p->scan.at;
    CoSlice name;
    if (!co_scan_type_name(&p->scan, &name))
        return co_parse_expected(p, "a type name");
    CoScan ahead = p->scan;
    co_scan_inline(&ahead);
    bool is_array = co_scan_char(&ahead, '['), ignored;
    if (is_array) {
        p->scan.at = ahead.at;
        co_scan_inline(&p->scan);
        if (!co_parse_char(p, ']'))
            return false;
    }
    CohortType type;
    if (!co_type_from_name(name.begin, name.length, &type, &ignored))
        return co_parse_fail(p, at, "found '%.*s', expected the name of a type",
                             name.length > 60 ? 60 : (int)name.length, name.begin);
    if (!co_scan_gap(&p->scan))
        return co_parse_expected(p, "a blank and a key");
    if (!parse_key(p, key) || !co_parse_assignment(p))
        return false;
    // A path stands for itself whatever the type.
    return co_scan_peek(&p->scan) == '<' ? co_parse_opaque(p, value)
                                         : co_parse_value(p, type, is_array, value);
}

static bool parse_entry(CoParser *p, void *context)
{
    CoDict *dict = context;
    const char *key;
    CoValue parsed;
    if (co_scan_word(&p->scan, "dictionary")) {
        CoDict *inner = co_parse_alloc(p, 1, sizeof *inner);
        if (!inner)
            return false;
        if (!co_scan_gap(&p->scan))
            return co_parse_expected(p, "a blank and a key");
        if (!parse_key(p, &key) || !co_parse_assignment(p) || !co_parse_dictionary(p, inner))
            return false;
        parsed = (CoValue){.type = COHORT_TYPE_DICTIONARY, .count = 1, .data = inner};
    } else if (!parse_typed(p, &key, &parsed)) {
        return false;
    }
    CoValue *value = co_parse_alloc(p, 1, sizeof *value);
    if (!value)
        return false;
    *value = parsed;
    return co_dict_push(p, dict, key, value);
}

bool co_parse_dictionary(CoParser *p, CoDict *out)
{
    const char *at = p->scan.at;
    *out = (CoDict){0};
    if (!co_parse_char(p, '{') || !co_parse_deeper(p, at))
        return false;
    bool good = co_parse_statements(p, '}', parse_entry, out);
    p->depth--;
    return good && co_dict_sort(p, out);
}
