// Leaves of subdivided meshes for rays of a group: a block's points are gathered once for all that
// enter it. Part of traverse.c.

#ifndef CO_ACCEL_KERNELS_GRID_STREAM_H
#define CO_ACCEL_KERNELS_GRID_STREAM_H

enum {
    TILE_NODES = CO_TILE_BLOCKS / CO_NODE_WIDTH
};

// The blocks of a tile as nodes. Returns how many these are.
static inline uint32_t unpack_tile(const CoGridLeaf *tile, uint32_t blocks,
                                   CoWideNode nodes[TILE_NODES])
{
    const uint8_t *planes = co_grid_planes(tile);
    for (uint32_t row = 0; row < 6; row++) {
        CoLane origin = co_lane_set1(tile->origin[row / 2]);
        CoLane step = co_lane_set1(co_grid_step(tile->exponent[row / 2]));
        for (uint32_t i = 0; i < blocks; i += CO_LANE_WIDTH) {
            CoLane bytes = co_lane_load_bytes(planes + row * blocks + i);
            co_lane_store(nodes[i / CO_NODE_WIDTH].planes[row] + i % CO_NODE_WIDTH,
                          co_lane_add(origin, co_lane_mul(bytes, step)));
        }
        for (uint32_t i = blocks; i < CO_NODE_WIDTH; i++)
            nodes[0].planes[row][i] = row & 1u ? -INFINITE : INFINITE;
    }
    return (blocks + CO_NODE_WIDTH - 1) / CO_NODE_WIDTH;
}

// Who enters the blocks, and in `first` where at the earliest. Returns one bit per block.
static inline uint32_t enter_tile(const StreamAsk *ask, uint64_t active, const CoWideNode *nodes,
                                  uint32_t count, StreamNode found[TILE_NODES],
                                  float first[CO_TILE_BLOCKS])
{
    bool is_many = __builtin_popcountll(active) > NARROW_MOST && ask->beam->is_safe;
    uint32_t bits = 0;
    for (uint32_t n = 0; n < count; n++) {
        if (is_many)
            beam_node(&nodes[n], ask->beam, ask->slabs, active, &found[n]);
        else
            stream_node(&nodes[n], ask->rays, ask->slabs, active, &found[n]);
        bits |= found[n].bits << n * CO_NODE_WIDTH;
        for (uint32_t i = 0; i < CO_NODE_WIDTH; i++) {
            uint32_t entry = (uint32_t)found[n].order[i] << 16;
            __builtin_memcpy(&first[n * CO_NODE_WIDTH + i], &entry, sizeof entry);
        }
    }
    ask->group->stats->bottom_nodes += (uint64_t)__builtin_popcountll(active);
    return bits;
}

static inline void stream_tile(const StreamAsk *ask, uint64_t active, uint32_t ref)
{
    const CoBvh *bvh = ask->walk->bvh;
    const CoGridLeaf *tile = open_tile(bvh, ref);
    CoWideNode nodes[TILE_NODES];
    StreamNode found[TILE_NODES];
    float first[CO_TILE_BLOCKS];
    GridBlock block;
    if (co_grid_blocks(tile) == 1) {
        const CoTriLeaf leaf = open_tile_block(bvh, tile, 0, &block);
        stream_triangles(ask, active, &leaf, leaf.count, block.valid, false);
        return;
    }
    uint32_t count = unpack_tile(tile, co_grid_blocks(tile), nodes);
    for (uint32_t bits = enter_tile(ask, active, nodes, count, found, first); bits;) {
        uint32_t nearest = nearest_block(bits, first);
        uint32_t n = nearest / CO_NODE_WIDTH, place = nearest % CO_NODE_WIDTH;
        bits &= ~(1u << nearest);
        active = found[n].active[place] & ~ask->rays->done;
        active = stream_child(&nodes[n], place, ask->rays, ask->slabs, active);
        if (!active)
            continue;
        const CoTriLeaf leaf = open_tile_block(bvh, tile, nearest, &block);
        stream_triangles(ask, active, &leaf, leaf.count, block.valid, false);
    }
}

static inline void stream_list(const StreamAsk *ask, uint64_t active, uint32_t ref)
{
    const CoBvh *bvh = ask->walk->bvh;
    uint32_t patches[CO_LIST_PATCHES], count = open_list(bvh, ref, patches);
    const uint32_t step = co_grid_list_step(bvh->patches);
    GridBlock block;
    for (uint32_t k = 0; k < count; k += step) {
        const CoTriLeaf leaf = open_patches(bvh, patches + k, count - k, &block);
        stream_triangles(ask, active & ~ask->rays->done, &leaf, leaf.count, block.valid, false);
    }
}

static void stream_grid_leaf(const StreamAsk *ask, uint64_t active, uint32_t ref)
{
    const CoBvh *bvh = ask->walk->bvh;
    GridBlock block;
    if ((active & (active - 1)) == 0) {
        uint32_t j = (uint32_t)__builtin_ctzll(active);
        Ray ray;
        Shear shear;
        take_single(ask->rays, j, ask->slabs, ask->walk, &ray);
        shear_load(&ray, &shear);
        trace_grid_leaf(ask->group, &ray, &shear, bvh, ref, ask->walk->path);
        rays_settle(ask->rays, j, ray.to);
    } else if (bvh->grid == CO_GRID_TILE) {
        stream_tile(ask, active, ref);
    } else if (bvh->grid == CO_GRID_LIST) {
        stream_list(ask, active, ref);
    } else {
        const CoTriLeaf leaf = bvh->grid == CO_GRID_NUMBERED ? open_numbered(bvh, ref, &block)
                                                             : open_block(bvh, ref, &block);
        stream_triangles(ask, active, &leaf, leaf.count, block.valid, false);
    }
}

#endif
