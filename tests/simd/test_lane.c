// Lanes: each operation of each instruction set gives the bits of the scalar one, edges included.

#include "base/hash.h"
#include "lane_calls.h"
#include "simd/isa.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const float edges[16] = {0.0f,      -0.0f,   1.0f,     -1.0f,   NAN,    INFINITY,
                                -INFINITY, FLT_MAX, -FLT_MAX, FLT_MIN, 1e-45f, -1e-45f,
                                1e-40f,    0.1f,    3.0f,     -1e30f};

// NaNs may differ in sign and payload; everything else may not.
static bool same(float x, float y)
{
    return (isnan(x) && isnan(y)) || memcmp(&x, &y, sizeof x) == 0;
}

static void lanes_equal_the_scalar_ones(void **state)
{
    (void)state;
    enum {
        COUNT = 256 // all pairs of edges
    };
    float a[COUNT], b[COUNT];
    uint8_t index[COUNT];
    for (int i = 0; i < COUNT; i++) {
        a[i] = edges[i / 16];
        b[i] = edges[i % 16];
        index[i] = (uint8_t)(i * 5 + i / 8);
    }
    float *expected = malloc(LANE_CALL_COUNT * COUNT * sizeof(float));
    float *got = malloc(LANE_CALL_COUNT * COUNT * sizeof(float));
    lane_calls_scalar(a, b, index, COUNT, expected);
    assert_true(expected[4 * COUNT + 2 * 16 + 4] !=
                expected[4 * COUNT + 2 * 16 + 4]);         // min(1, NaN)
    assert_true(expected[4 * COUNT + 4 * 16 + 2] == 1.0f); // min(NaN, 1)
#if defined(__x86_64__)
    LaneCalls *const calls[CO_ISA_COUNT] = {lane_calls_scalar, lane_calls_sse42, lane_calls_avx2,
                                            lane_calls_avx512};
    for (int isa = 1; isa < CO_ISA_COUNT; isa++) {
        if (!(co_isa_flags() >> isa & 1u))
            continue;
        memset(got, 0x77, LANE_CALL_COUNT * COUNT * sizeof(float));
        calls[isa](a, b, index, COUNT, got);
        for (int i = 0; i < LANE_CALL_COUNT * COUNT; i++) {
            if (!same(expected[i], got[i]))
                print_error("%s operation %d of (%a, %a): %a, not %a\n", co_isa_name((CoIsa)isa),
                            i / COUNT, (double)a[i % COUNT], (double)b[i % COUNT], (double)got[i],
                            (double)expected[i]);
            assert_true(same(expected[i], got[i]));
        }
    }
#endif
    free(expected);
    free(got);
}

// All pairs of edges, then floats of any bits; a few at a time, so that a third can be any as well.
static void fill(float *a, float *b, float *c, int count)
{
    for (int i = 0; i < count; i++) {
        uint32_t bits[3];
        for (uint32_t k = 0; k < 3; k++)
            bits[k] = (uint32_t)(co_hash64((uint64_t)i * 3 + k) >> 32);
        memcpy(&a[i], &bits[0], 4);
        memcpy(&b[i], &bits[1], 4);
        memcpy(&c[i], &bits[2], 4);
        if (i < 256) {
            a[i] = edges[i / 16];
            b[i] = edges[i % 16];
            c[i] = edges[(i * 7) % 16];
        }
    }
}

// What a muladd may give: the product rounded or not.
static bool is_muladd(float got, float a, float b, float c)
{
    volatile float product = a * b;
    return same(got, product + c) || same(got, fmaf(a, b, c));
}

static void wide_vectors_equal_the_scalar_ones(void **state)
{
    (void)state;
    enum {
        COUNT = 4096
    };
    static float a[COUNT], b[COUNT], c[COUNT];
    static float expected[WIDE_CALL_COUNT * COUNT], got[WIDE_CALL_COUNT * COUNT];
    fill(a, b, c, COUNT);
    wide_calls_scalar(a, b, c, COUNT, expected);
#if defined(__x86_64__)
    WideCalls *const calls[CO_ISA_COUNT] = {wide_calls_scalar, wide_calls_sse42, wide_calls_avx2,
                                            wide_calls_avx512};
    for (int isa = 0; isa < CO_ISA_COUNT; isa++) {
        if (!(co_isa_flags() >> isa & 1u))
            continue;
        memset(got, 0x77, sizeof got);
        calls[isa](a, b, c, COUNT, got);
        for (int i = 0; i < WIDE_CALL_COUNT * COUNT; i++) {
            int at = i % COUNT;
            bool is_good = i / COUNT == WIDE_CALL_COUNT - 1 ? is_muladd(got[i], a[at], b[at], c[at])
                                                            : same(expected[i], got[i]);
            if (!is_good)
                print_error("%s operation %d of (%a, %a, %a): %a\n", co_isa_name((CoIsa)isa),
                            i / COUNT, (double)a[at], (double)b[at], (double)c[at], (double)got[i]);
            assert_true(is_good);
        }
    }
#endif
    // The scalar ones are what C says.
    for (int i = 0; i < COUNT; i++) {
        assert_true(same(expected[i], a[i] + b[i]));
        assert_true(same(expected[3 * COUNT + i], a[i] / b[i]));
        assert_true(same(expected[4 * COUNT + i], a[i] < b[i] ? a[i] : b[i]));
        assert_true(same(expected[7 * COUNT + i], copysignf(a[i], b[i])));
        assert_true(expected[10 * COUNT + i] == (float)(a[i] != b[i]));
        volatile float product = a[i] * b[i];
        assert_true(same(expected[15 * COUNT + i], fmaf(a[i], b[i], -product)));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(lanes_equal_the_scalar_ones),
                                       cmocka_unit_test(wide_vectors_equal_the_scalar_ones)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
