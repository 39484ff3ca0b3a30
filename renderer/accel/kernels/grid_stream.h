// Leaves of subdivided meshes for rays of a group: a block's points are gathered once for all that
// enter it. Part of traverse.c.

#ifndef CO_ACCEL_KERNELS_GRID_STREAM_H
#define CO_ACCEL_KERNELS_GRID_STREAM_H

// What became of the blocks of a tile: who enters each, and where the first of them does.
typedef struct TileEntries {
    uint64_t active[CO_TILE_BLOCKS];
    float first[CO_TILE_BLOCKS];
    float entry[CO_GROUP_RAYS][CO_TILE_BLOCKS];
    uint32_t bits;
} TileEntries;

static inline void enter_tile(const StreamAsk *ask, uint64_t active, const CoGridLeaf *tile,
                              uint32_t side, TileEntries *out)
{
    out->bits = 0;
    for (; active; active &= active - 1) {
        uint32_t j = (uint32_t)__builtin_ctzll(active);
        float *entry = out->entry[j];
        Ray ray;
        take_single(ask->rays, j, ask->slabs, ask->walk, &ray);
        ask->group->stats->bottom_nodes++;
        for (uint32_t bits = slab_tile(tile, 1u << 2 * side, &ray, entry); bits; bits &= bits - 1) {
            uint32_t i = (uint32_t)__builtin_ctz(bits);
            bool is_new = !(out->bits >> i & 1u);
            out->first[i] = is_new ? entry[i] : float_min(entry[i], out->first[i]);
            out->active[i] = (is_new ? 0 : out->active[i]) | 1ull << j;
            out->bits |= 1u << i;
        }
    }
}

// Rays that enter block i of a tile and do not end before.
static inline uint64_t still_enter(const StreamAsk *ask, const TileEntries *entries, uint32_t i)
{
    uint64_t active = entries->active[i] & ~ask->rays->done;
    for (uint64_t left = active; left; left &= left - 1) {
        uint32_t j = (uint32_t)__builtin_ctzll(left);
        active &= ~((uint64_t) !(entries->entry[j][i] <= ask->rays->to[j]) << j);
    }
    return active;
}

static inline void stream_tile(const StreamAsk *ask, uint64_t active, uint32_t ref)
{
    const CoBvh *bvh = ask->walk->bvh;
    const CoGridLeaf *tile = open_tile(bvh, ref);
    const uint32_t side = tile->side;
    TileEntries entries;
    GridBlock block;
    if (side == 0) {
        const CoTriLeaf leaf = open_tile_block(bvh, tile, side, 0, &block);
        stream_triangles(ask, active, &leaf, CO_GRID_TRIS, block.valid);
        return;
    }
    enter_tile(ask, active, tile, side, &entries);
    for (uint32_t bits = entries.bits; bits;) {
        uint32_t nearest = nearest_block(bits, entries.first);
        bits &= ~(1u << nearest);
        active = still_enter(ask, &entries, nearest);
        if (!active)
            continue;
        const CoTriLeaf leaf = open_tile_block(bvh, tile, side, nearest, &block);
        stream_triangles(ask, active, &leaf, CO_GRID_TRIS, block.valid);
    }
}

static void stream_grid_leaf(const StreamAsk *ask, uint64_t active, uint32_t ref)
{
    const CoBvh *bvh = ask->walk->bvh;
    GridBlock block;
    if ((active & (active - 1)) == 0) {
        uint32_t j = (uint32_t)__builtin_ctzll(active);
        Ray ray;
        take_single(ask->rays, j, ask->slabs, ask->walk, &ray);
        trace_grid_leaf(ask->group, &ray, bvh, ref, ask->walk->path);
        rays_settle(ask->rays, j, ray.to);
    } else if (bvh->patches->level > 1) {
        stream_tile(ask, active, ref);
    } else {
        const CoTriLeaf leaf = open_block(bvh, ref, &block);
        stream_triangles(ask, active, &leaf, CO_GRID_TRIS, block.valid);
    }
}

#endif
