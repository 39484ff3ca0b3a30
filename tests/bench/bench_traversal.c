// Rays per second, bytes and build speed of the acceleration structure beside Embree, on the same
// rays in one run, in turns. Not a test, though it fails when hits differ. bench_traversal --help.

#include "traversal_embree.h"
#include "traversal_options.h"
#include "traversal_rays.h"

#include "base/clock.h"
#include "base/parallel.h"
#include "math/vec.h"
#include "rays/ray_kernels.h"
#include "sort/ray_sort.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum {
    CONTENDERS_MAX = 8,
    GRAIN = 1024,
    SORT_PAYS_BYTES = 1 << 20 // as integrate/render.c has it
};

typedef struct Bench {
    const BenchOptions *options;
    BenchScene scene;
    BenchRays rays;
    CoRayBatch shuffled, shuffled_light;
    CoHitBatch hits, checked;
    const CoAccelKernels *kernels;
    BenchEmbree *embree[2]; // fast, robust
    uint32_t threads;
    const char *isa;
    CoSortScratch scratch;
    uint32_t *order;
    bool has_printed, is_wrong;
} Bench;

// --- one measurement ----------------------------------------------------------------------------

static double now(const Bench *bench)
{
    struct timespec t;
    if (!bench->options->cpu)
        return co_clock_seconds();
    clock_gettime(bench->threads == 1 ? CLOCK_THREAD_CPUTIME_ID : CLOCK_PROCESS_CPUTIME_ID, &t);
    return ((double)t.tv_sec + 1e-9 * (double)t.tv_nsec) / (double)bench->threads;
}

typedef struct Contender {
    bool grouped;        // ours
    BenchEmbree *embree; // or this
    uint32_t width;      // of its packets
    bool coherent;
    double seconds[BENCH_REPEATS_MAX];
} Contender;

typedef struct Trace {
    const Bench *bench;
    const Contender *contender;
    const CoRayBatch *rays;
    const uint8_t *occlusion; // NULL: closest hits
    CoHitBatch *hits;
    CoTraverseStats *stats; // of ours, on one thread; may be NULL
} Trace;

static void trace_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Trace *trace = context;
    const Contender *c = trace->contender;
    CoTraverseStats stats = {0};
    (void)worker;
    if (c->embree)
        bench_embree_trace(c->embree, c->width, c->coherent, trace->occlusion != NULL, trace->rays,
                           trace->hits, begin, end);
    else
        trace->bench->kernels->traverse(&trace->bench->scene.accel, trace->rays, trace->occlusion,
                                        trace->hits, begin, end, c->grouped,
                                        trace->stats ? trace->stats : &stats);
}

static double trace_seconds(const Trace *trace)
{
    double start = now(trace->bench);
    co_parallel_for(trace->rays->count, GRAIN, trace_range, (void *)(uintptr_t)trace);
    return now(trace->bench) - start;
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(const double *values, int count)
{
    double sorted[BENCH_REPEATS_MAX];
    memcpy(sorted, values, (size_t)count * sizeof *sorted);
    qsort(sorted, (size_t)count, sizeof *sorted, compare_doubles);
    return count % 2 ? sorted[count / 2] : 0.5 * (sorted[count / 2 - 1] + sorted[count / 2]);
}

typedef struct Row {
    const char *rays, *what;
    double cohort, embree[2], ratio[2]; // 0: none
} Row;

static void print_number(const char *key, double x)
{
    if (x > 0.0)
        printf(", \"%s\": %.4g", key, x);
    else
        printf(", \"%s\": null", key);
}

static void print_row(Bench *bench, const Row *row)
{
    if (!bench->options->json) {
        printf("%-10s %-8s %u %-6s %-12s %8.3f | %8.3f %8.3f | %6.3f %6.3f\n", bench->scene.name,
               row->rays ? row->rays : "-", bench->threads, bench->isa, row->what, row->cohort,
               row->embree[0], row->embree[1], row->ratio[0], row->ratio[1]);
        fflush(stdout);
        return;
    }
    printf("%s\n  {\"scene\": \"%s\", \"rays\": ", bench->has_printed ? "," : "[",
           bench->scene.name);
    if (row->rays)
        printf("\"%s\"", row->rays);
    else
        printf("null");
    printf(", \"threads\": %u, \"isa\": \"%s\", \"what\": \"%s\"", bench->threads, bench->isa,
           row->what);
    print_number("cohort", row->cohort);
    print_number("embree_fast", row->embree[0]);
    print_number("embree_robust", row->embree[1]);
    print_number("ratio_fast", row->ratio[0]);
    print_number("ratio_robust", row->ratio[1]);
    printf("}");
    bench->has_printed = true;
    fflush(stdout);
}

// contenders[0] is ours; of the others the fastest of either mode counts.
static void finish_row(Bench *bench, const char *rays, const char *what, double count,
                       const Contender *contenders, int n)
{
    int repeats = bench->options->repeats;
    Row row = {.rays = rays, .what = what};
    row.cohort = count * 1e-6 / median(contenders[0].seconds, repeats);
    for (int c = 1; c < n; c++) {
        int mode = contenders[c].embree == bench->embree[1];
        double rate = count * 1e-6 / median(contenders[c].seconds, repeats);
        if (rate <= row.embree[mode])
            continue;
        double ratios[BENCH_REPEATS_MAX];
        for (int i = 0; i < repeats; i++)
            ratios[i] = contenders[c].seconds[i] / contenders[0].seconds[i];
        row.embree[mode] = rate;
        row.ratio[mode] = median(ratios, repeats);
    }
    print_row(bench, &row);
}

// Ours and Embree in both modes: single rays, and packets when asked for.
static int list_contenders(const Bench *bench, bool grouped, bool packets, bool coherent,
                           Contender *out)
{
    int n = 0;
    out[n++] = (Contender){.grouped = grouped};
    for (int mode = 0; mode < 2; mode++)
        for (uint32_t width = 1; bench->embree[mode] && width <= 16;
             width = width == 1 ? 8 : 2 * width)
            if (width == 1 || (packets && bench_embree_has(bench->embree[mode], width)))
                out[n++] = (Contender){.embree = bench->embree[mode],
                                       .width = width,
                                       .coherent = coherent && width > 1};
    return n;
}

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
    Trace trace = {bench, &(Contender){.grouped = false}, &some, occlusion, &bench->hits, NULL};
    trace.stats = bench->threads == 1 ? &stats : NULL;
    trace_seconds(&trace);
    trace.stats = NULL;
    trace.hits = &bench->checked;
    for (int k = 0; k < 8; k++) {
        bench->kernels = co_accel_kernels(isas[k / 2]);
        if (!bench->kernels)
            continue;
        trace.contender = &(Contender){.grouped = k % 2};
        trace_seconds(&trace);
        for (size_t i = 0; i < some.count; i++)
            wrong += !is_same_hit(&bench->hits, &bench->checked, i);
    }
    bench->kernels = own;
    if (bench->embree[1]) {
        trace.contender = &(Contender){.embree = bench->embree[1], .width = 1};
        trace_seconds(&trace);
        for (size_t i = 0; i < some.count; i++)
            far += !is_near_hit(bench->hits.t[i], bench->checked.t[i]);
    }
    fprintf(stderr, "%s %s %s: %zu rays; %zu hits differ between kernels, %zu from Embree's\n",
            bench->scene.name, name, bench->isa, some.count, wrong, far);
    if (stats.groups)
        fprintf(stderr, "  per ray: %.2f top nodes, %.2f bottom nodes, %.2f triangles\n",
                (double)stats.top_nodes_single / (double)stats.groups,
                (double)stats.bottom_nodes / (double)stats.groups,
                (double)stats.triangles / (double)stats.groups);
    bench->is_wrong = bench->is_wrong || wrong > 0 || far > some.count / 1000;
}

// --- rows ---------------------------------------------------------------------------------------

static void measure_rays(Bench *bench, const char *name, const CoRayBatch *rays, bool occlusion)
{
    Contender contenders[CONTENDERS_MAX];
    bool is_primary = strcmp(name, "primary") == 0;
    int n = list_contenders(bench, is_primary, is_primary, true, contenders);
    uint8_t *flags = calloc(rays->count, 1);
    if (!flags)
        return;
    memset(flags, 1, rays->count);
    Trace trace = {.bench = bench, .rays = rays, .hits = &bench->hits};
    trace.occlusion = occlusion ? flags : NULL;
    if (bench->threads == 1 || !strchr(bench->options->threads, '1'))
        check_hits(bench, name, rays, trace.occlusion);
    for (int round = 0; round < bench->options->repeats; round++)
        for (int c = 0; c < n; c++) {
            trace.contender = &contenders[c];
            contenders[c].seconds[round] = trace_seconds(&trace);
        }
    finish_row(bench, name, occlusion ? "occluded" : "closest", (double)rays->count, contenders, n);
    free(flags);
}

typedef struct Pack {
    const CoRayKernels *codes;
    const CoRayBatch *rays;
    CoRayBins *bins;
} Pack;

static void push_queue(const Pack *pack, uint32_t worker, CoRayQueue *queue)
{
    CoRayEncoded encoded;
    pack->codes->encode(queue, 0, &encoded);
    for (uint32_t i = 0; i < queue->count; i++)
        if (encoded.is_kept >> i & 1)
            co_ray_bins_push(pack->bins, worker, encoded.words[i], queue->bin[i]);
    queue->count = 0;
}

static void pack_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Pack *pack = context;
    const CoRayBatch *rays = pack->rays;
    CoRayQueue queue = {.count = 0};
    for (size_t i = begin; i < end; i++) {
        CoRay ray = {.kind = CO_RAY_BSDF, .depth = 2, .path = (uint32_t)i, .pdf = 0.25f};
        ray.org = co_vec3(rays->org_x[i], rays->org_y[i], rays->org_z[i]);
        ray.dir = co_vec3(rays->dir_x[i], rays->dir_y[i], rays->dir_z[i]);
        ray.dir = co_ray_snap_direction(ray.dir, ray.code);
        ray.weight = co_vec3(0.7f, 0.5f, 0.3f);
        ray.normal = co_vec3(0.0f, 1.0f, 0.0f);
        ray.width = 0.01f;
        if (co_ray_queue_add(&queue, &ray, (CoRayKey){(uint32_t)i, 0, 0}))
            push_queue(pack, worker, &queue);
    }
    push_queue(pack, worker, &queue);
}

// All bounces in their order, into these bins or into new ones.
static CoRayBins *pack_rays(const Bench *bench, CoRayBins *bins)
{
    size_t capacity = (size_t)1 << bench->options->batch_bits;
    if (!bins)
        bins = co_ray_bins_create(capacity, CO_RAY_WORDS, co_worker_count(), NULL, NULL);
    if (!bins)
        return NULL;
    Pack pack = {co_ray_kernels(bench->isa), &bench->rays.diffuse, bins};
    co_parallel_for(pack.rays->count, GRAIN, pack_range, &pack);
    co_ray_bins_flush(bins, NULL);
    return bins;
}

static void sort_batch(Bench *bench, const CoRayRecords *records)
{
    const char *sort = bench->options->sort;
    CoRaySorter sorter = {COHORT_SORTER_FAST, co_ray_keys(bench->isa)};
    if (sort && strcmp(sort, "exact") == 0)
        sorter.which = COHORT_SORTER_EXACT;
    co_sort_rays(records, sorter, &bench->scratch, bench->order, NULL);
}

typedef struct Decode {
    const CoRayKernels *codes;
    const CoRayRecords *records;
    const uint32_t *order;
    CoRayBatch *batch;
} Decode;

static void decode_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Decode *decode = context;
    (void)worker;
    decode->codes->decode(decode->records, decode->order, 0, begin, end, decode->batch);
}

// In the order given, or NULL.
static void decode_batch(const Bench *bench, const CoRayRecords *records, const uint32_t *order,
                         CoRayBatch *batch)
{
    Decode decode = {co_ray_kernels(bench->isa), records, order, batch};
    co_ray_batch_begin(batch, records->count);
    co_parallel_for(records->count, GRAIN, decode_range, &decode);
}

// The next batch, ready ones before what is left; false when there is none.
static bool next_batch(CoRayBins *bins, CoRayRecords *records)
{
    return co_ray_bins_pop(bins, records, NULL) &&
           (records->count > 0 || co_ray_bins_drain(bins, records, NULL)) && records->count > 0;
}

static void measure_sorted_batches(Bench *bench)
{
    Contender contenders[CONTENDERS_MAX];
    int n = list_contenders(bench, true, true, false, contenders);
    size_t capacity = (size_t)1 << bench->options->batch_bits;
    CoRayBatch batch = {.count = 0};
    CoRayRecords records;
    double count = 0.0;
    CoRayBins *bins = pack_rays(bench, NULL);
    if (!bins || !co_ray_batch_reserve(&batch, capacity, NULL))
        return;
    while (next_batch(bins, &records)) {
        sort_batch(bench, &records);
        decode_batch(bench, &records, bench->order, &batch);
        Trace trace = {.bench = bench, .rays = &batch, .hits = &bench->hits};
        count += (double)batch.count;
        for (int round = 0; round < bench->options->repeats; round++)
            for (int c = 0; c < n; c++) {
                trace.contender = &contenders[c];
                contenders[c].seconds[round] += trace_seconds(&trace);
            }
        co_ray_bins_recycle(bins, &records);
    }
    finish_row(bench, "diffuse", "sorted_batch", count, contenders, n);
    co_ray_bins_destroy(bins);
    co_ray_batch_clear(&batch);
}

// Where the time of sorted_total goes.
typedef enum Part {
    PART_PACK, // and bin
    PART_SORT,
    PART_DECODE,
    PART_TRACE,
    PART_COUNT
} Part;

// Adds the time since *since to a part.
static void book(const Bench *bench, double *since, double parts[PART_COUNT], Part part)
{
    double at = now(bench);
    parts[part] += at - *since;
    *since = at;
}

static void trace_batches(Bench *bench, CoRayBins *bins, CoRayBatch *batch, bool sorts,
                          double parts[PART_COUNT])
{
    double since = now(bench);
    CoRayRecords records;
    const Contender own = {.grouped = true};
    while (next_batch(bins, &records)) {
        if (sorts)
            sort_batch(bench, &records);
        book(bench, &since, parts, PART_SORT);
        decode_batch(bench, &records, sorts ? bench->order : NULL, batch);
        book(bench, &since, parts, PART_DECODE);
        Trace trace = {.bench = bench, .contender = &own, .rays = batch, .hits = &bench->hits};
        trace_seconds(&trace);
        book(bench, &since, parts, PART_TRACE);
        co_ray_bins_recycle(bins, &records);
    }
}

static CoRayBatch slice(const CoRayBatch *rays, size_t begin, size_t most)
{
    CoRayBatch out = *rays;
#define BENCH_OFFSET(type, name) out.name += begin;
    CO_RAY_FIELDS(BENCH_OFFSET)
    out.count = rays->count - begin < most ? rays->count - begin : most;
    return out;
}

static void measure_sorted_total(Bench *bench)
{
    Contender contenders[CONTENDERS_MAX];
    int n = list_contenders(bench, true, false, false, contenders);
    size_t capacity = (size_t)1 << bench->options->batch_bits;
    const CoRayBatch *rays = &bench->rays.diffuse;
    CoRayBatch batch = {.count = 0};
    CoRayBins *bins = pack_rays(bench, NULL); // which makes the files
    if (!bins || !co_ray_batch_reserve(&batch, capacity, NULL))
        return;
    double parts[PART_COUNT] = {0}, scale = 1e9 / (double)rays->count; // of the last round
    bool sorts = bench_scene_tree_bytes(&bench->scene) + bench->scene.mesh_bytes > SORT_PAYS_BYTES;
    if (bench->options->sort)
        sorts = strcmp(bench->options->sort, "none") != 0;
    trace_batches(bench, bins, &batch, sorts, parts);
    for (int round = 0; round < bench->options->repeats; round++) {
        double start = now(bench), since = start;
        pack_rays(bench, bins);
        memset(parts, 0, sizeof parts);
        book(bench, &since, parts, PART_PACK);
        trace_batches(bench, bins, &batch, sorts, parts);
        contenders[0].seconds[round] = now(bench) - start;
        for (int c = 1; c < n; c++)
            for (size_t i = 0; i < rays->count; i += capacity) {
                CoRayBatch part = slice(rays, i, capacity);
                Trace trace = {bench, &contenders[c], &part, NULL, &bench->hits, NULL};
                contenders[c].seconds[round] += trace_seconds(&trace);
            }
    }
    finish_row(bench, "diffuse", "sorted_total", (double)rays->count, contenders, n);
    fprintf(stderr, "  ns per ray: %.1f packing, %.1f sorting, %.1f decoding, %.1f traversal\n",
            scale * parts[PART_PACK], scale * parts[PART_SORT], scale * parts[PART_DECODE],
            scale * parts[PART_TRACE]);
    co_ray_bins_destroy(bins);
    co_ray_batch_clear(&batch);
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
        measure_sorted_batches(bench);
    if (bench_is_listed(o->what, "sorted_total") && bench_is_listed(o->rays, "diffuse"))
        measure_sorted_total(bench);
}

static void measure_build(Bench *bench)
{
    double seconds[3][BENCH_REPEATS_MAX] = {{0}}, ratios[2][BENCH_REPEATS_MAX] = {{0}},
           count = (double)bench->scene.triangles;
    int repeats = bench->options->repeats;
    Row row = {.what = "build"};
    bool has_embree = true;
    for (int round = 0; round < repeats; round++) {
        bench_scene_unbuild(&bench->scene);
        double start = co_clock_seconds();
        bench_scene_build(&bench->scene);
        seconds[0][round] = co_clock_seconds() - start;
        for (int mode = 0; mode < 2 && has_embree; mode++) {
            BenchEmbree *embree = bench_embree_create(&bench->scene, bench->isa, mode,
                                                      bench->threads, &seconds[1 + mode][round]);
            has_embree = embree != NULL;
            bench_embree_destroy(embree);
            if (has_embree)
                ratios[mode][round] = seconds[1 + mode][round] / seconds[0][round];
        }
    }
    row.cohort = count * 1e-6 / median(seconds[0], repeats);
    for (int mode = 0; mode < 2 && has_embree; mode++) {
        row.embree[mode] = count * 1e-6 / median(seconds[1 + mode], repeats);
        row.ratio[mode] = median(ratios[mode], repeats);
    }
    print_row(bench, &row);
}

static void report_bytes(Bench *bench)
{
    const BenchScene *scene = &bench->scene;
    double mesh = (double)scene->mesh_bytes, own = (double)scene->own_triangles;
    Row row = {.what = "bytes"};
    row.cohort = ((double)bench_scene_tree_bytes(scene) + mesh) / own;
    for (int mode = 0; mode < 2; mode++)
        if (bench->embree[mode]) {
            row.embree[mode] = ((double)bench_embree_bytes(bench->embree[mode]) + mesh) / own;
            row.ratio[mode] = row.embree[mode] / row.cohort;
        }
    print_row(bench, &row);
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
        if (bench_is_listed(o->what, "build") && bench->scene.meshes)
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
    if (!bench_scene_open(name, o->stage, &bench->scene))
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
    if (!bench_options_read(argc, argv, &options))
        return 2;
    static Bench bench;
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
