// Leaves over the patches of a subdivided mesh: no copy of points or triangles, only boxes.
//
// Triangles are tested by blocks of 4 x 2 squares: 15 points, 16 triangles; where a patch has fewer
// squares, of 2 x 2. A triangular patch of 4 squares a side is a block too. What a leaf is depends
// on the level of the mesh.
//
// - Level 0: triangles as in node.h, but for points, in place of which stand their numbers, see
//   co_grid_points.
// - Level 1 of triangular patches: a list of patches (CoGridList), 2 to a block, as many as are two
//   blocks. Level 0 of triangles that are split in 3: a list of faces, 4 in fans or 2 in quads, one
//   block.
// - Where all patches are one block, or two, that: the reference is the patch's number, or twice
//   that and which, and there is nothing else.
// - Level 3 of triangular patches: one patch, or two close together, in 4 blocks each, which are
//   triangles of 4 squares a side: CoGridLeaf, of two with the number of the second.
// - Else a tile of a patch, up to 8 x 8 squares: CoGridLeaf, with boxes of its 1, 2, 6 or 8 blocks.
//   Of triangular patches, blocks on the diagonal are parts, and those beyond it are left out: then
//   there are 6. Of triangles split in 3, with up to 4 squares a side
//   to a patch, a tile is the face: of 3 or 6 blocks.
//
// Boxes are rounded outward to 8 bits of the tile's box, so that a hit depends on none
// of this.

#ifndef CO_ACCEL_GRID_LEAF_H
#define CO_ACCEL_GRID_LEAF_H

#include "accel/build.h"
#include "accel/grid_plan.h"

enum {
    CO_LIST_PATCHES = 8,   // most of a list
    CO_GRID_LIST_TRIS = 8, // of a block of one
    CO_TILE_SQUARES = 8,   // a side
    CO_TILE_BLOCKS = 8
};

// Numbers stand in order. The others follow: 16 bits each, less the first, or, where that is not
// enough, 32 bits.
typedef struct CoGridList {
    uint32_t first;
    uint16_t count; // CO_LIST_FAR: 32 bits
    uint16_t near[];
} CoGridList;
#define CO_LIST_FAR 0x8000u

typedef struct CoGridLeaf {
    float origin[3]; // a plane is origin + byte * step, in float
    uint32_t patch;
    uint8_t exponent[3]; // of the steps, powers of two, as a float has it
    uint8_t blocks;      // CO_TILE_PLACED: of a tile that is not a whole patch; CO_TILE_PAIR
    uint16_t at[];       // of such, the first square; of pairs the second patch; else nothing
} CoGridLeaf; // then, of more than one block, planes: bytes [6][blocks], rows as in CoWideNode
_Static_assert(sizeof(CoGridLeaf) == 20, "followed by its place and its planes");
#define CO_TILE_PLACED 0x80u
#define CO_TILE_PAIR 0x40u // of two patches
enum {
    CO_PAIR_BLOCKS = 4 // of each
};

static inline uint32_t co_grid_blocks(const CoGridLeaf *leaf)
{
    return leaf->blocks & ~(CO_TILE_PLACED | CO_TILE_PAIR);
}

static inline bool co_grid_is_pair(const CoGridLeaf *leaf)
{
    return leaf->blocks & CO_TILE_PAIR;
}

// The second patch of a pair.
static inline uint32_t co_grid_second(const CoGridLeaf *leaf)
{
    return leaf->at[0] | (uint32_t)leaf->at[1] << 16;
}

static inline const uint8_t *co_grid_planes(const CoGridLeaf *leaf)
{
    return (const uint8_t *)(leaf->at + (leaf->blocks & (CO_TILE_PLACED | CO_TILE_PAIR) ? 2 : 0));
}

// Where block `place` of a tile of so many begins, in squares: row by row, two a row, or one where
// there are 2; of 6 the third and fourth row have the second only.
static inline void co_grid_block_at(uint32_t blocks, uint32_t place, uint32_t at[2])
{
    bool is_pair = blocks == 8 || (blocks == 6 && place < 4);
    uint32_t row = is_pair ? place >> 1 : blocks == 6 ? place - 2 : place;
    at[0] = is_pair ? 4 * (place & 1u) : blocks == 6 ? 4 : 0;
    at[1] = 2 * row;
}

// The same of a face of 3 or 6; returns which patch of the face it is in.
static inline uint32_t co_grid_face_block_at(uint32_t blocks, uint32_t place, uint32_t at[2])
{
    at[0] = 0;
    at[1] = blocks == 3 ? 0 : 2 * (place & 1u);
    return blocks == 3 ? place : place >> 1;
}

// Whether blocks are triangles, 4 of a patch, and leaves one or two patches.
static inline bool co_grid_is_paired(const CoPatchTable *table)
{
    return table->is_triangular && table->level == 3 && !table->is_mixed && !table->first_tri;
}

// Whether what a tree is built over, in place of patches, is faces: triangles, split in 3.
static inline bool co_grid_has_faces(const CoPatchTable *table)
{
    return table->fold && table->level <= 2;
}

// Whether leaves are triangles with the numbers of their points.
static inline bool co_grid_is_numbered(const CoPatchTable *table)
{
    return table->level == 0 && !table->fold;
}

static inline bool co_grid_is_list(const CoPatchTable *table)
{
    return table->level == 0 ? table->fold > 0 : table->level == 1 && table->is_triangular;
}

// How many of a list to a block.
static inline uint32_t co_grid_list_step(const CoPatchTable *table)
{
    bool is_two = table->level > 0 || table->stride > 4;
    return is_two ? 2 : 4;
}

// Whether all patches are quads with as many squares.
static inline bool co_grid_is_even(const CoPatchTable *table)
{
    return !table->is_triangular && !table->is_mixed && !table->first_tri && !table->fold;
}

// log2 of the blocks of a patch, where blocks are leaves.
static inline uint32_t co_grid_block_shift(const CoPatchTable *table)
{
    return table->level == 2 && co_grid_is_even(table) ? 1 : 0;
}

// Whether each block is a leaf.
static inline bool co_grid_is_block(const CoPatchTable *table)
{
    bool is_one = table->level == (table->is_triangular ? 2 : 1) && !co_grid_has_faces(table);
    return is_one || co_grid_block_shift(table) > 0;
}

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

// Reads a list; returns how many there are. What follows them in `patches` means nothing: all are
// read, with no branch on how many, and leaves have CO_LEAF_TAIL behind them.
static inline uint32_t co_grid_list(const CoGridList *list, uint32_t patches[CO_LIST_PATCHES])
{
    const uint32_t count = list->count & 0xffu;
    const uint32_t *far = (const uint32_t *)(const void *)(list + 1);
    patches[0] = list->first;
    if (list->count & CO_LIST_FAR) {
        for (uint32_t k = 1; k < count; k++)
            patches[k] = far[k - 1];
        return count;
    }
    for (uint32_t k = 1; k < CO_LIST_PATCHES; k++)
        patches[k] = list->first + list->near[k - 1];
    return count;
}

// Of a leaf of level 0 of so many points: their numbers, less the first word's, 16 bits each, or,
// where that is flagged, 32 bits. Returns what stands behind them. Up to 16 are read, whatever is
// there; none is above `last`.
#define CO_GRID_FAR 0x80000000u
static inline const void *co_grid_points(const uint32_t *words, uint32_t count, uint32_t last,
                                         uint32_t out[CO_LEAF_WIDTH])
{
    const uint32_t base = *words++;
    if (base & CO_GRID_FAR) {
        for (uint32_t k = 0; k < CO_LEAF_WIDTH; k++)
            out[k] = words[k] < last ? words[k] : last;
        return words + count;
    }
    const uint16_t *near = (const void *)words;
    for (uint32_t k = 0; k < CO_LEAF_WIDTH; k++)
        out[k] = base + near[k] < last ? base + near[k] : last;
    return words + (count + 1) / 2;
}

// Tells the tree where leaves are and what they refer to.
void co_grid_attach(CoBvh *bvh, const CoMesh *mesh);

#endif
