// Bounds of records (ray_bounds.c), as they are added and as batches come with them: those of their
// finite origins and no others, whoever wrote them, in files that were others' before.

#include "ray_bin_support.h"

#include "rays/ray_bounds.h"

#include <math.h>

// Origins of both signs, some far out; every eleventh is none: NaN or infinite in one coordinate.
static void fill_origin(uint32_t *words, uint32_t n)
{
    const float odd[] = {NAN, INFINITY, -INFINITY};
    float org[3];
    for (uint32_t a = 0; a < 3; a++)
        org[a] = ((float)(co_hash32(3 * n + a) >> 8) * 0x1p-24f - 0.5f) * (n % 100 ? 10.0f : 1e9f);
    if (n % 11 == 0)
        org[n / 11 % 3] = odd[n / 33 % 3];
    memcpy(words, org, sizeof org);
    for (uint32_t i = 3; i < CO_RAY_WORDS; i++)
        words[i] = co_hash32(n + i); // the one behind the origin is NaN at times
}

// One by one, as slowly and plainly as can be.
static void check_bounds(const CoRayBounds *bounds, const uint32_t *words, size_t count)
{
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    size_t invalid = 0;
    for (size_t i = 0; i < count; i++) {
        float org[3];
        memcpy(org, words + i * CO_RAY_WORDS, sizeof org);
        bool is_finite = isfinite(org[0]) && isfinite(org[1]) && isfinite(org[2]);
        invalid += !is_finite;
        for (int a = 0; a < 3 && is_finite; a++) {
            low[a] = fminf(low[a], org[a]);
            high[a] = fmaxf(high[a], org[a]);
        }
    }
    assert_int_equal(bounds->invalid, invalid);
    assert_true(bounds->low.x == low[0] && bounds->low.y == low[1] && bounds->low.z == low[2]);
    assert_true(bounds->high.x == high[0] && bounds->high.y == high[1] &&
                bounds->high.z == high[2]);
}

static void bounds_are_those_of_finite_origins(void **state)
{
    (void)state;
    enum {
        COUNT = 3600
    };
    static uint32_t words[COUNT * CO_RAY_WORDS];
    const size_t counts[] = {0, 1, 2, 10, 255, 256, 257, 1000, 2000};
    for (uint32_t n = 0; n < COUNT; n++)
        fill_origin(words + n * CO_RAY_WORDS, n);
    for (uint32_t n = 512; n < 1024; n++) // two parts without an odd one
        fill_origin(words + n * CO_RAY_WORDS, n % 10 + 1);
    for (int c = 0; c < 9; c++)
        for (size_t first = 0; first < 1000; first += 37) {
            const uint32_t *from = words + first * CO_RAY_WORDS;
            CoRayBounds bounds = co_ray_bounds_none(), rest = co_ray_bounds_none();
            co_ray_bounds_add(&bounds, from, counts[c], CO_RAY_WORDS);
            check_bounds(&bounds, from, counts[c]);
            co_ray_bounds_add(&rest, from + counts[c] * CO_RAY_WORDS, 500, CO_RAY_WORDS);
            co_ray_bounds_join(&bounds, &rest);
            check_bounds(&bounds, from, counts[c] + 500);
        }
}

static void push_origins(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Push *push = context;
    uint32_t words[CO_RAY_WORDS_MAX];
    for (size_t i = begin; i < end; i++) {
        fill_origin(words, push->base + (uint32_t)i);
        co_ray_bins_push(push->bins, worker, words, bin_of(push->base + (uint32_t)i));
    }
}

// Gathered over all bins too; the second round is small, in files that the first has used.
static void batches_know_their_bounds(void **state)
{
    const uint64_t *budget = *state;
    CohortError err = {0};
    CoRayRecords records;
    co_worker_count_set(4);
    CoRayBins *bins = co_ray_bins_create(512, CO_RAY_WORDS, 4, *budget, NULL, &err);
    Push push = {bins, CO_RAY_WORDS, 0};
    for (uint32_t round = 0; round < 2; round++) {
        size_t count = round ? 200 : 20000, seen = 0;
        push.base = round ? 1 : 0;
        co_parallel_for(count, 64, push_origins, &push);
        assert_true(co_ray_bins_flush(bins, &err));
        while (co_ray_bins_pop(bins, &records, &err) &&
               (records.count > 0 || co_ray_bins_drain(bins, &records, &err)) &&
               records.count > 0) {
            check_bounds(&records.bounds, records.words, records.count);
            seen += records.count;
            co_ray_bins_recycle(bins, &records);
        }
        assert_int_equal(seen, count);
    }
    co_ray_bins_destroy(bins);
    co_worker_count_set(0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bounds_are_those_of_finite_origins),
        WITH_BUDGETS(batches_know_their_bounds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
