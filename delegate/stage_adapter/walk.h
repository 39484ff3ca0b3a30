// Shared by walk.c and walk_lights.c; nobody else includes it.

#ifndef CO_ADAPTER_WALK_H
#define CO_ADAPTER_WALK_H

#include "stage_adapter/adapter.h"

// A prototype that the walk is in.
typedef struct CoOpen {
    const struct CoOpen *outer; // NULL: the world
    const CohortPrim *root;
    uint32_t depth;
    bool is_native; // its root's children, not the root itself
} CoOpen;

typedef struct CoWalk {
    CohortAdapter *adapter;
    CohortError *err;   // never NULL
    const CoOpen *open; // the innermost
} CoWalk;

// ---- walk.c ------------------------------------------------------------------------------------

bool co_is_point_instancer(const CohortPrim *prim);

// Invisible at all times: nothing below can undo it, so nothing below is looked at.
bool co_is_never_visible(const CohortAdapter *adapter, const CohortPrim *prim);

// A new prototype, found again by `key` (NULL: by nothing). COHORT_INVALID_ID when out of memory.
uint32_t co_walk_add_prototype(CoWalk *walk, const CoPrototype *prototype, const char *key);

// ---- walk_lights.c -----------------------------------------------------------------------------

bool co_walk_add_light(CoWalk *walk, CoPlace place);

// Whether a prim, or what it shows as an instance, is or holds a light; PointInstancers do not
// count.
bool co_walk_has_lights(CohortAdapter *adapter, const CohortPrim *prim);

// Adds all lights at and below a place, but for those that are never visible. Lights are no part of
// a prototype's group: each instance's are lights of the world.
bool co_walk_lights(CoWalk *walk, CoPlace place);

// There is no way to place lights by a PointInstancer: each one, or the instance that holds some,
// is named. Not at the walk, which comes to a shared prototype once, wherever it was met first.
void co_walk_report_lights(CohortAdapter *adapter, const CohortPrim *prim);

#endif
