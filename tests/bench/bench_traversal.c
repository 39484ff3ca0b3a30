// Rays per second, bytes and build speed of the acceleration structure beside Embree, on the same
// rays in one run, in turns. Not a test, though it fails when hits differ. bench_traversal --help.

#include "arguments.h"
#include "traversal_contest.h"
#include "traversal_sorted.h"

#include "base/clock.h"
#include "base/parallel.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// --- agreement ----------------------------------------------------------------------------------

static bool is_same_hit(const CoHitBatch *a, const CoHitBatch *b, size_t i)
{
    return memcmp(&a->t[i], &b->t[i], 4) == 0 && memcmp(&a->u[i], &b->u[i], 4) == 0 &&
           memcmp(&a->v[i], &b->v[i], 4) == 0 && a->instance[i] == b->instance[i] &&
           a->tri[i] == b->tri[i];
}

static bool is_near_hit(float a, float b)
{
    return a == b || fabsf(a - b) <= 1e-3f * fmaxf(1e-2f, fminf(fabsf(a), fabsf(b)));
}

// Single and grouped, every instruction set, bit for bit; Embree's robust mode to a tolerance, as
// rays at silhouettes and within the rounding of their start may go either way.
static void check_hits(Bench *bench, const char *name, const CoRayBatch *rays,
                       const uint8_t *occlusion)
{
    const char *const isas[] = {"scalar", "sse42", "avx2", "avx512"};
    CoRayBatch some = *rays;
    some.count = rays->count < 1 << 17 ? rays->count : 1 << 17;
    size_t wrong = 0, far = 0;
    const CoAccelKernels *own = bench->kernels;
    CoTraverseStats stats = {0};
    BenchTrace trace = {bench, &(BenchContender){.grouped = false}, &some, occlusion, &bench->hits,
                        NULL};
    trace.stats = bench->threads == 1 ? &stats : NULL;
    bench_trace_seconds(&trace);
    trace.stats = NULL;
    trace.hits = &bench->checked;
    for (int k = 0; k < 8; k++) {
        bench->kernels = co_accel_kernels(isas[k / 2]);
        if (!bench->kernels)
            continue;
        trace.contender = &(BenchContender){.grouped = k % 2};
        bench_trace_seconds(&trace);
        for (size_t i = 0; i < some.count; i++)
            wrong += !is_same_hit(&bench->hits, &bench->checked, i);
    }
    bench->kernels = own;
    if (bench->embree[1]) {
        trace.contender = &(BenchContender){.embree = bench->embree[1], .width = 1};
        bench_trace_seconds(&trace);
        for (size_t i = 0; i < some.count; i++)
            far += !is_near_hit(bench->hits.t[i], bench->checked.t[i]);
    }
    fprintf(stderr, "%s %s %s: %zu rays; %zu hits differ between kernels", bench->scene.name, name,
            bench->isa, some.count, wrong);
    if (bench->embree[1])
        fprintf(stderr, ", %zu from Embree's", far);
    fputc('\n', stderr);
    if (stats.groups)
        fprintf(stderr, "  per ray: %.2f top nodes, %.2f bottom nodes, %.2f triangles\n",
                (double)stats.top_nodes_single / (double)some.count,
                (double)stats.bottom_nodes / (double)some.count,
                (double)stats.triangles / (double)some.count);
    bench->is_wrong = bench->is_wrong || wrong > 0 || far > some.count / 1000;
}

// --- rows ---------------------------------------------------------------------------------------

static void measure_rays(Bench *bench, const char *name, const CoRayBatch *rays, bool occlusion)
{
    BenchContender contenders[BENCH_CONTENDERS_MAX];
    bool is_primary = strcmp(name, "primary") == 0;
    int n = bench_list_contenders(bench, is_primary, is_primary, true, contenders);
    uint8_t *flags = calloc(rays->count, 1);
    if (!flags)
        return;
    memset(flags, 1, rays->count);
    BenchTrace trace = {.bench = bench, .rays = rays, .hits = &bench->hits};
    trace.occlusion = occlusion ? flags : NULL;
    if (bench->threads == 1 || !strchr(bench->options->threads, '1'))
        check_hits(bench, name, rays, trace.occlusion);
    for (int round = 0; round < bench->options->repeats; round++)
        for (int c = 0; c < n; c++) {
            trace.contender = &contenders[c];
            contenders[c].seconds[round] = bench_trace_seconds(&trace);
        }
    bench_finish_row(bench, name, occlusion ? "occluded" : "closest", (double)rays->count,
                     contenders, n);
    free(flags);
}

static void measure_all_rays(Bench *bench)
{
    const BenchOptions *o = bench->options;
    for (int occlusion = 0; occlusion < 2; occlusion++) {
        if (!bench_is_listed(o->what, occlusion ? "occluded" : "closest"))
            continue;
        if (bench_is_listed(o->rays, "primary") && !occlusion)
            measure_rays(bench, "primary", &bench->rays.primary, false);
        CoRayBatch few = bench->rays.diffuse;
        few.count = bench->shuffled.count;
        if (bench_is_listed(o->rays, "diffuse"))
            measure_rays(bench, "diffuse", occlusion ? &bench->rays.light : &few, occlusion);
        if (bench_is_listed(o->rays, "shuffled"))
            measure_rays(bench, "shuffled", occlusion ? &bench->shuffled_light : &bench->shuffled,
                         occlusion);
    }
    if (bench_is_listed(o->what, "sorted_batch") && bench_is_listed(o->rays, "diffuse"))
        bench_measure_sorted_batches(bench);
    if (bench_is_listed(o->what, "sorted_total") && bench_is_listed(o->rays, "diffuse"))
        bench_measure_sorted_total(bench);
}

static void measure_build(Bench *bench)
{
    double seconds[3][BENCH_REPEATS_MAX] = {{0}}, ratios[2][BENCH_REPEATS_MAX] = {{0}},
           own = (double)bench->scene.own_triangles, count = (double)bench->scene.triangles;
    int repeats = bench->options->repeats;
    BenchRow row = {.what = "build"};
    bool has_embree = true;
    for (int round = 0; round < repeats; round++) {
        seconds[0][round] = bench_scene_rebuild(&bench->scene);
        for (int mode = 0; mode < 2 && has_embree; mode++) {
            BenchEmbree *embree = bench_embree_create(&bench->scene, bench->isa, mode,
                                                      bench->threads, &seconds[1 + mode][round]);
            has_embree = embree != NULL;
            bench_embree_destroy(embree);
            if (has_embree)
                ratios[mode][round] = own / count * seconds[1 + mode][round] / seconds[0][round];
        }
    }
    row.cohort = own * 1e-6 / bench_median(seconds[0], repeats);
    for (int mode = 0; mode < 2 && has_embree; mode++) {
        row.embree[mode] = count * 1e-6 / bench_median(seconds[1 + mode], repeats);
        row.ratio[mode] = bench_median(ratios[mode], repeats);
    }
    bench_print_row(bench, &row);
}

static void report_bytes(Bench *bench)
{
    const BenchScene *scene = &bench->scene;
    double mesh = (double)scene->mesh_bytes, own = (double)scene->own_triangles;
    BenchRow row = {.what = "bytes"};
    row.cohort = ((double)bench_scene_tree_bytes(scene) + mesh) / own;
    for (int mode = 0; mode < 2; mode++)
        if (bench->embree[mode]) {
            row.embree[mode] = ((double)bench_embree_bytes(bench->embree[mode]) + mesh) / own;
            row.ratio[mode] = row.embree[mode] / row.cohort;
        }
    bench_print_row(bench, &row);
}

static void measure_isa(Bench *bench)
{
    const BenchOptions *o = bench->options;
    double seconds;
    bench->kernels = co_accel_kernels(bench->isa);
    if (!bench->kernels) {
        fprintf(stderr, "%s: not on this machine\n", bench->isa);
        return;
    }
    for (int mode = 0; mode < 2; mode++)
        bench->embree[mode] = bench_embree_create(&bench->scene, bench->isa, mode, 2, &seconds);
    if (bench_is_listed(o->what, "bytes")) {
        bench->threads = 1;
        report_bytes(bench);
    }
    for (bench->threads = 1; bench->threads <= 64; bench->threads++) {
        char number[8];
        snprintf(number, sizeof number, "%u", bench->threads);
        if (!bench_is_listed(o->threads, number))
            continue;
        co_worker_count_set(bench->threads);
        measure_all_rays(bench);
        if (bench_is_listed(o->what, "build"))
            measure_build(bench);
    }
    bench_embree_destroy(bench->embree[0]);
    bench_embree_destroy(bench->embree[1]);
}

static void measure_scene(Bench *bench, const char *name)
{
    const BenchOptions *o = bench->options;
    size_t count = (size_t)1 << o->count_bits, batch = (size_t)1 << o->batch_bits;
    bool is_sorted =
        bench_is_listed(o->what, "sorted_batch") || bench_is_listed(o->what, "sorted_total");
    size_t diffuse = is_sorted && CO_RAY_BINS * batch > count ? CO_RAY_BINS * batch : count;
    co_worker_count_set(0);
    if (!bench_scene_open(name, o->stage, o->ground, &bench->scene))
        return;
    bool is_good = bench_rays_make(&bench->scene, diffuse, count, &bench->rays) &&
                   bench_rays_copy(&bench->rays.diffuse, count, true, &bench->shuffled) &&
                   bench_rays_copy(&bench->rays.light, count, true, &bench->shuffled_light) &&
                   co_hit_batch_reserve(&bench->hits, count > batch ? count : batch, NULL) &&
                   co_hit_batch_reserve(&bench->checked, count, NULL) &&
                   (bench->order = malloc(batch * sizeof *bench->order)) != NULL;
    fprintf(stderr, "%s: %llu triangles in %llu meshes\n", name,
            (unsigned long long)bench->scene.triangles,
            (unsigned long long)bench->scene.path_count);
    for (int k = 0; is_good && k < 2; k++) {
        bench->isa = k == 0 ? "avx2" : "avx512";
        if (bench_is_listed(o->isas, bench->isa))
            measure_isa(bench);
    }
    free(bench->order);
    bench->order = NULL;
    bench_rays_destroy(&bench->rays);
    co_ray_batch_clear(&bench->shuffled);
    co_ray_batch_clear(&bench->shuffled_light);
    bench_scene_destroy(&bench->scene);
}

int main(int argc, char **argv)
{
    const char *const scenes[] = {"small", "room_1m", "city_10m", "city_50m", "shaderball"};
    BenchOptions options;
    static Bench bench;
    bench_options_read(argc, argv, &options);
    bench_tell_of_embree();
    bench.options = &options;
    if (!options.json)
        printf("scene      rays     threads isa  what         cohort | embree fast, robust | "
               "ratios\n");
    for (int i = 0; i < 5; i++)
        if (bench_is_listed(options.scenes, scenes[i]))
            measure_scene(&bench, scenes[i]);
    if (options.json)
        printf("%s\n]\n", bench.has_printed ? "" : "[");
    if (bench.is_wrong)
        fprintf(stderr, "hits differ\n");
    return bench.is_wrong;
}
