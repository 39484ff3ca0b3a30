// A layer: specs and fields as plain data, exactly what one file says and nothing composed.
//
// Everything hangs off one arena and is freed by one call. Tokens, paths and strings are interned
// per process (co_token), so equal text means equal pointer.

#ifndef CO_PARSE_LAYER_H
#define CO_PARSE_LAYER_H

#include "base/arena.h"
#include "cohort/usda.h"

// Interns text for the life of the process; equal text gives the same pointer, NUL-terminated.
// Threads: any. NULL when out of memory.
const char *co_token(const char *text, size_t length);

typedef struct CoValue CoValue;

// Kinds beyond the plain ones that a field can hold.
typedef enum CoListOpKind {
    CO_LIST_EXPLICIT = 0,
    CO_LIST_ADDED,
    CO_LIST_PREPENDED,
    CO_LIST_APPENDED,
    CO_LIST_DELETED,
    CO_LIST_ORDERED,
    CO_LIST_KIND_COUNT
} CoListOpKind;

// Items are CohortString (tokens, strings, paths), int32/uint32/int64/uint64, or CoArc (references,
// payloads), by the value's type.
typedef struct CoListOp {
    bool is_explicit;
    struct {
        const void *items;
        size_t count;
    } list[CO_LIST_KIND_COUNT];
} CoListOp;

// A reference or payload item.
typedef struct CoArc {
    const char *asset; // "" = internal
    const char *prim;  // "" = default prim
    double offset, scale;
    CoValue *custom_data; // dictionary or NULL
    uint32_t line;
} CoArc;

typedef struct CoDictEntry {
    const char *key; // token
    CoValue *value;
} CoDictEntry;

typedef struct CoDict {
    CoDictEntry *entries; // sorted by key text
    size_t count;
} CoDict;

typedef struct CoTimeSamples {
    double *times; // ascending
    CoValue *values;
    size_t count;
} CoTimeSamples;

// Knots of an attribute's curve over time.
typedef enum CoSplineInterp {
    CO_SPLINE_INTERP_NONE = 0, // a value block up to the next knot
    CO_SPLINE_INTERP_HELD,
    CO_SPLINE_INTERP_LINEAR,
    CO_SPLINE_INTERP_CURVE
} CoSplineInterp;

typedef struct CoSplineTangent {
    bool is_set, has_width;
    const char *algorithm; // "custom", "autoEase" or "" (not said)
    double width, slope;
} CoSplineTangent;

typedef struct CoSplineKnot {
    double time, value, pre_value;
    bool has_pre_value;
    bool has_interp; // else held
    CoSplineInterp interp;
    CoSplineTangent pre, post;
    CoDict *custom_data; // or NULL
} CoSplineKnot;

typedef struct CoSplineExtrapolation {
    const char *
        mode; // "", "none", "held", "linear", "sloped", "loop repeat", "... reset", "... oscillate"
    double slope;
    bool has_boundary; // of a loop: it goes from or to the knot at `boundary`, not over all knots
    double boundary;
} CoSplineExtrapolation;

typedef struct CoSpline {
    const char *curve; // "bezier" (also when not said, then "") or "hermite"
    CoSplineExtrapolation pre, post;
    bool has_loop;
    double loop[5];      // prototype start and end, loops before and after, value offset
    CoSplineKnot *knots; // ascending in time
    size_t count;
} CoSpline;

// What is done to a weaker opinion's array. Indices below zero count from its end.
typedef enum CoArrayEditKind {
    CO_EDIT_WRITE = 0,
    CO_EDIT_INSERT,
    CO_EDIT_PREPEND,
    CO_EDIT_APPEND,
    CO_EDIT_ERASE,
    CO_EDIT_MINSIZE,
    CO_EDIT_MAXSIZE,
    CO_EDIT_RESIZE
} CoArrayEditKind;

typedef struct CoArrayEditItem {
    CoArrayEditKind kind;
    CoValue *literal;   // what is written, or the fill of a size; NULL: `source`, or no fill
    int64_t source;     // index of the element copied
    int64_t at_or_size; // index written to, inserted at or erased; the size
} CoArrayEditItem;

typedef struct CoArrayEdit {
    CoArrayEditItem *items;
    size_t count;
} CoArrayEdit;

typedef struct CoRelocate {
    const char *source, *target; // absolute paths; "" as target removes the source
} CoRelocate;

// One value. Arrays are packed elements at `data`; scalars too (count 1). Blocks (None) have
// type COHORT_TYPE_BLOCK. Equal small values of a layer may share their data.
struct CoValue {
    CohortType type : 16;
    bool is_array;
    uint32_t count;   // elements
    const void *data; // elements of co_type_size(type) bytes, or what stands below
};

// What `data` points to for the types that only fields hold:
//   DICTIONARY, VARIANT_SELECTION        CoDict (a selection's values are STRING)
//   TIME_SAMPLES, SPLINE, ARRAY_EDIT     CoTimeSamples, CoSpline, CoArrayEdit
//   *_LIST_OP                            CoListOp
//   SUBLAYERS                            CoArc[count]: asset, offset, scale
//   RELOCATES                            CoRelocate[count]
//   OPAQUE                               CohortString: the text of a value that Cohort does not
//   know,
//                                        as it stands in the file; with is_array a CoListOp of
//                                        those
// BLOCK and ANIMATION_BLOCK have no data.
//
// Field names are those of the reference, whatever the text calls them:
//   layer      subLayers, defaultPrim, relocates, customLayerData, documentation, comment,
//              expressionVariables, primOrder (token[]), startTimeCode (double), ...
//   prim       references, payload, inheritPaths, specializes, apiSchemas, variantSetNames
//              (STRING_LIST_OP), variantSelection, kind, active, instanceable, hidden, customData,
//              assetInfo, clips, documentation, comment, permission (token), symmetryFunction,
//              primOrder and propertyOrder (token[]), ...
//   attribute  default, timeSamples, spline, connectionPaths (PATH_LIST_OP), colorSpace, ...
//   relation   targetPaths (PATH_LIST_OP), default (string: a path), ...
// All paths are absolute: relative ones are resolved against the prim they stand in, and variant
// selections of that prim are left out.

// Bytes of one element: 12 for float3, sizeof(CohortString) for strings, tokens and asset paths,
// ...
size_t co_type_size(CohortType type);
const char *co_type_name(CohortType type); // "float3"; arrays add "[]"
bool co_type_from_name(const char *name, size_t length, CohortType *out, bool *is_array);

typedef struct CoField {
    const char *name; // token: "default", "timeSamples", "references", "kind", ...
    CoValue value;
    uint32_t line;
} CoField;

typedef enum CoSpecKind {
    CO_SPEC_LAYER = 0, // the pseudo-root: layer metadata
    CO_SPEC_PRIM,
    CO_SPEC_ATTRIBUTE,
    CO_SPEC_RELATIONSHIP,
    CO_SPEC_VARIANT_SET,
    CO_SPEC_VARIANT
} CoSpecKind;

typedef struct CoSpec CoSpec;
typedef struct CoNameIndex CoNameIndex;

// The specs below one.
typedef struct CoContents {
    CoSpec **children;     // prims, in order (of the layer, a prim or a variant)
    CoSpec **properties;   // in order
    CoSpec **variant_sets; // each with variants as its children
    uint32_t child_count, property_count, variant_set_count;
    CoNameIndex *index; // of long lists, for co_spec_child and _property
    const char *set;    // of a variant: the name of its set, a token
} CoContents;

// A layer can hold millions: what only some need is elsewhere.
struct CoSpec {
    const char *name;      // token; of a variant its name, of a variant set its name
    const char *type_name; // token: prim type ("" none) or attribute type ("float3[]")
    CoField *fields;
    CoContents *contents; // NULL: nothing; see co_spec_contents
    uint32_t line;
    uint32_t field_count : 24;
    CoSpecKind kind : 4;
    CohortSpecifier specifier : 2;      // prims
    bool is_custom : 1, is_uniform : 1; // properties
};

_Static_assert(sizeof(CoSpec) <= 40 && sizeof(CoField) <= 32, "specs and fields stay small");

// By which a file that has been written again is told from the one that was read.
typedef struct CoFileStamp {
    uint64_t inode, size;
    int64_t seconds, nanoseconds;
} CoFileStamp;

typedef struct CoLayer {
    CoArena arena;
    const char *path; // token: absolute, normalized file path
    CoSpec *root;     // kind CO_SPEC_LAYER
    size_t byte_count;
    CoFileStamp stamp;      // all 0: not from a file
    _Atomic uint32_t users; // stages beyond the first (co_layer_share)
} CoLayer;

// Parses text. diagnostics receives every error found (the parser recovers); NULL result when any.
// Limits come from options. Threads: any; no shared state but tokens.
CoLayer *co_layer_parse(const char *path, const char *text, size_t size,
                        const CohortStageOptions *options, CohortDiagnosticFn *report, void *cookie,
                        CohortError *err);

// Opens .usda and text .usd; refuses binary crates and packages by name.
CoLayer *co_layer_open(const char *path, const CohortStageOptions *options,
                       CohortDiagnosticFn *report, void *cookie, CohortError *err);

// One more co_layer_destroy is then needed. Threads: any.
CoLayer *co_layer_share(CoLayer *layer);

// True if the file is still the one that was read.
bool co_layer_is_current(const CoLayer *layer);
void co_layer_destroy(CoLayer *layer);

// Never NULL.
const CoContents *co_spec_contents(const CoSpec *spec);

// NULL when the spec has no such field. `name` must be a token.
const CoField *co_spec_field(const CoSpec *spec, const char *name);
const CoSpec *co_spec_child(const CoSpec *spec, const char *name);
const CoSpec *co_spec_property(const CoSpec *spec, const char *name);

// True if two values say the same, numbers by their bits, and two specs: name, kind, flags, fields
// in any order and properties, but not children. Lines do not count.
bool co_value_equal(const CoValue *a, const CoValue *b);
bool co_spec_equal(const CoSpec *a, const CoSpec *b);

// Writes the layer as USDA, every spec and field, floats in shortest round-trip form.
bool co_layer_write(const CoLayer *layer, const char *path, CohortError *err);

#endif
