// Random numbers as a pure function of (pixel, sample, vertex, branch, decision).
//
// Each decision draws from its own shuffled, Owen-scrambled Sobol' set of at most 4 dimensions
// (Burley 2020, "Practical Hash-based Owen Scrambling").

#ifndef CO_SAMPLE_SAMPLE_H
#define CO_SAMPLE_SAMPLE_H

#include "cohort/render.h"

#include <stdint.h>

typedef enum CoDecision {
    CO_DECISION_CAMERA = 0, // filter x, y; lens x, y
    CO_DECISION_BSDF,       // direction x, y; lobe
    CO_DECISION_LIGHT,      // position x, y; light
    CO_DECISION_ROULETTE    // survival
} CoDecision;

// The path whose numbers are drawn. Even and odd samples are two half films with scrambles of their
// own; within a half, number k = sample / 2 is point k of each set, or point k * n + branch where
// the decision splits n ways. Points beyond 2^32 begin a set anew.
typedef struct CoSampleKey {
    uint32_t pixel, sample, seed;
} CoSampleKey;

// Fills out[0..count), count <= 4, each in [0, 1). vertex = depth of the ray that leaves; `split` =
// n branches at this decision (0 or 1 if none), `branch` in [0, split); path_branch = branch the
// path follows. Past a split, either give the path's branch as path_branch (a set per branch), or
// as branch with the same n (one set over all branches, which stratifies better). About 10 ns per
// dimension.
void co_sample(CoSampleKey key, uint32_t vertex, uint32_t path_branch, CoDecision decision,
               uint32_t branch, uint32_t split, uint32_t count, float *out);

// Uniform hash in [0, 1) for decisions that must not use up a dimension (pass-through, rounding).
float co_sample_hash(CoSampleKey key, uint32_t a, uint32_t b);

// Offset from the pixel's center, importance-sampled from the filter: (u0, u1) -> pixels.
void co_filter_sample(CohortFilter filter, float u0, float u1, float *dx, float *dy);

// Uniform disk (Shirley, Chiu 1997).
void co_disk_sample(float u0, float u1, float *x, float *y);

#endif
