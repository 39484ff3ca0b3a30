// Sample sequences: the table, stratification, uniformity, independence of what must be
// independent, and the rate at which an integral converges.

#include "sample/sample.h"
#include "sample/sobol_table.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static uint32_t reversed(uint32_t x)
{
    uint32_t r = 0;
    for (int i = 0; i < 32; i++)
        r |= ((x >> i) & 1u) << (31 - i);
    return r;
}

// Direction numbers of dimension d from its primitive polynomial: degree s, inner coefficients a.
static void directions(int d, uint32_t v[32])
{
    static const int degree[4] = {0, 1, 2, 3};
    static const uint32_t inner[4] = {0, 0, 1, 1};
    static const uint32_t first[4][3] = {{1, 1, 1}, {1, 0, 0}, {1, 3, 0}, {1, 3, 1}};
    int s = degree[d];
    for (int i = 0; i < 32; i++) {
        if (d == 0 || i < s) {
            v[i] = first[d][d == 0 ? 0 : i] << (31 - i);
            continue;
        }
        v[i] = v[i - s] ^ (v[i - s] >> s);
        for (int k = 1; k < s; k++)
            if ((inner[d] >> (s - 1 - k)) & 1u)
                v[i] ^= v[i - k];
    }
}

static void the_table_follows_from_the_polynomials(void **state)
{
    (void)state;
    for (int d = 0; d < 4; d++) {
        uint32_t v[32];
        directions(d, v);
        for (int bit = 0; bit < 32; bit++)
            assert_int_equal(sobol_table[bit / 4][1 << (bit % 4)][d], reversed(v[31 - bit]));
    }
    for (int i = 0; i < 8; i++)
        for (int v = 1; v < 16; v++)
            for (int d = 0; d < 4; d++)
                assert_int_equal(sobol_table[i][v][d],
                                 sobol_table[i][v & (v - 1)][d] ^ sobol_table[i][v & -v][d]);
}

// Points of one half-film: samples 2i + parity.
static void draw(uint32_t pixel, uint32_t parity, uint32_t i, float out[4])
{
    CoSampleKey key = {pixel, 2u * i + parity, 7u};
    co_sample(key, 2, 0, CO_DECISION_BSDF, 0, 1, 4, out);
}

static void each_dimension_is_stratified_at_powers_of_two(void **state)
{
    (void)state;
    for (uint32_t pixel = 0; pixel < 20; pixel++)
        for (uint32_t n = 1; n <= 1024; n *= 2) {
            unsigned char seen[4][1024];
            memset(seen, 0, sizeof seen);
            for (uint32_t i = 0; i < n; i++) {
                float u[4];
                draw(pixel, pixel & 1u, i, u);
                for (int d = 0; d < 4; d++) {
                    assert_true(u[d] >= 0.0f && u[d] < 1.0f);
                    seen[d][(int)(u[d] * (float)n)]++;
                }
            }
            for (int d = 0; d < 4; d++)
                for (uint32_t i = 0; i < n; i++)
                    assert_int_equal(seen[d][i], 1);
        }
}

// The first two dimensions are a (0, 2)-sequence: every elementary box of area 1/n holds one point.
static void the_first_pair_is_stratified_in_every_shape(void **state)
{
    (void)state;
    enum {
        LOG_N = 8,
        N = 1 << LOG_N
    };
    for (uint32_t pixel = 0; pixel < 20; pixel++)
        for (int shape = 0; shape <= LOG_N; shape++) {
            unsigned char seen[N] = {0};
            for (uint32_t i = 0; i < N; i++) {
                float u[4];
                draw(pixel, 0, i, u);
                int x = (int)(u[0] * (float)(1 << shape));
                int y = (int)(u[1] * (float)(1 << (LOG_N - shape)));
                seen[(x << (LOG_N - shape)) + y]++;
            }
            for (int i = 0; i < N; i++)
                assert_int_equal(seen[i], 1);
        }
}

static void branches_extend_the_sequence(void **state)
{
    (void)state;
    // 64 samples of one half times 4 branches are 256 strata.
    unsigned char seen[256] = {0};
    for (uint32_t s = 0; s < 128; s += 2)
        for (uint32_t branch = 0; branch < 4; branch++) {
            CoSampleKey key = {3, s, 0};
            float u;
            co_sample(key, 1, 0, CO_DECISION_LIGHT, branch, 4, 1, &u);
            seen[(int)(u * 256.0f)]++;
        }
    for (int i = 0; i < 256; i++)
        assert_int_equal(seen[i], 1);
}

// Chi-square over `bins` bins; the bound is 4.5 standard deviations of its normal limit.
static void assert_uniform(const uint32_t *count, int bins, uint32_t total)
{
    double expected = (double)total / bins, chi2 = 0.0;
    for (int i = 0; i < bins; i++)
        chi2 += ((double)count[i] - expected) * ((double)count[i] - expected) / expected;
    assert_true(chi2 < bins + 4.5 * sqrt(2.0 * bins));
}

static void the_first_sample_is_uniform_over_pixels(void **state)
{
    (void)state;
    enum {
        BINS = 256,
        N = 100000
    };
    for (int d = 0; d < 4; d++) {
        uint32_t count[BINS] = {0}, pair[BINS] = {0};
        for (uint32_t pixel = 0; pixel < N; pixel++) {
            float u[4], v[4];
            CoSampleKey key = {pixel, 0, 0};
            co_sample(key, 1, 0, CO_DECISION_BSDF, 0, 1, 4, u);
            co_sample(key, 2, 0, CO_DECISION_BSDF, 0, 1, 4, v);
            count[(int)(u[d] * BINS)]++;
            // Different vertices of a path, and different dimensions of a decision.
            pair[(int)(u[d] * 16) * 16 + (int)(v[d] * 16)]++;
        }
        assert_uniform(count, BINS, N);
        assert_uniform(pair, BINS, N);
    }
}

static void keys_that_differ_in_anything_are_independent(void **state)
{
    (void)state;
    enum {
        BINS = 256,
        N = 60000
    };
    for (int what = 0; what < 7; what++) {
        uint32_t pair[BINS] = {0};
        for (uint32_t pixel = 0; pixel < N; pixel++) {
            CoSampleKey a = {2u * pixel, 4u, 0}, b = a;
            b.pixel += what == 0 ? 1u : 0u;
            b.sample += what == 1 ? 1u : 0u; // the other half
            b.seed += what == 2 ? 1u : 0u;
            float u, v;
            co_sample(a, 1, 0, CO_DECISION_BSDF, 0, 1, 1, &u);
            co_sample(b, what == 3 ? 2u : 1u, what == 4 ? 1u : 0u,
                      what == 5 ? CO_DECISION_LIGHT : CO_DECISION_BSDF, 0, 1, 1, &v);
            if (what == 6)
                v = co_sample_hash(a, 1, 0);
            pair[(int)(u * 16) * 16 + (int)(v * 16)]++;
        }
        assert_uniform(pair, BINS, N);
    }
}

static void the_halves_estimate_independently(void **state)
{
    (void)state;
    enum {
        PIXELS = 4000,
        N = 16
    };
    double cov = 0.0, var[2] = {0.0, 0.0};
    for (uint32_t pixel = 0; pixel < PIXELS; pixel++) {
        double error[2];
        for (uint32_t half = 0; half < 2; half++) {
            double sum = 0.0;
            for (uint32_t i = 0; i < N; i++) {
                float u[4];
                draw(pixel, half, i, u);
                sum += (double)(u[0] * u[1]);
            }
            error[half] = sum / N - 0.25;
            var[half] += error[half] * error[half];
        }
        cov += error[0] * error[1];
    }
    assert_true(fabs(cov) / sqrt(var[0] * var[1]) < 4.0 / sqrt((double)PIXELS));
}

static double integrand(const float u[4])
{
    return sin(3.0 * (double)u[0]) * exp((double)u[1]) * (1.0 + (double)(u[2] * u[3]));
}

static void a_smooth_integral_converges_faster_than_at_random(void **state)
{
    (void)state;
    const double exact = (1.0 - cos(3.0)) / 3.0 * (exp(1.0) - 1.0) * 1.25;
    enum {
        PIXELS = 64
    };
    double error[2];
    for (int which = 0; which < 2; which++) {
        uint32_t n = which == 0 ? 32u : 2048u;
        double sum2 = 0.0;
        for (uint32_t pixel = 0; pixel < PIXELS; pixel++) {
            double sum = 0.0;
            for (uint32_t s = 0; s < n; s++) {
                CoSampleKey key = {pixel, s, 1};
                float u[4];
                co_sample(key, 1, 0, CO_DECISION_CAMERA, 0, 1, 4, u);
                sum += integrand(u);
            }
            sum2 += (sum / n - exact) * (sum / n - exact);
        }
        error[which] = sqrt(sum2 / PIXELS);
    }
    double slope = log(error[1] / error[0]) / log(2048.0 / 32.0);
    assert_true(slope < -0.9);
    assert_true(error[1] < 1e-3);
}

static void huge_indices_and_zero_splits_still_draw(void **state)
{
    (void)state;
    CoSampleKey key = {UINT32_MAX, UINT32_MAX, UINT32_MAX};
    float a[4], b[4];
    co_sample(key, 1023, 255, CO_DECISION_ROULETTE, 254, 255, 4, a);
    co_sample(key, 1023, 255, CO_DECISION_ROULETTE, 253, 255, 4, b);
    for (int d = 0; d < 4; d++)
        assert_true(a[d] >= 0.0f && a[d] < 1.0f && b[d] < 1.0f);
    assert_true(a[0] != b[0] && a[1] != b[1]);
    co_sample(key, 1, 0, CO_DECISION_BSDF, 0, 0, 2, a);
    co_sample(key, 1, 0, CO_DECISION_BSDF, 0, 1, 2, b);
    assert_true(a[0] == b[0] && a[1] == b[1]);
}

static void fewer_dimensions_are_the_first_of_more(void **state)
{
    (void)state;
    CoSampleKey key = {5, 6, 7};
    float all[4], one[2] = {-1.0f, -1.0f};
    co_sample(key, 1, 0, CO_DECISION_BSDF, 0, 1, 4, all);
    co_sample(key, 1, 0, CO_DECISION_BSDF, 0, 1, 1, one);
    assert_true(one[0] == all[0] && one[1] == -1.0f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_table_follows_from_the_polynomials),
        cmocka_unit_test(each_dimension_is_stratified_at_powers_of_two),
        cmocka_unit_test(the_first_pair_is_stratified_in_every_shape),
        cmocka_unit_test(branches_extend_the_sequence),
        cmocka_unit_test(the_first_sample_is_uniform_over_pixels),
        cmocka_unit_test(keys_that_differ_in_anything_are_independent),
        cmocka_unit_test(the_halves_estimate_independently),
        cmocka_unit_test(a_smooth_integral_converges_faster_than_at_random),
        cmocka_unit_test(huge_indices_and_zero_splits_still_draw),
        cmocka_unit_test(fewer_dimensions_are_the_first_of_more),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
