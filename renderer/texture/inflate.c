#include "texture/inflate.h"

#include <libdeflate.h>

void co_block_counted(CoBlockCount *count, CoBlockStamp *stamp, size_t bytes)
{
    atomic_fetch_add_explicit(&count->read, 1, memory_order_relaxed);
    atomic_fetch_add_explicit(&count->bytes, bytes, memory_order_relaxed);
    if (atomic_exchange_explicit(stamp, count->batch, memory_order_relaxed) == count->batch)
        atomic_fetch_add_explicit(&count->twice, 1, memory_order_relaxed);
}

void co_inflate_clear(CoInflate *inflate)
{
    libdeflate_free_decompressor(inflate->state);
    inflate->state = NULL;
}

bool co_inflate_is_possible(size_t packed, uint64_t size)
{
    return size <= (uint64_t)packed * 1032;
}

bool co_inflate(CoInflate *inflate, const void *packed, size_t packed_size, void *out, size_t size,
                CoBlockCount *count, CoBlockStamp *stamp)
{
    if (!inflate->state)
        inflate->state = libdeflate_alloc_decompressor();
    if (!inflate->state)
        return false;
    if (count)
        co_block_counted(count, stamp, packed_size);
    // Without a place for the real size, libdeflate accepts nothing but exactly `size` bytes.
    return libdeflate_zlib_decompress(inflate->state, packed, packed_size, out, size, NULL) ==
           LIBDEFLATE_SUCCESS;
}
