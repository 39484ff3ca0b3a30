// The ray sort: a permutation, median splits as the paper has them, coherence of both sorters, the
// same result for any thread count and input order, degenerate and hostile batches.

#include "base/hash.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "rays/ray_batch.h"
#include "rays/ray_queue.h"
#include "sort/hilbert.h"
#include "sort/ray_sort.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const CohortSorter sorters[] = {COHORT_SORTER_EXACT, COHORT_SORTER_FAST};

static float uniform(uint32_t n, uint32_t what)
{
    return (float)(co_hash64((uint64_t)n << 8 | what) >> 40) * 0x1p-24f;
}

// Ray number n of a room with spheres in it: origins on surfaces, directions in the +x bin.
static CoRay scene_ray(uint32_t n)
{
    CoRay ray = {.depth = n};
    CoVec3 s;
    do {
        s = co_vec3(uniform(n, 0) - 0.5f, uniform(n, 1) - 0.5f, uniform(n, 2) - 0.5f);
        n += 0x10000000u;
    } while (co_dot(s, s) > 0.25f || co_dot(s, s) < 1e-4f);
    uint32_t sphere = co_hash32(ray.depth) % 20;
    CoVec3 center = {100.0f * uniform(sphere, 9), 40.0f * uniform(sphere, 10),
                     10.0f * uniform(sphere, 11)};
    ray.org = sphere < 5 ? co_vec3(100.0f * uniform(n, 3), 40.0f * uniform(n, 4), 0.0f)
                         : co_madd(center, co_normalize(s), 3.0f);
    ray.dir = co_ray_quantize_direction(
        co_normalize(co_vec3(1.0f, 2.0f * uniform(n, 5) - 1.0f, 2.0f * uniform(n, 6) - 1.0f)));
    return ray;
}

static void set_ray(CoRayBatch *batch, size_t i, const CoRay *ray, uint32_t record)
{
    batch->org_x[i] = ray->org.x;
    batch->org_y[i] = ray->org.y;
    batch->org_z[i] = ray->org.z;
    batch->dir_x[i] = ray->dir.x;
    batch->dir_y[i] = ray->dir.y;
    batch->dir_z[i] = ray->dir.z;
    batch->tnear[i] = (float)record;
    batch->tfar[i] = (float)record + 1.0f;
    batch->record[i] = record;
}

// Position i holds ray (i * step) modulo count; step must be coprime to count.
static void fill_scene(CoRayBatch *batch, size_t count, size_t step)
{
    assert_true(co_ray_batch_reserve(batch, count, NULL));
    batch->count = count;
    for (size_t i = 0; i < count; i++) {
        uint32_t n = (uint32_t)(i * step % count);
        CoRay ray = scene_ray(n);
        set_ray(batch, i, &ray, n);
    }
}

// What sorting looks at; the rest of the records is left zero. Batches of one bin say so.
static void write_records(const CoRayBatch *b, uint32_t *words, CoRayRecords *out)
{
    *out = (CoRayRecords){words, b->count, CO_RAY_WORDS, 0, NULL};
    for (size_t i = 0; i < b->count; i++) {
        uint32_t *w = words + i * CO_RAY_WORDS, code[2];
        CoVec3 dir = co_vec3(b->dir_x[i], b->dir_y[i], b->dir_z[i]);
        co_ray_find_direction_code(dir, code);
        memcpy(&w[0], &b->org_x[i], sizeof *w);
        memcpy(&w[1], &b->org_y[i], sizeof *w);
        memcpy(&w[2], &b->org_z[i], sizeof *w);
        w[3] = code[0] ? code[0] - 1 : CO_DIRECTION_MAX;
        w[4] = code[1] ? code[1] - 1 : CO_DIRECTION_MAX;
        CoOct grid = {(int32_t)w[3] - CO_DIRECTION_MAX, (int32_t)w[4] - CO_DIRECTION_MAX};
        if (co_ray_bin(grid) != 0)
            out->bin = CO_RAY_BIN_MIXED;
    }
}

// Sorts the rays of a batch with everything that belongs to them.
static bool sort_batch(CoRayBatch *batch, CohortSorter which, CoSortScratch *scratch,
                       CohortError *err)
{
    size_t count = batch->count;
    uint32_t *words = calloc(count + 1, CO_RAY_WORDS * sizeof *words);
    uint32_t *order = malloc((count + 1) * sizeof *order), *held = malloc((count + 1) * 4);
    CoRayRecords records;
    write_records(batch, words, &records);
    order[count] = 77;
    bool is_good = co_sort_rays(&records, (CoRaySorter){which, co_ray_keys(NULL)}, scratch, order,
                                err);
    assert_int_equal(order[count], 77);
#define REORDER(type, name) \
    for (size_t i = 0; i < count; i++) \
        memcpy(&held[i], &batch->name[i], 4); \
    for (size_t i = 0; i < count && is_good; i++) { \
        assert_true(order[i] < count); \
        memcpy(&batch->name[i], &held[order[i]], 4); \
    }
    CO_RAY_FIELDS(REORDER)
    free(words);
    free(order);
    free(held);
    return is_good;
}

static void check_permutation(const CoRayBatch *batch)
{
    uint8_t *seen = calloc(batch->count + 1, 1);
    for (size_t i = 0; i < batch->count; i++) {
        uint32_t n = batch->record[i];
        assert_true(n < batch->count && !seen[n]);
        seen[n] = 1;
        CoRay ray = scene_ray(n);
        assert_true(batch->org_x[i] == ray.org.x && batch->org_y[i] == ray.org.y &&
                    batch->org_z[i] == ray.org.z);
        assert_true(batch->dir_x[i] == ray.dir.x && batch->dir_y[i] == ray.dir.y &&
                    batch->dir_z[i] == ray.dir.z);
        assert_true(batch->tnear[i] == (float)n && batch->tfar[i] == (float)n + 1.0f);
    }
    free(seen);
}

static void content_stays_for_every_count(void **state)
{
    (void)state;
    const size_t counts[] = {0, 1, 2, 63, 64, 65, 128, 1000, 4096, 4097, 20001};
    CoSortScratch scratch = {NULL, 0};
    CoRayBatch batch = {.count = 0};
    for (int s = 0; s < 2; s++)
        for (int c = 0; c < 11; c++) {
            fill_scene(&batch, counts[c], 1);
            assert_true(sort_batch(&batch, sorters[s], &scratch, NULL));
            assert_int_equal(batch.count, counts[c]);
            check_permutation(&batch);
        }
    co_ray_batch_clear(&batch);
    co_sort_scratch_clear(&scratch);
}

static uint32_t hilbert(uint32_t x, uint32_t y, uint32_t z, int dimensions, uint32_t bits)
{
    uint32_t at[3][CO_HILBERT_CELLS] = {{0}}, keys[CO_HILBERT_CELLS];
    at[0][5] = x;
    at[1][5] = y;
    at[2][5] = z;
    if (dimensions == 2)
        co_hilbert2(at[0], at[1], bits, keys);
    else
        co_hilbert3(at[0], at[1], at[2], bits, keys);
    return keys[5];
}

// Every cell once, and each step goes to a cell that shares a side. The first cells of a finer curve
// are those of a coarser one.
static void hilbert_curves_visit_neighbors(void **state)
{
    (void)state;
    static uint32_t cell[4096];
    for (int dimensions = 2; dimensions <= 3; dimensions++) {
        memset(cell, 0xff, sizeof cell);
        uint32_t bits = dimensions == 2 ? 6 : 4, mask = (1u << bits) - 1;
        for (uint32_t i = 0; i < 4096; i++) {
            uint32_t x = i & mask, y = i >> bits & mask, z = i >> (2 * bits) & mask;
            uint32_t key = hilbert(x, y, z, dimensions, bits);
            assert_true(key < 4096 && cell[key] == UINT32_MAX);
            cell[key] = i;
            assert_int_equal(hilbert(x >> 1, y >> 1, z >> 1, dimensions, bits - 1),
                             key >> dimensions);
        }
        for (uint32_t key = 1; key < 4096; key++) {
            int distance = 0;
            for (uint32_t shift = 0; shift < 18; shift += bits)
                distance +=
                    abs((int)(cell[key] >> shift & mask) - (int)(cell[key - 1] >> shift & mask));
            assert_int_equal(distance, 1);
        }
    }
    const uint32_t most2 = 65535, most3 = 1023;
    assert_true(hilbert(most2, 0, 0, 2, 16) == UINT32_MAX || hilbert(0, most2, 0, 2, 16) == UINT32_MAX);
    assert_true(hilbert(most3, 0, 0, 3, 10) == (1u << 30) - 1 ||
                hilbert(0, most3, 0, 3, 10) == (1u << 30) - 1 ||
                hilbert(0, 0, most3, 3, 10) == (1u << 30) - 1);
}

// With every instruction set, for parts of any length: rays of all kinds, infinite and NaN ones too.
static void keys_do_not_depend_on_the_instruction_set(void **state)
{
    (void)state;
    static const char *const isas[] = {"sse42", "avx2", "avx512"};
    enum { COUNT = 5003 };
    static uint32_t words[COUNT * CO_RAY_WORDS];
    static uint64_t expected[COUNT], items[COUNT + 1];
    for (uint32_t i = 0; i < COUNT; i++) {
        const float odd[] = {NAN, INFINITY, -INFINITY, 3e38f};
        CoRay ray = scene_ray(i);
        float org[3] = {ray.org.x, ray.org.y, ray.org.z};
        if (i % 10 == 0)
            org[i / 10 % 3] = odd[i / 30 % 4];
        memcpy(words + i * CO_RAY_WORDS, org, sizeof org);
        words[i * CO_RAY_WORDS + 3] = co_hash32(i);
        words[i * CO_RAY_WORDS + 4] = co_hash32(i + COUNT);
    }
    for (int k = 0; k < 6; k++) {
        CoKeyGrid grid = {{0, -1, 0}, 0.0f, 7, 12, 27, 0, 13};
        if (k % 2)
            grid = (CoKeyGrid){{0, -1, 0}, 1.28f, 7, 5, 21, 13, 13};
        CoRayRecords records = {words, COUNT, CO_RAY_WORDS, CO_RAY_BIN_MIXED, NULL};
        CoRayKeysFn *keys = co_ray_keys(isas[k / 2]);
        if (!keys)
            continue;
        co_ray_keys("scalar")(&records, &grid, 0, COUNT, expected);
        items[COUNT] = 77;
        keys(&records, &grid, 1000, COUNT, items);
        keys(&records, &grid, 0, 1000, items);
        assert_memory_equal(items, expected, sizeof expected);
        assert_int_equal(items[COUNT], 77);
        for (uint32_t i = 0; i < COUNT; i++) {
            const uint32_t *w = words + i * CO_RAY_WORDS;
            bool is_valid = true;
            for (int a = 0; a < 3; a++)
                is_valid = is_valid && (w[a] & 0x7f800000u) != 0x7f800000u;
            assert_int_equal(items[i] & 8191u, i);
            assert_int_equal(items[i] >> (13 + grid.direction_bits + grid.place_bits), !is_valid);
        }
    }
    assert_null(co_ray_keys("no such"));
}

typedef struct Coherence {
    double spread; // mean over groups of 1 - |mean direction|
    double size;   // mean over groups of the diagonal of the origins' box
} Coherence;

static Coherence measure(const CoRayBatch *b)
{
    Coherence total = {0};
    size_t groups = b->count / 64;
    const float *org[3] = {b->org_x, b->org_y, b->org_z};
    const float *dir[3] = {b->dir_x, b->dir_y, b->dir_z};
    for (size_t g = 0; g < groups; g++) {
        double length2 = 0, diagonal2 = 0;
        for (int a = 0; a < 3; a++) {
            double sum = 0, low = HUGE_VAL, high = -HUGE_VAL;
            for (size_t i = g * 64; i < g * 64 + 64; i++) {
                sum += (double)dir[a][i] / 64.0;
                low = fmin(low, (double)org[a][i]);
                high = fmax(high, (double)org[a][i]);
            }
            length2 += sum * sum;
            diagonal2 += (high - low) * (high - low);
        }
        total.spread += (1.0 - sqrt(length2)) / (double)groups;
        total.size += sqrt(diagonal2) / (double)groups;
    }
    return total;
}

static void groups_are_coherent(void **state)
{
    (void)state;
    CoSortScratch scratch = {NULL, 0};
    CoRayBatch batch = {.count = 0};
    Coherence sorted[2];
    fill_scene(&batch, 1 << 17, 77777);
    Coherence before = measure(&batch);
    for (int s = 0; s < 2; s++) {
        fill_scene(&batch, 1 << 17, 77777);
        assert_true(sort_batch(&batch, sorters[s], &scratch, NULL));
        sorted[s] = measure(&batch);
        print_message("%s: spread %.4f -> %.4f, size %.1f -> %.1f\n", s ? "fast" : "exact",
                      before.spread, sorted[s].spread, before.size, sorted[s].size);
        assert_true(sorted[s].spread < before.spread / 8.0);
        assert_true(sorted[s].size < before.size / 4.0);
    }
    // Shorter runs are smaller, and their groups are spread wider: the product says how well both are.
    double exact = sorted[0].spread * sorted[0].size * sorted[0].size;
    double fast = sorted[1].spread * sorted[1].size * sorted[1].size;
    assert_true(fast < exact * 3.0);
    co_ray_batch_clear(&batch);
    co_sort_scratch_clear(&scratch);
}

// On the longest axis of all origins, the first half ends where the second begins, at a multiple
// of 64.
static void exact_splits_at_the_median(void **state)
{
    (void)state;
    CoSortScratch scratch = {NULL, 0};
    CoRayBatch batch = {.count = 0};
    size_t count = 10000, middle = (157 + 1) / 2 * 64;
    fill_scene(&batch, count, 1);
    assert_true(sort_batch(&batch, COHORT_SORTER_EXACT, &scratch, NULL));
    float high = -INFINITY, low = INFINITY;
    for (size_t i = 0; i < count; i++) {
        if (i < middle)
            high = fmaxf(high, batch.org_x[i]);
        else
            low = fminf(low, batch.org_x[i]);
    }
    assert_true(high <= low);
    // At most 4096 rays: by direction only; y is the longest axis of this bin's directions or z is.
    fill_scene(&batch, 4096, 1);
    for (size_t i = 0; i < 4096; i++) {
        CoVec3 d = co_vec3(0.1f * batch.dir_x[i], 0.1f * batch.dir_y[i], batch.dir_z[i]);
        d = co_ray_quantize_direction(co_normalize(d));
        batch.dir_x[i] = d.x;
        batch.dir_y[i] = d.y;
        batch.dir_z[i] = d.z;
    }
    assert_true(sort_batch(&batch, COHORT_SORTER_EXACT, &scratch, NULL));
    high = -INFINITY;
    low = INFINITY;
    for (size_t i = 0; i < 4096; i++) {
        if (i < 2048)
            high = fmaxf(high, batch.dir_z[i]);
        else
            low = fminf(low, batch.dir_z[i]);
    }
    assert_true(high <= low);
    co_ray_batch_clear(&batch);
    co_sort_scratch_clear(&scratch);
}

static int compare_records(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return x < y ? -1 : x > y;
}

static void threads_and_input_order_do_not_matter(void **state)
{
    (void)state;
    const size_t count = 50001, steps[] = {1, 7919, 49999};
    CoSortScratch scratch = {NULL, 0};
    CoRayBatch batch = {.count = 0};
    uint32_t *first = malloc(count * sizeof *first), *groups = malloc(count * sizeof *groups);
    for (int s = 0; s < 2; s++)
        for (int o = 0; o < 3; o++)
            for (uint32_t threads = 1; threads <= 4; threads++) {
                fill_scene(&batch, count, steps[o]);
                co_worker_count_set(threads);
                assert_true(sort_batch(&batch, sorters[s], &scratch, NULL));
                if (threads == 1)
                    memcpy(first, batch.record, count * sizeof *first);
                assert_memory_equal(first, batch.record, count * sizeof *first);
                for (size_t i = 0; i < count; i += 64)
                    qsort(batch.record + i, count - i < 64 ? count - i : 64, sizeof(uint32_t),
                          compare_records);
                if (s > 0) // the fast one is only stable
                    continue;
                if (o == 0)
                    memcpy(groups, batch.record, count * sizeof *groups);
                assert_memory_equal(groups, batch.record, count * sizeof *groups);
            }
    free(first);
    free(groups);
    co_worker_count_set(0);
    co_ray_batch_clear(&batch);
    co_sort_scratch_clear(&scratch);
}

static void one_origin_is_sorted_by_direction(void **state)
{
    (void)state;
    CoSortScratch scratch = {NULL, 0};
    CoRayBatch batch = {.count = 0};
    for (int s = 0; s < 2; s++) {
        fill_scene(&batch, 1 << 16, 12345);
        for (size_t i = 0; i < batch.count; i++)
            batch.org_x[i] = batch.org_y[i] = batch.org_z[i] = -3.5f;
        double before = measure(&batch).spread;
        assert_true(sort_batch(&batch, sorters[s], &scratch, NULL));
        assert_true(measure(&batch).spread < before / 200.0);
    }
    co_ray_batch_clear(&batch);
    co_sort_scratch_clear(&scratch);
}

static void equal_and_hostile_rays_end_well(void **state)
{
    (void)state;
    CoSortScratch scratch = {NULL, 0};
    CoRayBatch batch = {.count = 0};
    for (int s = 0; s < 2; s++)
        for (int kind = 0; kind < 5; kind++) {
            size_t count = 30000, valid = 0;
            fill_scene(&batch, count, 1);
            for (size_t i = 0; i < count; i++) {
                CoRay ray = {.dir = {0, 0, 1}};
                if (kind == 1 || kind == 2)
                    ray.org.x = i % 7 == 0 ? NAN : i % 11 == 0 ? -INFINITY : (float)(i % 5);
                if (kind == 2)
                    ray.org.x = NAN;
                if (kind == 3)
                    ray.org.y = i % 2 ? 3e38f : -3e38f;
                if (kind == 4)
                    ray.dir = i % 2 ? co_vec3(0, 0, 0) : co_vec3(NAN, 1, 0);
                set_ray(&batch, i, &ray, (uint32_t)i);
                valid += isfinite(ray.org.x) != 0;
            }
            assert_true(sort_batch(&batch, sorters[s], &scratch, NULL));
            uint64_t sum = 0;
            for (size_t i = 0; i < count; i++) {
                sum += batch.record[i];
                assert_int_equal(isfinite(batch.org_x[i]) != 0, i < valid);
            }
            assert_int_equal(sum, (uint64_t)count * (count - 1) / 2);
        }
    co_ray_batch_clear(&batch);
    co_sort_scratch_clear(&scratch);
}

static void out_of_memory_leaves_the_batch(void **state)
{
    (void)state;
    CoRayBatch batch = {.count = 0};
    for (int s = 0; s < 2; s++) {
        CoSortScratch scratch = {NULL, 0};
        CohortError err = {0};
        fill_scene(&batch, 5000, 1);
        co_memory_fail_after(1);
        assert_false(sort_batch(&batch, sorters[s], &scratch, &err));
        co_memory_fail_after(0);
        assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
        for (size_t i = 0; i < 5000; i++)
            assert_int_equal(batch.record[i], i);
    }
    co_ray_batch_clear(&batch);
    assert_int_equal(co_memory_live(CO_MEMORY_RAYS), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(content_stays_for_every_count),
        cmocka_unit_test(hilbert_curves_visit_neighbors),
        cmocka_unit_test(keys_do_not_depend_on_the_instruction_set),
        cmocka_unit_test(groups_are_coherent),
        cmocka_unit_test(exact_splits_at_the_median),
        cmocka_unit_test(threads_and_input_order_do_not_matter),
        cmocka_unit_test(one_origin_is_sorted_by_direction),
        cmocka_unit_test(equal_and_hostile_rays_end_well),
        cmocka_unit_test(out_of_memory_leaves_the_batch),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
