// The composed stage as one layer: what cohort_stage_flatten is made of.

#ifndef CO_STAGE_FLATTEN_H
#define CO_STAGE_FLATTEN_H

#include "stage/stage_data.h"

// Children of an instance are told under its own path, not its prototype's.
typedef struct CoRenaming {
    const CoPath *from, *to;
    const struct CoRenaming *outer;
} CoRenaming;

typedef struct CoFlattener {
    const CohortStage *stage;
    CoLayer layer;
    CoPathTable paths; // those that renaming makes
    const CoRenaming *renaming;
    jmp_buf escape; // out of memory
} CoFlattener;

void *co_flat_alloc(CoFlattener *flat, size_t count, size_t size);

// A value as the flat layer has to say it: asset paths absolute, times in the stage's time.
CoValue co_flat_value(CoFlattener *flat, const CoValue *value, const CoSource *source);

// The same of a curve; the knots of a timecode's are times as well.
CoValue co_flat_spline(CoFlattener *flat, const CoValueSource *from);

// All fields of a prim (property NULL) or property that are not composition's own.
void co_flat_fields(CoFlattener *flat, CoSpec *out, const CohortPrim *prim, const char *property);

void co_flat_add_field(CoFlattener *flat, CoSpec *out, const char *name, CoValue value);

// An explicit list op of texts.
CoValue co_flat_texts(CoFlattener *flat, CohortType type, const char *const *texts, size_t count);

// A target path under the names that instances give it.
const char *co_flat_rename(CoFlattener *flat, const char *target);

#endif
