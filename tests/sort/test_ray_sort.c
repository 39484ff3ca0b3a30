// Both ray sorts, the exact one and the fast one (ray_curve.c): a permutation, coherence, the same
// result for any thread count and input order, degenerate and hostile batches.

#include "base/memory.h"
#include "base/parallel.h"
#include "ray_sort_support.h"

static const CohortSorter sorters[] = {COHORT_SORTER_EXACT, COHORT_SORTER_FAST};

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
    // Shorter runs are smaller, and their groups are spread wider: the product says how well both
    // are.
    double exact = sorted[0].spread * sorted[0].size * sorted[0].size;
    double fast = sorted[1].spread * sorted[1].size * sorted[1].size;
    assert_true(fast < exact * 3.0);
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
        cmocka_unit_test(groups_are_coherent),
        cmocka_unit_test(threads_and_input_order_do_not_matter),
        cmocka_unit_test(one_origin_is_sorted_by_direction),
        cmocka_unit_test(equal_and_hostile_rays_end_well),
        cmocka_unit_test(out_of_memory_leaves_the_batch),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
