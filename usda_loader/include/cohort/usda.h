// Reading USDA: layers, composition, and the composed stage as typed values.
//
// A stage is opened once and is then read-only: any number of threads may query it. Every pointer
// that a query returns lives until cohort_stage_destroy. What is asked for by a number beyond the
// last is NULL, or false.

#ifndef COHORT_USDA_H
#define COHORT_USDA_H

#include "cohort/base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct CohortStage CohortStage;
typedef struct CohortPrim CohortPrim;

// A run of bytes, also NUL-terminated.
typedef struct CohortString {
    const char *text;
    size_t length;
} CohortString;

// Value types as USDA spells them; roles (point3f, color3f ...) keep their own number.
typedef enum CohortType {
    COHORT_TYPE_NONE = 0,
    COHORT_TYPE_BLOCK, // None
    COHORT_TYPE_BOOL,  // 1 byte
    COHORT_TYPE_UCHAR,
    COHORT_TYPE_INT,
    COHORT_TYPE_UINT,
    COHORT_TYPE_INT64,
    COHORT_TYPE_UINT64,
    COHORT_TYPE_HALF, // stored as 2 bytes
    COHORT_TYPE_FLOAT,
    COHORT_TYPE_DOUBLE,
    COHORT_TYPE_TIMECODE, // double
    COHORT_TYPE_STRING,   // CohortString
    COHORT_TYPE_TOKEN,
    COHORT_TYPE_ASSET,
    COHORT_TYPE_PATH_EXPRESSION,
    COHORT_TYPE_INT2,
    COHORT_TYPE_INT3,
    COHORT_TYPE_INT4,
    COHORT_TYPE_HALF2,
    COHORT_TYPE_HALF3,
    COHORT_TYPE_HALF4,
    COHORT_TYPE_FLOAT2,
    COHORT_TYPE_FLOAT3,
    COHORT_TYPE_FLOAT4,
    COHORT_TYPE_DOUBLE2,
    COHORT_TYPE_DOUBLE3,
    COHORT_TYPE_DOUBLE4,
    COHORT_TYPE_QUATH, // stored imaginary first (x, y, z, w) as the reference does; text is (w, x,
                       // y, z)
    COHORT_TYPE_QUATF,
    COHORT_TYPE_QUATD,
    COHORT_TYPE_MATRIX2D,
    COHORT_TYPE_MATRIX3D,
    COHORT_TYPE_MATRIX4D,
    COHORT_TYPE_POINT3H,
    COHORT_TYPE_POINT3F,
    COHORT_TYPE_POINT3D,
    COHORT_TYPE_NORMAL3H,
    COHORT_TYPE_NORMAL3F,
    COHORT_TYPE_NORMAL3D,
    COHORT_TYPE_VECTOR3H,
    COHORT_TYPE_VECTOR3F,
    COHORT_TYPE_VECTOR3D,
    COHORT_TYPE_COLOR3H,
    COHORT_TYPE_COLOR3F,
    COHORT_TYPE_COLOR3D,
    COHORT_TYPE_COLOR4H,
    COHORT_TYPE_COLOR4F,
    COHORT_TYPE_COLOR4D,
    COHORT_TYPE_FRAME4D,
    COHORT_TYPE_TEXCOORD2H,
    COHORT_TYPE_TEXCOORD2F,
    COHORT_TYPE_TEXCOORD2D,
    COHORT_TYPE_TEXCOORD3H,
    COHORT_TYPE_TEXCOORD3F,
    COHORT_TYPE_TEXCOORD3D,
    COHORT_TYPE_OPAQUE,
    COHORT_TYPE_GROUP,
    // What only fields hold:
    COHORT_TYPE_DICTIONARY,
    COHORT_TYPE_TIME_SAMPLES,
    COHORT_TYPE_TOKEN_LIST_OP,
    COHORT_TYPE_STRING_LIST_OP,
    COHORT_TYPE_PATH_LIST_OP,
    COHORT_TYPE_INT_LIST_OP,
    COHORT_TYPE_UINT_LIST_OP,
    COHORT_TYPE_INT64_LIST_OP,
    COHORT_TYPE_UINT64_LIST_OP,
    COHORT_TYPE_REFERENCE_LIST_OP,
    COHORT_TYPE_PAYLOAD_LIST_OP,
    COHORT_TYPE_VARIANT_SELECTION,
    COHORT_TYPE_SUBLAYERS,
    COHORT_TYPE_RELOCATES,
    COHORT_TYPE_SPLINE,
    COHORT_TYPE_ARRAY_EDIT,
    COHORT_TYPE_ANIMATION_BLOCK,
    COHORT_TYPE_DURATION, // double; an ordinary type, last so that numbers stay
    COHORT_TYPE_COUNT
} CohortType;

typedef enum CohortSpecifier {
    COHORT_SPECIFIER_DEF = 0,
    COHORT_SPECIFIER_OVER,
    COHORT_SPECIFIER_CLASS
} CohortSpecifier;

// One thing found in the input.
typedef void CohortDiagnosticFn(void *cookie, CohortSeverity severity, const char *file,
                                uint32_t line, uint32_t column, const char *prim_path,
                                const char *text);

// A variant selection from outside the stage: beats every opinion in it.
typedef struct CohortVariantChoice {
    const char *prim, *set, *selection;
} CohortVariantChoice;

// What to select where nothing in the stage does: the first of the choices of a set, in this order,
// that the prim has.
typedef struct CohortVariantFallback {
    const char *set, *selection;
} CohortVariantFallback;

// A layer's bytes from elsewhere than the file system.
typedef struct CohortBytes {
    const void *data; // constant until released
    size_t size;
    void *handle; // the opener's own
} CohortBytes;

// Is asked for every layer before the file system, by its absolute, normalized path. True: *out
// holds the layer. False: it is none of the opener's. With out NULL it is only asked whether it has
// the file (then also for textures and the like). Threads: may be called by several at a time.
typedef bool CohortOpenFn(void *cookie, const char *path, CohortBytes *out);

// Called once for all bytes handed out, as soon as they have been read.
typedef void CohortReleaseFn(void *cookie, const CohortBytes *bytes);

// Paths of prims or layers.
typedef struct CohortPaths {
    const char *const *items;
    size_t count;
} CohortPaths;

// Zero is the default of every field; limits are finite by default, COHORT_NO_LIMIT lifts them. All
// that the options point to is copied while opening, but for the cookies: those of the opener must
// outlive the stage.
typedef struct CohortStageOptions {
    uint64_t max_bytes;        // of one layer; 0 = 16 GiB
    uint64_t max_depth;        // of prims, values, sublayers in sublayers, arcs by arcs; 0 = 512
    uint64_t max_prims;        // in a layer, and composed with their arcs; 0 = 5 million
    uint64_t max_layers;       // 0 = 100,000
    uint64_t max_array_length; // elements; 0 = 2^31, and 2^24 where an array edit asks for them
    bool no_payloads;          // but for those of `loads`
    bool strict;               // warnings are errors
    const CohortVariantChoice *variants;
    size_t variant_count;
    CohortDiagnosticFn *report; // receives errors and warnings as they are found; may be NULL
    void *cookie;
    uint32_t threads; // that read layers; 0 = as many as the machine has
    // Payloads by prim: those at, above and below `loads` come in, those at and below `unloads` do
    // not; where both hold, the longer path decides. Elsewhere no_payloads does.
    CohortPaths loads, unloads;
    // Only these prims, what is above them and what is below; none = all. Targets are kept.
    CohortPaths mask;
    CohortPaths muted; // layers (never the root) that are as if they were empty; relative paths
                       // begin at the root layer's folder, or at the current one
    CohortPaths search_paths; // folders for asset paths that begin with neither "/", "./" nor "../"
                              // and lead nowhere from their layer nor from the current folder; the
                              // first that has it
    const char *session;      // a layer stronger than the root layer; NULL or "" = none
    const CohortVariantFallback *fallbacks;
    size_t fallback_count;
    CohortOpenFn *open;       // NULL: the file system alone
    CohortReleaseFn *release; // may be NULL
    void *open_cookie;
    // An int that any thread, or a signal handler, makes other than 0 to end the opening: within a
    // fraction of a second it fails with COHORT_ERROR_CANCELLED. Borrowed; NULL = none. A reload
    // looks at it too.
    const volatile int *stop;
} CohortStageOptions;

// Opens and composes. Missing references and the like are reported and composition goes on. NULL
// when the root layer cannot be read (COHORT_ERROR_FILE_NOT_FOUND, _FILE_READ, _USDA_SYNTAX with
// line and column, _USD_BINARY), when a limit of the options is passed (_LIMIT), stopped
// (_CANCELLED), out of memory, or, with `strict`, at the first warning.
//   path     of the root layer, relative to the current folder
//   options  NULL: all defaults
CohortStage *cohort_stage_open(const char *path, const CohortStageOptions *options,
                               CohortError *err);
void cohort_stage_destroy(CohortStage *stage); // NULL is allowed

// Whether a query has found no memory since this was asked last: what it said then may lack what is
// there. Nothing of it is kept; the same query may be made again.
bool cohort_stage_ran_short(const CohortStage *stage);

// Opens the stage again, with the same options, and finds out what has become different; layers
// that have not changed on disk are not read again. `stage` stays as it is and is still the
// caller's; the new stage holds the list of changes. NULL when the root layer cannot be read any
// more. Layers from an opener are asked for again. Threads: as if `stage` were queried.
CohortStage *cohort_stage_reload(const CohortStage *stage, CohortError *err);

// What differs from the stage this one was reloaded from, in the order of the namespace.
typedef struct CohortChange {
    const char *path;
    bool is_structural; // the prim has come, gone, or is of another kind, or its children are
                        // others; else only its properties and metadata have changed
} CohortChange;
size_t cohort_stage_change_count(const CohortStage *stage);
bool cohort_stage_change(const CohortStage *stage, size_t i, CohortChange *out);

// What composition found and went on without: the same kinds as the reference has.
typedef enum CohortProblemKind {
    COHORT_PROBLEM_ARC_CYCLE = 0,        // an arc leads back to itself and is left out
    COHORT_PROBLEM_ARC_CAPACITY,         // a prim has more arcs than it may, the rest are left out
    COHORT_PROBLEM_ARC_TO_MOVED_PRIM,    // a relocate has moved away what an arc leads to
    COHORT_PROBLEM_INVALID_PRIM_PATH,    // an arc names no prim and is left out
    COHORT_PROBLEM_UNRESOLVED_PRIM_PATH, // there is no prim where an arc leads
    COHORT_PROBLEM_INVALID_ASSET_PATH,   // the layer of an arc cannot be read
    COHORT_PROBLEM_MUTED_ASSET_PATH,     // the layer of an arc is muted
    COHORT_PROBLEM_INVALID_REFERENCE_OFFSET, // is ignored
    COHORT_PROBLEM_INVALID_SUBLAYER_OFFSET,  // is ignored
    COHORT_PROBLEM_INVALID_SUBLAYER_PATH,    // a sublayer cannot be read
    COHORT_PROBLEM_SUBLAYER_CYCLE,
    COHORT_PROBLEM_INVALID_RELOCATE,
    COHORT_PROBLEM_CONFLICTING_RELOCATE,
    COHORT_PROBLEM_SAME_TARGET_RELOCATES,
    COHORT_PROBLEM_OPINION_AT_RELOCATION_SOURCE, // is ignored
    COHORT_PROBLEM_VARIABLE_EXPRESSION,          // cannot be evaluated
    COHORT_PROBLEM_CLIPS,                        // value clips that cannot be used
    COHORT_PROBLEM_KIND_COUNT
} CohortProblemKind;

// Where the arc (or whatever it is) is authored, the prim of the stage that it is about ("" for
// whole layers), and what is wrong with it.
typedef struct CohortProblem {
    CohortProblemKind kind;
    const char *layer, *prim, *text;
    uint32_t line;
} CohortProblem;

// All of them, in the order they were found; the same text that was reported while opening.
size_t cohort_stage_problem_count(const CohortStage *stage);
bool cohort_stage_problem(const CohortStage *stage, size_t i, CohortProblem *out);

// ---- Stage -------------------------------------------------------------------------------------
typedef struct CohortStageInfo {
    const char *default_prim;              // "" if none
    const char *up_axis;                   // "Y" or "Z"
    const char *render_settings_prim_path; // "" if none
    double meters_per_unit, time_codes_per_second, frames_per_second;
    double start_time_code, end_time_code;
    bool has_time_range;
    size_t layer_count, prim_count;
    uint64_t hash; // of the contents of all layers used
} CohortStageInfo;
void cohort_stage_info(const CohortStage *stage, CohortStageInfo *out);

// Path of a layer used, i < layer_count; the root layer is 0.
const char *cohort_stage_layer(const CohortStage *stage, size_t i);

// Whether anything in the stage led to the layer that options.muted.items[i] names; else muting it
// has changed nothing.
bool cohort_stage_met_muted(const CohortStage *stage, size_t i);

// Earliest time at which anything is sampled, or the start time code; false if nothing varies and
// no range is authored.
bool cohort_stage_earliest_time(const CohortStage *stage, double *out);

// ---- Prims -------------------------------------------------------------------------------------
// Active, defined, loaded prims are what iteration shows; classes and overs are skipped but can be
// found by path. Instances show their prototype's children in place (the prims are shared: several
// instances return the same CohortPrim children; see cohort_prim_prototype).
const CohortPrim *cohort_stage_root(const CohortStage *stage);                   // the pseudo-root
const CohortPrim *cohort_stage_prim(const CohortStage *stage, const char *path); // NULL: none

const char *cohort_prim_name(const CohortPrim *prim);
const char *cohort_prim_path(const CohortPrim *prim); // "/World/Mesh"
const char *cohort_prim_type(const CohortPrim *prim); // "Mesh", "" if untyped
CohortSpecifier cohort_prim_specifier(const CohortPrim *prim);
const CohortPrim *cohort_prim_parent(const CohortPrim *prim); // NULL for the pseudo-root
size_t cohort_prim_child_count(const CohortPrim *prim);
const CohortPrim *cohort_prim_child(const CohortPrim *prim, size_t i);
bool cohort_prim_is_active(const CohortPrim *prim);
bool cohort_prim_is_defined(const CohortPrim *prim);  // specifier def, all ancestors too
bool cohort_prim_is_abstract(const CohortPrim *prim); // class, or below one
bool cohort_prim_is_instance(const CohortPrim *prim); // instanceable with arcs
// Equal for instances that share everything below; NULL for others. The prototype is the first
// instance met, whose children all of them show.
const CohortPrim *cohort_prim_prototype(const CohortPrim *prim);
bool cohort_prim_has_api(const CohortPrim *prim, const char *schema); // applied API schemas
const char *cohort_prim_kind(const CohortPrim *prim);

// Variant sets of a prim and what is selected ("" if nothing).
size_t cohort_prim_variant_set_count(const CohortPrim *prim);
const char *cohort_prim_variant_set(const CohortPrim *prim, size_t i);
const char *cohort_prim_variant_selection(const CohortPrim *prim, const char *set);
size_t cohort_prim_variant_count(const CohortPrim *prim, const char *set);
const char *cohort_prim_variant(const CohortPrim *prim, const char *set, size_t i);

// ---- Properties --------------------------------------------------------------------------------
// Names of authored properties, composed, sorted as the reference does.
size_t cohort_prim_property_count(const CohortPrim *prim);
const char *cohort_prim_property_name(const CohortPrim *prim, size_t i);
bool cohort_prim_has_attribute(const CohortPrim *prim, const char *name);
bool cohort_prim_has_relationship(const CohortPrim *prim, const char *name);

// A resolved value: the strongest opinion at a time, interpolated where that is asked for.
typedef struct CohortValue {
    CohortType type; // NONE: no value (or blocked)
    bool is_array;
    size_t count;     // elements; 1 for scalars
    const void *data; // packed elements of the type
} CohortValue;

// Asks for default values instead of a time. Include <math.h> to use it.
#define COHORT_TIME_DEFAULT ((double)NAN)

// The value of an attribute at a time code (NAN = default value). Linear interpolation for floating
// types of equal length, else held. Returns false when there is none.
bool cohort_prim_value(const CohortPrim *prim, const char *name, double time, CohortValue *out);

// Authored sample times (in stage time); count 0 = not animated.
size_t cohort_prim_time_samples(const CohortPrim *prim, const char *name, const double **times);

// Attribute metadata as a value: "interpolation", "elementSize", "colorSpace", ...
bool cohort_prim_attribute_metadata(const CohortPrim *prim, const char *name, const char *key,
                                    CohortValue *out);
bool cohort_prim_metadata(const CohortPrim *prim, const char *key, CohortValue *out);

// An asset-valued attribute's paths resolved against the layer that authored each: as many as
// elements. resolved is "" where no file exists (but see `anchored`: the path it should have had).
typedef struct CohortAsset {
    const char *authored, *anchored, *resolved;
} CohortAsset;
size_t cohort_prim_assets(const CohortPrim *prim, const char *name, double time,
                          const CohortAsset **out);

// Targets of a relationship, or connections of an attribute, as absolute stage paths.
size_t cohort_prim_targets(const CohortPrim *prim, const char *name, const char *const **out);
size_t cohort_prim_connections(const CohortPrim *prim, const char *name, const char *const **out);

// Where the strongest opinion of a property stands, for messages.
bool cohort_prim_origin(const CohortPrim *prim, const char *property, const char **layer,
                        uint32_t *line);

// One layer's opinion on a prim.
typedef struct CohortOpinion {
    const char *layer;
    uint32_t line;
    const char *arc; // how it comes in: "local", "reference", "payload", "inherit", "variant", ...
    bool is_introduced; // by this very prim, not by an arc of an ancestor
} CohortOpinion;
// All of them, strongest first; i < count.
size_t cohort_prim_opinion_count(const CohortPrim *prim);
bool cohort_prim_opinion(const CohortPrim *prim, size_t i, CohortOpinion *out);

// The same of one of its properties; false past the last.
bool cohort_prim_property_opinion(const CohortPrim *prim, const char *property, size_t i,
                                  CohortOpinion *out);

// ---- Convenience over values (typed, with a fallback) ------------------------------------------
// The first number of the value at a time (NAN = default value), whatever its type; the fallback
// where there is no value or it is no number.
double cohort_prim_double(const CohortPrim *prim, const char *name, double time, double fallback);
bool cohort_prim_bool(const CohortPrim *prim, const char *name, double time, bool fallback);
const char *
cohort_prim_token(const CohortPrim *prim, const char *name, double time,
                  const char *fallback); // token, string or asset text; the first of an array
// Copies up to `count` numbers of a scalar, vector, matrix or array of such, converted to double;
// `out` keeps what there is no number for. False, with nothing copied, where the value is absent or
// no number.
bool cohort_prim_numbers(const CohortPrim *prim, const char *name, double time, double *out,
                         size_t count);

// UsdGeomXformable: the prim's own transform (row vectors) at a time; *resets = !resetXformStack!,
// may be NULL. False, and the identity, where no op is authored or the prim can have none: it has
// no type, or is a Scope.
bool cohort_prim_local_transform(const CohortPrim *prim, double time, double out[4][4],
                                 bool *resets);

// ---- Layers ------------------------------------------------------------------------------------
// Reads one layer and writes it back as USDA; flatten writes the composed stage as one layer. out
// NULL = standard output; a file is written beside its place and moved there when it is whole.
// Errors of reading as cohort_stage_open's; COHORT_ERROR_FILE_WRITE.
bool cohort_layer_cat(const char *in, const char *out, const CohortStageOptions *options,
                      CohortError *err);
bool cohort_stage_flatten(const CohortStage *stage, const char *out, CohortError *err);

#ifdef __cplusplus
}
#endif

#endif
