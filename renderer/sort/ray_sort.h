// Ray sort: turns a batch of rays into groups of 64 that traverse coherently.
//
// Source: Eisenacher, Nichols, Selle, Burley 2013, 3.1.
// Terms: run = rays that are close by origin, at most 4096; group = 64 rays of a run, close by
// direction.

#ifndef CO_SORT_RAY_SORT_H
#define CO_SORT_RAY_SORT_H

#include "cohort/render.h"
#include "rays/ray.h"
#include "sort/radix.h"

// Puts the rays of a batch into a coherent order; every group but the last is full. Order changes,
// content does not. Rays with NaN or infinite origins come last.
//   EXACT  median splits on the longest axis of the subset's bounds: by origin down to 4096 rays,
//   by
//          direction down to 64. Where all origins are one point (a pinhole), by direction at once.
//          Which rays share a group does not depend on the order they came in, ties of equal rays
//          aside.
//   FAST   a radix sort along a Morton curve through the origins, cut into runs of 4096; each run
//   is
//          sorted along a Morton curve through the octahedral map of directions. Stable.
//   batch    in/out; its padding is left alone; count at most 2^26
//   scratch  kept and grown; about 36 bytes per ray (exact) or 52 (fast)
// False with COHORT_ERROR_OUT_OF_MEMORY: the batch is then unchanged.
// Threads: parallel inside; the result is the same for any number of them.
bool co_sort_rays(CoRayBatch *batch, CohortSorter sorter, CoSortScratch *scratch, CohortError *err);

#endif
