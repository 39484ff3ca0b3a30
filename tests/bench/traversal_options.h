// Options of the traversal benchmark.

#ifndef TRAVERSAL_OPTIONS_H
#define TRAVERSAL_OPTIONS_H

#include "timing.h"

#include <stdbool.h>

// Lists are of words with commas between.
typedef struct BenchOptions {
    const char *scenes, *isas, *threads, *rays, *what;
    const char *stage; // NULL: the shader ball
    const char *sort;  // NULL: as the engine chooses
    double ground;     // side of a square below made scenes; 0: none
    int batch_bits, count_bits, repeats;
    bool json, cpu, disk;
} BenchOptions;

// As bench_arguments_read: does not return when the arguments are not understood.
void bench_options_read(int argc, char **argv, BenchOptions *out);

#endif
