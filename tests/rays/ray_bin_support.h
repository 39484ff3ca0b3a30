// What the tests of ray bins share: records that can be told apart, and all of them counted.

#ifndef TEST_RAY_BIN_SUPPORT_H
#define TEST_RAY_BIN_SUPPORT_H

#include "base/hash.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "rays/ray_bin.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

// What memory files get: each test below that looks at `state` holds for all of these.
static const uint64_t test_budgets[] = {0, 3 * 256 * 36, UINT64_MAX};

static inline CoRayBins *make_bins(void **state, size_t capacity, CohortError *err)
{
    const uint64_t *budget = *state;
    return co_ray_bins_create(capacity, CO_RAY_WORDS, 1, *budget, NULL, err);
}

typedef struct Push {
    CoRayBins *bins;
    uint32_t stride;
    uint32_t base; // number of the first record
} Push;

// Record number n: every word follows from it.
static inline void fill_record(uint32_t *words, uint32_t stride, uint32_t n)
{
    words[0] = n;
    for (uint32_t i = 1; i < stride; i++)
        words[i] = co_hash32(n + i);
}

static inline uint32_t bin_of(uint32_t n)
{
    return co_hash32(n) % 8 < 3 ? 0 : co_hash32(n) % 6; // one bin fills faster
}

static inline void push_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Push *push = context;
    uint32_t words[CO_RAY_WORDS_MAX];
    for (size_t i = begin; i < end; i++) {
        uint32_t n = push->base + (uint32_t)i;
        fill_record(words, push->stride, n);
        co_ray_bins_push(push->bins, worker, words, bin_of(n));
    }
}

// Checks the records of a batch and ticks them off.
static inline void tick_off(const CoRayRecords *records, uint8_t *seen, size_t total)
{
    for (size_t i = 0; i < records->count; i++) {
        const uint32_t *words = records->words + i * records->stride;
        uint32_t expected[CO_RAY_WORDS_MAX], n = words[0];
        assert_true(n < total);
        fill_record(expected, records->stride, n);
        assert_memory_equal(words, expected, records->stride * sizeof(uint32_t));
        assert_true(records->bin == CO_RAY_BIN_MIXED || records->bin == bin_of(n));
        assert_int_equal(seen[n], 0);
        seen[n] = 1;
    }
}

static inline void take_all(CoRayBins *bins, uint8_t *seen, size_t total, size_t capacity)
{
    CohortError err = {0};
    CoRayRecords records;
    for (;;) {
        assert_true(co_ray_bins_pop(bins, &records, &err));
        if (records.count == 0)
            break;
        assert_int_equal(records.count, capacity);
        tick_off(&records, seen, total);
        co_ray_bins_recycle(bins, &records);
    }
    for (;;) {
        assert_true(co_ray_bins_drain(bins, &records, &err));
        if (records.count == 0)
            break;
        tick_off(&records, seen, total);
        co_ray_bins_recycle(bins, &records);
    }
    for (size_t i = 0; i < total; i++)
        assert_int_equal(seen[i], 1);
}

static inline void push_serial(CoRayBins *bins, uint32_t first, uint32_t count, uint32_t bin)
{
    uint32_t words[CO_RAY_WORDS_MAX];
    for (uint32_t n = first; n < first + count; n++) {
        fill_record(words, CO_RAY_WORDS, n);
        co_ray_bins_push(bins, 0, words, bin);
    }
}

#define WITH_BUDGET(test, i) cmocka_unit_test_prestate(test, (void *)(uintptr_t)&test_budgets[i])
#define WITH_BUDGETS(test) WITH_BUDGET(test, 0), WITH_BUDGET(test, 1), WITH_BUDGET(test, 2)

#endif
