// Points of subdivided quads without an index array.
//
// A patch has m x m squares of two triangles each: a quad face of the cage with m = 2^level, or a
// sub-quad of another face with half as many a side. Grid point (i, j), 0 <= i, j <= m, is a
// corner, lies on an edge or inside; each of these is a run of points, so a patch is the four
// corners, the beginnings of four edges and of its inside. At level 0 it is a quad, or one triangle
// of a fan. Triangles of a patch: those of square (i, j), row by row, (i,j) (i+1,j) (i+1,j+1) and
// (i,j) (i+1,j+1) (i,j+1); those of patches one after the other.

#ifndef CO_GEOMETRY_PATCH_H
#define CO_GEOMETRY_PATCH_H

#include <stddef.h>
#include <stdint.h>

// What the words of a patch are.
enum {
    CO_PATCH_CORNER = 0, // points (0,0) (m,0) (m,m) (0,m); the last of a fan's triangle is NONE
    CO_PATCH_EDGE = 4,   // j = 0 and i = m, j = m and i = 0: point t is the word + t, flagged - t
    CO_PATCH_INNER = 8,  // point (1,1), then row by row; flagged: a sub-quad
    CO_PATCH_WORDS = 9   // at level 0 the corners alone
};
#define CO_PATCH_FLAG 0x80000000u
#define CO_PATCH_NONE 0xffffffffu

typedef struct CoPatchTable {
    uint32_t level;
    uint32_t count, stride;    // patches, and words of one
    const uint32_t *words;     // [count * stride]
    const uint32_t *first_tri; // [count + 1], NULL: all are whole quads, patch << (2 level + 1)
    const uint32_t *tri_patch; // with first_tri: the patch of triangle k << (2 level + 1)
    const uint32_t *face;      // [count] face of the cage, NULL: patch k is face k
} CoPatchTable;

static inline const uint32_t *co_patch_words(const CoPatchTable *table, uint32_t patch)
{
    return table->words + (size_t)patch * table->stride;
}

static inline uint32_t co_patch_is_fan(const CoPatchTable *table, const uint32_t *words)
{
    return table->level == 0 && words[3] == CO_PATCH_NONE;
}

// log2 of the squares a side.
static inline uint32_t co_patch_shift(const CoPatchTable *table, const uint32_t *words)
{
    return table->level == 0 ? 0 : table->level - (words[CO_PATCH_INNER] >> 31);
}

static inline uint32_t co_patch_first_tri(const CoPatchTable *table, uint32_t patch)
{
    return table->first_tri ? table->first_tri[patch] : patch << (2 * table->level + 1);
}

// The patch of a triangle.
static inline uint32_t co_patch_of(const CoPatchTable *table, uint32_t tri)
{
    uint32_t patch = tri >> (2 * table->level + 1);
    if (!table->first_tri)
        return patch;
    // A whole quad has as many triangles as four sub-quads: this takes at most a few steps.
    patch = table->tri_patch[patch];
    while (table->first_tri[patch + 1] <= tri)
        patch++;
    return patch;
}

// Point t of an edge, 0 < t < m.
static inline uint32_t co_patch_edge_point(const uint32_t *words, uint32_t edge, uint32_t t)
{
    uint32_t word = words[CO_PATCH_EDGE + edge];
    return word & CO_PATCH_FLAG ? (word & ~CO_PATCH_FLAG) - t : word + t;
}

// The point at (i, j) of a patch with m squares a side.
static inline uint32_t co_patch_point(const uint32_t *words, uint32_t m, uint32_t i, uint32_t j)
{
    uint32_t on_i = i == 0 || i == m, on_j = j == 0 || j == m;
    if (on_i && on_j)
        return words[j ? (i ? 2 : 3) : (i ? 1 : 0)];
    if (on_j)
        return co_patch_edge_point(words, j ? 2 : 0, i);
    if (on_i)
        return co_patch_edge_point(words, i ? 1 : 3, j);
    return (words[CO_PATCH_INNER] & ~CO_PATCH_FLAG) + (j - 1) * (m - 1) + i - 1;
}

// Grid points of the corners of triangle `local` of a patch with 2^shift squares a side.
static inline void co_patch_corners(uint32_t shift, uint32_t local, uint32_t i[3], uint32_t j[3])
{
    uint32_t square = local >> 1, upper = local & 1u;
    i[0] = square & ((1u << shift) - 1u);
    j[0] = square >> shift;
    i[1] = i[0] + 1;
    j[1] = j[0] + upper;
    i[2] = i[1] - upper;
    j[2] = j[0] + 1;
}

// The three points of a triangle.
static inline void co_patch_triangle(const CoPatchTable *table, uint32_t tri, uint32_t out[3])
{
    uint32_t patch = co_patch_of(table, tri), i[3], j[3];
    const uint32_t *words = co_patch_words(table, patch);
    if (co_patch_is_fan(table, words)) {
        for (int c = 0; c < 3; c++)
            out[c] = words[c];
        return;
    }
    uint32_t shift = co_patch_shift(table, words);
    co_patch_corners(shift, tri - co_patch_first_tri(table, patch), i, j);
    for (int c = 0; c < 3; c++)
        out[c] = co_patch_point(words, 1u << shift, i[c], j[c]);
}

#endif
