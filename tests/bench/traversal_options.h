// Options of the traversal benchmark.

#ifndef TRAVERSAL_OPTIONS_H
#define TRAVERSAL_OPTIONS_H

#include <stdbool.h>

enum {
    BENCH_REPEATS_MAX = 31
};

// Lists are of words with commas between.
typedef struct BenchOptions {
    const char *scenes, *isas, *threads, *rays, *what;
    const char *stage; // NULL: the shader ball
    const char *sort;  // NULL: as the engine chooses
    int batch_bits, count_bits, repeats;
    bool json, cpu, disk;
} BenchOptions;

// False, with the usage on stderr, when the arguments are not understood.
bool bench_options_read(int argc, char **argv, BenchOptions *out);

bool bench_is_listed(const char *list, const char *name);

#endif
