// How the composed stage lies in memory. Everything is in the composer's arena and constant once
// the stage is open, except the cache of answers that had to be worked out, which a lock guards.

#ifndef CO_STAGE_STAGE_DATA_H
#define CO_STAGE_STAGE_DATA_H

#include "cohort/usda.h"
#include "compose/prim_index.h"

#include <pthread.h>
#include <stdatomic.h>

// See clips.h.
typedef struct CoClips CoClips;

// One spec with a say in a prim.
typedef struct CoOpinion {
    const CoSpec *spec;
    const CoSource *source;
} CoOpinion;

enum {
    CO_PRIM_ACTIVE = 1,
    CO_PRIM_DEFINED = 2,
    CO_PRIM_ABSTRACT = 4,
    CO_PRIM_INSTANCE = 8
};

// Names of properties in order. Prims with the same properties share one.
typedef struct CoNameList {
    size_t count, authored_count;
    const char *const *names;    // unique and sorted
    const char *const *authored; // as the opinions hold them
} CoNameList;

// What composition found out about a prim. Prims that say the same but for where they hang share
// it (share.h); only `properties` is filled in later, by whoever asks first.
typedef struct CoPrimData {
    CohortStage *stage;
    const CoPath *path;             // of the prim that was composed
    const struct CoPrimData *above; // of its parent; NULL for the pseudo-root
    const char *type;               // token
    const CoClips *clips;           // of this prim or an ancestor; NULL: none
    const CohortPrim *prototype;
    const uint32_t *shown; // which children iteration shows; NULL: all
    _Atomic(const CoNameList *) properties;
    uint32_t opinion_count, child_count, shown_count;
    uint8_t specifier, flags;
    CoOpinion opinions[]; // strongest first
} CoPrimData;

struct CohortPrim {
    const CohortPrim *parent;
    CoPrimData *data;
    CohortPrim *children; // all of them, in order; an instance's are its prototype's
};

// What a cached answer is about.
typedef enum CoQueryKind {
    CO_QUERY_PATH = 1,
    CO_QUERY_PROPERTIES,
    CO_QUERY_VALUE,
    CO_QUERY_TIMES,
    CO_QUERY_METADATA,
    CO_QUERY_ASSETS,
    CO_QUERY_TARGETS,
    CO_QUERY_VARIANT_SETS,
    CO_QUERY_VARIANTS,
    CO_QUERY_CLIPS,
    CO_QUERY_CHILDREN
} CoQueryKind;

typedef struct CoQueryKey {
    const void *subject; // a prim, spec or path
    const void *detail;  // a token
    uint64_t number;     // kind and index
    double time;
} CoQueryKey;

typedef struct CoAnswer {
    const void *data;
    size_t count;
    CohortType type;
    bool is_array;
} CoAnswer;

typedef struct CoAnswerSlot {
    CoQueryKey key;
    CoAnswer answer;
    bool is_used;
} CoAnswerSlot;

typedef struct CoInstanceSlot {
    const uint64_t *key; // words
    size_t length;
    uint64_t hash;
    CohortPrim *prim;
} CoInstanceSlot;

struct CohortStage {
    CoComposer composer;
    CohortStage *self; // to fill the cache of a const stage
    CoStack *stack;
    CohortPrim root;
    size_t prim_count;
    uint64_t arc_count;        // of all prims that were composed, not shared
    CoInstanceSlot *instances; // prototypes by key, open addressing
    size_t instance_count, instance_capacity;
    CoInstanceSlot *shares; // prims whose children others may take over (share.h)
    size_t share_count, share_capacity;
    pthread_mutex_t lock; // guards all below
    CoArena answers_arena;
    uint64_t refusals, told;  // of memory to queries; of these cohort_stage_ran_short has told
    uint64_t refusals_before; // whoever has the lock took it
    CoAnswerSlot *answers;
    size_t answer_count, answer_capacity;
    const CohortChange *changes; // since the stage this one was reloaded from
    size_t change_count;
    bool has_lock, has_hash, has_earliest, varies;
    uint64_t hash;
    double earliest;
};

// As cohort_stage_open; layers that `before` has read and that are as they were are shared with it.
CohortStage *co_stage_open(const char *path, const CohortStageOptions *options,
                           const CohortStage *before, CohortError *err);

// Builds the whole tree below stage->root; leaves by the composer's escape on failure.
void co_stage_compose(CohortStage *stage);

// The child of that name (a token), or NULL.
const CohortPrim *co_prim_find_child(const CohortPrim *prim, const char *name);

static inline const char *co_prim_name(const CohortPrim *prim)
{
    return prim->data->path->name;
}

// Writes the prim's path with a NUL, at most `size` bytes, and returns the full length.
size_t co_prim_path_text(const CohortPrim *prim, char *out, size_t size);

// Where shared data was composed and where the prim stands: a path that starts with *from in the
// one starts with *to in the other. The pseudo-root twice when the data is the prim's own.
void co_prim_renaming(const CohortPrim *prim, const CoPath **from, const CohortPrim **to);

// ---- Answers ------------------------------------------------------------------------------------
// Queries that need memory: lock, look up, else work out in the arena and keep. `lock` is not
// recursive. All of these are called with the lock held, but for the first. Nothing is kept of what
// was worked out after memory was refused in the same hold: it may lack something.
void co_stage_lock(const CohortStage *stage);
void co_stage_unlock(const CohortStage *stage);
const CoAnswer *co_stage_find_answer(const CohortStage *stage, const CoQueryKey *key);
const CoAnswer *co_stage_keep_answer(const CohortStage *stage, const CoQueryKey *key,
                                     const CoAnswer *answer); // NULL: out of memory
void *co_stage_alloc(const CohortStage *stage, size_t count, size_t size);

// ---- Opinions on a property
// -----------------------------------------------------------------------
typedef struct CoPropertyWalk {
    const CohortPrim *prim;
    const char *name; // token
    uint32_t next;
    CoSpecKind kind; // of the strongest; weaker ones of the other kind are passed over
    const CoSpec *spec;
    const CoSource *source;
} CoPropertyWalk;

// Weaker and weaker: while (co_property_next(&walk)). NULL names end at once.
CoPropertyWalk co_property_walk(const CohortPrim *prim, const char *name);
bool co_property_next(CoPropertyWalk *walk);

// The token of a property's name. A token that the prim has a property of need not be looked up.
const char *co_property_token(const CohortPrim *prim, const char *name);

// ---- Values
// --------------------------------------------------------------------------------------- A value
// as its layer means it, in stage terms: times scaled. Allocates only where it must.
bool co_value_in_stage(const CohortStage *stage, const CoValue *value, const CoSource *source,
                       CohortValue *out);

// Interpolates between two values; false when they must be held instead.
bool co_value_can_interpolate(const CoValue *a, const CoValue *b);
void co_value_interpolate(const CoValue *a, const CoValue *b, double u, void *out);

// Where the value of an attribute comes from.
typedef struct CoValueSource {
    const CoField *field; // default, timeSamples or spline; NULL: nothing, or blocked
    const CoSource *source;
    const CoSpec *spec; // NULL when the value comes from clips
} CoValueSource;
bool co_prim_value(const CohortPrim *prim, const char *token, double time, CohortValue *out);
CoValueSource co_prim_value_source(const CohortPrim *prim, const char *name, bool at_default);

// The next weaker source that the walk has not passed yet.
CoValueSource co_value_source_next(CoPropertyWalk *walk, bool at_default);

// The value of a source that is a curve, at a time of its own layer, as the attribute's type.
bool co_spline_value(const CohortStage *stage, const CoValueSource *from, double time,
                     CohortValue *out);

// True if a source edits the array of a weaker one, by default or at any time. Then the value
// changes whenever that of a weaker one does, up to the first that edits nothing: all these times,
// ascending.
bool co_source_has_edits(const CoValueSource *source);
size_t co_prim_edited_times(const CohortPrim *prim, const char *token, const double **times);

// An array of `type` with edits applied; base->count may be 0.
bool co_value_edited(const CohortStage *stage, const CoArrayEdit *edit, CohortType type,
                     const CohortValue *base, double time, CohortValue *out);

// ---- List ops over packed items (with the lock held)
// ----------------------------------------------
typedef struct CoEditList {
    const CohortStage *stage;
    void *items;
    size_t count, capacity, item_size;
    bool is_text; // items are CohortString
} CoEditList;

// What an item becomes in the stage's namespace; false drops it.
typedef struct CoEditTranslate {
    bool (*fn)(void *context, const CohortString *in, CohortString *out);
    void *context;
} CoEditTranslate;

// Edits the list by an op of its item type; false when memory is at an end.
bool co_edit_list_apply(CoEditList *list, const CoListOp *op, const CoEditTranslate *translate);

// Everything of `strong`, and of `weak` what it lacks, dictionaries within them likewise (with the
// lock held); NULL when memory is at an end.
const CoDict *co_dict_merge(const CohortStage *stage, const CoDict *strong, const CoDict *weak);

// Where an asset path leads (with the lock held).
bool co_asset_locate(CohortStage *stage, const CoSource *source, const CohortString *text,
                     CohortAsset *out);

// Composed metadata of the prim (property NULL) or of a property.
bool co_prim_field(const CohortPrim *prim, const char *property, const char *key, CohortValue *out);

// TfDictionaryLessThan: numbers by value, letters without case first.
int co_name_compare(const char *a, const char *b);

#endif
