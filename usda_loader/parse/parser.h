// The state of one parse, and what the files of this room call of each other.
//
// Every co_parse_* consumes what its name says from p->scan and returns true, or reports what was
// found and what was expected, and returns false with the cursor anywhere. Whoever parses a
// statement list skips to the next statement then, so that one file can yield several errors.

#ifndef CO_PARSE_PARSER_H
#define CO_PARSE_PARSER_H

#include "lex/number.h"
#include "lex/scan.h"
#include "parse/layer.h"
#include "parse/types.h"

enum {
    CO_NAME_CACHE = 64,
    CO_TOKEN_CACHE = 256,
    CO_KEPT_CACHE = 256,
    CO_SPARE_SIZES = 13 // blocks of up to 4096 bytes
};

typedef struct CoKnownToken {
    const char *token;
    uint64_t hash;
    size_t length;
} CoKnownToken;

typedef struct CoKnownType {
    const char *name; // token
    CohortType type;
    bool is_array;
} CoKnownType;

typedef struct CoKept {
    const void *data;
    size_t size, align;
} CoKept;

typedef struct CoSiblings CoSiblings;

typedef struct CoParser {
    CoScan scan;
    CoLayer *layer;
    uint64_t max_depth, max_array_length, max_prims;
    uint64_t max_edit_size; // elements that an array edit may ask for
    uint64_t depth, prim_count;
    CohortDiagnosticFn *report;
    void *cookie;
    CohortError *err;
    const char *empty; // the token of ""
    struct {
        const char *name, *token;
    } names[CO_NAME_CACHE];              // tokens of field names by the address of the name
    CoKnownToken tokens[CO_TOKEN_CACHE]; // met last, by hash
    CoKnownType types[CO_NAME_CACHE];    // named last, by address
    CoKept kept[CO_KEPT_CACHE];          // small values stored last, by hash
    void *spare[CO_SPARE_SIZES];         // blocks that lists outgrew, by log2 of the size
    const CoSpec *field_spec; // of many fields, which these are: position + 1 by name, 0 = empty
    uint32_t *field_slots;
    size_t field_capacity;
    const char *line_at; // the last place whose line was asked for
    uint32_t line;
    bool is_mapped;       // the text is a file that can be read again
    const char *released; // text whose memory was given back
    uint32_t error_count, max_errors;
    bool stopped;             // memory or a limit is at an end, or the host's patience: no recovery
    const volatile int *stop; // the host's
    char *prim_path;          // of the prim being parsed, without variant selections; "/" outside
    size_t prim_path_length, prim_path_capacity;
    unsigned char *scratch; // elements of the array being read
    size_t scratch_size;
    CoSiblings *siblings; // prims read ahead by several threads; NULL: there is one
} CoParser;

// ---- Errors, memory, lists (parser.c)
// Reports an error at a place in the text; always false.
bool co_parse_fail(CoParser *p, const char *at, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
// The same for what ends the parse: limits and memory.
bool co_parse_stop(CoParser *p, const char *at, CohortErrorCode code, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
// Ends the parse because the host wants no more. Nothing is reported: it knows.
bool co_parse_give_up(CoParser *p);
// "expected <what>, found <the text at the cursor>"
bool co_parse_expected(CoParser *p, const char *what);
bool co_parse_char(CoParser *p, char c); // demands it

void *co_parse_alloc(CoParser *p, size_t count, size_t size); // zeroed
const char *co_parse_token(CoParser *p, const char *text, size_t length);
// A copy that nobody will change. Small ones may be those of an equal copy made before.
const void *co_parse_keep(CoParser *p, const void *data, size_t size);
const char *co_parse_keep_text(CoParser *p, const char *text, size_t length); // with a NUL
// Makes room for item `count` of a list and returns it, zeroed. Capacity is the next power of two
// of the count; blocks that a list has outgrown go to others.
void *co_parse_push(CoParser *p, void *list_pointer, size_t count, size_t size);
void co_parse_list_free(CoParser *p, void *list, size_t count, size_t size);
// `count` items, a power of two, zeroed; given back as a list.
void *co_parse_block(CoParser *p, size_t count, size_t size);
void co_parse_buffers_free(CoParser *p); // those that do not belong to the layer
// The type that a token names; false when it is not known.
bool co_parse_type(CoParser *p, const char *name, CohortType *type, bool *is_array);
// The field of that name, new or with what was said before. `name` outlives the parse.
CoValue *co_parse_field(CoParser *p, CoSpec *spec, const char *name, const char *at);
bool co_parse_deeper(CoParser *p, const char *at); // p->depth++ within the limit
bool co_parse_scratch(CoParser *p, size_t size);   // at least that many bytes
// Going back costs a search. Who asks behind a long value asks before it too: the last answer is
// kept.
uint32_t co_parse_line(CoParser *p, const char *at);

// ---- Statements and lists (parser.c)
typedef bool CoItemFn(CoParser *p, void *context);
// items separated by line ends or ';' up to and with `close`, after the opening bracket.
bool co_parse_statements(CoParser *p, char close, CoItemFn *item, void *context);
// items separated by ',' up to and with `close`; at_least_one refuses an empty list.
bool co_parse_list(CoParser *p, char close, bool at_least_one, CoItemFn *item, void *context);
bool co_parse_assignment(CoParser *p); // '=' with inline padding
// Skips what is left of a bad statement.
void co_parse_recover(CoParser *p);

// ---- Words (words.c)
bool co_parse_string(CoParser *p, CohortString *out);
bool co_parse_asset(CoParser *p, CohortString *out);
// Refuses what no asset path may hold, however it was quoted: control characters, bad UTF-8.
bool co_asset_check(CoParser *p, const char *at, const CohortString *asset);
// An identifier with C++ namespaces that is no keyword: a type or a metadata name.
bool co_scan_type_name(CoScan *scan, CoSlice *out);

// True when the slice is all of `text`; an empty one is no text.
static inline bool co_slice_is(CoSlice slice, const char *text)
{
    for (size_t i = 0; i < slice.length; i++)
        if (slice.begin[i] != text[i] || !text[i])
            return false;
    return slice.length > 0 && !text[slice.length];
}

// co_token by co_hash_bytes(text, length, 0).
const char *co_token_hashed(const char *text, size_t length, uint64_t hash);

// ---- Paths (path.c)
typedef struct CoPathInfo {
    bool is_absolute, is_root, is_property;
    bool has_variant, is_variant; // anywhere; at the end
    bool is_target;               // ends in [target]
} CoPathInfo;
// Judges the syntax; `bad` receives the offset of what does not belong.
bool co_path_check(CoSlice path, CoPathInfo *info, size_t *bad);
// <...> as an absolute path, a token; "" for <>.
bool co_parse_path(CoParser *p, const char **out, CoPathInfo *info);

// Judges a path expression (path_expression.c); `bad` receives the offset of what does not belong.
bool co_expression_check(const char *text, size_t length, size_t *bad);

// ---- Values (value.c, array.c, opaque.c)
bool co_parse_scalar(CoParser *p, CoScalar scalar, void *out);
bool co_parse_element(CoParser *p, const CoTypeInfo *info, void *out);
bool co_parse_array(CoParser *p, CohortType type, CoValue *out);
// The value of a type, not None.
bool co_parse_value(CoParser *p, CohortType type, bool is_array, CoValue *out);
// A value of no known type as its text.
bool co_parse_opaque(CoParser *p, CoValue *out);
bool co_parse_opaque_item(CoParser *p, CoValue *out); // the same of a list: no path, not None
bool co_parse_dictionary(CoParser *p, CoDict *out);   // from its '{'
// One more entry, then the order that a dictionary has: of equal keys the last stays.
bool co_dict_push(CoParser *p, CoDict *dict, const char *key, CoValue *value);
bool co_dict_sort(CoParser *p, CoDict *dict);
bool co_parse_array_edit(CoParser *p, CohortType type, CoValue *out); // from its '['

// ---- List operations (listop.c)
bool co_scan_list_kind(CoScan *scan, CoListOpKind *kind); // "prepend" and a gap, ...
// An item of a list op: reads one into `out` (of the list's item size).
typedef bool CoListItemFn(CoParser *p, void *context, void *out);
typedef struct CoListSyntax {
    CohortType type;
    size_t item_size;
    CoListItemFn *item;
    void *context;
    bool single; // one item may stand without brackets
    bool none;   // None stands for the empty list
    // As the reference has it: any of the lists may be empty, one with two items alike does not
    // count.
    bool is_metadata;
} CoListSyntax;
bool co_parse_list_op(CoParser *p, CoSpec *spec, const char *field, CoListOpKind kind,
                      const CoListSyntax *syntax);
bool co_parse_arcs(CoParser *p, CoSpec *spec, bool is_payload, CoListOpKind kind);
bool co_parse_path_list(CoParser *p, CoSpec *spec, const char *field, CoListOpKind kind);
bool co_parse_names(CoParser *p, CoSpec *spec, const char *field); // a token[] field

// ---- Metadata (metadata.c, known_field.c, layer_metadata.c)
typedef struct CoKnownField {
    const char *name;
    CohortType type;
    bool is_array;
    unsigned where; // bits by CoSpecKind
} CoKnownField;
// NULL for what nobody has registered for specs of that kind: such values are kept as text.
const CoKnownField *co_known_field(CoSlice name, CoSpecKind kind);
// The name of a field of such specs that has syntax of its own and is no metadata, or NULL.
const char *co_structural_field(CoSlice name, CoSpecKind kind);
bool co_parse_metadata(CoParser *p, CoSpec *spec); // a block from its '('
bool co_variant_name_check(CoParser *p, const char *at, const CohortString *name);
bool co_parse_sublayers(CoParser *p, CoSpec *root);
bool co_parse_relocates(CoParser *p, CoSpec *root);
// "offset = 1" or "scale = 2"; *found is false when neither stands here.
bool co_parse_layer_offset(CoParser *p, double *offset, double *scale, bool *found);

// ---- Prims and properties (prim.c, property.c, samples.c, spline.c, spec.c)
bool co_parse_contents(CoParser *p, CoSpec *spec); // up to the closing '}' of a prim or variant
bool co_parse_property(CoParser *p, CoSpec *prim, bool *found);
// A value of the attribute's type, None, or the text of a value of a type that is not known.
bool co_parse_typed(CoParser *p, const CoSpec *attribute, CoValue *out);
bool co_parse_samples(CoParser *p, CoSpec *attribute); // from its '='
bool co_parse_spline(CoParser *p, CoSpline *out);      // from its '{'
CoSpec *co_parse_spec(CoParser *p, CoSpec *parent, CoSpecKind kind, const char *name,
                      const char *at);
// The spec of that name below one, NULL if none.
CoSpec *co_parse_child(const CoSpec *spec, const char *name);
CoSpec *co_parse_property_named(const CoSpec *spec, const char *name);
CoSpec *co_parse_variant_set(const CoSpec *spec, const char *name);
// Said a second time, a set holds only the variants said then.
void co_parse_clear_children(CoSpec *spec);
// Puts prims read elsewhere below a parent, unless one has a name that is there already.
bool co_parse_adopt(CoParser *p, CoSpec *parent, CoSpec *const *prims, size_t count);
// Gives back the lists of children, but not what is in them.
void co_parse_children_free(CoParser *p, CoContents *contents);
bool co_parse_prim(CoParser *p, CoSpec *parent, bool *found);
bool co_parse_prims(CoParser *p, CoSpec *parent); // and nothing else up to the end of the text
bool co_prim_begins(const CoScan *scan);          // def, over or class
bool co_parse_set_prim_path(CoParser *p, const char *path, size_t length);

// ---- Siblings (siblings.c)
// Takes prims read ahead from the cursor on, or reads ahead; false when the next is to be parsed.
bool co_parse_siblings(CoParser *p, CoSpec *parent);

#endif
