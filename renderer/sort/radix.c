// After Satish, Harris, Garland 2009: a histogram per block, one scan over (digit, block), and a
// scatter in which each block keeps its order.
#include "sort/radix.h"

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"

#include <stdatomic.h>
#include <string.h>

#define DIGIT_BITS_MAX 10u
#define DIGITS_MAX (1u << DIGIT_BITS_MAX)
#define BLOCKS_MAX 128u
#define BLOCK_MIN 16384u

void *co_sort_scratch_reserve(CoSortScratch *scratch, size_t bytes, CohortError *err)
{
    if (bytes <= scratch->bytes)
        return scratch->data;
    co_sort_scratch_clear(scratch);
    scratch->data = co_alloc(CO_MEMORY_RAYS, bytes);
    CO_CHECK_NULL(scratch->data, err, COHORT_ERROR_OUT_OF_MEMORY,
                  "out of memory: sorting wants %zu bytes", bytes);
    scratch->bytes = bytes;
    return scratch->data;
}

void co_sort_scratch_clear(CoSortScratch *scratch)
{
    co_free(CO_MEMORY_RAYS, scratch->data, scratch->bytes);
    *scratch = (CoSortScratch){NULL, 0};
}

size_t co_radix_histogram_bytes(void)
{
    return (size_t)BLOCKS_MAX * DIGITS_MAX * sizeof(uint32_t);
}

typedef struct Pass {
    const uint64_t *from;
    uint64_t *to;
    size_t count, block_size;
    uint32_t shift, digits;
    uint32_t *histograms; // [block][digit]; after the scan: where the block's next one goes
} Pass;

static void count_block(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Pass *pass = context;
    (void)worker;
    for (size_t block = begin; block < end; block++) {
        uint32_t *histogram = pass->histograms + block * pass->digits;
        memset(histogram, 0, pass->digits * sizeof *histogram);
        size_t first = block * pass->block_size, left = pass->count - first;
        size_t n = left < pass->block_size ? left : pass->block_size;
        for (size_t i = first; i < first + n; i++)
            histogram[(pass->from[i] >> pass->shift) & (pass->digits - 1)]++;
    }
}

static void scatter_block(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Pass *pass = context;
    (void)worker;
    for (size_t block = begin; block < end; block++) {
        uint32_t *next = pass->histograms + block * pass->digits;
        size_t first = block * pass->block_size, left = pass->count - first;
        size_t n = left < pass->block_size ? left : pass->block_size;
        for (size_t i = first; i < first + n; i++) {
            uint64_t item = pass->from[i];
            pass->to[next[(item >> pass->shift) & (pass->digits - 1)]++] = item;
        }
    }
}

static void scan(const Pass *pass, size_t blocks)
{
    uint32_t sum = 0;
    for (uint32_t digit = 0; digit < pass->digits; digit++)
        for (size_t block = 0; block < blocks; block++) {
            uint32_t *slot = &pass->histograms[block * pass->digits + digit];
            uint32_t n = *slot;
            *slot = sum;
            sum += n;
        }
}

typedef struct Differences {
    const uint64_t *items;
    _Atomic uint64_t any; // bits in which an item differs from the first
} Differences;

static void find_differences(void *context, size_t begin, size_t end, uint32_t worker)
{
    Differences *d = context;
    uint64_t any = 0;
    (void)worker;
    for (size_t i = begin; i < end; i++)
        any |= d->items[i] ^ d->items[0];
    atomic_fetch_or_explicit(&d->any, any, memory_order_relaxed);
}

uint64_t *co_radix_sort(uint64_t *items, uint64_t *temp, size_t count, uint32_t first_bit,
                        uint32_t bits, void *histograms)
{
    if (count < 2 || bits == 0)
        return items;
    uint32_t workers = co_worker_count();
    Differences differences = {items, 0};
    co_parallel_for(count, BLOCK_MIN, find_differences, &differences);
    uint64_t differs = atomic_load(&differences.any);

    size_t blocks = (count + BLOCK_MIN - 1) / BLOCK_MIN;
    size_t most = workers == 1 ? 1 : workers * 2 < BLOCKS_MAX ? workers * 2 : BLOCKS_MAX;
    if (blocks > most)
        blocks = most;
    Pass pass = {.count = count, .histograms = histograms};
    pass.block_size = (count + blocks - 1) / blocks;
    blocks = (count + pass.block_size - 1) / pass.block_size;
    uint32_t passes = (bits + DIGIT_BITS_MAX - 1) / DIGIT_BITS_MAX;
    uint32_t digit_bits = (bits + passes - 1) / passes;
    for (uint32_t done = 0; done < bits; done += digit_bits) {
        uint32_t width = bits - done < digit_bits ? bits - done : digit_bits;
        pass.shift = first_bit + done;
        pass.digits = 1u << width;
        if (((differs >> pass.shift) & (pass.digits - 1)) == 0)
            continue;
        pass.from = items;
        pass.to = temp;
        co_parallel_for(blocks, 1, count_block, &pass);
        scan(&pass, blocks);
        co_parallel_for(blocks, 1, scatter_block, &pass);
        temp = items;
        items = pass.to;
    }
    return items;
}
