// Parts of bench_stability: each prints rows of its table.

#ifndef BENCH_STABILITY_H
#define BENCH_STABILITY_H

#include "../accel/exact.h"

enum {
    BLOCK = 1 << 14, // rays made, traced and judged at a time
    WORKERS_MAX = 64
};

// A line may pass the triangle that it is said to meet by so many units in the last place of the
// triangle's largest coordinate as seen from the ray's origin.
#define FALSE_HIT_ULPS 4.0

// What one worker, or all of them, found.
typedef struct Score {
    uint64_t rays, leaks, false_hits;
    double worst_ulps; // by which a line passes the triangle it is said to meet
} Score;

// Numbers of a run: blocks of other numbers are other rays.
typedef struct StabilityRun {
    uint64_t rays, embree_rays, first_block;
} StabilityRun;

Score stability_sum(const Score scores[WORKERS_MAX]);
void stability_print(const char *name, const char *who, Score score);

// Blocks that hold so many rays.
static inline size_t stability_blocks(uint64_t rays)
{
    return (size_t)((rays + BLOCK - 1) / BLOCK);
}

// Rays at edges and vertices of closed meshes: all cases, or the one of that name. False when any
// of ours leaks or is false.
bool stability_edges(const char *only, const StabilityRun *run);
bool stability_is_case(const char *name);

// Rays through soups of triangles, every hit beside a search through all of them in double.
bool stability_soups(const StabilityRun *run);

// The same rays through every kernel and tree, grouped and single, one row each; false when their
// hashes differ.
bool stability_hashes(const StabilityRun *run);

// Nanoseconds of CPU time per ray of the AVX2 kernels, beside triangle tests that are not
// watertight.
void stability_cost(uint64_t rays);

// The same over kernels that know neither where hits of a ray begin nor what is hidden from it,
// single rays and groups.
void stability_unused(uint64_t rays);

#endif
