// Leaves over the patches of a subdivided mesh: no copy of points or triangles, only boxes.
//
// Triangles are tested by blocks of 2 x 2 squares: 9 points, 8 triangles. What a leaf is depends on
// the level of the mesh:
//   0    up to 4 patches (quads, single triangles): their numbers, the first again where there are
//        fewer
//   1    one patch, which is one block; the reference is its number, there is nothing else
//   2..  a tile of a patch, up to 8 x 8 squares: CoGridLeaf, with boxes of its 1, 4 or 16 blocks
// Of triangular patches, tiles and blocks on the diagonal are halves, and those beyond it empty.
// Boxes are rounded outward to 8 bits of the tile's box, so that a hit depends on none of this.

#ifndef CO_ACCEL_GRID_LEAF_H
#define CO_ACCEL_GRID_LEAF_H

#include "accel/build.h"

enum {
    CO_LIST_PATCHES = 4,
    CO_TILE_SQUARES = 8, // a side
    CO_TILE_BLOCKS = 16,
    CO_GRID_TRIS = 8 // of a block
};

typedef struct CoGridLeaf {
    uint32_t patch;
    uint16_t i, j;       // first square
    float origin[3];     // a plane is origin + byte * step, in float
    uint8_t exponent[3]; // of the steps, powers of two, as a float has it
    uint8_t side;        // log2 of the blocks a side
} CoGridLeaf; // then planes: bytes [6][blocks], rows as in CoWideNode, blocks row by row
_Static_assert(sizeof(CoGridLeaf) == 24, "followed by its planes");

// 2^(exponent - 127).
static inline float co_grid_step(uint8_t exponent)
{
    union {
        uint32_t u;
        float f;
    } bits = {(uint32_t)exponent << 23};
    return bits.f;
}

// A tree of patches is built over patches, above level 3 over tiles of them: their number (below
// 2^31 for any mesh that fits in memory) and boxes, and what leaves look like.
uint32_t co_grid_count(const CoMesh *mesh);
CoBox co_grid_box(const CoMesh *mesh, uint32_t id);
CoLeafRule co_grid_rule(const CoMesh *mesh);

// Writes the leaf that a reference stands for again, where it holds boxes; returns its own.
CoBox co_grid_refit(const CoMesh *mesh, uint32_t ref, unsigned char *leaves);

// Tells the tree where leaves are and what they refer to.
void co_grid_attach(CoBvh *bvh, const CoMesh *mesh);

#endif
