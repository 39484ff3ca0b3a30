#include "texture/block_cache.h"

#include "base/hash.h"
#include "base/memory.h"

typedef struct CoCachedBlock {
    struct CoCachedBlock *chain; // of one table entry
    struct CoCachedBlock *newer, *older;
    uint64_t block; // file and block
    uint64_t axes;  // halvings: their number and axes
    size_t size;    // of the allocation
    _Alignas(64) unsigned char texels[];
} CoCachedBlock;

static CoCachedBlock **entry_of(const CoBlockCache *cache, uint64_t block, uint64_t axes)
{
    return &cache->table[co_hash_combine(block, axes) & (cache->table_size - 1)];
}

static void unlink_age(CoBlockCache *cache, CoCachedBlock *block)
{
    *(block->newer ? &block->newer->older : &cache->newest) = block->older;
    *(block->older ? &block->older->newer : &cache->oldest) = block->newer;
}

static void make_newest(CoBlockCache *cache, CoCachedBlock *block)
{
    block->newer = NULL;
    block->older = cache->newest;
    *(cache->newest ? &cache->newest->newer : &cache->oldest) = block;
    cache->newest = block;
}

static void drop_oldest(CoBlockCache *cache)
{
    CoCachedBlock *block = cache->oldest;
    CoCachedBlock **at = entry_of(cache, block->block, block->axes);
    while (*at != block)
        at = &(*at)->chain;
    *at = block->chain;
    unlink_age(cache, block);
    cache->bytes -= block->size;
    cache->count--;
    co_free(CO_MEMORY_TEXTURE, block, block->size);
}

static bool grow(CoBlockCache *cache)
{
    size_t size = cache->table_size ? 2 * cache->table_size : 256;
    CoCachedBlock **table = co_alloc_zero(CO_MEMORY_TEXTURE, size * sizeof *table);
    if (!table)
        return false;
    co_free(CO_MEMORY_TEXTURE, cache->table, cache->table_size * sizeof *table);
    cache->table = table;
    cache->table_size = size;
    for (CoCachedBlock *block = cache->newest; block; block = block->older) {
        CoCachedBlock **at = entry_of(cache, block->block, block->axes);
        block->chain = *at;
        *at = block;
    }
    return true;
}

const void *co_block_cache_get(CoBlockCache *cache, CoReader *reader, const CoTextureFile *file,
                               const CoRequest *request, bool *is_damaged)
{
    uint64_t block = (uint64_t)request->file << 32 | request->block;
    uint64_t axes = (uint64_t)request->steps << 32 | request->axes;
    *is_damaged = false;
    if (cache->count >= cache->table_size && !grow(cache))
        return NULL;
    for (CoCachedBlock *found = *entry_of(cache, block, axes); found; found = found->chain) {
        if (found->block == block && found->axes == axes) {
            unlink_age(cache, found);
            make_newest(cache, found);
            return found->texels;
        }
    }
    size_t size = sizeof(CoCachedBlock) + co_reader_block_size(file, request);
    while (cache->count > 0 && cache->bytes + size > cache->limit)
        drop_oldest(cache);
    CoCachedBlock *added = co_alloc(CO_MEMORY_TEXTURE, size);
    if (!added)
        return NULL;
    if (!co_reader_decode(reader, file, request, added->texels)) {
        *is_damaged = !co_reader_is_short(reader, file);
        co_free(CO_MEMORY_TEXTURE, added, size);
        return NULL;
    }
    if (request->steps) {
        CoPtexSource source = {.ulog2 = request->ulog2,
                               .vlog2 = request->vlog2,
                               .steps = request->steps,
                               .axes = request->axes};
        co_ptex_halve_all(file->ptex, &source, added->texels);
    }
    added->block = block;
    added->axes = axes;
    added->size = size;
    CoCachedBlock **at = entry_of(cache, block, axes);
    added->chain = *at;
    *at = added;
    make_newest(cache, added);
    cache->bytes += size;
    cache->count++;
    return added->texels;
}

void co_block_cache_clear(CoBlockCache *cache)
{
    while (cache->count > 0)
        drop_oldest(cache);
    co_free(CO_MEMORY_TEXTURE, cache->table, cache->table_size * sizeof *cache->table);
    *cache = (CoBlockCache){.limit = cache->limit};
}
