// Namespace composed once and shown often.
//
// Two prims that the same arcs bring about, to the same sites, have the same prims below them if
// what else speaks of them (the stage's own layers, say) is silent about their descendants. Then
// the second takes over the children of the first: new prims, which cost little, with the data of
// the old ones. Data holds the paths of where it was composed; co_prim_renaming leads from there to
// the prim that has it.

#ifndef CO_STAGE_SHARE_H
#define CO_STAGE_SHARE_H

#include "stage/stage_data.h"

typedef struct CoShareKey {
    const uint64_t *words;
    size_t length; // 0: the prim's children are its own alone
    uint64_t hash;
    uint64_t remarks; // how much had happened that speaks of one prim and no other
} CoShareKey;

// What decides about the children of a prim; in scratch memory.
CoShareKey co_share_key(CohortStage *stage, const CohortPrim *prim, const CoGraph *graph);

// Takes over the children of a prim with the same key; false if there is none.
bool co_share_take(CohortStage *stage, CohortPrim *prim, const CoShareKey *key);

// Offers the composed children to later prims, unless composing them led to what holds for this
// prim only: a warning, or an arc into a layer stack that was thought silent.
void co_share_offer(CohortStage *stage, CohortPrim *prim, const CoGraph *graph,
                    const CoShareKey *key);

#endif
