// Billions of hard rays: leaks and false hits at shared edges and vertices of closed meshes, beside
// Embree where it is installed; hashes of hits on slivers and coincident quads over all kernels;
// random triangles against a brute-force search in double.
//
// Not a test: prints tables for docs/stability.md. Ends with 1 where something leaks, is false or
// differs.
//
// Leak: a ray that starts inside a closed mesh and meets nothing. False hit: the ray's line passes
// the triangle it is said to meet by more than 4 units in the last place of the largest coordinate
// of the triangle as seen from the ray's origin, in double.

#include "arguments.h"
#include "stability.h"

#include <inttypes.h>
#include <stdio.h>

static const char usage[] =
    "usage: bench_stability [options]\n"
    "  --rays N         rays of each case (10 million; soups, hashes: a tenth; cost, unused: a "
    "twentieth)\n"
    "  --embree-rays N  rays of each case by Embree (1 million)\n"
    "  --case NAME      a row of the table by its name, soups, cost, unused or hashes (all)\n"
    "  --first-block N  rays come in blocks of 16,384, numbered; other blocks are other rays (0)\n";

Score stability_sum(const Score scores[WORKERS_MAX])
{
    Score sum = {0};
    for (uint32_t i = 0; i < WORKERS_MAX; i++) {
        sum.rays += scores[i].rays;
        sum.leaks += scores[i].leaks;
        sum.false_hits += scores[i].false_hits;
        sum.worst_ulps = fmax(sum.worst_ulps, scores[i].worst_ulps);
    }
    return sum;
}

void stability_print(const char *name, const char *who, Score score)
{
    printf("| %s | %s | %.3g | %" PRIu64 " | %" PRIu64 " | %.2f |\n", name, who, (double)score.rays,
           score.leaks, score.false_hits, score.worst_ulps);
    fflush(stdout);
}

static bool is_wanted(const char *name, const char *only)
{
    return !only || strcmp(name, only) == 0;
}

// Part of the rays of each case.
static StabilityRun part_of(const StabilityRun *run, uint64_t divisor)
{
    StabilityRun part = *run;
    part.rays /= divisor;
    return part;
}

int main(int argc, char **argv)
{
    double rays = 1e7, embree_rays = 1e6, first_block = 0;
    const char *only = NULL;
    const BenchArgument arguments[] = {
        {.name = "--rays", .number = &rays, .least = 20, .most = 1e15},
        {.name = "--embree-rays", .number = &embree_rays, .most = 1e15},
        {.name = "--first-block", .number = &first_block, .most = 1e12},
        {.name = "--case", .text = &only}};
    bench_arguments_read(argc, argv, usage, arguments, sizeof arguments / sizeof *arguments);
    bench_tell_of_embree();
    if (only && !stability_is_case(only) && !bench_is_listed("soups,cost,unused,hashes", only))
        bench_refuse(argv[0], "there is no case '%s'", only);
    StabilityRun run = {(uint64_t)rays, (uint64_t)embree_rays, (uint64_t)first_block};
    StabilityRun tenth = part_of(&run, 10);
    printf("| case | who | rays | leaks | false hits | farthest, ulps |\n"
           "|---|---|---|---|---|---|\n");
    bool is_clean = stability_edges(only, &run);
    if (is_wanted("soups", only))
        is_clean = stability_soups(&tenth) && is_clean;
#ifdef BENCH_PLAIN
    if (is_wanted("cost", only) && co_accel_kernels("avx2"))
        stability_cost(run.rays / 20);
    if (is_wanted("unused", only) && co_accel_kernels("avx2"))
        stability_unused(run.rays / 20);
#endif
    if (is_wanted("hashes", only))
        is_clean = stability_hashes(&tenth) && is_clean;
    return is_clean ? 0 : 1;
}
