// Clocks and medians of the measuring programs.

#ifndef BENCH_TIMING_H
#define BENCH_TIMING_H

#include <stdlib.h>
#include <string.h>
#include <time.h>

enum {
    BENCH_REPEATS_MAX = 31
};

// CLOCK_THREAD_CPUTIME_ID: of the calling thread; CLOCK_PROCESS_CPUTIME_ID: of all, which the load
// of the machine changes little.
static inline double bench_seconds(clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static inline int bench_compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Of the first `count` <= BENCH_REPEATS_MAX values, at least one.
static inline double bench_median(const double *values, int count)
{
    double sorted[BENCH_REPEATS_MAX];
    memcpy(sorted, values, (size_t)count * sizeof *sorted);
    qsort(sorted, (size_t)count, sizeof *sorted, bench_compare);
    return count % 2 ? sorted[count / 2] : 0.5 * (sorted[count / 2 - 1] + sorted[count / 2]);
}

#endif
