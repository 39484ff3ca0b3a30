// A contest of the traversal benchmark: the engine's kernels and Embree's on the same rays in
// turns, and the row that it prints.

#ifndef TRAVERSAL_CONTEST_H
#define TRAVERSAL_CONTEST_H

#include "sort/ray_sort.h"
#include "timing.h"
#include "traversal_embree.h"
#include "traversal_options.h"
#include "traversal_rays.h"

enum {
    BENCH_CONTENDERS_MAX = 8,
    BENCH_GRAIN = 1024 // rays to a task
};

// What all measurements of a run share.
typedef struct Bench {
    const BenchOptions *options;
    BenchScene scene;
    BenchRays rays;
    CoRayBatch shuffled, shuffled_light; // of the diffuse and the light rays
    CoHitBatch hits, checked;            // those of a check beside the first
    const CoAccelKernels *kernels;
    BenchEmbree *embree[2]; // fast, robust
    uint32_t threads;
    const char *isa;
    CoSortScratch scratch;
    uint32_t *order; // of the sorted records
    bool has_printed, is_wrong;
} Bench;

typedef struct BenchContender {
    bool grouped;        // ours
    BenchEmbree *embree; // or this
    uint32_t width;      // of its packets
    bool coherent;
    double seconds[BENCH_REPEATS_MAX];
} BenchContender;

typedef struct BenchTrace {
    const Bench *bench;
    const BenchContender *contender;
    const CoRayBatch *rays;
    const uint8_t *occlusion; // NULL: closest hits
    CoHitBatch *hits;
    CoTraverseStats *stats; // of ours, on one thread; may be NULL
} BenchTrace;

typedef struct BenchRow {
    const char *rays, *what;            // rays: NULL for what needs none
    double cohort, embree[2], ratio[2]; // 0: none
} BenchRow;

// Seconds of the wall, or of the processor over the threads, as the options ask.
double bench_now(const Bench *bench);

// Ours and Embree in both modes: single rays, and packets when asked for. Returns how many.
int bench_list_contenders(const Bench *bench, bool grouped, bool packets, bool coherent,
                          BenchContender *out);

// Traces all rays once and returns how long that took.
double bench_trace_seconds(const BenchTrace *trace);

void bench_print_row(Bench *bench, const BenchRow *row);

// Prints the row of a contest over `count` rays: medians of the rounds, and of their ratios.
// contenders[0] is ours; of the others the fastest of either mode counts.
void bench_finish_row(Bench *bench, const char *rays, const char *what, double count,
                      const BenchContender *contenders, int n);

#endif
