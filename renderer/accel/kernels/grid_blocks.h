// Leaves of subdivided meshes (grid_leaf.h): blocks are gathered from the mesh's points, then
// tested like any other leaf. Part of traverse.c.

#ifndef CO_ACCEL_KERNELS_GRID_BLOCKS_H
#define CO_ACCEL_KERNELS_GRID_BLOCKS_H

#include "accel/grid_leaf.h"
#include "accel/kernels/triangle.h"

#include <stddef.h>
#include <string.h>

// 8 triangles over points that are gathered. From `first` on it stands as in a leaf, each triangle
// a run of its own.
typedef struct GridBlock {
    uint32_t index[CO_LEAF_WIDTH]; // of the points in the mesh
    uint8_t corner[20];            // see CoTriLeaf; the last 8 are not looked at
    uint32_t first;                // number of the first triangle
    float points[3][CO_LEAF_WIDTH];
    uint16_t starts, unused;
    uint32_t skipped[CO_GRID_TRIS - 1];
    uint32_t valid; // one bit per triangle that is one
} GridBlock;
_Static_assert(offsetof(GridBlock, points) == offsetof(GridBlock, first) + 4 &&
                   offsetof(GridBlock, starts) == offsetof(GridBlock, first) + 4 + 192,
               "as co_leaf_tri finds them");

// Triangle k is tri[k & 3], in the second half row on.
static inline void number_block(GridBlock *block, const uint32_t tri[4], uint32_t row)
{
    block->first = tri[0];
    block->starts = 0xffu;
    for (uint32_t k = 1; k < CO_GRID_TRIS; k++)
        block->skipped[k - 1] = tri[k & 3u] + (k >> 2) * row - tri[0] - k;
}

static inline CoTriLeaf gather_block(GridBlock *block, const float *mesh_points)
{
    for (uint32_t i = 0; i < CO_LEAF_WIDTH; i += CO_LANE_WIDTH) {
        CoLane p[3];
        co_lane_load_points(mesh_points, block->index + i, p);
        for (int k = 0; k < 3; k++)
            co_lane_store(block->points[k] + i, p[k]);
    }
    return (CoTriLeaf){CO_GRID_TRIS,
                       CO_LEAF_WIDTH,
                       CO_GRID_TRIS / 2,
                       block->corner,
                       {block->points[0], block->points[1], block->points[2]}};
}

// Offers what the ray pierces of the block's triangles.
static inline bool trace_block(Group *group, Ray *ray, const CoTriLeaf *leaf, uint32_t valid,
                               uint32_t path)
{
    LeafHits hits;
    Shear shear;
    shear_load(ray, &shear);
    group->stats->triangles += (uint64_t)__builtin_popcount(valid);
    shear_points(leaf, &shear, &hits);
    uint32_t pierced = pierce_triangles(leaf, CO_GRID_TRIS, &hits) & valid;
    return pierced && offer_pierced(group, ray, leaf, &shear, pierced, path, &hits);
}

// Points of the 3 x 3 around square (i, j) of a patch with m squares a side, m >= 2: all as if they
// were inside, then those on edges and corners put right.
static inline void block_indices(const uint32_t *words, uint32_t m, uint32_t i, uint32_t j,
                                 uint32_t out[9])
{
    uint32_t inner = (words[CO_PATCH_INNER] & ~CO_PATCH_FLAG) + (j - 1) * (m - 1) + i - 1;
    for (uint32_t r = 0; r < 3; r++)
        for (uint32_t c = 0; c < 3; c++)
            out[3 * r + c] = inner + r * (m - 1) + c;
    bool is_left = i == 0, is_right = i + 2 == m, is_low = j == 0, is_high = j + 2 == m;
    for (uint32_t k = 0; k < 3; k++) {
        if (is_low)
            out[k] = co_patch_edge_point(words, 0, i + k);
        if (is_high)
            out[6 + k] = co_patch_edge_point(words, 2, i + k);
    }
    for (uint32_t k = 0; k < 3; k++) {
        if (is_left)
            out[3 * k] = co_patch_edge_point(words, 3, j + k);
        if (is_right)
            out[3 * k + 2] = co_patch_edge_point(words, 1, j + k);
    }
    if (is_low && is_left)
        out[0] = words[0];
    if (is_low && is_right)
        out[2] = words[1];
    if (is_high && is_right)
        out[8] = words[2];
    if (is_high && is_left)
        out[6] = words[3];
}

// The same of any table. Beyond the diagonal of a triangular patch are points too, of triangles
// that are not valid.
static inline void any_block_indices(const CoPatchTable *table, const uint32_t *words, uint32_t m,
                                     uint32_t i, uint32_t j, uint32_t out[9])
{
    bool is_inside = j > 0 && i + 2 < m && (table->is_triangular ? i > j + 2 : i > 0 && j + 2 < m);
    for (uint32_t r = 0; r < 3; r++) {
        uint32_t row = is_inside ? co_patch_inner_row(table, words, m, j + r) : 0;
        for (uint32_t c = 0; c < 3; c++) {
            uint32_t a = i + c, b = j + r;
            if (is_inside) {
                out[3 * r + c] = row + a;
                continue;
            }
            b = table->is_triangular && b > a ? a : b;
            co_patch_settle(table, words, m, &a, &b);
            out[3 * r + c] = co_patch_point(table, words, m, a, b);
        }
    }
}

// Numbers and validity of the block's triangles, in a triangular patch: second triangles of squares
// precede their first.
static inline void number_triangular(GridBlock *block, uint32_t first, uint32_t m,
                                     const uint32_t at[2])
{
    uint32_t at_first = first + co_patch_row(m, at[1]) + 2 * (at[0] - at[1]);
    const uint32_t tri[4] = {at_first, at_first - 1, at_first + 2, at_first + 1};
    number_block(block, tri, 2 * (m - at[1]) - 3);
    block->valid = at[0] < at[1] ? 0 : at[0] > at[1] ? 0xffu : m > 1 ? 0x4du : 0x01u;
}

// The 2 x 2 squares from (i, j) on of a patch; of a patch that is one square, that.
static inline CoTriLeaf open_squares(const CoBvh *bvh, uint32_t patch, const uint32_t at[2],
                                     GridBlock *block)
{
    const CoPatchTable *table = bvh->patches;
    const uint32_t *words = co_patch_words(table, patch), first = words[0];
    uint32_t shift = co_patch_shift(table, words), first_tri = co_patch_first_tri(table, patch);
    uint32_t at_first = first_tri + (at[1] << (shift + 1)) + 2 * at[0];
    const uint32_t tri[4] = {at_first, at_first + 1, at_first + 2, at_first + 3};
    for (uint32_t k = 0; k < CO_LEAF_WIDTH; k++)
        block->index[k] = first;
    if (shift && (table->is_triangular || table->is_mixed)) {
        any_block_indices(table, words, 1u << shift, at[0], at[1], block->index);
    } else if (shift) {
        block_indices(words, 1u << shift, at[0], at[1], block->index);
    } else {
        block->index[1] = words[1];
        block->index[3] = words[table->is_triangular ? 0 : 3];
        block->index[4] = words[2];
    }
    const uint8_t corner[20] = {0x00, 0x11, 0x33, 0x44, 0x41, 0x52,
                                0x74, 0x85, 0x34, 0x45, 0x67, 0x78};
    memcpy(block->corner, corner, sizeof corner);
    block->valid = shift ? 0xffu : 0x03u;
    if (table->is_triangular)
        number_triangular(block, first_tri, 1u << shift, at);
    else
        number_block(block, tri, 2u << shift);
    return gather_block(block, bvh->points);
}

// Patches of level 0: corner 0 of all, then 1 and 2, then 2 and 3; lanes are the first triangles of
// all, 0 1 2, then the second, 0 2 3.
static inline CoTriLeaf open_list(const CoBvh *bvh, uint32_t ref, GridBlock *block)
{
    const void *at = bvh->leaves + (size_t)(ref & CO_REF_LEAF_PLACE) * CO_LEAF_UNIT;
    const uint32_t *list = at;
    uint32_t tri[CO_LIST_PATCHES];
    const uint8_t corner[20] = {0x10, 0x32, 0x10, 0x32, 0x54, 0x76,
                                0x98, 0xba, 0x98, 0xba, 0xdc, 0xfe};
    memcpy(block->corner, corner, sizeof corner);
    block->valid = 0;
    for (uint32_t q = 0; q < CO_LIST_PATCHES; q++) {
        const uint32_t *words = co_patch_words(bvh->patches, list[q]);
        bool is_fan = co_patch_is_fan(bvh->patches, words);
        uint32_t *index = block->index + q;
        index[0] = words[0];
        index[4] = words[1];
        index[8] = words[2];
        index[12] = words[is_fan ? 0 : 3];
        tri[q] = co_patch_first_tri(bvh->patches, list[q]);
        bool is_there = q == 0 || list[q] != list[0];
        block->valid |= ((uint32_t)is_there | (uint32_t)(is_there && !is_fan) << 4) << q;
    }
    number_block(block, tri, 1);
    return gather_block(block, bvh->points);
}

// One bit per block that the ray enters, as slab_node has it.
static inline uint32_t slab_tile(const CoGridLeaf *leaf, uint32_t blocks, const Ray *ray,
                                 float entry[CO_TILE_BLOCKS])
{
    const uint8_t *planes = (const uint8_t *)(leaf + 1);
    uint32_t bits = 0;
    for (uint32_t i = 0; i < blocks; i += CO_LANE_WIDTH) {
        CoLane near = co_lane_set1(ray->from), far = co_lane_set1(ray->to);
        for (uint32_t k = 0; k < 3; k++) {
            const uint8_t *near_bytes = planes + ray->near_row[k] * blocks + i;
            const uint8_t *far_bytes = planes + (ray->near_row[k] ^ 1u) * blocks + i;
            CoLane origin = co_lane_set1(leaf->origin[k]), inv = co_lane_set1(ray->inv[k]);
            CoLane step = co_lane_set1(co_grid_step(leaf->exponent[k]));
            CoLane near_plane =
                co_lane_add(origin, co_lane_mul(co_lane_load_bytes(near_bytes), step));
            CoLane far_plane =
                co_lane_add(origin, co_lane_mul(co_lane_load_bytes(far_bytes), step));
            near_plane = co_lane_muladd(near_plane, inv, co_lane_set1(ray->near_c[k]));
            far_plane = co_lane_muladd(far_plane, inv, co_lane_set1(ray->far_c[k]));
            near = co_lane_max(near_plane, near);
            far = co_lane_min(far_plane, far);
        }
        co_lane_store(entry + i, near);
        bits |= co_lane_bits(co_lane_le(near, far)) << i;
    }
    return bits & ((1u << blocks) - 1u);
}

static inline const CoGridLeaf *open_tile(const CoBvh *bvh, uint32_t ref)
{
    return (const void *)(bvh->leaves + (size_t)(ref & CO_REF_LEAF_PLACE) * CO_LEAF_UNIT);
}

// Block `place` of a tile.
static inline CoTriLeaf open_tile_block(const CoBvh *bvh, const CoGridLeaf *tile, uint32_t side,
                                        uint32_t place, GridBlock *block)
{
    const uint32_t at[2] = {tile->i + 2 * (place & ((1u << side) - 1u)),
                            tile->j + 2 * (place >> side)};
    return open_squares(bvh, tile->patch, at, block);
}

static inline uint32_t nearest_block(uint32_t bits, const float entry[CO_TILE_BLOCKS])
{
    uint32_t nearest = (uint32_t)__builtin_ctz(bits);
    for (uint32_t left = bits & (bits - 1); left; left &= left - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(left);
        nearest = entry[i] < entry[nearest] ? i : nearest;
    }
    return nearest;
}

static inline bool trace_tile(Group *group, Ray *ray, const CoBvh *bvh, uint32_t ref, uint32_t path)
{
    const CoGridLeaf *tile = open_tile(bvh, ref);
    float entry[CO_TILE_BLOCKS];
    GridBlock block;
    uint32_t side = tile->side;
    uint32_t bits = 1;
    entry[0] = ray->from;
    if (side) {
        bits = slab_tile(tile, 1u << 2 * side, ray, entry);
        group->stats->bottom_nodes++;
    }
    while (bits) {
        uint32_t nearest = nearest_block(bits, entry);
        bits &= ~(1u << nearest);
        if (!(entry[nearest] <= ray->to))
            return false;
        const CoTriLeaf leaf = open_tile_block(bvh, tile, side, nearest, &block);
        if (trace_block(group, ray, &leaf, block.valid, path))
            return true;
    }
    return false;
}

// A leaf that is one block.
static inline CoTriLeaf open_block(const CoBvh *bvh, uint32_t ref, GridBlock *block)
{
    const uint32_t origin[2] = {0, 0};
    if (bvh->patches->level == 1)
        return open_squares(bvh, ref & CO_REF_LEAF_PLACE, origin, block);
    return open_list(bvh, ref, block);
}

// Returns true when the ray needs no more.
static __attribute__((noinline)) bool trace_grid_leaf(Group *group, Ray *ray, const CoBvh *bvh,
                                                      uint32_t ref, uint32_t path)
{
    GridBlock block;
    if (bvh->patches->level > 1)
        return trace_tile(group, ray, bvh, ref, path);
    const CoTriLeaf leaf = open_block(bvh, ref, &block);
    return trace_block(group, ray, &leaf, block.valid, path);
}

#endif
