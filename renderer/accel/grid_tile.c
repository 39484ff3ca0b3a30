#include "accel/grid_tile.h"

#include "geometry/patch_tile.h"

#include <string.h>

_Static_assert(CO_TILE_SQUARES == 1 << CO_PATCH_TILE_SHIFT, "tiles are those of patch.h");

CoGridTile co_grid_find_tile(const CoPatchTable *table, uint32_t id)
{
    const uint32_t shift = co_grid_block_shift(table);
    CoGridTile tile = {.patch = co_grid_has_faces(table) ? id * 3 : id >> shift};
    tile.j = 2 * (id & ((1u << shift) - 1u));
    if (table->level > CO_PATCH_TILE_SHIFT)
        tile.patch = co_patch_tile(table, id, &tile.i, &tile.j);
    uint32_t room[CO_PATCH_WORDS];
    if (table->level > 0)
        tile.shift = co_patch_shift(table, co_patch_words(table, tile.patch, room));
    return tile;
}

// The box of squares [i, i + wide] x [j, j + high] of the tile's patch.
static CoBox squares_box(const CoMesh *mesh, const CoGridTile *tile, uint32_t i, uint32_t j,
                         uint32_t wide, uint32_t high)
{
    const CoPatchTable *table = mesh->patches;
    uint32_t room[CO_PATCH_WORDS];
    const uint32_t *words = co_patch_words(table, tile->patch, room);
    uint32_t m = 1u << tile->shift;
    CoBox box;
    co_box_empty(&box);
    for (uint32_t row = j; row <= j + high; row++) {
        for (uint32_t k = table->is_triangular && row > i ? row : i; k <= i + wide; k++) {
            uint32_t a = k, b = row;
            co_patch_settle(table, words, m, &a, &b);
            co_grid_extend(mesh, co_patch_point(table, words, m, a, b), &box);
        }
    }
    return box;
}

// The box of a block that is a triangle: three stand upright at the corners, the last lies between.
static CoBox triangle_box(const CoMesh *mesh, uint32_t patch, uint32_t place)
{
    const CoPatchTable *table = mesh->patches;
    const uint32_t i = place > 0 ? 4 : 0, j = place == 2 ? 4 : 0;
    uint32_t room[CO_PATCH_WORDS];
    const uint32_t *words = co_patch_words(table, patch, room);
    CoBox box;
    co_box_empty(&box);
    for (uint32_t r = 0; r <= 4; r++) {
        const uint32_t first = place == 3 ? 0 : r, last = place == 3 ? r : 4;
        for (uint32_t c = first; c <= last; c++)
            co_grid_extend(mesh, co_patch_point(table, words, 8, i + c, j + r), &box);
    }
    return box;
}

// The box of one of its blocks.
static CoBox block_box(const CoMesh *mesh, const CoGridTile *tile, uint32_t blocks, uint32_t place)
{
    CoGridTile of = *tile;
    uint32_t at[2];
    if (co_grid_is_paired(mesh->patches))
        return triangle_box(mesh, tile->patch, place);
    if (co_grid_has_faces(mesh->patches))
        of.patch += co_grid_face_block_at(blocks, place, at);
    else
        co_grid_block_at(blocks, place, at);
    return squares_box(mesh, &of, of.i + at[0], of.j + at[1], blocks == 3 ? 2 : 4, 2);
}

static uint32_t block_count(const CoPatchTable *table, const CoGridTile *tile)
{
    if (co_grid_has_faces(table))
        return 3 * table->level;
    if (co_grid_is_paired(table))
        return CO_PAIR_BLOCKS;
    if (tile->shift < CO_PATCH_TILE_SHIFT)
        return tile->shift == 2 && !table->is_triangular ? 2 : 1;
    return table->is_triangular && tile->i == tile->j ? 6 : 8;
}

static CoBox face_box(const CoMesh *mesh, const CoGridTile *tile)
{
    uint32_t points[7], count = 0, blocks = block_count(mesh->patches, tile);
    CoBox all;
    co_box_empty(&all);
    if (mesh->patches->level == 0)
        count = co_patch_face_points(mesh->patches, tile->patch / 3, points);
    for (uint32_t k = 0; k < count; k++)
        co_grid_extend(mesh, points[k], &all);
    for (uint32_t b = 0; b < blocks; b++) {
        CoBox box = block_box(mesh, tile, blocks, b);
        co_box_extend(&all, box.lo, box.hi);
    }
    return all;
}

CoBox co_grid_tile_box(const CoMesh *mesh, const CoGridTile *tile)
{
    if (co_grid_has_faces(mesh->patches))
        return face_box(mesh, tile);
    uint32_t room[CO_PATCH_WORDS];
    const uint32_t *words = co_patch_words(mesh->patches, tile->patch, room);
    if (mesh->patches->level > 0) {
        uint32_t m = 1u << tile->shift, size = m < CO_TILE_SQUARES ? m : CO_TILE_SQUARES;
        uint32_t high = size >> co_grid_block_shift(mesh->patches);
        return squares_box(mesh, tile, tile->i, tile->j, size, high);
    }
    CoBox box;
    co_box_empty(&box);
    for (int k = 0; k < (co_patch_is_fan(mesh->patches, words) ? 3 : 4); k++)
        co_grid_extend(mesh, words[k], &box);
    return box;
}

uint32_t co_grid_count(const CoMesh *mesh)
{
    const CoPatchTable *table = mesh->patches;
    if (co_grid_has_faces(table))
        return table->count / 3;
    if (table->level > CO_PATCH_TILE_SHIFT)
        return co_patch_tile_count(table);
    return table->count << co_grid_block_shift(table);
}

CoBox co_grid_box(const CoMesh *mesh, uint32_t id)
{
    CoGridTile tile = co_grid_find_tile(mesh->patches, id);
    return co_grid_tile_box(mesh, &tile);
}

// The smallest step by which a byte reaches hi from lo.
static uint8_t find_exponent(float lo, float hi)
{
    uint32_t exponent = 1;
    double extent = ((double)hi - (double)lo) / 255.0;
    if (extent > 0.0) {
        int e = 0;
        frexp(extent, &e);
        exponent = e < -125 ? 1 : (uint32_t)(e + 126);
    }
    while (exponent < 254 && !(lo + 255.0f * co_grid_step((uint8_t)exponent) >= hi))
        exponent++;
    return (uint8_t)exponent;
}

// The byte whose plane is nearest to x from below, or from above.
static uint8_t find_byte(float origin, float step, float x, bool is_high)
{
    double place = ((double)x - (double)origin) / (double)step;
    double whole = is_high ? ceil(place) : floor(place);
    int byte = whole < 0.0 ? 0 : whole > 255.0 ? 255 : (int)whole;
    // origin + byte * step is rounded itself.
    while (is_high && byte < 255 && origin + (float)byte * step < x)
        byte++;
    while (!is_high && byte > 0 && !(origin + (float)byte * step <= x))
        byte--;
    return (uint8_t)byte;
}

size_t co_grid_tile_bytes(const CoPatchTable *table, const CoGridTile *tile, size_t count)
{
    uint32_t blocks = (uint32_t)count * block_count(table, tile);
    bool has_place = table->level > CO_PATCH_TILE_SHIFT || count > 1;
    size_t bytes = sizeof(CoGridLeaf) + (has_place ? 4 : 0);
    bytes += blocks > 1 ? 6 * blocks : 0;
    return (bytes + CO_LEAF_UNIT - 1) & ~(size_t)(CO_LEAF_UNIT - 1);
}

// The boxes of all blocks of a leaf, where it has several, and of the whole.
static CoBox find_boxes(const CoMesh *mesh, const CoGridTile *tiles, size_t count,
                        CoBox blocks[CO_TILE_BLOCKS])
{
    const uint32_t each = block_count(mesh->patches, tiles), all = (uint32_t)count * each;
    if (all == 1)
        return co_grid_tile_box(mesh, tiles);
    CoBox box;
    co_box_empty(&box);
    for (uint32_t b = 0; b < all; b++) {
        blocks[b] = block_box(mesh, &tiles[b / each], each, b % each);
        co_box_extend(&box, blocks[b].lo, blocks[b].hi);
    }
    return box;
}

CoBox co_grid_write_tiles(const CoMesh *mesh, const CoGridTile *tiles, size_t count,
                          unsigned char *out, size_t *bytes)
{
    CoBox boxes[CO_TILE_BLOCKS];
    const CoBox box = find_boxes(mesh, tiles, count, boxes);
    const bool is_placed = mesh->patches->level > CO_PATCH_TILE_SHIFT, is_pair = count > 1;
    const uint32_t second = tiles[count - 1].patch;
    const uint32_t blocks = (uint32_t)count * block_count(mesh->patches, tiles);
    const uint16_t at[2] = {(uint16_t)(is_pair ? second : tiles->i),
                            (uint16_t)(is_pair ? second >> 16 : tiles->j)};
    CoGridLeaf leaf = {.patch = tiles->patch,
                       .blocks = (uint8_t)(blocks | (is_placed ? CO_TILE_PLACED : 0) |
                                           (is_pair ? CO_TILE_PAIR : 0))};
    for (int k = 0; k < 3; k++) {
        leaf.origin[k] = box.lo[k];
        leaf.exponent[k] = find_exponent(box.lo[k], box.hi[k]);
    }
    memcpy(out, &leaf, sizeof leaf);
    size_t end = sizeof leaf + (is_placed || is_pair ? sizeof at : 0);
    memcpy(out + sizeof leaf, at, end - sizeof leaf);
    for (uint32_t b = 0; blocks > 1 && b < blocks; b++) {
        unsigned char *planes = out + end + b;
        for (uint32_t k = 0; k < 3; k++) {
            float step = co_grid_step(leaf.exponent[k]);
            planes[2 * k * blocks] = find_byte(leaf.origin[k], step, boxes[b].lo[k], false);
            planes[(2 * k + 1) * blocks] = find_byte(leaf.origin[k], step, boxes[b].hi[k], true);
        }
    }
    end += blocks > 1 ? 6 * blocks : 0;
    *bytes = co_grid_tile_bytes(mesh->patches, tiles, count);
    memset(out + end, 0, *bytes - end);
    return box;
}
