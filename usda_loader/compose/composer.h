// What one opening of a stage works with: memory, paths, layers, layer stacks and sites, all
// cached.
//
// Memory: everything is in `arena` and lives as long as the stage. Running out of it anywhere below
// leaves composition by co_composer_fail, a long jump to co_compose_guard's caller: there is
// nothing to unwind but the arena and the layers, which the stage frees. Threads: one.

#ifndef CO_COMPOSE_COMPOSER_H
#define CO_COMPOSE_COMPOSER_H

#include "compose/map.h"
#include "parse/layer.h"

#include <setjmp.h>

// Field names, interned once.
#define CO_FIELD_NAMES(X) \
    X(references) \
    X(payload) \
    X(inheritPaths) \
    X(specializes) \
    X(variantSetNames) \
    X(variantSelection) \
    X(subLayers) \
    X(relocates) \
    X(expressionVariables) \
    X(defaultPrim) \
    X(timeCodesPerSecond) \
    X(framesPerSecond) \
    X(primOrder) \
    X(propertyOrder) \
    X(active) \
    X(instanceable) \
    X(kind) \
    X(apiSchemas) \
    X(timeSamples) \
    X(spline) \
    X(targetPaths) \
    X(connectionPaths) \
    X(xformOpOrder) \
    X(clips) \
    X(clipSets)

typedef struct CoFieldNames {
#define CO_FIELD_MEMBER(name) const char *name;
    CO_FIELD_NAMES(CO_FIELD_MEMBER)
#undef CO_FIELD_MEMBER
    const char *default_value; // "default"
    const char *any_type;      // "__AnyType__": no type
} CoFieldNames;

typedef struct CoReading CoReading; // read_ahead.h

// One layer, read once. `layer` is NULL if it could not be read.
typedef struct CoLayerFile {
    const char *path; // token: absolute and normalized
    CoLayer *layer;
    const char *why; // it could not be read
    double time_codes_per_second;
    size_t index;       // in order of first use
    CoReading *reading; // the layer has been read and waits for its first use; else NULL
    bool is_used;
} CoLayerFile;

typedef struct CoStackLayer {
    const CoLayerFile *file;
    double offset, scale; // from the layer's time to the stack's
} CoStackLayer;

// The moves that one path is looked up for, each in order.
typedef enum CoMoveList {
    CO_MOVES_FROM,        // it is their source
    CO_MOVES_TO,          // it is their target
    CO_MOVES_OF_CHILDREN, // it is the parent of their source
    CO_MOVES_TO_CHILDREN, // it is the parent of their target
    CO_MOVE_LIST_COUNT
} CoMoveList;

// One relocate as composition uses it; without a target the source is removed.
typedef struct CoMove {
    const CoPath *source, *target;
    const CoPath *origin;              // the source before any move of an ancestor
    uint32_t next[CO_MOVE_LIST_COUNT]; // of the lists it is in: move + 1
} CoMove;

// What the moves say of one path.
typedef struct CoMovesAt {
    const CoPath *path;
    uint32_t first[CO_MOVE_LIST_COUNT]; // move + 1; 0: none
    bool is_above;                      // of a source or an origin, or is one
} CoMovesAt;

typedef struct CoMoveIndex {
    CoMovesAt *slots; // open addressing by path
    size_t count, capacity;
} CoMoveIndex;

typedef struct CoVariable {
    const char *name; // token
    const CoValue *value;
} CoVariable;

// The values that variable expressions see; those of the referencing stack win.
typedef struct CoVariables {
    const CoVariable *items;
    size_t count;
} CoVariables;

// A root layer and its sublayers, strongest first.
typedef struct CoStack {
    const CoLayerFile *root;
    const CoLayerFile *session;   // of the stage's own stack alone: stronger than the root; or NULL
    const CoVariables *overrides; // of the stack that refers to this one
    const CoVariables *variables; // NULL: none
    CoStackLayer *layers;
    size_t layer_count;
    double time_codes_per_second; // of the root, but a session layer may say otherwise
    CoMove *relocates;            // incremental: each says one move
    size_t relocate_count;
    CoMoveIndex moves;
    uint64_t arc_count; // made so far to any site here
    bool is_stage;      // the stage's own, which no arc leads to
} CoStack;

typedef struct CoSite CoSite;

typedef struct CoPathList {
    const CoPath **items;
    size_t count;
} CoPathList;

typedef struct CoMutedPath {
    const char *beside_root, *from_here; // where it may lead; tokens
    bool is_met;                         // something led to it
} CoMutedPath;

enum {
    CO_FOUND_PLACES = 1024
};

typedef struct CoComposer {
    CoArena arena;
    CoArena scratch; // graphs and tasks; marked and rewound by whoever walks the stage
    CoPathTable paths;
    CohortStageOptions options;
    CohortError *err;
    jmp_buf escape;
    CoFieldNames names;
    CoPathList loads, unloads, mask;    // of the options (population.h)
    CoMutedPath *muted;                 // of the options
    const struct CoComposer *donor;     // of a stage whose layers may be shared; NULL: none
    const char *found[CO_FOUND_PLACES]; // assets that were there; tokens, by hash
    CoLayerFile **files;
    size_t file_count, file_capacity;
    CoLayerFile **entries; // open addressing by path: files, and what was read ahead of use
    size_t entry_count, entry_capacity;
    CoStack **stacks;
    size_t stack_count, stack_capacity;
    CoSite **first_sites; // of each path, by its number
    size_t first_site_capacity;
    CoSite **sites; // the others: open addressing over (stack, path)
    size_t site_count, site_capacity;
    uint64_t warning_count;
    CohortProblem *problems;
    size_t problem_count, problem_capacity;
    bool is_strict_failure; // strict, and something was reported
    const CoPath *crowded;  // the last stage prim found to have too many arcs
    size_t crowded_count;   // prims like it
} CoComposer;

bool co_composer_init(CoComposer *c, const CohortStageOptions *options, CohortError *err);
void co_composer_clear(CoComposer *c);

// Leaves composition with an error set. Never returns.
_Noreturn void co_composer_fail(CoComposer *c, CohortErrorCode code, const char *text);

// Leaves composition because the input asks for more than an option allows: says how much that is,
// which option, and where. `layer` and `path` may be NULL.
_Noreturn void co_composer_limit(CoComposer *c, const CoLayerFile *layer, const CoPath *path,
                                 const char *what, uint64_t limit, const char *option);

// Zeroed memory; never NULL.
void *co_composer_alloc(CoComposer *c, size_t size);
void *co_composer_array(CoComposer *c, size_t count, size_t size);

void *co_composer_scratch(CoComposer *c, size_t count, size_t size);

// Room for one more element in an array that doubles; *capacity is in elements.
void *co_composer_grow(CoComposer *c, void *items, size_t count, size_t *capacity, size_t size);

// Asserts that a path, map or token could be made.
const void *co_composer_need(CoComposer *c, const void *made);

// Something in the input that composition goes on without. `path` and `layer` may be NULL.
void co_composer_warn(CoComposer *c, CohortProblemKind kind, const CoLayerFile *layer,
                      uint32_t line, const CoPath *path, const char *format, ...)
    __attribute__((format(printf, 6, 7)));

// The layer at an absolute path: read at first use. NULL when it cannot be read; *err then says
// why.
const CoLayerFile *co_composer_layer(CoComposer *c, const char *path, CohortError *err);

// The stack of a root layer as seen from a stack with these variables (NULL: none).
CoStack *co_composer_stack(CoComposer *c, const CoLayerFile *root, const CoVariables *overrides);

// The stage's own stack: the session layer and what it brings in, then the root layer. An arc that
// leads to the root layer by its path leads to another stack, without the session, so that it is
// no circle yet.
CoStack *co_composer_root_stack(CoComposer *c, const CoLayerFile *root, const CoLayerFile *session);

// True if the options mute the layer at that absolute path.
bool co_composer_is_muted(CoComposer *c, const char *path);

// Reads what the layers of a stack say is moved; what is not allowed or contradicts itself is
// reported and left out.
void co_stack_relocates(CoComposer *c, CoStack *stack);

// What the moves of the stack say of a path; NULL for nothing.
const CoMovesAt *co_stack_moves_at(const CoStack *stack, const CoPath *path);

// The move from (or to) a path; NULL for none.
const CoMove *co_stack_move_from(const CoStack *stack, const CoPath *source);
const CoMove *co_stack_move_to(const CoStack *stack, const CoPath *target);

// A field of a layer's own metadata.
const CoField *co_layer_field(const CoLayerFile *file, const char *name);

// Path, relative to the layer that says it, without looking for the file: absolute and normalized.
// A path that begins with no dot and leads nowhere is looked for in the search paths. Token.
const char *co_asset_anchor(CoComposer *c, const CoLayerFile *layer, const char *authored);
bool co_asset_exists(const CoComposer *c, const char *path);

// Evaluates `"${VAR}"`-like text between backquotes. Text that is no expression comes back as it
// is. NULL after a warning when it is malformed or names an unknown variable.
const char *co_expression_evaluate(CoComposer *c, const CoVariables *variables, const char *text,
                                   const char **why);

#endif
