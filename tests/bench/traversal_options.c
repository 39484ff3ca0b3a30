#include "traversal_options.h"

#include "arguments.h"

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
    "  --ground SIZE   a square of that side below what is made (0: none)\n"
    "  --stage FILE    the shader ball (by default in $COHORT_SHARED)\n"
    "Millions per second (bytes: per triangle); ratios above 1: Cohort is better.\n"
    "closest, occluded: ray by ray against single rays; primary rays in groups against the best\n"
    "packets. sorted_batch: against the best of singles and packets on the same sorted rays.\n"
    "sorted_total: packing, bins, sort and traversal against single rays in the order they were\n"
    "made in.\n";

static void check_threads(const char *program, const char *list)
{
    for (const char *at = list; at; at = strchr(at, ',') ? strchr(at, ',') + 1 : NULL) {
        char *end;
        long threads = strtol(at, &end, 10);
        if (end == at || (*end && *end != ',') || threads < 1 || threads > 64)
            bench_refuse(program, "--threads takes numbers from 1 to 64, not '%s'", list);
    }
}

void bench_options_read(int argc, char **argv, BenchOptions *o)
{
    *o = (BenchOptions){.scenes = "room_1m,city_10m,city_50m,shaderball,small",
                        .isas = "avx2,avx512",
                        .threads = "1,2",
                        .rays = "primary,diffuse,shuffled",
                        .what = "closest,occluded,sorted_batch,sorted_total,build,bytes"};
    double batch_bits = 22, count_bits = 21, repeats = 5;
    const BenchArgument arguments[] = {
        {.name = "--scenes", .text = &o->scenes, .words = o->scenes},
        {.name = "--isa", .text = &o->isas, .words = o->isas},
        {.name = "--threads", .text = &o->threads},
        {.name = "--rays", .text = &o->rays, .words = o->rays},
        {.name = "--what", .text = &o->what, .words = o->what},
        {.name = "--batch", .number = &batch_bits, .least = 8, .most = 24},
        {.name = "--count", .number = &count_bits, .least = 8, .most = 24},
        {.name = "--repeats", .number = &repeats, .least = 1, .most = BENCH_REPEATS_MAX},
        {.name = "--sort", .text = &o->sort, .words = "fast,exact,none"},
        {.name = "--ground", .number = &o->ground, .least = 0, .most = 1e12},
        {.name = "--stage", .text = &o->stage},
        {.name = "--json", .flag = &o->json},
        {.name = "--cpu", .flag = &o->cpu},
        {.name = "--disk", .flag = &o->disk}};
    bench_arguments_read(argc, argv, usage, arguments, sizeof arguments / sizeof *arguments);
    check_threads(argv[0], o->threads);
    o->batch_bits = (int)batch_bits;
    o->count_bits = (int)count_bits;
    o->repeats = (int)repeats;
}
