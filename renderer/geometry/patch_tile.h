// Tiles of patches, which trees of tables above level 3 are built over: 8 x 8 squares, or a whole
// patch that is smaller.

#ifndef CO_GEOMETRY_PATCH_TILE_H
#define CO_GEOMETRY_PATCH_TILE_H

#include "geometry/patch.h"

enum {
    CO_PATCH_TILE_SHIFT = 3
};

// Tiles of a patch with 2^shift squares a side: row by row, those of triangular patches at i >= j.
static inline uint32_t co_patch_tiles(const CoPatchTable *table, uint32_t shift)
{
    uint32_t side = shift > CO_PATCH_TILE_SHIFT ? 1u << (shift - CO_PATCH_TILE_SHIFT) : 1;
    return table->is_triangular ? side * (side + 1) / 2 : side * side;
}

static inline uint32_t co_patch_tile_count(const CoPatchTable *table)
{
    return table->first_tile ? table->first_tile[table->count]
                             : table->count * co_patch_tiles(table, table->level);
}

// The patch of a tile, and the first square of it.
static inline uint32_t co_patch_tile(const CoPatchTable *table, uint32_t tile, uint32_t *i,
                                     uint32_t *j)
{
    uint32_t all = co_patch_tiles(table, table->level), patch, number, row = 0;
    patch = table->first_tile ? co_patch_search(table->first_tile, 0, table->count - 1, tile)
                              : tile / all;
    number = tile - (table->first_tile ? table->first_tile[patch] : patch * all);
    uint32_t room[CO_PATCH_WORDS];
    uint32_t shift = co_patch_shift(table, co_patch_words(table, patch, room));
    uint32_t side = shift > CO_PATCH_TILE_SHIFT ? 1u << (shift - CO_PATCH_TILE_SHIFT) : 1;
    if (table->is_triangular) {
        for (; number >= side - row; row++)
            number -= side - row;
        number += row;
    } else {
        row = number / side;
        number %= side;
    }
    *i = number << CO_PATCH_TILE_SHIFT;
    *j = row << CO_PATCH_TILE_SHIFT;
    return patch;
}

#endif
