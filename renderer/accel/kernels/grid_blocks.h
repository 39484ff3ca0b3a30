// Leaves of subdivided meshes (grid_leaf.h): blocks are gathered from the mesh's points, then
// tested like any other leaf. Part of traverse.c.

#ifndef CO_ACCEL_KERNELS_GRID_BLOCKS_H
#define CO_ACCEL_KERNELS_GRID_BLOCKS_H

#include "accel/grid_leaf.h"
#include "accel/kernels/triangle.h"

#include <stddef.h>
#include <string.h>

// Up to 16 triangles over points that are gathered. From `first` on it stands as in a leaf.
typedef struct GridBlock {
    uint32_t index[CO_LEAF_WIDTH]; // of the points in the mesh
    uint8_t corner[3 * 8 + 8];     // see CoTriLeaf; the last 8 are not looked at
    uint32_t first;                // number of the first triangle
    float points[3][CO_LEAF_WIDTH];
    uint16_t starts, unused;
    uint32_t skipped[CO_LEAF_WIDTH - 1];
    uint32_t count, valid; // triangles, and one bit per triangle that is one
} GridBlock;
_Static_assert(offsetof(GridBlock, points) == offsetof(GridBlock, first) + 4 &&
                   offsetof(GridBlock, starts) == offsetof(GridBlock, first) + 4 + 192,
               "as co_leaf_tri finds them");

// Two rows of triangles that are numbered one after the other, from `low` and from `high` on. Where
// triangle 0 is none its number may be below 0.
static inline void number_rows(GridBlock *block, uint32_t low, uint32_t high)
{
    const uint32_t half = block->count / 2;
    block->first = low == UINT32_MAX ? 0 : low;
    block->starts = (uint16_t)(3u | 1u << half);
    block->skipped[0] = low - block->first;
    block->skipped[1] = high - half - block->first;
}

static inline CoTriLeaf gather_block(GridBlock *block, const float *mesh_points)
{
    // Stored as they are loaded later, or that would wait.
    for (uint32_t i = 0; i < CO_LEAF_WIDTH; i += CO_WIDE_WIDTH) {
        CoWide p[3];
        co_wide_load_points(mesh_points, block->index + i, p);
        for (int k = 0; k < 3; k++)
            co_wide_store(block->points[k] + i, p[k]);
    }
    return (CoTriLeaf){block->count,
                       CO_LEAF_WIDTH,
                       (block->count + 1) / 2,
                       block->corner,
                       {block->points[0], block->points[1], block->points[2]},
                       false};
}

// Offers what the ray pierces of the block's triangles.
static inline bool trace_block(Group *group, Ray *ray, const Shear *shear, const CoTriLeaf *leaf,
                               uint32_t valid, uint32_t path)
{
    LeafHits hits;
    group->stats->triangles += (uint64_t)__builtin_popcount(valid);
    shear_points(leaf, shear, &hits);
    uint32_t pierced = pierce_triangles(leaf, leaf->count, &hits) & valid;
    return pierced && offer_pierced(group, ray, leaf, shear, pierced, path, &hits, false);
}

// Points of an edge from its t-th on, `step` apart.
static inline __attribute__((always_inline)) void
edge_indices(uint32_t word, uint32_t t, const uint32_t count, const uint32_t step, uint32_t *out)
{
    const uint32_t on = 1u - 2u * (word >> 31), first = (word & ~CO_PATCH_FLAG) + on * t;
    for (uint32_t k = 0; k < count; k++)
        out[k * step] = first + k * on;
}

// Points of the `wide` x 2 squares from (i, j) on of a patch with m squares a side, m >= wide: all
// as if they were inside, then those on edges and corners put right.
static inline __attribute__((always_inline)) void block_indices(const uint32_t *words, uint32_t m,
                                                                uint32_t i, uint32_t j,
                                                                const uint32_t wide, uint32_t *out)
{
    const uint32_t row = wide + 1;
    uint32_t inner = (words[CO_PATCH_INNER] & ~CO_PATCH_FLAG) + (j - 1) * (m - 1) + i - 1;
    for (uint32_t r = 0; r < 3; r++)
        for (uint32_t c = 0; c < row; c++)
            out[row * r + c] = inner + r * (m - 1) + c;
    bool is_left = i == 0, is_right = i + wide == m, is_low = j == 0, is_high = j + 2 == m;
    if (is_low)
        edge_indices(words[CO_PATCH_EDGE], i, row, 1, out);
    if (is_high)
        edge_indices(words[CO_PATCH_EDGE + 2], i, row, 1, out + 2 * row);
    if (is_left)
        edge_indices(words[CO_PATCH_EDGE + 3], j, 3, row, out);
    if (is_right)
        edge_indices(words[CO_PATCH_EDGE + 1], j, 3, row, out + wide);
    if (is_low && is_left)
        out[0] = words[0];
    if (is_low && is_right)
        out[wide] = words[1];
    if (is_high && is_right)
        out[2 * row + wide] = words[2];
    if (is_high && is_left)
        out[2 * row] = words[3];
}

// The same of 4 x 2 squares of a triangular patch. Beyond the diagonal are points too, of triangles
// that are not valid.
static inline void triangular_indices(const CoPatchTable *table, const uint32_t *words, uint32_t m,
                                      const uint32_t at[2], uint32_t *out)
{
    const uint32_t i = at[0], j = at[1], row = 5;
    for (uint32_t r = 0; r < 3; r++) {
        const uint32_t inner = co_patch_inner_row(table, words, m, j + r) + i;
        for (uint32_t c = 0; c < row; c++)
            out[row * r + c] = inner + c;
    }
    bool is_low = j == 0, is_right = i + 4 == m;
    if (is_low)
        edge_indices(words[CO_PATCH_EDGE], i, row, 1, out);
    if (is_right)
        edge_indices(words[CO_PATCH_EDGE + 1], j, 3, row, out + 4);
    for (uint32_t r = 0; r < 3 && i <= j + 2; r++) // of the diagonal
        if (i <= j + r)
            out[row * r + j + r - i] = co_patch_edge_point(words, 2, j + r);
    if (is_low && i == 0)
        out[0] = words[0];
    if (is_low && is_right)
        out[4] = words[1];
    if (is_right && j + 2 == m)
        out[2 * row + 4] = words[2];
}

// The same of any table. Beyond the diagonal of a triangular patch are points too, of triangles
// that are not valid.
static inline void any_block_indices(const CoPatchTable *table, const uint32_t *words, uint32_t m,
                                     const uint32_t at[2], uint32_t wide, uint32_t *out)
{
    const uint32_t i = at[0], j = at[1];
    bool is_inside =
        j > 0 && i + wide < m && (table->is_triangular ? i > j + 2 : i > 0 && j + 2 < m);
    for (uint32_t r = 0; r < 3; r++) {
        uint32_t row = is_inside ? co_patch_inner_row(table, words, m, j + r) : 0;
        for (uint32_t c = 0; c <= wide; c++) {
            uint32_t a = i + c, b = j + r;
            if (is_inside) {
                *out++ = row + a;
                continue;
            }
            b = table->is_triangular && b > a ? a : b;
            co_patch_settle(table, words, m, &a, &b);
            *out++ = co_patch_point(table, words, m, a, b);
        }
    }
}

// Of a row of squares of a triangular patch, of which the first is so many right of the diagonal,
// the triangles that are there: second triangles precede their first.
static inline uint32_t valid_row(int32_t right, uint32_t count)
{
    uint32_t all = (1u << count) - 1u;
    return right > 0 ? all : all & ~0u << (1 - 2 * right);
}

static inline void number_triangular(GridBlock *block, uint32_t first, uint32_t m,
                                     const uint32_t at[2])
{
    const int32_t right = (int32_t)at[0] - (int32_t)at[1];
    const uint32_t half = block->count / 2, before = 2 * (uint32_t)right - 1;
    number_rows(block, first + co_patch_row(m, at[1]) + before,
                first + co_patch_row(m, at[1] + 1) + before - 2);
    block->valid = valid_row(right, half);
    block->valid |= m > 1 ? valid_row(right - 1, half) << half : 0;
    if (m == 1)
        block->valid = 2u;
}

// Corners of the triangles of 2 x 2 squares, whose points are 3 a row, and of 4 x 2, 5 a row.
static inline void set_corners(GridBlock *block, bool is_triangular)
{
    const uint8_t narrow[12] = {0x00, 0x11, 0x33, 0x44, 0x41, 0x52,
                                0x74, 0x85, 0x34, 0x45, 0x67, 0x78};
    const uint8_t broad[24] = {0x00, 0x11, 0x22, 0x33, 0x55, 0x66, 0x77, 0x88,
                               0x61, 0x72, 0x83, 0x94, 0xb6, 0xc7, 0xd8, 0xe9,
                               0x56, 0x67, 0x78, 0x89, 0xab, 0xbc, 0xcd, 0xde};
    const uint32_t half = block->count / 2;
    if (block->count == 8)
        memcpy(block->corner, narrow, sizeof narrow);
    else
        memcpy(block->corner, broad, sizeof broad);
    for (uint32_t i = half; is_triangular && i < 3 * half; i++) // the second comes first
        block->corner[i] = (uint8_t)(block->corner[i] << 4 | block->corner[i] >> 4);
}

// All of a triangular patch with 4 squares a side: 15 points, row by row, and 16 triangles.
static inline CoTriLeaf open_triangle(const CoBvh *bvh, const uint32_t *words, uint32_t first,
                                      GridBlock *block)
{
    const CoPatchTable *table = bvh->patches;
    const uint8_t corner[24] = {0x10, 0x21, 0x32, 0x53, 0x66, 0x77, 0xa9, 0xca,
                                0x61, 0x72, 0x83, 0x64, 0x7a, 0x8b, 0xda, 0xdb,
                                0x55, 0x66, 0x77, 0x98, 0xa9, 0xba, 0xcc, 0xed};
    uint32_t *out = block->index;
    memcpy(block->corner, corner, sizeof corner);
    for (uint32_t j = 0; j <= 4; j++) {
        for (uint32_t i = j; i <= 4; i++) {
            uint32_t a = i, b = j;
            co_patch_settle(table, words, 4, &a, &b);
            *out++ = co_patch_point(table, words, 4, a, b);
        }
    }
    *out = words[0];
    block->count = 16;
    block->valid = 0xffffu;
    block->first = first;
    block->starts = 1;
    return gather_block(block, bvh->points);
}

// The 4 x 2 squares from (i, j) on of a patch, or all of one with fewer: the 2 x 2 or the one that
// it is, or a triangular one with 4 a side.
static inline CoTriLeaf open_squares(const CoBvh *bvh, uint32_t patch, const uint32_t at[2],
                                     GridBlock *block)
{
    const CoPatchTable *table = bvh->patches;
    uint32_t room[CO_PATCH_WORDS];
    const uint32_t *words = co_patch_words(table, patch, room), first = words[0];
    uint32_t shift = co_patch_shift(table, words), first_tri = co_patch_first_tri(table, patch);
    uint32_t m = 1u << shift, wide = shift > 1 ? 4 : 2;
    if (table->is_triangular && shift == 2)
        return open_triangle(bvh, words, first_tri, block);
    block->count = 4 * wide;
    for (uint32_t k = shift == 0 ? 0 : wide == 4 ? 15 : 9; k < CO_LEAF_WIDTH; k++)
        block->index[k] = first;
    if (table->is_triangular && !table->is_mixed && wide == 4) {
        triangular_indices(table, words, m, at, block->index);
    } else if (shift && (table->is_triangular || table->is_mixed)) {
        any_block_indices(table, words, m, at, wide, block->index);
    } else if (wide == 4) {
        block_indices(words, m, at[0], at[1], 4, block->index);
    } else if (shift) {
        block_indices(words, m, 0, 0, 2, block->index);
    } else {
        block->index[1] = words[1];
        block->index[3] = words[table->is_triangular ? 0 : 3];
        block->index[4] = words[2];
    }
    set_corners(block, table->is_triangular);
    if (table->is_triangular) {
        number_triangular(block, first_tri, m, at);
    } else {
        uint32_t low = first_tri + (at[1] << (shift + 1)) + 2 * at[0];
        number_rows(block, low, low + 2 * m);
        block->valid = shift ? (1u << block->count) - 1u : 3u;
    }
    return gather_block(block, bvh->points);
}

// Triangles of the four rows of a plan.
static inline void number_four_rows(GridBlock *block, const CoGridPlan *plan, int32_t first_tri)
{
    const CoGridRows rows = plan->rows;
    block->first = (uint32_t)(first_tri + plan->first[0]);
    block->starts = 1;
    for (uint32_t q = 1; q < 4; q++) {
        const uint32_t start = co_grid_row_start(rows, q);
        block->starts |= (uint16_t)(1u << start);
        block->skipped[q - 1] = (uint32_t)(plan->first[q] - plan->first[0]) - start;
    }
}

// The same by plan, from the words of a patch or of its face.
static inline CoTriLeaf open_planned(const CoBvh *bvh, const uint32_t *words, uint32_t patch,
                                     uint32_t place, GridBlock *block)
{
    const CoGridPlan *plan = &bvh->plans[place];
    const int32_t first_tri = (int32_t)(patch << bvh->patches->unit_shift);
    for (uint32_t i = 0; i < CO_LEAF_WIDTH; i += CO_LANE_WIDTH)
        co_lane_along(words, plan->word + i, plan->step + i, block->index + i);
    block->count = plan->count;
    block->valid = plan->valid;
    if (plan->rows == CO_GRID_ROWS_EVEN)
        number_rows(block, (uint32_t)(first_tri + plan->first[0]),
                    (uint32_t)(first_tri + plan->first[1]));
    else
        number_four_rows(block, plan, first_tri);
    CoTriLeaf leaf = gather_block(block, bvh->points);
    leaf.corner = plan->corner;
    return leaf;
}

// A block of a tile.
static inline CoTriLeaf open_planned_tile(const CoBvh *bvh, const CoGridLeaf *tile, uint32_t place,
                                          GridBlock *block)
{
    const CoPatchTable *table = bvh->patches;
    if (!table->fold) {
        const bool is_second = co_grid_is_pair(tile) && place >= CO_PAIR_BLOCKS;
        const uint32_t patch = is_second ? co_grid_second(tile) : tile->patch;
        const uint32_t *words = table->words + (size_t)patch * table->stride;
        return open_planned(bvh, words, patch, place - (is_second ? CO_PAIR_BLOCKS : 0), block);
    }
    const uint32_t face = tile->patch / 3, k = tile->patch % 3; // 0 where the tile is the face
    const uint32_t *words = table->words + (size_t)face * table->stride;
    const uint32_t within = table->level == 3 ? k : place >> (table->level - 1);
    return open_planned(bvh, words, 3 * face + within, 8 * k + place, block);
}

// One bit per block that the ray enters, as slab_node has it.
static inline uint32_t slab_tile(const CoGridLeaf *leaf, uint32_t blocks, const Ray *ray,
                                 float entry[CO_TILE_BLOCKS])
{
    const uint8_t *planes = co_grid_planes(leaf);
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
static inline CoTriLeaf open_tile_block(const CoBvh *bvh, const CoGridLeaf *tile, uint32_t place,
                                        GridBlock *block)
{
    uint32_t at[2];
    if (bvh->plans)
        return open_planned_tile(bvh, tile, place, block);
    co_grid_block_at(co_grid_blocks(tile), place, at);
    if (tile->blocks & CO_TILE_PLACED) {
        at[0] += tile->at[0];
        at[1] += tile->at[1];
    }
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

static inline bool trace_tile(Group *group, Ray *ray, const Shear *shear, const CoBvh *bvh,
                              uint32_t ref, uint32_t path)
{
    const CoGridLeaf *tile = open_tile(bvh, ref);
    float entry[CO_TILE_BLOCKS];
    GridBlock block;
    uint32_t bits = 1;
    entry[0] = ray->from;
    const uint32_t blocks = co_grid_blocks(tile);
    if (blocks > 1) {
        bits = slab_tile(tile, blocks, ray, entry);
        group->stats->bottom_nodes++;
    }
    while (bits) {
        uint32_t nearest = nearest_block(bits, entry);
        bits &= ~(1u << nearest);
        if (!(entry[nearest] <= ray->to))
            return false;
        const CoTriLeaf leaf = open_tile_block(bvh, tile, nearest, &block);
        if (trace_block(group, ray, shear, &leaf, block.valid, path))
            return true;
    }
    return false;
}

// A leaf that is one block.
static inline CoTriLeaf open_block(const CoBvh *bvh, uint32_t ref, GridBlock *block)
{
    const uint32_t origin[2] = {0, 0}, number = ref & CO_REF_LEAF_PLACE;
    if (bvh->plans) {
        const uint32_t shift = bvh->block_shift;
        const uint32_t patch = number >> shift;
        const uint32_t *words = bvh->patches->words + (size_t)patch * bvh->patches->stride;
        return open_planned(bvh, words, patch, number & ((1u << shift) - 1u), block);
    }
    return open_squares(bvh, number, origin, block);
}

// A leaf of triangles with the numbers of their points.
static inline CoTriLeaf open_numbered(const CoBvh *bvh, uint32_t ref, GridBlock *block)
{
    const uint8_t *bytes = bvh->leaves + (size_t)(ref & CO_REF_LEAF_PLACE) * CO_LEAF_UNIT;
    const uint32_t points = (bytes[0] >> 4) + 1u;
    block->count = (bytes[0] & 15u) + 1u;
    block->valid = (2u << (block->count - 1)) - 1u;
    const uint32_t *words = (const void *)(bytes + co_leaf_first(block->count));
    block->first = words[0];
    const void *runs = co_grid_points(words + 1, points, bvh->last_point, block->index);
    memcpy(&block->starts, runs, sizeof(uint32_t) * CO_LEAF_WIDTH);
    CoTriLeaf leaf = gather_block(block, bvh->points);
    leaf.corner = bytes + 1;
    return leaf;
}

#include "accel/kernels/grid_lists.h"

// Returns true when the ray needs no more.
static __attribute__((noinline)) bool trace_grid_leaf(Group *group, Ray *ray, const Shear *shear,
                                                      const CoBvh *bvh, uint32_t ref, uint32_t path)
{
    GridBlock block;
    if (bvh->grid == CO_GRID_TILE)
        return trace_tile(group, ray, shear, bvh, ref, path);
    if (bvh->grid == CO_GRID_LIST)
        return trace_list(group, ray, shear, bvh, ref, path);
    const CoTriLeaf leaf = bvh->grid == CO_GRID_NUMBERED ? open_numbered(bvh, ref, &block)
                                                         : open_block(bvh, ref, &block);
    return trace_block(group, ray, shear, &leaf, block.valid, path);
}

#endif
