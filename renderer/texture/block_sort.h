// Sorting a batch's requests into the order in which their blocks lie on disk.

#ifndef CO_TEXTURE_BLOCK_SORT_H
#define CO_TEXTURE_BLOCK_SORT_H

#include "texture/request.h"

typedef struct CoBlockEntry {
    uint64_t key; // co_request_key
    CoRequest *request;
} CoBlockEntry;

// Sorts `count` entries by key with a parallel radix sort; `spare` is as large. Returns the one of
// the two that holds the result. NULL without memory for the histograms.
CoBlockEntry *co_block_sort(CoBlockEntry *entries, CoBlockEntry *spare, size_t count);

#endif
