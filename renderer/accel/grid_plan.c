#include "accel/grid_plan.h"

#include <stddef.h>

// ---- Quads: grid point (i, j) of a patch with m squares a side ---------------------------------

#define QUAD_EDGE(m, i, j) ((j) == 0 ? 4 : (i) == (m) ? 5 : (j) == (m) ? 6 : (i) == 0 ? 7 : 8)
#define QUAD_IS_CORNER(m, i, j) (((i) == 0 || (i) == (m)) && ((j) == 0 || (j) == (m)))
#define QUAD_CORNER(i, j) ((j) ? ((i) ? 2 : 3) : ((i) ? 1 : 0))
#define QUAD_WORD(m, i, j) (QUAD_IS_CORNER(m, i, j) ? QUAD_CORNER(i, j) : QUAD_EDGE(m, i, j))
#define QUAD_INNER(m, i, j) (((j)-1) * ((m)-1) + (i)-1)
#define QUAD_ALONG(m, i, j) \
    (QUAD_EDGE(m, i, j) == 8 ? QUAD_INNER(m, i, j) : QUAD_EDGE(m, i, j) % 2 ? (j) : (i))
#define QUAD_STEP(m, i, j) (QUAD_IS_CORNER(m, i, j) ? 0 : QUAD_ALONG(m, i, j))

// ---- Triangles: what lies beyond the diagonal is not asked for ---------------------------------

#define TRI_EDGE(m, i, j) ((j) == 0 ? 4 : (i) == (m) ? 5 : (i) <= (j) ? 6 : 3)
#define TRI_IS_CORNER(m, i, j) ((i) == 0 || (j) >= (m) || ((i) == (m) && (j) == 0))
#define TRI_CORNER(m, i, j) ((i) == 0 ? 0 : (j) == 0 ? 1 : 2)
#define TRI_WORD(m, i, j) (TRI_IS_CORNER(m, i, j) ? TRI_CORNER(m, i, j) : TRI_EDGE(m, i, j))
#define TRI_INNER(m, i, j) (((j)-1) * (2 * (m)-2 - (j)) / 2 - (j)-1 + (i))
#define TRI_ALONG(m, i, j) \
    (TRI_EDGE(m, i, j) == 3 ? TRI_INNER(m, i, j) : TRI_EDGE(m, i, j) == 5 ? (j) : (i))
#define TRI_STEP(m, i, j) (TRI_IS_CORNER(m, i, j) ? 0 : TRI_ALONG(m, i, j))

// ---- Patch k of a triangle, from the words of its face, see co_patch_unfold -------------------

#define LAST(k) (((k) + 2) % 3)
#define SPOKE(m) ((m)-1)
#define FOLD_IS_CENTER(m, i, j) ((i) != 0 && (j) != 0)
#define FOLD_WORD(m, k, i, j) \
    ((i) == 0 && (j) == 0 ? (k) : FOLD_IS_CENTER(m, i, j) ? 6 : (j) == 0 ? 3 + (k) : 3 + LAST(k))
#define FOLD_INNER(m, k, i, j) \
    (1 + 3 * SPOKE(m) + (k)*SPOKE(m) * SPOKE(m) + ((j)-1) * SPOKE(m) + (i)-1)
#define FOLD_STEP(m, k, i, j) \
    ((i) == 0 && (j) == 0       ? 0 \
     : (j) == 0                 ? (i) \
     : (i) == 0                 ? 2 * (m) - (j) \
     : (i) == (m) && (j) == (m) ? 0 \
     : (i) == (m)               ? (k)*SPOKE(m) + (j) \
     : (j) == (m)               ? LAST(k) * SPOKE(m) + (i) \
                                : FOLD_INNER(m, k, i, j))

// ---- Blocks ------------------------------------------------------------------------------------

// clang-format off
#define BYTE(F, m, i, j) (uint8_t)(F(m, i, j))
#define ROW2(F, m, i, j) BYTE(F, m, i, j), BYTE(F, m, i + 1, j)
#define ROW3(F, m, i, j) ROW2(F, m, i, j), BYTE(F, m, i + 2, j)
#define ROW4(F, m, i, j) ROW3(F, m, i, j), BYTE(F, m, i + 3, j)
#define ROW5(F, m, i, j) ROW4(F, m, i, j), BYTE(F, m, i + 4, j)
#define ROWS3(F, m) {ROW3(F, m, 0, 0), ROW3(F, m, 0, 1), ROW3(F, m, 0, 2)}
#define ROWS5(F, m, i, j) {ROW5(F, m, i, j), ROW5(F, m, i, j + 1), ROW5(F, m, i, j + 2)}

// 2 x 2 squares, 3 points a row.
#define NARROW {0x00, 0x11, 0x33, 0x44, 0x41, 0x52, 0x74, 0x85, 0x34, 0x45, 0x67, 0x78}
// 4 x 2, 5 a row.
#define BROAD {0x00, 0x11, 0x22, 0x33, 0x55, 0x66, 0x77, 0x88, 0x61, 0x72, 0x83, 0x94, \
               0xb6, 0xc7, 0xd8, 0xe9, 0x56, 0x67, 0x78, 0x89, 0xab, 0xbc, 0xcd, 0xde}

#define QUAD_PLAN(m, i, j) \
    {ROWS5(QUAD_WORD, m, i, j), ROWS5(QUAD_STEP, m, i, j), BROAD, \
     {2 * ((m) * (j) + (i)), 2 * ((m) * ((j) + 1) + (i))}, 16, 0, 0xffff}

static const CoGridPlan quads_1[] = {
    {ROWS3(QUAD_WORD, 2), ROWS3(QUAD_STEP, 2), NARROW, {0, 4}, 8, 0, 0xff}};
static const CoGridPlan quads_2[] = {QUAD_PLAN(4, 0, 0), QUAD_PLAN(4, 0, 2)};
static const CoGridPlan quads_3[] = {
    QUAD_PLAN(8, 0, 0), QUAD_PLAN(8, 4, 0), QUAD_PLAN(8, 0, 2), QUAD_PLAN(8, 4, 2),
    QUAD_PLAN(8, 0, 4), QUAD_PLAN(8, 4, 4), QUAD_PLAN(8, 0, 6), QUAD_PLAN(8, 4, 6)};

// By patch of the face.
#define FOLD_BYTE(F, m, k, i, j) (uint8_t)(F(m, k, i, j))
#define FOLD3(F, m, k, j) \
    FOLD_BYTE(F, m, k, 0, j), FOLD_BYTE(F, m, k, 1, j), FOLD_BYTE(F, m, k, 2, j)
#define FOLDS3(F, m, k) {FOLD3(F, m, k, 0), FOLD3(F, m, k, 1), FOLD3(F, m, k, 2)}
#define FOLD5(F, m, k, i, j) FOLD_BYTE(F, m, k, i, j), FOLD_BYTE(F, m, k, i + 1, j), \
    FOLD_BYTE(F, m, k, i + 2, j), FOLD_BYTE(F, m, k, i + 3, j), FOLD_BYTE(F, m, k, i + 4, j)
#define FOLDS5(F, m, k, i, j) {FOLD5(F, m, k, i, j), FOLD5(F, m, k, i, j + 1), \
    FOLD5(F, m, k, i, j + 2)}
#define SMALL_FOLD_PLAN(k) \
    {FOLDS3(FOLD_WORD, 2, k), FOLDS3(FOLD_STEP, 2, k), NARROW, {0, 4}, 8, 0, 0xff}
#define FOLD_PLAN(m, k, i, j) \
    {FOLDS5(FOLD_WORD, m, k, i, j), FOLDS5(FOLD_STEP, m, k, i, j), BROAD, \
     {2 * ((m) * (j) + (i)), 2 * ((m) * ((j) + 1) + (i))}, 16, 0, 0xffff}
#define FOLD_PAIR(k) FOLD_PLAN(4, k, 0, 0), FOLD_PLAN(4, k, 0, 2)
#define FOLD_TILE(k) \
    FOLD_PLAN(8, k, 0, 0), FOLD_PLAN(8, k, 4, 0), FOLD_PLAN(8, k, 0, 2), FOLD_PLAN(8, k, 4, 2), \
    FOLD_PLAN(8, k, 0, 4), FOLD_PLAN(8, k, 4, 4), FOLD_PLAN(8, k, 0, 6), FOLD_PLAN(8, k, 4, 6)
static const CoGridPlan folds_1[] = {SMALL_FOLD_PLAN(0), SMALL_FOLD_PLAN(1), SMALL_FOLD_PLAN(2)};
static const CoGridPlan folds_2[] = {FOLD_PAIR(0), FOLD_PAIR(1), FOLD_PAIR(2)};
static const CoGridPlan folds_3[] = {FOLD_TILE(0), FOLD_TILE(1), FOLD_TILE(2)};

// 4 triangles over 6 points, row by row, in a block of two patches.
static const CoGridPlan triangles_1[] = {
    {{ROW3(TRI_WORD, 2, 0, 0), ROW2(TRI_WORD, 2, 1, 1), BYTE(TRI_WORD, 2, 2, 2)},
     {ROW3(TRI_STEP, 2, 0, 0), ROW2(TRI_STEP, 2, 1, 1), BYTE(TRI_STEP, 2, 2, 2)},
     {0x10, 0x31, 0x98, 0xb9, 0x41, 0x42, 0xc9, 0xca, 0x33, 0x54, 0xbb, 0xdc}, {0, 4}, 8, 0, 0xff}};
// 16 triangles over 15 points, row by row, from corner (i, j) on: upright and, of a row one more
// than of that before it, inverted.
#define TRI_ROW(m, j) ((m) * (m) - ((m) - (j)) * ((m) - (j)))
#define UPRIGHT_POINTS(F, m, i, j) \
    {ROW5(F, m, i, j), ROW4(F, m, (i) + 1, (j) + 1), ROW3(F, m, (i) + 2, (j) + 2), \
     ROW2(F, m, (i) + 3, (j) + 3), BYTE(F, m, (i) + 4, (j) + 4)}
#define INVERTED_POINTS(F, m, i, j) \
    {BYTE(F, m, i, j), ROW2(F, m, i, (j) + 1), ROW3(F, m, i, (j) + 2), ROW4(F, m, i, (j) + 3), \
     ROW5(F, m, i, (j) + 4)}
#define UPRIGHT {0x10, 0x21, 0x32, 0x53, 0x66, 0x77, 0xa9, 0xca, 0x61, 0x72, 0x83, 0x64, \
                 0x7a, 0x8b, 0xda, 0xdb, 0x55, 0x66, 0x77, 0x98, 0xa9, 0xba, 0xcc, 0xed}
#define INVERTED {0x10, 0x21, 0x33, 0x44, 0x65, 0x76, 0x87, 0x98, 0x42, 0x52, 0x47, 0x58, \
                  0xb9, 0xc7, 0xd8, 0xe9, 0x31, 0x44, 0x76, 0x87, 0xa8, 0xbb, 0xcc, 0xdd}
#define UPRIGHT_FIRST(m, i, j, q) (TRI_ROW(m, (j) + (q)) + 2 * ((i) - (j)))
#define INVERTED_FIRST(m, i, j, q) (TRI_ROW(m, (j) + (q)) + 2 * ((i) - (j) - (q)) - 1)
#define FIRSTS(F, m, i, j) {F(m, i, j, 0), F(m, i, j, 1), F(m, i, j, 2), F(m, i, j, 3)}
#define UPRIGHT_PLAN(m, i, j) \
    {UPRIGHT_POINTS(TRI_WORD, m, i, j), UPRIGHT_POINTS(TRI_STEP, m, i, j), UPRIGHT, \
     FIRSTS(UPRIGHT_FIRST, m, i, j), 16, CO_GRID_ROWS_UPRIGHT, 0xffff}
#define INVERTED_PLAN(m, i, j) \
    {INVERTED_POINTS(TRI_WORD, m, i, j), INVERTED_POINTS(TRI_STEP, m, i, j), INVERTED, \
     FIRSTS(INVERTED_FIRST, m, i, j), 16, CO_GRID_ROWS_INVERTED, 0xffff}
static const CoGridPlan triangles_2[] = {
    {UPRIGHT_POINTS(TRI_WORD, 4, 0, 0), UPRIGHT_POINTS(TRI_STEP, 4, 0, 0), UPRIGHT, {0, 8}, 16, 0,
     0xffff}};
static const CoGridPlan triangles_3[] = {UPRIGHT_PLAN(8, 0, 0), UPRIGHT_PLAN(8, 4, 0),
                                         UPRIGHT_PLAN(8, 4, 4), INVERTED_PLAN(8, 4, 0)};
// clang-format on

const CoGridPlan *co_grid_plans(const CoPatchTable *table)
{
    const CoGridPlan *const quads[] = {NULL, quads_1, quads_2, quads_3};
    const CoGridPlan *const triangles[] = {NULL, triangles_1, triangles_2, triangles_3};
    const CoGridPlan *const folds[] = {NULL, folds_1, folds_2, folds_3};
    if (table->is_mixed || table->first_tri || table->level > 3)
        return NULL;
    const CoGridPlan *const *by_level = table->fold            ? folds
                                        : table->is_triangular ? triangles
                                                               : quads;
    return by_level[table->level];
}
