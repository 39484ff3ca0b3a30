// How the points of a block (grid_leaf.h) follow from the words of its patch, where all patches are
// alike and of level 1 to 3.

#ifndef CO_ACCEL_GRID_PLAN_H
#define CO_ACCEL_GRID_PLAN_H

#include "geometry/patch.h"

typedef struct CoGridPlan {
    uint8_t word[16], step[16]; // by point: see co_lane_along
    uint8_t corner[24];         // as of CoTriLeaf
    int8_t low, high;           // first triangles of its two rows, in the patch
    uint8_t count, unused;      // of triangles
    uint16_t valid;             // one bit per triangle that is one
    uint8_t unused_too[2];
} CoGridPlan;
_Static_assert(sizeof(CoGridPlan) == 64, "a plan is a cache line");

// By block of a patch, of folded tables of a face; NULL for other tables. Of level 1 of triangular
// patches the only one is of two patches, points of the second from 8 on.
const CoGridPlan *co_grid_plans(const CoPatchTable *table);

#endif
