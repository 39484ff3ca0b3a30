#include "traversal_sorted.h"

#include "base/parallel.h"
#include "rays/ray_kernels.h"

#include <stdio.h>
#include <string.h>

enum {
    SORT_PAYS_BYTES = 1 << 20,   // as integrate/render.c has it
    TASK_RAYS = 16 * BENCH_GRAIN // as integrate/trace.c has it
};

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
            co_ray_bins_push(pack->bins, worker, encoded.words[i], encoded.bin[i]);
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
        co_ray_nearest_code(ray.dir, ray.code);
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
        bins = co_ray_bins_create(capacity, CO_RAY_WORDS, co_worker_count(),
                                  bench->options->disk ? 0 : co_ray_bins_budget(), NULL, NULL);
    if (!bins)
        return NULL;
    Pack pack = {co_ray_kernels(bench->isa), &bench->rays.diffuse, bins};
    co_parallel_for(pack.rays->count, BENCH_GRAIN, pack_range, &pack);
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
    co_parallel_for(records->count, BENCH_GRAIN, decode_range, &decode);
}

// The next batch, ready ones before what is left; false when there is none.
static bool next_batch(CoRayBins *bins, CoRayRecords *records)
{
    return co_ray_bins_pop(bins, records, NULL) &&
           (records->count > 0 || co_ray_bins_drain(bins, records, NULL)) && records->count > 0;
}

void bench_measure_sorted_batches(Bench *bench)
{
    BenchContender contenders[BENCH_CONTENDERS_MAX];
    int n = bench_list_contenders(bench, true, true, false, contenders);
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
        BenchTrace trace = {.bench = bench, .rays = &batch, .hits = &bench->hits};
        count += (double)batch.count;
        for (int round = 0; round < bench->options->repeats; round++)
            for (int c = 0; c < n; c++) {
                trace.contender = &contenders[c];
                contenders[c].seconds[round] += bench_trace_seconds(&trace);
            }
        co_ray_bins_recycle(bins, &records);
    }
    bench_finish_row(bench, "diffuse", "sorted_batch", count, contenders, n);
    co_ray_bins_destroy(bins);
    co_ray_batch_clear(&batch);
}

// Where the time of sorted_total goes.
typedef enum Part {
    PART_PACK, // and bin
    PART_SORT,
    PART_TRACE, // and decode
    PART_COUNT
} Part;

// Adds the time since *since to a part.
static void book(const Bench *bench, double *since, double parts[PART_COUNT], Part part)
{
    double at = bench_now(bench);
    parts[part] += at - *since;
    *since = at;
}

// As integrate/trace.c has it: some groups at a time, traversed while what was decoded is in the
// inner cache.
typedef struct Trace {
    const Bench *bench;
    Decode decode;
    CoHitBatch *hits;
} Trace;

static void decode_and_trace(void *context, size_t begin, size_t end, uint32_t worker)
{
    Trace *trace = context;
    CoTraverseStats stats = {0};
    for (size_t first = begin; first < end; first += BENCH_GRAIN) {
        size_t last = end - first < BENCH_GRAIN ? end : first + BENCH_GRAIN;
        decode_range(&trace->decode, first, last, worker);
        trace->bench->kernels->traverse(&trace->bench->scene.accel, trace->decode.batch, NULL,
                                        trace->hits, first, last, true, &stats);
    }
}

static void trace_batches(Bench *bench, CoRayBins *bins, CoRayBatch *batch, bool sorts,
                          double parts[PART_COUNT])
{
    double since = bench_now(bench);
    CoRayRecords records;
    Trace trace = {bench, {co_ray_kernels(bench->isa), &records, NULL, batch}, &bench->hits};
    trace.decode.order = sorts ? bench->order : NULL;
    while (next_batch(bins, &records)) {
        if (sorts)
            sort_batch(bench, &records);
        book(bench, &since, parts, PART_SORT);
        co_ray_batch_begin(batch, records.count);
        co_parallel_for_tapered(records.count, TASK_RAYS, BENCH_GRAIN, decode_and_trace, &trace);
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

void bench_measure_sorted_total(Bench *bench)
{
    BenchContender contenders[BENCH_CONTENDERS_MAX];
    int n = bench_list_contenders(bench, true, false, false, contenders);
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
        double start = bench_now(bench), since = start;
        pack_rays(bench, bins);
        memset(parts, 0, sizeof parts);
        book(bench, &since, parts, PART_PACK);
        trace_batches(bench, bins, &batch, sorts, parts);
        contenders[0].seconds[round] = bench_now(bench) - start;
        for (int c = 1; c < n; c++)
            for (size_t i = 0; i < rays->count; i += capacity) {
                CoRayBatch part = slice(rays, i, capacity);
                BenchTrace trace = {bench, &contenders[c], &part, NULL, &bench->hits, NULL};
                contenders[c].seconds[round] += bench_trace_seconds(&trace);
            }
    }
    bench_finish_row(bench, "diffuse", "sorted_total", (double)rays->count, contenders, n);
    fprintf(stderr, "  ns per ray: %.1f packing, %.1f sorting, %.1f decoding and traversal\n",
            scale * parts[PART_PACK], scale * parts[PART_SORT], scale * parts[PART_TRACE]);
    CoRayBinStats stats;
    co_ray_bins_stats(bins, &stats);
    fprintf(stderr, "  batches of 2^%d; bins: %u in memory, %u on disk\n",
            bench->options->batch_bits, stats.files_in_memory, stats.files_on_disk);
    co_ray_bins_destroy(bins);
    co_ray_batch_clear(&batch);
}
