// Nanoseconds per ray of each step of the ray stream: encode, push, decode, ray sorts, hit sort;
// and of a film add. Not a test: prints a table.

#include "arguments.h"
#include "base/clock.h"
#include "base/hash.h"
#include "base/parallel.h"
#include "film/film.h"
#include "rays/ray_batch.h"
#include "rays/ray_kernels.h"
#include "sort/hit_sort.h"
#include "sort/ray_sort.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define REPEATS 5

static const char usage[] = "usage: bench_rays [BITS [THREADS]]\n"
                            "  BITS     2^BITS rays to a batch (22)\n"
                            "  THREADS  (all)\n";

typedef struct Bench {
    const CoRayKernels *codes;
    CoRayBins *bins;
    CoRayRecords records; // of the batch
    uint32_t *order;
    CoRayBatch batch;
    CoRay *rays;
    uint32_t *words;
    size_t count;
    CoFilm *film;
} Bench;

static float uniform(uint64_t n, uint32_t what)
{
    return (float)(co_hash64(n << 8 | what) >> 40) * 0x1p-24f;
}

// Cosine-like bounces off 200 spheres in a box, all in the +x bin, in random order.
static CoRay make_ray(uint32_t n)
{
    uint32_t sphere = co_hash32(n) % 200;
    CoVec3 center = {100.0f * uniform(sphere, 9), 40.0f * uniform(sphere, 10),
                     30.0f * uniform(sphere, 11)};
    CoVec3 normal =
        co_normalize(co_vec3(uniform(n, 0) - 0.5f, uniform(n, 1) - 0.5f, uniform(n, 2) - 0.5f));
    CoRay ray = {.org = co_madd(center, normal, 2.0f), .kind = CO_RAY_BSDF, .depth = 2};
    uint32_t code[2]; // the encoder finds it
    ray.dir = co_ray_snap_direction(
        co_normalize(co_vec3(1.0f, 2.0f * uniform(n, 5) - 1.0f, 2.0f * uniform(n, 6) - 1.0f)),
        code);
    ray.weight = co_vec3(uniform(n, 7), uniform(n, 8), 0.5f);
    ray.normal = co_ray_snap_normal(normal, code);
    ray.pdf = uniform(n, 12);
    ray.path = n;
    ray.width = 0.01f;
    return ray;
}

static void encode_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    Bench *b = context;
    CoRayQueue queue = {.count = 0};
    CoRayEncoded encoded;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        CoRayKey key = {(uint32_t)i, 0, 0};
        if (!co_ray_queue_add(&queue, &b->rays[i], key) && i + 1 < end)
            continue;
        b->codes->encode(&queue, 0, &encoded);
        for (uint32_t k = 0; k < queue.count; k++)
            memcpy(b->words + (i + 1 - queue.count + k) * CO_RAY_WORDS, encoded.words[k],
                   CO_RAY_WORDS * sizeof(uint32_t));
        queue.count = 0;
    }
}

static void decode_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    Bench *b = context;
    (void)worker;
    b->codes->decode(&b->records, b->order, 0, begin, end, &b->batch);
}

static void push_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    Bench *b = context;
    for (size_t i = begin; i < end; i++)
        co_ray_bins_push(b->bins, worker, b->words + i * CO_RAY_WORDS, 0);
}

static void add_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    Bench *b = context;
    (void)worker;
    for (size_t i = begin; i < end; i++)
        co_film_add_color(b->film, co_hash32((uint32_t)i) % (1280 * 720), (uint32_t)i & 1,
                          b->rays[i].weight);
}

// Best of the repeats, the first one apart: it pays for fresh memory and files.
typedef struct Timing {
    double first, best;
    int runs;
} Timing;

static void time_add(Timing *t, double begin, size_t count)
{
    double ns = (co_clock_seconds() - begin) * 1e9 / (double)count;
    if (t->runs++ == 0)
        t->first = ns;
    else if (t->runs == 2 || ns < t->best)
        t->best = ns;
}

static void report(const char *what, const Timing *t)
{
    printf("%-28s %8.2f %8.2f\n", what, t->first, t->best);
}

static double group_spread(const CoRayBatch *b)
{
    double total = 0.0;
    size_t groups = b->count / 64;
    for (size_t g = 0; g < groups; g++) {
        double x = 0, y = 0, z = 0;
        for (size_t i = g * 64; i < g * 64 + 64; i++) {
            x += (double)b->dir_x[i] / 64;
            y += (double)b->dir_y[i] / 64;
            z += (double)b->dir_z[i] / 64;
        }
        total += 1.0 - sqrt(x * x + y * y + z * z);
    }
    return total / (double)groups;
}

static double group_size(const CoRayBatch *b)
{
    double total = 0.0;
    size_t groups = b->count / 64;
    for (size_t g = 0; g < groups; g++) {
        const float *org[3] = {b->org_x + g * 64, b->org_y + g * 64, b->org_z + g * 64};
        double diagonal2 = 0.0;
        for (int a = 0; a < 3; a++) {
            float low = org[a][0], high = low;
            for (int i = 1; i < 64; i++) {
                low = fminf(low, org[a][i]);
                high = fmaxf(high, org[a][i]);
            }
            diagonal2 += (double)(high - low) * (double)(high - low);
        }
        total += sqrt(diagonal2);
    }
    return total / (double)groups;
}

static void bench_stream(Bench *b)
{
    Timing encode = {0}, push = {0}, decode = {0}, sort[2] = {{.runs = 0}, {.runs = 0}};
    double spread[2], size[2];
    CoRayBatch *batch = &b->batch;
    CoSortScratch scratch = {NULL, 0};
    CohortError err = {0};
    CoRayRecords *records = &b->records;
    for (int r = 0; r < REPEATS; r++) {
        double t = co_clock_seconds();
        co_parallel_for(b->count, 4096, encode_range, b);
        time_add(&encode, t, b->count);
        t = co_clock_seconds();
        co_parallel_for(b->count, 4096, push_range, b);
        bool is_good = co_ray_bins_flush(b->bins, &err);
        time_add(&push, t, b->count);
        if (!is_good || !co_ray_bins_pop(b->bins, records, &err) ||
            !co_ray_batch_reserve(batch, records->count, &err))
            break;
        for (int s = 0; s < 2; s++) {
            t = co_clock_seconds();
            CoRaySorter sorter = {s ? COHORT_SORTER_FAST : COHORT_SORTER_EXACT, co_ray_keys(NULL)};
            if (!co_sort_rays(records, sorter, &scratch, b->order, &err))
                break;
            time_add(&sort[s], t, b->count);
            t = co_clock_seconds();
            co_ray_batch_begin(batch, b->count);
            co_parallel_for(b->count, 4096, decode_range, b);
            time_add(&decode, t, b->count);
            spread[s] = group_spread(batch);
            size[s] = group_size(batch);
        }
        co_ray_bins_recycle(b->bins, records);
    }
    if (err.code != COHORT_OK) {
        printf("failed: %s\n", err.message);
        return;
    }
    report("encode", &encode);
    report("push to the bin's file", &push);
    report("ray sort, exact", &sort[0]);
    report("ray sort, fast", &sort[1]);
    report("decode to arrays, in order", &decode);
    printf("group spread, exact and fast %8.5f %8.5f\n", spread[0], spread[1]);
    printf("group size, exact and fast   %8.4f %8.4f\n", size[0], size[1]);
    co_ray_batch_clear(batch);
    co_sort_scratch_clear(&scratch);
}

static void bench_hits(size_t count)
{
    uint32_t *mesh = malloc(count * 4), *tri = malloc(count * 4), *order = malloc(count * 4);
    CoSortScratch scratch = {NULL, 0};
    Timing timing = {0};
    for (int r = 0; r < REPEATS && mesh && tri && order; r++) {
        for (uint32_t i = 0; i < count; i++) {
            mesh[i] = co_hash32(i) % 2710;
            tri[i] = co_hash32(i + 1000) % 26000;
            order[i] = i;
        }
        double t = co_clock_seconds();
        co_sort_hits(mesh, tri, order, count, &scratch, NULL);
        time_add(&timing, t, count);
    }
    report("hit sort, 2710 x 26000", &timing);
    co_sort_scratch_clear(&scratch);
    free(mesh);
    free(tri);
    free(order);
}

int main(int argc, char **argv)
{
    double bits = 22, threads = 0;
    const BenchArgument arguments[] = {
        {.name = "BITS", .number = &bits, .least = 8, .most = 26},
        {.name = "THREADS", .number = &threads, .least = 1, .most = 64}};
    bench_arguments_read(argc, argv, usage, arguments, sizeof arguments / sizeof *arguments);
    size_t count = (size_t)1 << (int)bits;
    co_worker_count_set((uint32_t)threads);
    CohortError err = {0};
    Bench bench = {.count = count, .codes = co_ray_kernels(NULL)};
    bench.bins = co_ray_bins_create(count, CO_RAY_WORDS, co_worker_count(), co_ray_bins_budget(),
                                    NULL, &err);
    bench.rays = malloc(count * sizeof *bench.rays);
    bench.words = malloc(count * CO_RAY_WORDS * sizeof *bench.words);
    bench.order = malloc(count * sizeof *bench.order);
    bench.film = co_film_create(1280, 720, 0, 4, &err);
    if (!bench.bins || !bench.rays || !bench.words || !bench.order || !bench.film) {
        printf("failed: %s\n", err.message);
        return 1;
    }
    for (size_t i = 0; i < count; i++)
        bench.rays[i] = make_ray((uint32_t)i);
    printf("%zu rays, %u threads\n%-28s %8s %8s  ns per ray\n", count, co_worker_count(), "",
           "first", "best");
    bench_stream(&bench);
    bench_hits(count);
    Timing film = {0};
    for (int r = 0; r < REPEATS; r++) {
        double t = co_clock_seconds();
        co_parallel_for(count, 4096, add_range, &bench);
        time_add(&film, t, count);
    }
    report("film, add a color", &film);
    co_film_destroy(bench.film);
    co_ray_bins_destroy(bench.bins);
    free(bench.rays);
    free(bench.words);
    free(bench.order);
    return 0;
}
