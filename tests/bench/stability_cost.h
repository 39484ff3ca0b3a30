// What the watertight triangle test costs beside plain ones, and what the kernels' options cost
// where nothing asks for them, for bench_stability.

#ifndef BENCH_STABILITY_COST_H
#define BENCH_STABILITY_COST_H

#include <stdint.h>

// Traces `count` rays by the AVX2 kernels and prints nanoseconds of CPU time per ray as a table.
void stability_cost(uint64_t count);

// The same over kernels that know neither where hits of a ray begin nor what is hidden from it,
// single rays and groups.
void stability_unused(uint64_t count);

#endif
