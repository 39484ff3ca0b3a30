// Lanes: each operation of each instruction set gives the bits of the scalar one, edges included.

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
    float a[COUNT], b[COUNT], table[8];
    uint8_t index[COUNT];
    for (int i = 0; i < COUNT; i++) {
        a[i] = edges[i / 16];
        b[i] = edges[i % 16];
        index[i] = (uint8_t)(i * 5 + i / 8);
        table[i % 8] = edges[i % 8];
    }
    float *expected = malloc(LANE_CALL_COUNT * COUNT * sizeof(float));
    float *got = malloc(LANE_CALL_COUNT * COUNT * sizeof(float));
    lane_calls_scalar(a, b, table, index, COUNT, expected);
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
        calls[isa](a, b, table, index, COUNT, got);
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

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(lanes_equal_the_scalar_ones)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
