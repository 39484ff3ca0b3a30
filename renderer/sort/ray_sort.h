// Ray sort: an order of the records of a batch in which groups of 64 traverse coherently.
//
// Source: Eisenacher, Nichols, Selle, Burley 2013, 3.1.
// Terms: run = rays that are close by origin, at most 4096 (exact), about 1024 or 2048 (fast);
// group = 64 rays of a run, close by direction.

#ifndef CO_SORT_RAY_SORT_H
#define CO_SORT_RAY_SORT_H

#include "cohort/render.h"
#include "rays/ray_bin.h"
#include "sort/radix.h"
#include "sort/ray_keys.h"

typedef struct CoRaySorter {
    CohortSorter which;
    CoRayKeysFn *keys; // of FAST, from co_ray_keys
} CoRaySorter;

// Fills order[0 .. records->count) with the indices of the records, each once, in a coherent order.
// Records with NaN or infinite origins come last; records->bounds counts them.
//   EXACT  median splits on the longest axis of the subset's bounds: by origin down to 4096
//          rays, by direction down to 64. Where all origins are one point (a pinhole), by
//          direction at once. Which rays share a group does not depend on the order they came in,
//          ties of equal rays aside.
//   FAST   by cells along a Hilbert curve through the origins; neighboring cells make runs, and
//          each run is sorted along a Hilbert curve through its directions. Stable.
//   count    at most 2^26
//   scratch  kept and grown; about 28 bytes per ray (exact) or 17 (fast)
// False with COHORT_ERROR_OUT_OF_MEMORY.
// Threads: parallel inside; the result is the same for any number of them.
bool co_sort_rays(const CoRayRecords *records, CoRaySorter sorter, CoSortScratch *scratch,
                  uint32_t *order, CohortError *err);

#endif
