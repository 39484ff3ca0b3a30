// How the points of a block (grid_leaf.h) follow from the words of its patch, where all patches are
// alike and of level 1 to 3.

#ifndef CO_ACCEL_GRID_PLAN_H
#define CO_ACCEL_GRID_PLAN_H

#include "geometry/patch.h"

typedef struct CoGridPlan {
    uint8_t word[16], step[16]; // by point: see co_lane_along
    uint8_t corner[24];         // as of CoTriLeaf
    int8_t first[4];            // triangles of its rows, in the patch
    uint8_t count, rows;        // of triangles; which these are, CoGridRows
    uint16_t valid;             // one bit per triangle that is one
} CoGridPlan;
_Static_assert(sizeof(CoGridPlan) == 64, "a plan is a cache line");

// Rows of a plan's triangles: two of as many, or four of a triangle of 4 squares a side, which
// stands on its long row, or on its tip.
typedef enum CoGridRows {
    CO_GRID_ROWS_EVEN = 0,
    CO_GRID_ROWS_UPRIGHT,
    CO_GRID_ROWS_INVERTED
} CoGridRows;

// Where row q of the four begins.
static inline uint32_t co_grid_row_start(CoGridRows rows, uint32_t q)
{
    return rows == CO_GRID_ROWS_UPRIGHT ? q * (8 - q) : q * q;
}

// By block of a patch, of folded tables of a face; NULL for other tables. Of level 1 of triangular
// patches the only one is of two patches, points of the second from 8 on. Those of level 3 are
// triangles too, see co_grid_is_paired.
const CoGridPlan *co_grid_plans(const CoPatchTable *table);

#endif
