// Wall-clock time for statistics and limits; never for anything that reaches the image.

#ifndef CO_BASE_CLOCK_H
#define CO_BASE_CLOCK_H

#include <time.h>

static inline double co_clock_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

#endif
