// Values as text: numbers in their shortest form, arrays, edits, splines, dictionaries.

#include "parse/writer.h"

#include "lex/scan.h"

#include <inttypes.h>
#include <string.h>

void co_write_text(CoWriter *w, const char *text)
{
    fwrite(text, 1, strlen(text), w->file);
}

void co_write_indent(CoWriter *w)
{
    for (unsigned i = 0; i < w->depth; i++)
        fwrite("    ", 1, 4, w->file);
}

// Bytes from the first on that stand for themselves in a string.
static size_t plain_length(const char *text, size_t length)
{
    size_t i = 0;
    while (i < length && ((text[i] >= 0x20 && text[i] < 0x7f) || text[i] == '\n') &&
           text[i] != '"' && text[i] != '\\')
        i++;
    return i;
}

void co_write_string(CoWriter *w, const char *text, size_t length)
{
    const char *quotes = memchr(text, '\n', length) ? "\"\"\"" : "\"";
    co_write_text(w, quotes);
    for (size_t i = 0; i < length; i++) {
        size_t plain = plain_length(text + i, length - i);
        fwrite(text + i, 1, plain, w->file);
        i += plain;
        if (i >= length)
            break;
        unsigned char c = (unsigned char)text[i];
        uint32_t code;
        size_t step = co_utf8_decode(text + i, text + length, &code);
        if (step > 1) {
            fwrite(text + i, 1, step, w->file);
            i += step - 1;
        } else if (c == '"' || c == '\\') {
            fprintf(w->file, "\\%c", c);
        } else if (c == '\t') {
            co_write_text(w, "\\t");
        } else if (c == '\r') {
            co_write_text(w, "\\r");
        } else if ((c < 0x20 && c != '\n') || c == 0x7f || step == 0) {
            fprintf(w->file, "\\x%02x", c);
        }
    }
    co_write_text(w, quotes);
}

void co_write_asset(CoWriter *w, const char *text, size_t length)
{
    bool triple = memchr(text, '@', length) != NULL;
    co_write_text(w, triple ? "@@@" : "@");
    for (size_t i = 0; i < length; i++) {
        if (triple && length - i >= 3 && memcmp(text + i, "@@@", 3) == 0) {
            co_write_text(w, "\\@@@");
            i += 2;
        } else {
            putc((unsigned char)text[i], w->file);
        }
    }
    co_write_text(w, triple ? "@@@" : "@");
}

void co_write_double(CoWriter *w, double value)
{
    char text[CO_NUMBER_TEXT];
    fwrite(text, 1, co_format_double(value, text), w->file);
}

static void write_real(CoWriter *w, CoScalar scalar, const unsigned char *at)
{
    char text[CO_NUMBER_TEXT];
    size_t length;
    if (scalar == CO_SCALAR_DOUBLE) {
        double value;
        memcpy(&value, at, sizeof value);
        length = co_format_double(value, text);
    } else if (scalar == CO_SCALAR_FLOAT) {
        float value;
        memcpy(&value, at, sizeof value);
        length = co_format_float(value, text);
    } else {
        uint16_t half;
        memcpy(&half, at, sizeof half);
        length = co_format_half(half, text);
    }
    fwrite(text, 1, length, w->file);
}

static void write_integer(CoWriter *w, CoScalar scalar, const unsigned char *at)
{
    int32_t small;
    int64_t big = 0;
    uint64_t magnitude = 0;
    if (scalar == CO_SCALAR_INT) {
        memcpy(&small, at, sizeof small);
        big = small;
    } else if (scalar == CO_SCALAR_INT64) {
        memcpy(&big, at, sizeof big);
    } else if (scalar == CO_SCALAR_UINT) {
        uint32_t value;
        memcpy(&value, at, sizeof value);
        magnitude = value;
    } else if (scalar == CO_SCALAR_UINT64) {
        memcpy(&magnitude, at, sizeof magnitude);
    } else {
        magnitude = *at;
    }
    if (big)
        magnitude = big < 0 ? 0 - (uint64_t)big : (uint64_t)big;
    char text[CO_NUMBER_TEXT];
    fwrite(text, 1, co_format_integer(big < 0, magnitude, text), w->file);
}

static void write_scalar(CoWriter *w, CoScalar scalar, const unsigned char *at)
{
    if (scalar == CO_SCALAR_BOOL) {
        co_write_text(w, *at ? "true" : "false");
    } else if (scalar >= CO_SCALAR_HALF && scalar <= CO_SCALAR_DOUBLE) {
        write_real(w, scalar, at);
    } else if (scalar < CO_SCALAR_STRING) {
        write_integer(w, scalar, at);
    } else {
        CohortString string;
        memcpy(&string, at, sizeof string);
        if (scalar == CO_SCALAR_ASSET)
            co_write_asset(w, string.text, string.length);
        else
            co_write_string(w, string.text, string.length);
    }
}

static void write_row(CoWriter *w, const CoTypeInfo *info, const unsigned char *at)
{
    size_t size = co_scalar_size(info->scalar);
    putc('(', w->file);
    for (unsigned i = 0; i < info->columns; i++) {
        unsigned from = info->is_quaternion ? (i + 3) % 4 : i;
        if (i)
            co_write_text(w, ", ");
        write_scalar(w, info->scalar, at + from * size);
    }
    putc(')', w->file);
}

static void write_element(CoWriter *w, const CoTypeInfo *info, const unsigned char *at)
{
    if (!info->columns) {
        write_scalar(w, info->scalar, at);
        return;
    }
    if (!info->rows) {
        write_row(w, info, at);
        return;
    }
    size_t row = co_scalar_size(info->scalar) * info->columns;
    putc('(', w->file);
    for (unsigned i = 0; i < info->rows; i++) {
        if (i)
            co_write_text(w, ", ");
        write_row(w, info, at + i * row);
    }
    putc(')', w->file);
}

// ---- Array edits and splines -------------------------------------------------------------------

static void write_edit_item(CoWriter *w, const CoArrayEditItem *item)
{
    static const char *const words[] = {
        [CO_EDIT_WRITE] = "write ",     [CO_EDIT_INSERT] = "insert ",
        [CO_EDIT_PREPEND] = "prepend ", [CO_EDIT_APPEND] = "append ",
        [CO_EDIT_ERASE] = "erase ",     [CO_EDIT_MINSIZE] = "minsize ",
        [CO_EDIT_MAXSIZE] = "maxsize ", [CO_EDIT_RESIZE] = "resize ",
    };
    co_write_text(w, words[item->kind]);
    if (item->kind == CO_EDIT_ERASE) {
        fprintf(w->file, "[%" PRId64 "]", item->at_or_size);
    } else if (item->kind >= CO_EDIT_MINSIZE) {
        fprintf(w->file, "%" PRId64, item->at_or_size);
        if (item->literal) {
            co_write_text(w, " fill ");
            co_write_value(w, item->literal);
        }
    } else {
        if (item->literal)
            co_write_value(w, item->literal);
        else
            fprintf(w->file, "[%" PRId64 "]", item->source);
        if (item->kind <= CO_EDIT_INSERT)
            fprintf(w->file, " %s [%" PRId64 "]", item->kind == CO_EDIT_WRITE ? "to" : "at",
                    item->at_or_size);
    }
}

static void write_array_edit(CoWriter *w, const CoArrayEdit *edit)
{
    co_write_text(w, "edit [");
    for (size_t i = 0; i < edit->count; i++) {
        if (i)
            co_write_text(w, "; ");
        write_edit_item(w, &edit->items[i]);
    }
    putc(']', w->file);
}

static void write_extrapolation(CoWriter *w, const char *side, const CoSplineExtrapolation *e)
{
    if (!e->mode[0])
        return;
    co_write_indent(w);
    fprintf(w->file, "%s: %s", side, e->mode);
    if (strcmp(e->mode, "sloped") == 0) {
        putc('(', w->file);
        co_write_double(w, e->slope);
        putc(')', w->file);
    }
    if (e->has_boundary) {
        putc('(', w->file);
        co_write_double(w, e->boundary);
        putc(')', w->file);
    }
    co_write_text(w, ",\n");
}

static void write_tangent(CoWriter *w, const CoSplineTangent *tangent)
{
    co_write_text(w, " (");
    if (tangent->has_width) {
        co_write_double(w, tangent->width);
        co_write_text(w, ", ");
    }
    co_write_double(w, tangent->slope);
    if (tangent->algorithm[0])
        fprintf(w->file, ", %s", tangent->algorithm);
    putc(')', w->file);
}

static void write_knot(CoWriter *w, const CoSplineKnot *knot)
{
    static const char *const modes[] = {"none", "held", "linear", "curve"};
    co_write_indent(w);
    co_write_double(w, knot->time);
    co_write_text(w, ": ");
    if (knot->has_pre_value) {
        co_write_double(w, knot->pre_value);
        co_write_text(w, " & ");
    }
    co_write_double(w, knot->value);
    if (knot->pre.is_set) {
        co_write_text(w, "; pre");
        write_tangent(w, &knot->pre);
    }
    if (knot->has_interp) {
        fprintf(w->file, "; post %s", modes[knot->interp]);
        if (knot->post.is_set)
            write_tangent(w, &knot->post);
    }
    if (knot->custom_data) {
        co_write_text(w, "; ");
        co_write_dictionary(w, knot->custom_data);
    }
    co_write_text(w, ",\n");
}

static void write_spline(CoWriter *w, const CoSpline *spline)
{
    co_write_text(w, "{\n");
    w->depth++;
    if (spline->curve[0]) {
        co_write_indent(w);
        fprintf(w->file, "%s,\n", spline->curve);
    }
    write_extrapolation(w, "pre", &spline->pre);
    write_extrapolation(w, "post", &spline->post);
    if (spline->has_loop) {
        co_write_indent(w);
        co_write_text(w, "loop: (");
        for (int i = 0; i < 5; i++) {
            if (i)
                co_write_text(w, ", ");
            co_write_double(w, spline->loop[i]);
        }
        co_write_text(w, "),\n");
    }
    for (size_t i = 0; i < spline->count; i++)
        write_knot(w, &spline->knots[i]);
    w->depth--;
    co_write_indent(w);
    putc('}', w->file);
}

// ---- Values ------------------------------------------------------------------------------------

static void write_key(CoWriter *w, const char *key)
{
    size_t length = strlen(key);
    bool plain = length &&
                 strspn(key, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_"
                             "0123456789") == length &&
                 !(key[0] >= '0' && key[0] <= '9');
    if (plain)
        co_write_text(w, key);
    else
        co_write_string(w, key, length);
}

void co_write_dictionary(CoWriter *w, const CoDict *dict)
{
    co_write_text(w, "{\n");
    w->depth++;
    for (size_t i = 0; i < dict->count; i++) {
        const CoValue *value = dict->entries[i].value;
        co_write_indent(w);
        fprintf(w->file, "%s%s ", co_type_name(value->type), value->is_array ? "[]" : "");
        write_key(w, dict->entries[i].key);
        co_write_text(w, " = ");
        co_write_value(w, value);
        putc('\n', w->file);
    }
    w->depth--;
    co_write_indent(w);
    putc('}', w->file);
}

static void write_samples(CoWriter *w, const CoTimeSamples *samples)
{
    co_write_text(w, "{\n");
    w->depth++;
    for (size_t i = 0; i < samples->count; i++) {
        co_write_indent(w);
        co_write_double(w, samples->times[i]);
        co_write_text(w, ": ");
        co_write_value(w, &samples->values[i]);
        co_write_text(w, ",\n");
    }
    w->depth--;
    co_write_indent(w);
    putc('}', w->file);
}

void co_write_value(CoWriter *w, const CoValue *value)
{
    const CoTypeInfo *info = co_type_info(value->type);
    const unsigned char *at = value->data;
    if (value->type == COHORT_TYPE_BLOCK || value->type == COHORT_TYPE_ANIMATION_BLOCK) {
        co_write_text(w, info->name);
    } else if (value->type == COHORT_TYPE_DICTIONARY) {
        co_write_dictionary(w, value->data);
    } else if (value->type == COHORT_TYPE_TIME_SAMPLES) {
        write_samples(w, value->data);
    } else if (value->type == COHORT_TYPE_SPLINE) {
        write_spline(w, value->data);
    } else if (value->type == COHORT_TYPE_ARRAY_EDIT) {
        write_array_edit(w, value->data);
    } else if (value->type == COHORT_TYPE_OPAQUE) {
        const CohortString *raw = value->data;
        fwrite(raw->text, 1, raw->length, w->file);
    } else if (!value->is_array) {
        write_element(w, info, at);
    } else {
        size_t size = co_type_size(value->type);
        putc('[', w->file);
        for (size_t i = 0; i < value->count; i++) {
            if (i)
                co_write_text(w, ", ");
            write_element(w, info, at + i * size);
        }
        putc(']', w->file);
    }
}
