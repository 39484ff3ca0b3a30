// Fields as text: metadata, list ops, arcs.

#include "parse/writer.h"

#include <inttypes.h>
#include <string.h>

// Fields that stand elsewhere than in the block of metadata.
static const char *const statements[] = {
    "connectionPaths", "default",     "primOrder",   "propertyOrder",
    "spline",          "targetPaths", "timeSamples",
};

// Of metadata that is not known: it may have any name.
static bool is_unknown(const CoValue *value)
{
    return value->type == COHORT_TYPE_OPAQUE || value->type == COHORT_TYPE_DICTIONARY;
}

bool co_is_metadata(const CoField *field)
{
    if (is_unknown(&field->value) && strcmp(field->name, "default") != 0)
        return true;
    for (size_t i = 0; i < sizeof statements / sizeof *statements; i++)
        if (strcmp(field->name, statements[i]) == 0)
            return false;
    return true;
}

// The word for a field in the text, where it is another.
static const char *word_of(const CoField *field)
{
    const char *name = field->name;
    static const char *const words[][2] = {
        {"documentation", "doc"},
        {"inheritPaths", "inherits"},
        {"variantSelection", "variants"},
        {"variantSetNames", "variantSets"},
    };
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (strcmp(name, words[i][0]) == 0 && !is_unknown(&field->value))
            return words[i][1];
    return name;
}

// ---- List operations ---------------------------------------------------------------------------

const char *co_list_word(CoListOpKind kind)
{
    static const char *const words[CO_LIST_KIND_COUNT] = {
        [CO_LIST_EXPLICIT] = "",          [CO_LIST_ADDED] = "add ",
        [CO_LIST_PREPENDED] = "prepend ", [CO_LIST_APPENDED] = "append ",
        [CO_LIST_DELETED] = "delete ",    [CO_LIST_ORDERED] = "reorder ",
    };
    return words[kind];
}

bool co_list_op_next(const CoListOp *op, CoListOpKind *kind, bool first)
{
    if (op->is_explicit) {
        *kind = CO_LIST_EXPLICIT;
        return first;
    }
    unsigned next = first ? CO_LIST_ADDED : (unsigned)*kind + 1;
    while (next < CO_LIST_KIND_COUNT && !op->list[next].count)
        next++;
    *kind = (CoListOpKind)next;
    return next < CO_LIST_KIND_COUNT;
}

static void write_offset(CoWriter *w, const CoArc *arc)
{
    bool offset = arc->offset != 0.0, scale = arc->scale != 1.0;
    if (!offset && !scale && !arc->custom_data)
        return;
    co_write_text(w, " (");
    if (offset) {
        co_write_text(w, "offset = ");
        co_write_double(w, arc->offset);
    }
    if (scale) {
        co_write_text(w, offset ? "; scale = " : "scale = ");
        co_write_double(w, arc->scale);
    }
    if (arc->custom_data) {
        co_write_text(w, offset || scale ? "; customData = " : "customData = ");
        co_write_value(w, arc->custom_data);
    }
    putc(')', w->file);
}

static void write_arc(CoWriter *w, const CoArc *arc)
{
    if (arc->asset[0])
        co_write_asset(w, arc->asset, strlen(arc->asset));
    if (arc->prim[0] || !arc->asset[0])
        fprintf(w->file, "<%s>", arc->prim);
    write_offset(w, arc);
}

static void write_item(CoWriter *w, CohortType type, const void *items, size_t i)
{
    const CohortString *strings = items;
    if (type == COHORT_TYPE_REFERENCE_LIST_OP || type == COHORT_TYPE_PAYLOAD_LIST_OP)
        write_arc(w, (const CoArc *)items + i);
    else if (type == COHORT_TYPE_PATH_LIST_OP)
        fprintf(w->file, "<%s>", strings[i].text);
    else if (type == COHORT_TYPE_OPAQUE)
        fwrite(strings[i].text, 1, strings[i].length, w->file);
    else if (type == COHORT_TYPE_INT64_LIST_OP)
        fprintf(w->file, "%" PRId64, ((const int64_t *)items)[i]);
    else if (type == COHORT_TYPE_INT_LIST_OP)
        fprintf(w->file, "%" PRId32, ((const int32_t *)items)[i]);
    else if (type == COHORT_TYPE_UINT_LIST_OP)
        fprintf(w->file, "%" PRIu32, ((const uint32_t *)items)[i]);
    else if (type == COHORT_TYPE_UINT64_LIST_OP)
        fprintf(w->file, "%" PRIu64, ((const uint64_t *)items)[i]);
    else
        co_write_string(w, strings[i].text, strings[i].length);
}

void co_write_items(CoWriter *w, CohortType type, const void *items, size_t count)
{
    if (!count) {
        co_write_text(w, "None");
        return;
    }
    putc('[', w->file);
    for (size_t i = 0; i < count; i++) {
        if (i)
            co_write_text(w, ", ");
        write_item(w, type, items, i);
    }
    putc(']', w->file);
}

static void write_list_op(CoWriter *w, const char *name, const CoValue *value)
{
    const CoListOp *op = value->data;
    CoListOpKind kind = CO_LIST_EXPLICIT;
    if (!co_list_op_next(op, &kind, true)) {
        co_write_indent(w);
        fprintf(w->file, "add %s = None\n", name);
    }
    for (bool more = co_list_op_next(op, &kind, true); more;
         more = co_list_op_next(op, &kind, false)) {
        co_write_indent(w);
        fprintf(w->file, "%s%s = ", co_list_word(kind), name);
        co_write_items(w, value->type, op->list[kind].items, op->list[kind].count);
        putc('\n', w->file);
    }
}

// ---- Other shapes ------------------------------------------------------------------------------

static void write_sublayers(CoWriter *w, const CoValue *value)
{
    const CoArc *arcs = value->data;
    co_write_text(w, "[\n");
    w->depth++;
    for (size_t i = 0; i < value->count; i++) {
        co_write_indent(w);
        co_write_asset(w, arcs[i].asset, strlen(arcs[i].asset));
        write_offset(w, &arcs[i]);
        co_write_text(w, ",\n");
    }
    w->depth--;
    co_write_indent(w);
    putc(']', w->file);
}

static void write_relocates(CoWriter *w, const CoValue *value)
{
    const CoRelocate *relocates = value->data;
    co_write_text(w, "{\n");
    w->depth++;
    for (size_t i = 0; i < value->count; i++) {
        co_write_indent(w);
        fprintf(w->file, "<%s>: <%s>,\n", relocates[i].source, relocates[i].target);
    }
    w->depth--;
    co_write_indent(w);
    putc('}', w->file);
}

static void write_substitutions(CoWriter *w, const CoDict *dict)
{
    putc('{', w->file);
    for (size_t i = 0; i < dict->count; i++) {
        const CohortString *text = dict->entries[i].value->data;
        if (i)
            co_write_text(w, ", ");
        co_write_string(w, dict->entries[i].key, strlen(dict->entries[i].key));
        co_write_text(w, ": ");
        co_write_string(w, text->text, text->length);
    }
    putc('}', w->file);
}

static bool is_bare_word(const char *name)
{
    return strcmp(name, "permission") == 0 || strcmp(name, "symmetryFunction") == 0 ||
           strcmp(name, "displayUnit") == 0;
}

static bool is_list(const CoValue *value)
{
    return (value->type >= COHORT_TYPE_TOKEN_LIST_OP &&
            value->type <= COHORT_TYPE_PAYLOAD_LIST_OP) ||
           (value->type == COHORT_TYPE_OPAQUE && value->is_array);
}

void co_write_metadata(CoWriter *w, const CoField *field)
{
    const CoValue *value = &field->value;
    const char *word = word_of(field);
    if (is_list(value)) {
        write_list_op(w, word, value);
        return;
    }
    co_write_indent(w);
    if (strcmp(field->name, "comment") == 0) {
        co_write_value(w, value);
        putc('\n', w->file);
        return;
    }
    fprintf(w->file, "%s = ", word);
    if (value->type == COHORT_TYPE_SUBLAYERS) {
        write_sublayers(w, value);
    } else if (value->type == COHORT_TYPE_RELOCATES) {
        write_relocates(w, value);
    } else if (value->type == COHORT_TYPE_VARIANT_SELECTION) {
        co_write_dictionary(w, value->data);
    } else if (is_bare_word(field->name)) {
        const CohortString *text = value->data;
        fwrite(text->text, 1, text->length, w->file);
    } else if (strcmp(field->name, "prefixSubstitutions") == 0 ||
               strcmp(field->name, "suffixSubstitutions") == 0) {
        write_substitutions(w, value->data);
    } else {
        co_write_value(w, value);
    }
    putc('\n', w->file);
}
