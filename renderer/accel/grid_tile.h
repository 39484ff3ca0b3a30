// Tiles, which trees of patches are built over: their boxes, those of their blocks, and leaves that
// hold these (grid_leaf.h).

#ifndef CO_ACCEL_GRID_TILE_H
#define CO_ACCEL_GRID_TILE_H

#include "accel/grid_leaf.h"

// A patch, above level 3 a tile of it.
typedef struct CoGridTile {
    uint32_t patch;
    uint32_t i, j;  // first square
    uint32_t shift; // log2 of the squares a side of the patch
} CoGridTile;

static inline void co_grid_extend(const CoMesh *mesh, uint32_t point, CoBox *box)
{
    const float *p = mesh->points + 3 * (size_t)point;
    co_box_extend(box, p, p);
}

// Of those that co_grid_count counts.
CoGridTile co_grid_find_tile(const CoPatchTable *table, uint32_t id);
CoBox co_grid_tile_box(const CoMesh *mesh, const CoGridTile *tile);

// A leaf of one tile, or of two that are a pair: how many bytes it takes; writes it, and returns
// its box.
size_t co_grid_tile_bytes(const CoPatchTable *table, const CoGridTile *tiles, size_t count);
CoBox co_grid_write_tiles(const CoMesh *mesh, const CoGridTile *tiles, size_t count,
                          unsigned char *out, size_t *bytes);

#endif
