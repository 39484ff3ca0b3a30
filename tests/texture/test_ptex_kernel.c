// Kernels: whatever is done to one, its weight stays, and rotations undo each other.

#include "texture/ptex_kernel.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static CoPtexKernel sample(void)
{
    return (CoPtexKernel){.ulog2 = 3,
                          .vlog2 = 2,
                          .u = -1,
                          .v = 2,
                          .uw = 3,
                          .vw = 3,
                          .ku = {.25f, .5f, 1},
                          .kv = {.125f, 2, .75f}};
}

static void axes_sum_to_their_filters(void **state)
{
    (void)state;
    float weights[CO_PTEX_KERNEL_MOST];
    int log2, start;
    for (int i = 0; i <= 100; i++) {
        for (float w = 0; w < 2; w = w == 0 ? 1e-6f : 1.7f * w) {
            float u = (float)i / 100;
            assert_int_equal(co_ptex_bilinear(u, w, 5, &log2, &start, weights), 2);
            assert_true(log2 >= 0 && log2 <= 5);
            assert_true(fabsf(weights[0] + weights[1] - 1) < 1e-6f);
            int count = co_ptex_box(u, w, 5, &log2, &start, weights);
            assert_true(count >= 1 && count <= 3 && log2 <= 5);
            float sum = 0, width = w < 1.0f / 32 ? 1.0f / 32 : w > 1 ? 1 : w;
            for (int k = 0; k < count; k++)
                sum += weights[k];
            assert_true(fabsf(sum - width * (float)(1 << log2)) < 1e-5f);
            // Its first moment is where it was asked for.
            float center = 0, begin = u * (float)(1 << log2) - sum / 2;
            for (int k = 0; k < count; k++)
                center += weights[k];
            assert_true(begin >= (float)start - 1e-4f &&
                        begin + center <= (float)(start + count) + 1e-4f);
        }
    }
    co_ptex_bilinear(.5f, NAN, 5, &log2, &start, weights);
    assert_int_equal(log2, 0);
}

static void splits_and_merges_keep_the_weight(void **state)
{
    (void)state;
    CoPtexKernel whole = sample(), rest = whole, part;
    float weight = co_ptex_weight(&whole);
    co_ptex_split(&rest, CO_PTEX_LEFT, &part);
    assert_int_equal(part.u, 7); // the last column of the neighbor
    assert_int_equal(part.uw, 1);
    assert_int_equal(rest.u, 0);
    assert_true(fabsf(co_ptex_weight(&rest) + co_ptex_weight(&part) - weight) < 1e-6f);
    rest = whole;
    co_ptex_split(&rest, CO_PTEX_TOP, &part);
    assert_int_equal(part.v, 0);
    assert_int_equal(part.vw, 1);
    assert_true(part.kv[0] == .75f);
    CoPtexKernel merged = whole;
    co_ptex_merge(&merged, CO_PTEX_LEFT, false);
    assert_true(fabsf(co_ptex_weight(&merged) - weight) < 1e-6f);
    assert_true(merged.u == 0 && merged.uw == 2 && merged.ku[0] == .75f);
    co_ptex_merge(&whole, CO_PTEX_TOP, true);
    assert_true(co_ptex_weight(&whole) < weight && whole.vw == 2);
    // A kernel wholly beyond the edge moves as it is.
    CoPtexKernel beyond = sample();
    beyond.u = 9;
    co_ptex_split(&beyond, CO_PTEX_RIGHT, &part);
    assert_true(beyond.uw == 0 && part.u == 1 && part.uw == 3);
    beyond.uw = 3;
    beyond.u = 9;
    co_ptex_merge(&beyond, CO_PTEX_RIGHT, true);
    assert_int_equal(beyond.uw, 0);
}

static void four_quarter_turns_are_none(void **state)
{
    (void)state;
    for (int turns = 0; turns < 4; turns++) {
        CoPtexKernel kernel = sample(), before = kernel;
        co_ptex_rotate(&kernel, turns);
        assert_int_equal(kernel.rotation, turns);
        assert_true(co_ptex_weight(&kernel) == co_ptex_weight(&before));
        co_ptex_rotate(&kernel, -turns);
        assert_true(kernel.u == before.u && kernel.v == before.v && kernel.ulog2 == before.ulog2);
        assert_memory_equal(kernel.ku, before.ku, 3 * sizeof(float));
        assert_memory_equal(kernel.kv, before.kv, 3 * sizeof(float));
        assert_int_equal(kernel.rotation, 0);
    }
}

static void resolutions_change_without_losing_weight(void **state)
{
    (void)state;
    CoPtexKernel kernel = sample();
    float weight = co_ptex_weight(&kernel);
    co_ptex_coarsen_u(&kernel); // texels -1 | 0 1 become -1 and 0
    assert_true(kernel.u == -1 && kernel.uw == 2 && kernel.ulog2 == 2);
    assert_true(kernel.ku[0] == .25f && kernel.ku[1] == 1.5f);
    co_ptex_coarsen_v(&kernel); // 2 3 | 4
    assert_true(kernel.v == 1 && kernel.vw == 2 && kernel.kv[0] == 2.125f);
    assert_true(co_ptex_weight(&kernel) == weight);
    co_ptex_refine_u(&kernel);
    co_ptex_refine_v(&kernel);
    assert_true(kernel.uw == 4 && kernel.vw == 4 && kernel.u == -2 && kernel.v == 2);
    assert_true(co_ptex_weight(&kernel) == weight);
    CoPtexKernel symmetric = sample();
    float now = co_ptex_make_symmetric(&symmetric, weight);
    assert_true(symmetric.ulog2 == symmetric.vlog2 && symmetric.uw == symmetric.vw);
    assert_true(fabsf(co_ptex_weight(&symmetric) - now) < 1e-5f);
}

static void zero_weights_are_stripped(void **state)
{
    (void)state;
    CoPtexKernel kernel = {.uw = 4, .vw = 2, .ku = {0, 0, 3, 0}, .kv = {0, 0}};
    co_ptex_strip_zeros(&kernel);
    assert_true(kernel.u == 2 && kernel.uw == 1 && kernel.ku[0] == 3);
    assert_int_equal(kernel.vw, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(axes_sum_to_their_filters),
        cmocka_unit_test(splits_and_merges_keep_the_weight),
        cmocka_unit_test(four_quarter_turns_are_none),
        cmocka_unit_test(resolutions_change_without_losing_weight),
        cmocka_unit_test(zero_weights_are_stripped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
