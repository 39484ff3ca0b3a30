// Inflating zlib streams: the one place where texel blocks are decompressed, and so counted.
//
// Source: Eisenacher et al. 2013, 3.2: "each mesh face is touched at most once when shading a ray
// batch". The counter here is what proves that for (file, block): it sits below every schedule.

#ifndef CO_TEXTURE_INFLATE_H
#define CO_TEXTURE_INFLATE_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// What was decompressed in one batch. Threads: any may add.
typedef struct CoBlockCount {
    uint32_t batch;             // number of the batch, never 0
    atomic_uint_fast64_t read;  // blocks decompressed
    atomic_uint_fast64_t twice; // of these, blocks already decompressed in this batch
    atomic_uint_fast64_t bytes; // compressed bytes that were read
} CoBlockCount;

// A block's mark: the number of the last batch that decompressed it.
typedef atomic_uint_least32_t CoBlockStamp;

// Counts one block of `bytes` compressed bytes.
void co_block_counted(CoBlockCount *count, CoBlockStamp *stamp, size_t bytes);

// One thread's decompressor. {0} is valid; the first use creates it.
typedef struct CoInflate {
    void *state;
} CoInflate;

void co_inflate_clear(CoInflate *inflate);

// True when `packed` bytes of deflate can hold `size` bytes (the format's limit is 1032 : 1). Check
// before allocating what a file asks for.
bool co_inflate_is_possible(size_t packed, uint64_t size);

// Inflates one zlib stream to exactly `size` bytes; shorter, longer or broken streams fail. `count`
// and `stamp` are NULL for headers, which are no texel blocks. Threads: one per CoInflate.
bool co_inflate(CoInflate *inflate, const void *packed, size_t packed_size, void *out, size_t size,
                CoBlockCount *count, CoBlockStamp *stamp);

#endif
