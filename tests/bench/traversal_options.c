#include "traversal_options.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char usage[] =
    "usage: bench_traversal [--json] [options]\n"
    "  --scenes LIST   of room_1m,city_10m,city_50m,shaderball,small (all; city_50m takes 12 GB)\n"
    "  --isa LIST      of avx2,avx512 (both)\n"
    "  --threads LIST  (1,2)\n"
    "  --rays LIST     of primary,diffuse,shuffled (all)\n"
    "  --what LIST     of closest,occluded,sorted_batch,sorted_total,build,bytes (all)\n"
    "  --batch N       2^N rays to a sorted batch (22)\n"
    "  --count N       2^N rays to the other measurements (21)\n"
    "  --repeats N     median of N (5)\n"
    "  --sort WHICH    fast, exact or none (as the engine chooses; sorted_batch: fast)\n"
    "  --cpu           processor seconds: for a machine that is not idle\n"
    "  --disk          all bins on disk, none in memory\n"
    "  --stage FILE    the shader ball (by default in $COHORT_SHARED)\n"
    "Millions per second (bytes: per triangle); ratios above 1: Cohort is better. closest, "
    "occluded:\n"
    "ray by ray against single rays; primary rays in groups against the best packets. "
    "sorted_batch:\n"
    "against the best of singles and packets on the same sorted rays. sorted_total: packing, "
    "bins,\n"
    "sort and traversal against single rays in the order they were made in.\n";

bool bench_is_listed(const char *list, const char *name)
{
    size_t n = strlen(name);
    for (const char *at = list; at; at = strchr(at, ',') ? strchr(at, ',') + 1 : NULL)
        if (strncmp(at, name, n) == 0 && (at[n] == '\0' || at[n] == ','))
            return true;
    return false;
}

static bool read_arguments(int argc, char **argv, BenchOptions *o)
{
    for (int i = 1; i < argc; i++) {
        const char *key = argv[i], *value = i + 1 < argc ? argv[i + 1] : NULL;
        if (bench_is_listed("--json,--cpu,--disk", key)) {
            o->json = o->json || key[2] == 'j';
            o->cpu = o->cpu || key[2] == 'c';
            o->disk = o->disk || key[2] == 'd';
            continue;
        }
        if (!value)
            return false;
        i++;
        if (strcmp(key, "--scenes") == 0)
            o->scenes = value;
        else if (strcmp(key, "--isa") == 0)
            o->isas = value;
        else if (strcmp(key, "--threads") == 0)
            o->threads = value;
        else if (strcmp(key, "--rays") == 0)
            o->rays = value;
        else if (strcmp(key, "--what") == 0)
            o->what = value;
        else if (strcmp(key, "--stage") == 0)
            o->stage = value;
        else if (strcmp(key, "--sort") == 0)
            o->sort = value;
        else if (strcmp(key, "--batch") == 0)
            o->batch_bits = atoi(value);
        else if (strcmp(key, "--count") == 0)
            o->count_bits = atoi(value);
        else if (strcmp(key, "--repeats") == 0)
            o->repeats = atoi(value);
        else
            return false;
    }
    return o->repeats >= 1 && o->repeats <= BENCH_REPEATS_MAX && o->batch_bits >= 8 &&
           o->batch_bits <= 24 && o->count_bits >= 8 && o->count_bits <= 24;
}

bool bench_options_read(int argc, char **argv, BenchOptions *o)
{
    *o = (BenchOptions){.scenes = "room_1m,city_10m,city_50m,shaderball,small",
                        .isas = "avx2,avx512",
                        .threads = "1,2",
                        .rays = "primary,diffuse,shuffled",
                        .what = "closest,occluded,sorted_batch,sorted_total,build,bytes",
                        .batch_bits = 22,
                        .count_bits = 21,
                        .repeats = 5};
    if (read_arguments(argc, argv, o))
        return true;
    fputs(usage, stderr);
    return false;
}
