// What comes next in a round, and how many samples a round has.
//
// Source: Eisenacher et al. 2013, 3.1; docs/architecture.md ("Rays": schedule, rounds).

#ifndef CO_RAYS_SCHEDULE_H
#define CO_RAYS_SCHEDULE_H

#include "rays/ray_bin.h"

typedef enum CoScheduleStep {
    CO_SCHEDULE_BATCH,  // *out is to be traced, shaded and recycled
    CO_SCHEDULE_CAMERA, // make more camera rays
    CO_SCHEDULE_DONE,   // every bin is empty: the round is complete
    CO_SCHEDULE_FAILED  // *err says why
} CoScheduleStep;

// The newest ready batch first: deep paths end before new ones begin, which bounds what is in
// flight. Then camera rays while the round has any; then what is left. Flushes the local buffers
// first.
CoScheduleStep co_schedule_next(CoRayBins *bins, bool has_camera_rays, CoRayRecords *out,
                                CohortError *err);

// Samples per pixel of the next round: 1, 1, 2, 4, ... doubling what is there until a round takes
// about 10 seconds, from then on of that size; at most `target - taken`, and at most 2^32 paths.
//   last        samples of the round before, 0 if none; seconds: how long it took
//   pixels      > 0
// The image does not depend on it.
uint64_t co_schedule_round(uint64_t taken, uint64_t target, uint64_t pixels, uint64_t last,
                           double seconds);

#endif
