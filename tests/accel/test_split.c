// Splits: both halves hold something, nothing is lost, boxes fit; wide ones split like small
// ones, with any number of threads. Also tests split_wide.c.

#include "base/parallel.h"
#include "build_prims.h"

static void check_halves(const CoBuildPrim *prims, const CoRange *range, const CoRange halves[2])
{
    assert_true(halves[0].count > 0 && halves[1].count > 0);
    assert_int_equal(halves[0].count + halves[1].count, range->count);
    assert_int_equal(halves[0].first, range->first);
    assert_int_equal(halves[1].first, range->first + halves[0].count);
    for (int i = 0; i < 2; i++) {
        CoBox box = prims_box(prims + halves[i].first, halves[i].count);
        assert_same_box(&box, &halves[i].box);
        assert_int_equal(halves[i].depth, range->depth + 1);
    }
}

static void halves_hold_everything(void **state)
{
    (void)state;
    const uint32_t counts[] = {2, 3, 4, 11, 12, 31, 33, 1000, 1500};
    static CoBuildPrim prims[1600];
    for (int kind = 0; kind < PRIM_KINDS; kind++) {
        for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
            for (uint32_t depth = 0; depth <= CO_SPLIT_DEPTH; depth += CO_SPLIT_DEPTH) {
                prims_fill(prims, 1600, (PrimKind)kind, c);
                CoRange range = {0, counts[c], depth, prims_box(prims, counts[c])}, halves[2];
                co_split_range(prims, &range, halves);
                check_halves(prims, &range, halves);
                assert_all_there(prims, counts[c]);
                // From a certain depth on both are of one size, wherever they lie.
                if (depth == CO_SPLIT_DEPTH || kind == PRIMS_IN_ONE_PLACE)
                    assert_int_equal(halves[0].count, counts[c] / 2);
            }
        }
    }
}

// What lies around the range stays.
static void neighbors_are_left_alone(void **state)
{
    (void)state;
    CoBuildPrim prims[300], before[300];
    prims_fill(prims, 300, PRIMS_ANYWHERE, 3);
    memcpy(before, prims, sizeof prims);
    CoRange range = {100, 77, 0, prims_box(prims + 100, 77)}, halves[2];
    co_split_range(prims, &range, halves);
    check_halves(prims, &range, halves);
    assert_memory_equal(prims, before, 100 * sizeof *prims);
    assert_memory_equal(prims + 177, before + 177, 123 * sizeof *prims);
}

static void two_heaps_are_told_apart(void **state)
{
    (void)state;
    CoBuildPrim prims[64];
    for (int axis = 0; axis < 3; axis++) {
        prims_fill(prims, 64, PRIMS_ANYWHERE, 9);
        for (uint32_t i = 0; i < 64; i++) {
            prims[i].lo[axis] += i % 4 ? 0.0f : 100.0f;
            prims[i].hi[axis] += i % 4 ? 0.0f : 100.0f;
        }
        CoRange range = {0, 64, 0, prims_box(prims, 64)}, halves[2];
        co_split_range(prims, &range, halves);
        assert_int_equal(halves[0].count, 48);
        for (uint32_t i = 0; i < 64; i++)
            assert_int_equal(prims[i].id % 4 == 0, i >= 48);
    }
}

// However many are on the wrong side, and wherever the blocks in which they are looked for end.
static void moving_parts_any_order(void **state)
{
    (void)state;
    enum {
        COUNT = 700
    };
    static CoBuildPrim prims[COUNT];
    Random random = {4};
    const CoSplit split = {.axis = 1, .origin = 0.0f, .scale = 1.0f, .edge = 0.5f};
    for (uint32_t count = 0; count <= COUNT; count += 1 + count / 3) {
        for (int kind = 0; kind < 5; kind++) {
            size_t left = 0;
            prims_fill(prims, count, PRIMS_IN_ONE_PLACE, 1);
            for (uint32_t i = 0; i < count; i++) {
                const bool sides[5] = {true, false, i % 2, i < count / 2,
                                       random_float(&random, 0.0f, 1.0f) < 0.1f};
                prims[i].lo[1] = prims[i].hi[1] = sides[kind] ? 1.0f : 0.0f;
                left += !sides[kind];
            }
            assert_int_equal(co_split_count(&split, prims, count), left);
            co_split_move(&split, prims, count, left);
            for (uint32_t i = 0; i < count; i++)
                assert_true(prims[i].lo[1] == (i < left ? 0.0f : 1.0f));
            assert_all_there(prims, count);
        }
    }
}

static void wide_splits_are_the_same_ones(void **state)
{
    (void)state;
    enum {
        COUNT = 40000
    };
    CoBuildPrim *small = malloc(COUNT * sizeof *small);
    CoBuildPrim *wide = malloc(COUNT * sizeof *wide), *first = malloc(COUNT * sizeof *first);
    for (int kind = 0; kind < PRIM_KINDS; kind++) {
        prims_fill(small, COUNT, (PrimKind)kind, 1);
        CoRange range = {0, COUNT, 0, prims_box(small, COUNT)}, want[2], got[2];
        co_split_range(small, &range, want);
        for (uint32_t workers = 1; workers <= 8; workers *= 2) {
            co_worker_count_set(workers);
            CoWideSplit *split = co_wide_split_create(COUNT, workers);
            assert_non_null(split);
            prims_fill(wide, COUNT, (PrimKind)kind, 1);
            CoBox box = co_wide_split_box(split, wide, COUNT);
            assert_same_box(&box, &range.box);
            co_wide_split_range(split, wide, &range, got);
            co_wide_split_destroy(split);
            check_halves(wide, &range, got);
            assert_all_there(wide, COUNT);
            assert_int_equal(got[0].count, want[0].count);
            assert_same_box(&got[0].box, &want[0].box);
            assert_same_box(&got[1].box, &want[1].box);
            if (workers == 1)
                memcpy(first, wide, COUNT * sizeof *wide);
            assert_memory_equal(first, wide, COUNT * sizeof *wide);
        }
    }
    co_worker_count_set(0);
    free(small);
    free(wide);
    free(first);
}

static void no_memory_is_no_split(void **state)
{
    (void)state;
    size_t live = co_memory_live(CO_MEMORY_ACCEL);
    uint64_t n = 0;
    for (CoWideSplit *split = NULL; !split && n < 20;) {
        co_memory_fail_after(++n);
        split = co_wide_split_create(100000, 2);
        co_memory_fail_after(0);
        assert_true(split || co_memory_live(CO_MEMORY_ACCEL) == live);
        co_wide_split_destroy(split);
        if (split)
            break;
    }
    assert_in_range(n, 3, 19);
    assert_int_equal(co_memory_live(CO_MEMORY_ACCEL), live);
    co_wide_split_destroy(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(halves_hold_everything),        cmocka_unit_test(neighbors_are_left_alone),
        cmocka_unit_test(two_heaps_are_told_apart),      cmocka_unit_test(moving_parts_any_order),
        cmocka_unit_test(wide_splits_are_the_same_ones), cmocka_unit_test(no_memory_is_no_split),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
