// What the watertight triangle test costs beside plain ones, for bench_stability.

#ifndef BENCH_STABILITY_COST_H
#define BENCH_STABILITY_COST_H

#include <stdint.h>

// Traces `count` rays by the AVX2 kernels and prints nanoseconds of CPU time per ray as a table.
void stability_cost(uint64_t count);

#endif
