// Rays of the traversal benchmark as the engine traces them: packed into bins, popped as batches,
// sorted, decoded and traced.

#ifndef TRAVERSAL_SORTED_H
#define TRAVERSAL_SORTED_H

#include "traversal_contest.h"

// Traversal alone: the contenders trace the same sorted batches.
void bench_measure_sorted_batches(Bench *bench);

// The whole way of ours, with its parts on stderr, against Embree on the rays as they were made.
void bench_measure_sorted_total(Bench *bench);

#endif
