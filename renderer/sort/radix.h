// A stable, parallel radix sort of 64-bit items, and the scratch memory that sorts share.

#ifndef CO_SORT_RADIX_H
#define CO_SORT_RADIX_H

#include "cohort/base.h"

// Grows and is kept, so that sorting in the steady state allocates nothing. {0} is valid.
typedef struct CoSortScratch {
    void *data; // 64-byte aligned
    size_t bytes;
} CoSortScratch;

// At least `bytes` bytes, contents undefined; NULL with *err set on failure.
void *co_sort_scratch_reserve(CoSortScratch *scratch, size_t bytes, CohortError *err);
void co_sort_scratch_clear(CoSortScratch *scratch);

// Bytes that co_radix_sort wants for histograms, whatever the count. A multiple of 64.
size_t co_radix_histogram_bytes(void);

// Sorts by bits [first_bit, first_bit + bits) of the items, from the lowest digit up; bits that no
// two items differ in cost a look, not a pass. Stable, so the result is the same for any number of
// threads. items and temp hold `count` each; returns the one of them that has the result.
uint64_t *co_radix_sort(uint64_t *items, uint64_t *temp, size_t count, uint32_t first_bit,
                        uint32_t bits, void *histograms);

// Bits needed to tell apart 0 .. largest; 0 for 0.
static inline uint32_t co_radix_bits(uint32_t largest)
{
    return largest ? 32u - (uint32_t)__builtin_clz(largest) : 0u;
}

#endif
