// Points of subdivided faces without an index array.
//
// A patch has m x m squares of two triangles each: a quad face of the cage with m = 2^level, or a
// sub-quad of another face with half as many a side. Grid point (i, j), 0 <= i, j <= m, is a
// corner, lies on an edge or inside; each of these is a run of points, so a patch is the four
// corners, the beginnings of four edges and of its inside. At level 0 it is a quad, or one triangle
// (of a fan, or of a Loop mesh). Triangles of a patch: those of square (i, j), row by row,
// (i,j) (i+1,j) (i+1,j+1) and (i,j) (i+1,j+1) (i,j+1); those of patches one after the other.
//
// A triangular patch (Loop) is what of that lies at i >= j: of squares on the diagonal their first
// triangle. Its corners are (0,0) (m,0) (m,m), its edges j = 0, i = m and the diagonal. In a row
// the second triangle of a square stands before its first.
//
// In mixed tables patches have m of their own, and an edge may be coarser than its patch, by a
// power of two. Then grid points on it stand for the nearest of its points: some triangles along it
// become wider, and as many collapse, having two corners that are one point; so the face beside it,
// finer or coarser, has the same points there. No other triangle collapses or turns over.

#ifndef CO_GEOMETRY_PATCH_H
#define CO_GEOMETRY_PATCH_H

#include "geometry/patch_pack.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// What the words of a patch are. A triangular one has three corners and edges.
enum {
    CO_PATCH_CORNER = 0, // points (0,0) (m,0) (m,m) (0,m); the last of a fan's triangle is NONE
    CO_PATCH_EDGE = 4,  // j = 0 and i = m, j = m and i = 0 (triangular: j = 0, i = m, i = j): point
                        // t of the edge's own is the word + t, flagged - t
    CO_PATCH_INNER = 8, // first point inside, then row by row; flagged: m is half of 2^level
    CO_PATCH_INNER_TRIANGULAR = 3,
    CO_PATCH_WORDS = 9, // at level 0 the corners alone; mixed: one more, log2 of m, then for each
                        // edge by how many halvings it is coarser, four bits each
    CO_PATCH_WORDS_TRIANGULAR = 7
};
#define CO_PATCH_FLAG 0x80000000u
#define CO_PATCH_NONE 0xffffffffu

// Three corners and the middles of three edges, in few bytes: of each three the first, and how far
// the others are from it. Where that is too far, corners[0] says so, and `corner` which of the
// table's far ones it is.
typedef struct CoPatchNear {
    uint32_t corner, edge;
    int16_t corners[2], edges[2];
} CoPatchNear;
_Static_assert(sizeof(CoPatchNear) == 16, "a quarter of a cache line");
#define CO_PATCH_FAR INT16_MIN
enum {
    CO_PATCH_NEAR_POINTS = 6
};

typedef struct CoPatchTable {
    uint32_t level; // of the finest patch, or of the finest face where some are split and some not
    bool is_triangular, is_mixed;
    uint32_t count, stride;      // patches, and words of one, or of a face, see fold
    uint32_t fold;               // 3: of triangles split in 3, words are by face; else 0
    const uint32_t *words;       // [count * stride]; NULL: packed, or near
    const CoPatchPack *packs;    // of level 0, not of folded tables, see patch_pack.h; or NULL
    const unsigned char *packed; // with packs, their bits
    const CoPatchNear *nears;    // of patches, or of faces of a folded table; or NULL
    const uint32_t *fars;        // with nears, the points of those that are not near
    uint32_t center;             // with nears of faces: inside the first; those of others follow
    uint32_t unit_shift;         // log2 of triangles per patch, or of what tri_patch counts
    const uint32_t *first_tri;   // [count + 1], NULL: all have the same number
    const uint32_t *tri_patch;   // with first_tri: patch of triangle k << unit_shift, then the last
    const uint32_t *first_tile;  // [count + 1], with first_tri above level 3: see patch_tile.h
    uint32_t per_face;           // patches of each face of the cage, where all have as many; else 0
    const uint32_t *face;        // [count] then face of the cage
} CoPatchTable;

// Point t along an edge that is this word.
static inline uint32_t co_patch_word_point(uint32_t word, uint32_t t)
{
    return word & CO_PATCH_FLAG ? (word & ~CO_PATCH_FLAG) - t : word + t;
}

// Patch k of a triangle whose words are its corners, its edges, each counted from its corner on,
// unless the patches are fans, and the first point inside: there lie the center, the spokes from
// the middle of each edge to it, and the inner points of each patch.
static inline void co_patch_unfold(const CoPatchTable *table, const uint32_t *face, uint32_t k,
                                   uint32_t words[CO_PATCH_WORDS])
{
    const uint32_t n = 3, m = 1u << table->level, spoke = m - 1;
    const uint32_t before = k > 0 ? k - 1 : n - 1, center = face[table->stride - 1];
    words[CO_PATCH_CORNER] = face[k];
    if (table->stride == n + 1) {
        words[CO_PATCH_CORNER + 1] = face[k + 1 < n ? k + 1 : 0];
        words[CO_PATCH_CORNER + 2] = center;
        words[CO_PATCH_CORNER + 3] = CO_PATCH_NONE;
        return;
    }
    const uint32_t next = face[n + k], last = face[n + before];
    words[CO_PATCH_CORNER + 1] = co_patch_word_point(next, m);
    words[CO_PATCH_CORNER + 2] = center;
    words[CO_PATCH_CORNER + 3] = co_patch_word_point(last, m);
    words[CO_PATCH_EDGE] = next;
    words[CO_PATCH_EDGE + 1] = center + k * spoke;
    words[CO_PATCH_EDGE + 2] = center + before * spoke;
    words[CO_PATCH_EDGE + 3] =
        last & CO_PATCH_FLAG ? (last & ~CO_PATCH_FLAG) - 2 * m : CO_PATCH_FLAG | (last + 2 * m);
    words[CO_PATCH_INNER] = center + 1 + n * spoke + k * spoke * spoke;
}

static inline uint32_t co_patch_near_point(uint32_t first, int32_t step)
{
    return first + (uint32_t)step;
}

// The corners of a patch or face that is near, then the middles of its edges.
static inline void co_patch_near_points(const CoPatchTable *table, uint32_t k,
                                        uint32_t out[CO_PATCH_NEAR_POINTS])
{
    const CoPatchNear *near = &table->nears[k];
    if (near->corners[0] == CO_PATCH_FAR) {
        memcpy(out, table->fars + (size_t)near->corner * CO_PATCH_NEAR_POINTS,
               CO_PATCH_NEAR_POINTS * sizeof *out);
        return;
    }
    out[0] = near->corner;
    out[1] = co_patch_near_point(near->corner, near->corners[0]);
    out[2] = co_patch_near_point(near->corner, near->corners[1]);
    out[3] = near->edge;
    out[4] = co_patch_near_point(near->edge, near->edges[0]);
    out[5] = co_patch_near_point(near->edge, near->edges[1]);
}

// The words of a patch, or of a face of a folded table, that is near.
static inline void co_patch_near_words(const CoPatchTable *table, uint32_t k,
                                       uint32_t words[CO_PATCH_WORDS_TRIANGULAR])
{
    uint32_t points[CO_PATCH_NEAR_POINTS];
    co_patch_near_points(table, k, points);
    const uint32_t edge = table->fold ? 3 : CO_PATCH_EDGE;
    for (uint32_t c = 0; c < 3; c++) {
        words[c] = points[c];
        words[edge + c] = points[3 + c] - 1;
    }
    words[table->fold ? 6 : CO_PATCH_INNER_TRIANGULAR] = table->fold ? table->center + k : 0;
}

// Points of a face of triangles in a folded table of level 0, as many as it has words: corners,
// then the middles of edges, unless patches are fans, then the center.
static inline uint32_t co_patch_face_points(const CoPatchTable *table, uint32_t face,
                                            uint32_t out[7])
{
    if (table->nears) {
        co_patch_near_points(table, face, out);
        out[CO_PATCH_NEAR_POINTS] = table->center + face;
        return table->stride;
    }
    const uint32_t *words = table->words + (size_t)face * table->stride;
    for (uint32_t k = 0; k < 3; k++)
        out[k] = words[k];
    for (uint32_t k = 3; k + 1 < table->stride; k++)
        out[k] = co_patch_word_point(words[k], 1);
    out[table->stride - 1] = words[table->stride - 1];
    return table->stride;
}

// Words of all patches or faces.
static inline size_t co_patch_word_count(const CoPatchTable *table)
{
    return (size_t)table->count / (table->fold ? 3 : 1) * table->stride;
}

// Asks for the words of a patch.
static inline void co_patch_approach(const CoPatchTable *table, uint32_t patch)
{
    if (table->packs)
        __builtin_prefetch(table->packed + co_patch_pack_place(table->packs, patch) / 8);
    else
        __builtin_prefetch(table->words + (size_t)patch * table->stride);
}

// The words of a patch; `room` is for those that have to be put together.
static inline const uint32_t *co_patch_words(const CoPatchTable *table, uint32_t patch,
                                             uint32_t room[CO_PATCH_WORDS])
{
    if (table->packs) {
        co_patch_unpack(table->packs, table->packed, patch, room);
        return room;
    }
    if (!table->fold && table->nears) {
        co_patch_near_words(table, patch, room);
        return room;
    }
    if (!table->fold)
        return table->words + (size_t)patch * table->stride;
    uint32_t face = patch / 3, own[CO_PATCH_WORDS_TRIANGULAR];
    if (table->nears)
        co_patch_near_words(table, face, own);
    const uint32_t *words = table->nears ? own : table->words + (size_t)face * table->stride;
    co_patch_unfold(table, words, patch % 3, room);
    return room;
}

static inline uint32_t co_patch_inner(const CoPatchTable *table, const uint32_t *words)
{
    return words[table->is_triangular ? CO_PATCH_INNER_TRIANGULAR : CO_PATCH_INNER];
}

// Of mixed tables.
static inline uint32_t co_patch_rates(const CoPatchTable *table, const uint32_t *words)
{
    return words[table->stride - 1];
}

// Whether it is one triangle.
static inline uint32_t co_patch_is_fan(const CoPatchTable *table, const uint32_t *words)
{
    return table->level == 0 && (table->is_triangular || words[3] == CO_PATCH_NONE);
}

// log2 of the squares a side.
static inline uint32_t co_patch_shift(const CoPatchTable *table, const uint32_t *words)
{
    if (table->is_mixed)
        return co_patch_rates(table, words) & 15u;
    return table->level == 0 ? 0 : table->level - (co_patch_inner(table, words) >> 31);
}

static inline uint32_t co_patch_first_tri(const CoPatchTable *table, uint32_t patch)
{
    return table->first_tri ? table->first_tri[patch] : patch << table->unit_shift;
}

// The last patch from `low` to `high` whose entry is not above `value`; that of `low` is not.
static inline uint32_t co_patch_search(const uint32_t *first, uint32_t low, uint32_t high,
                                       uint32_t value)
{
    while (low < high) {
        uint32_t middle = low + (high - low + 1) / 2;
        bool is_above = first[middle] > value;
        low = is_above ? low : middle;
        high = is_above ? middle - 1 : high;
    }
    return low;
}

// The patch of a triangle.
static inline uint32_t co_patch_of(const CoPatchTable *table, uint32_t tri)
{
    uint32_t unit = tri >> table->unit_shift;
    if (!table->first_tri)
        return unit;
    return co_patch_search(table->first_tri, table->tri_patch[unit], table->tri_patch[unit + 1],
                           tri);
}

// ---- Places in a patch -------------------------------------------------------------------------

// Squares of row j of a triangular patch are preceded by so many triangles of the patch.
static inline uint32_t co_patch_row(uint32_t m, uint32_t j)
{
    return m * m - (m - j) * (m - j);
}

// Where point t along an edge goes, that is coarser by so many halvings. Halves go up.
static inline uint32_t co_patch_round(uint32_t t, uint32_t drop)
{
    return (t + (1u << drop >> 1)) >> drop << drop;
}

static inline uint32_t co_patch_drop(const CoPatchTable *table, const uint32_t *words,
                                     uint32_t edge)
{
    return table->is_mixed ? co_patch_rates(table, words) >> (4 + 4 * edge) & 15u : 0;
}

// Moves a grid point of a mixed table to where it stands for. On the diagonal halves go down: two
// edges that both rounded away from their corner would leave a triangle without area there.
static inline void co_patch_settle(const CoPatchTable *table, const uint32_t *words, uint32_t m,
                                   uint32_t *i, uint32_t *j)
{
    if (*j == 0)
        *i = co_patch_round(*i, co_patch_drop(table, words, 0));
    else if (*i == m)
        *j = co_patch_round(*j, co_patch_drop(table, words, 1));
    else if (table->is_triangular && *i == *j)
        *i = *j = m - co_patch_round(m - *i, co_patch_drop(table, words, 2));
    else if (!table->is_triangular && *j == m)
        *i = co_patch_round(*i, co_patch_drop(table, words, 2));
    else if (*i == 0)
        *j = co_patch_round(*j, co_patch_drop(table, words, 3));
}

// Grid points of the corners of triangle `local` of a patch.
static inline void co_patch_corners(const CoPatchTable *table, const uint32_t *words,
                                    uint32_t local, uint32_t i[3], uint32_t j[3])
{
    uint32_t shift = co_patch_shift(table, words), m = 1u << shift, upper;
    if (table->is_triangular) {
        // Rows j and above hold (m - j)^2 triangles; the root is exact in double.
        j[0] = m - (uint32_t)ceil(sqrt((double)(m * m - local)));
        uint32_t k = local - co_patch_row(m, j[0]);
        upper = k & 1u;
        i[0] = j[0] + ((k + 1) >> 1);
    } else {
        upper = local & 1u;
        i[0] = local >> 1 & (m - 1u);
        j[0] = local >> 1 >> shift;
    }
    i[1] = i[0] + 1;
    j[1] = j[0] + upper;
    i[2] = i[1] - upper;
    j[2] = j[0] + 1;
    for (int c = 0; table->is_mixed && c < 3; c++)
        co_patch_settle(table, words, m, &i[c], &j[c]);
}

// ---- Points ------------------------------------------------------------------------------------

// Point t of an edge's own.
static inline uint32_t co_patch_edge_point(const uint32_t *words, uint32_t edge, uint32_t t)
{
    return co_patch_word_point(words[CO_PATCH_EDGE + edge], t);
}

// Point (i, j) inside a patch, less i.
static inline uint32_t co_patch_inner_row(const CoPatchTable *table, const uint32_t *words,
                                          uint32_t m, uint32_t j)
{
    uint32_t first = co_patch_inner(table, words) & ~CO_PATCH_FLAG;
    return table->is_triangular ? first + (j - 1) * (2 * m - 2 - j) / 2 - j - 1
                                : first + (j - 1) * (m - 1) - 1;
}

// The edge of a patch that holds a grid point other than a corner; 4: none.
static inline uint32_t co_patch_edge_of(const CoPatchTable *table, uint32_t m, uint32_t i,
                                        uint32_t j)
{
    if (j == 0 || i == m)
        return j == 0 ? 0 : 1;
    if (table->is_triangular)
        return i == j ? 2 : 4;
    return j == m ? 2 : i == 0 ? 3 : 4;
}

// The point at (i, j) of a patch with m squares a side; in mixed tables settled.
static inline uint32_t co_patch_point(const CoPatchTable *table, const uint32_t *words, uint32_t m,
                                      uint32_t i, uint32_t j)
{
    bool on_i = i == 0 || i == m, on_j = j == 0 || j == m;
    if (on_i && on_j)
        return words[j ? (i ? 2 : 3) : (i ? 1 : 0)];
    uint32_t edge = co_patch_edge_of(table, m, i, j);
    if (edge == 4)
        return co_patch_inner_row(table, words, m, j) + i;
    uint32_t t = edge & 1u ? j : i;
    return co_patch_edge_point(words, edge, t >> co_patch_drop(table, words, edge));
}

// The three points of a triangle.
static inline void co_patch_triangle(const CoPatchTable *table, uint32_t tri, uint32_t out[3])
{
    uint32_t patch = co_patch_of(table, tri), i[3], j[3], room[CO_PATCH_WORDS];
    const uint32_t *words = co_patch_words(table, patch, room);
    if (co_patch_is_fan(table, words)) {
        for (int c = 0; c < 3; c++)
            out[c] = words[c];
        return;
    }
    uint32_t m = 1u << co_patch_shift(table, words);
    co_patch_corners(table, words, tri - co_patch_first_tri(table, patch), i, j);
    for (int c = 0; c < 3; c++)
        out[c] = co_patch_point(table, words, m, i[c], j[c]);
}

#endif
