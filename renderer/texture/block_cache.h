// A cache of decoded blocks, as an ordinary renderer has one; one per thread. What the unsorted
// mode uses, so that both modes can be compared; the sorted mode has none.

#ifndef CO_TEXTURE_BLOCK_CACHE_H
#define CO_TEXTURE_BLOCK_CACHE_H

#include "texture/reader.h"

// {0} is an empty cache that holds nothing until it has a limit.
typedef struct CoBlockCache {
    struct CoCachedBlock **table; // by hash of (file, block, halvings)
    size_t table_size;            // a power of two
    struct CoCachedBlock *newest, *oldest;
    size_t count, bytes, limit;
} CoBlockCache;

// The texels a request needs, all its halvings made: from the cache or decoded into it, least
// recently used blocks making room. Valid until the next call. NULL when the block is damaged
// (*is_damaged) or memory is short.
const void *co_block_cache_get(CoBlockCache *cache, CoReader *reader, const CoTextureFile *file,
                               const CoRequest *request, bool *is_damaged);

void co_block_cache_clear(CoBlockCache *cache); // keeps the limit

#endif
