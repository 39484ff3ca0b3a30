// Plans of blocks: their triangles are those of the patches, each once.

#include "accel/grid_plan.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

enum {
    PATCHES = 3
};

// A point of a plan, as kernels find it (co_lane_along).
static uint32_t plan_point(const CoGridPlan *plan, const uint32_t *words, uint32_t k)
{
    const uint32_t word = words[plan->word[k]];
    return co_patch_word_point(word, plan->step[k]);
}

static uint32_t corner_of(const CoGridPlan *plan, uint32_t c, uint32_t i)
{
    return (uint32_t)plan->corner[c * plan->count / 2 + i / 2] >> 4 * (i & 1u) & 15u;
}

// Number of triangle i in the patch.
static int32_t triangle_of(const CoGridPlan *plan, int32_t i)
{
    const int32_t half = plan->count / 2;
    if (plan->rows == CO_GRID_ROWS_EVEN)
        return i < half ? plan->first[0] + i : plan->first[1] + i - half;
    const CoGridRows rows = plan->rows;
    uint32_t q = 0;
    while (q < 3 && (int32_t)co_grid_row_start(rows, q + 1) <= i)
        q++;
    return plan->first[q] + i - (int32_t)co_grid_row_start(rows, q);
}

// Checks the triangles of a plan for a patch whose words, or whose face's, these are; counts them.
static void check_plan(const CoPatchTable *table, const CoGridPlan *plan, const uint32_t *words,
                       uint32_t patch, uint8_t *seen)
{
    for (uint32_t i = 0; i < plan->count; i++) {
        if (!(plan->valid >> i & 1u))
            continue;
        const int32_t own = triangle_of(plan, (int32_t)i);
        const uint32_t tri = (patch << table->unit_shift) + (uint32_t)own;
        uint32_t want[3];
        assert_true(own >= 0 && own < 1 << table->unit_shift);
        co_patch_triangle(table, tri, want);
        for (uint32_t c = 0; c < 3; c++)
            assert_int_equal(plan_point(plan, words, corner_of(plan, c, i)), want[c]);
        seen[tri]++;
    }
}

static void assert_all_seen(const CoPatchTable *table, const uint8_t *seen)
{
    for (uint32_t tri = 0; tri < table->count << table->unit_shift; tri++)
        assert_int_equal(seen[tri], 1);
}

// Words of patches, every other run backwards.
static void fill_words(uint32_t *words, size_t count)
{
    for (size_t k = 0; k < count; k++) {
        uint32_t first = 1000 * (uint32_t)(k + 1);
        words[k] = k % 2 ? CO_PATCH_FLAG | first : first;
    }
}

static void blocks_of_quads(void **state)
{
    (void)state;
    for (uint32_t level = 1; level <= 3; level++) {
        uint32_t words[PATCHES * CO_PATCH_WORDS], blocks = level == 3 ? 8 : level;
        uint8_t seen[PATCHES << 7] = {0};
        fill_words(words, PATCHES * CO_PATCH_WORDS);
        CoPatchTable table = {.level = level,
                              .count = PATCHES,
                              .stride = CO_PATCH_WORDS,
                              .words = words,
                              .unit_shift = 2 * level + 1};
        for (uint32_t patch = 0; patch < PATCHES; patch++) {
            uint32_t *own = words + patch * CO_PATCH_WORDS;
            for (uint32_t k = 0; k < 9; k++) // corners and the inside have no direction
                own[k] &= k < 4 || k == CO_PATCH_INNER ? ~CO_PATCH_FLAG : UINT32_MAX;
            for (uint32_t b = 0; b < blocks; b++)
                check_plan(&table, &co_grid_plans(&table)[b], own, patch, seen);
        }
        assert_all_seen(&table, seen);
    }
}

static void blocks_of_triangles(void **state)
{
    (void)state;
    for (uint32_t level = 2; level <= 3; level++) {
        uint32_t words[PATCHES * CO_PATCH_WORDS_TRIANGULAR + 2];
        uint8_t seen[PATCHES << 6] = {0};
        fill_words(words, PATCHES * CO_PATCH_WORDS_TRIANGULAR);
        CoPatchTable table = {.level = level,
                              .is_triangular = true,
                              .count = PATCHES,
                              .stride = CO_PATCH_WORDS_TRIANGULAR,
                              .words = words,
                              .unit_shift = 2 * level};
        for (uint32_t patch = 0; patch < PATCHES; patch++) {
            uint32_t *own = words + patch * CO_PATCH_WORDS_TRIANGULAR;
            for (uint32_t k = 0; k <= CO_PATCH_INNER_TRIANGULAR; k++)
                own[k] &= ~CO_PATCH_FLAG;
            for (uint32_t b = 0; b < (level == 3 ? 4 : 1); b++)
                check_plan(&table, &co_grid_plans(&table)[b], own, patch, seen);
        }
        assert_all_seen(&table, seen);
    }
}

// The points of the second patch of a pair stand from 8 on.
static void pairs_of_triangles(void **state)
{
    (void)state;
    uint32_t words[2 * CO_PATCH_WORDS_TRIANGULAR + 2];
    fill_words(words, 2 * CO_PATCH_WORDS_TRIANGULAR);
    for (uint32_t k = 0; k < 2 * CO_PATCH_WORDS_TRIANGULAR; k++)
        words[k] &= k % CO_PATCH_WORDS_TRIANGULAR <= 3 ? ~CO_PATCH_FLAG : UINT32_MAX;
    CoPatchTable table = {.level = 1,
                          .is_triangular = true,
                          .count = 2,
                          .stride = CO_PATCH_WORDS_TRIANGULAR,
                          .words = words,
                          .unit_shift = 2};
    const CoGridPlan *plan = co_grid_plans(&table);
    for (uint32_t tri = 0; tri < 8; tri++) {
        uint32_t want[3];
        co_patch_triangle(&table, tri, want);
        for (uint32_t c = 0; c < 3; c++) {
            const uint32_t k = corner_of(plan, c, tri);
            assert_int_equal(k / 8, tri / 4);
            const uint32_t *own = words + k / 8 * CO_PATCH_WORDS_TRIANGULAR;
            assert_int_equal(plan_point(plan, own, k % 8), want[c]);
        }
    }
}

static void blocks_of_split_triangles(void **state)
{
    (void)state;
    enum {
        STRIDE = 7
    };
    for (uint32_t level = 1; level <= 3; level++) {
        uint32_t words[2 * STRIDE + 2], blocks = level == 3 ? 8 : level;
        uint8_t seen[6 << 7] = {0};
        fill_words(words, 2 * STRIDE);
        CoPatchTable table = {.level = level,
                              .count = 6,
                              .stride = STRIDE,
                              .fold = 3,
                              .words = words,
                              .unit_shift = 2 * level + 1};
        for (uint32_t patch = 0; patch < 6; patch++) {
            uint32_t *own = words + patch / 3 * STRIDE;
            for (uint32_t k = 0; k < STRIDE; k++)
                own[k] &= k < 3 || k == 6 ? ~CO_PATCH_FLAG : UINT32_MAX;
            for (uint32_t b = 0; b < blocks; b++)
                check_plan(&table, &co_grid_plans(&table)[patch % 3 * blocks + b], own, patch,
                           seen);
        }
        assert_all_seen(&table, seen);
    }
}

static void others_have_none(void **state)
{
    (void)state;
    const uint32_t first[] = {0, 2};
    const CoPatchTable tables[] = {{.level = 0},
                                   {.level = 4},
                                   {.level = 2, .is_mixed = true},
                                   {.level = 2, .first_tri = first}};
    for (size_t k = 0; k < sizeof tables / sizeof *tables; k++)
        assert_null(co_grid_plans(&tables[k]));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_of_quads),    cmocka_unit_test(blocks_of_triangles),
        cmocka_unit_test(pairs_of_triangles), cmocka_unit_test(blocks_of_split_triangles),
        cmocka_unit_test(others_have_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
