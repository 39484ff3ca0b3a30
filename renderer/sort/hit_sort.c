#include "sort/hit_sort.h"

#include "base/parallel.h"

#include <stdatomic.h>

#define GRAIN 16384

typedef struct Pack {
    const uint32_t *mesh, *tri; // either may be NULL: not part of the key
    uint32_t *order;
    uint64_t *items; // key above, position in `order` below
    uint32_t index_bits, tri_bits;
    _Atomic uint32_t any_hit, any_mesh, any_tri; // the bits that occur
} Pack;

static void find_bits(void *context, size_t begin, size_t end, uint32_t worker)
{
    Pack *pack = context;
    (void)worker;
    uint32_t meshes = 0, tris = 0, hits = 0;
    for (size_t i = begin; i < end; i++) {
        uint32_t hit = pack->order[i];
        hits |= hit;
        meshes |= pack->mesh[hit];
        tris |= pack->tri[hit];
    }
    atomic_fetch_or_explicit(&pack->any_hit, hits, memory_order_relaxed);
    atomic_fetch_or_explicit(&pack->any_mesh, meshes, memory_order_relaxed);
    atomic_fetch_or_explicit(&pack->any_tri, tris, memory_order_relaxed);
}

static void pack_items(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Pack *pack = context;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        uint64_t hit = pack->order[i], key = 0;
        if (pack->mesh)
            key = (uint64_t)pack->mesh[hit] << pack->tri_bits;
        if (pack->tri)
            key |= pack->tri[hit];
        pack->items[i] = key << pack->index_bits | hit;
    }
}

static void unpack_items(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Pack *pack = context;
    uint64_t mask = ((uint64_t)1 << pack->index_bits) - 1;
    (void)worker;
    for (size_t i = begin; i < end; i++)
        pack->order[i] = (uint32_t)(pack->items[i] & mask);
}

static void sort_by(Pack *pack, size_t count, uint32_t key_bits, uint64_t *items, uint64_t *temp,
                    void *histograms)
{
    pack->items = items;
    co_parallel_for(count, GRAIN, pack_items, pack);
    pack->items = co_radix_sort(items, temp, count, pack->index_bits, key_bits, histograms);
    co_parallel_for(count, GRAIN, unpack_items, pack);
}

bool co_sort_hits(const uint32_t *mesh, const uint32_t *tri, uint32_t *order, size_t count,
                  CoSortScratch *scratch, CohortError *err)
{
    if (count < 2)
        return true;
    size_t item_bytes = (count * sizeof(uint64_t) + 63) & ~(size_t)63;
    char *memory =
        co_sort_scratch_reserve(scratch, 2 * item_bytes + co_radix_histogram_bytes(), err);
    if (!memory)
        return false;
    uint64_t *items = (uint64_t *)(void *)memory;
    uint64_t *temp = (uint64_t *)(void *)(memory + item_bytes);
    void *histograms = memory + 2 * item_bytes;
    Pack pack = {.mesh = mesh, .tri = tri, .order = order};
    co_parallel_for(count, GRAIN, find_bits, &pack);
    uint32_t mesh_bits = co_radix_bits(pack.any_mesh);
    pack.index_bits = co_radix_bits(pack.any_hit);
    pack.tri_bits = co_radix_bits(pack.any_tri);
    if (mesh_bits + pack.tri_bits + pack.index_bits <= 64) {
        sort_by(&pack, count, mesh_bits + pack.tri_bits, items, temp, histograms);
        return true;
    }
    // The key does not fit beside the index: by triangle first, then, stably, by mesh.
    uint32_t tri_bits = pack.tri_bits;
    pack.mesh = NULL;
    sort_by(&pack, count, tri_bits, items, temp, histograms);
    pack.mesh = mesh;
    pack.tri = NULL;
    pack.tri_bits = 0;
    sort_by(&pack, count, mesh_bits, items, temp, histograms);
    return true;
}
