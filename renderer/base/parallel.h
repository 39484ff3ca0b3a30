// The one thread pool: OpenMP behind a function that says what a worker may rely on.

#ifndef CO_BASE_PARALLEL_H
#define CO_BASE_PARALLEL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Works on items [begin, end). `worker` is less than co_worker_count() and than the number of
// blocks, and is not shared by two calls that run at once, so it may index per-worker state.
typedef void CoParallelFn(void *context, size_t begin, size_t end, uint32_t worker);

// Calls fn over [0, count) in blocks of at most `grain` items (0 = 1), claimed dynamically, and
// returns when all are done. What fn writes must not depend on which worker or when.
void co_parallel_for(size_t count, size_t grain, CoParallelFn *fn, void *context);

// The same, but each thread begins with a part of [0, count) of its own, the same one in every call
// over as many blocks, and helps others once it is done: for passes over memory that is written in
// one and met again in the next, which then is in that thread's own cache.
void co_parallel_for_parts(size_t count, size_t grain, CoParallelFn *fn, void *context);

// The same in long blocks, for work that finds in a thread's caches what its neighbors left there:
// the last of them, one for each thread, are cut into blocks of `least` items, so that threads end
// together.
void co_parallel_for_tapered(size_t count, size_t grain, size_t least, CoParallelFn *fn,
                             void *context);

// Sets how many threads later calls from this thread use; 0 = as many as the machine has; at most
// 64 or four per processor.
void co_worker_count_set(uint32_t count);
uint32_t co_worker_count(void);

// The same, or 1 while more than twice as many threads want to run as there are processors, if the
// system says: for work that takes less time than waiting for a thread that is not run.
uint32_t co_worker_count_at_hand(void);

// True while called by co_parallel_for with several threads: further calls then use one.
bool co_in_parallel(void);

#endif
