// Text on its way to a file: what the writing half of this room calls of each other.

#ifndef CO_PARSE_WRITER_H
#define CO_PARSE_WRITER_H

#include "parse/layer.h"
#include "parse/types.h"

#include <stdio.h>

// Longest text of a number, with its NUL.
enum {
    CO_NUMBER_TEXT = 40
};

typedef struct CoWriter {
    FILE *file;
    unsigned depth; // levels of indentation
} CoWriter;

// The shortest decimal that reads back as exactly this number (format.c). Returns the length.
size_t co_format_double(double value, char out[CO_NUMBER_TEXT]);
size_t co_format_float(float value, char out[CO_NUMBER_TEXT]);
size_t co_format_half(uint16_t half, char out[CO_NUMBER_TEXT]);
size_t co_format_integer(bool negative, uint64_t magnitude, char out[CO_NUMBER_TEXT]);

// ---- write_layer.c
// The whole layer onto an open stream, whose errors the caller looks for.
void co_write_layer(const CoLayer *layer, FILE *file);

// ---- write_value.c
void co_write_text(CoWriter *w, const char *text);
void co_write_indent(CoWriter *w);
void co_write_string(CoWriter *w, const char *text, size_t length); // quoted
void co_write_asset(CoWriter *w, const char *text, size_t length);
void co_write_double(CoWriter *w, double value);
// Anything that may stand behind an '='; a dictionary's braces enclose lines of their own.
void co_write_value(CoWriter *w, const CoValue *value);
void co_write_dictionary(CoWriter *w, const CoDict *dict);

// ---- write_field.c
// One metadata field as the lines it takes; nothing for fields that are no metadata.
void co_write_metadata(CoWriter *w, const CoField *field);
bool co_is_metadata(const CoField *field);
// The items of one list in brackets, or None.
void co_write_items(CoWriter *w, CohortType type, const void *items, size_t count);
const char *co_list_word(CoListOpKind kind); // "prepend ", "" for the whole list
// The lists of an op in the order in which they are written; false past the last.
bool co_list_op_next(const CoListOp *op, CoListOpKind *kind, bool first);

#endif
