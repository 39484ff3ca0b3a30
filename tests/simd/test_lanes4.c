// Four floats, eight numbers: against plain C.

#include "simd/lanes4.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>

#include <cmocka.h>

static bool same(float x, float y)
{
    return (isnan(x) && isnan(y)) || memcmp(&x, &y, sizeof x) == 0;
}

static void floats_are_plain_c(void **state)
{
    (void)state;
    const float odd[8] = {0.0f, -0.0f, 1.5f, -3e38f, INFINITY, NAN, 1e-45f, 0.1f};
    for (int i = 0; i < 64; i++) {
        float a[4], b[4], got[9][4];
        for (int k = 0; k < 4; k++) {
            a[k] = odd[(i / 8 + k) % 8];
            b[k] = odd[(i + k) % 8];
        }
        Co4 x = co4_load(a), y = co4_load(b);
        co4_store(got[0], co4_min(x, y));
        co4_store(got[1], co4_max(x, y));
        co4_store(got[2], co4_add(x, y));
        co4_store(got[3], co4_sub(x, y));
        co4_store(got[4], co4_mul(x, y));
        co4_store(got[5], co4_xyz(x));
        co4_store(got[6], co4_div(x, y));
        co4_store(got[7], co4_where_less(x, y, co4_set1(1.0f), co4_set1(-0.0f)));
        co4_store(got[8], co4_yzx(x));
        for (int k = 0; k < 4; k++) {
            assert_true(same(got[0][k], a[k] < b[k] ? a[k] : b[k]));
            assert_true(same(got[1][k], a[k] > b[k] ? a[k] : b[k]));
            assert_true(same(got[2][k], a[k] + b[k]));
            assert_true(same(got[3][k], a[k] - b[k]));
            assert_true(same(got[4][k], a[k] * b[k]));
            assert_true(same(got[5][k], k < 3 ? a[k] : 0.0f));
            assert_true(same(got[6][k], a[k] / b[k]));
            assert_true(same(got[7][k], a[k] < b[k] ? 1.0f : -0.0f));
            assert_true(same(got[8][k], a[k < 3 ? (k + 1) % 3 : 3]));
        }
        assert_true(same(co4_first(x), a[0]));
        float three[4] = {0.0f, 0.0f, 0.0f, 9.0f};
        co4_store3(three, co4_load3(a));
        assert_true(same(three[0], a[0]) && same(three[1], a[1]) && same(three[2], a[2]));
        assert_true(three[3] == 9.0f);
    }
}

static void floats_are_cut_and_turned(void **state)
{
    (void)state;
    const float from[4] = {2.9f, -2.9f, 0.0f, 1e6f};
    int32_t to[4];
    co4_truncate(co4_load(from), to);
    assert_int_equal(to[0], 2);
    assert_int_equal(to[1], -2);
    assert_int_equal(to[2], 0);
    assert_int_equal(to[3], 1000000);
    Co4 rows[4];
    float m[4][4];
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 4; k++)
            m[i][k] = (float)(4 * i + k);
        rows[i] = co4_load(m[i]);
    }
    co4_transpose(rows);
    for (int i = 0; i < 4; i++) {
        float row[4];
        co4_store(row, rows[i]);
        for (int k = 0; k < 4; k++)
            assert_true(row[k] == m[k][i]);
    }
    co4_store(m[0], co4_set1(-7.0f));
    assert_true(m[0][0] == -7.0f && m[0][3] == -7.0f);
}

static void numbers_are_found_where_they_were_put(void **state)
{
    (void)state;
    for (uint32_t at = 0; at < 16; at++) {
        Co16 a = co16_set1(5);
        uint32_t out[16], bit = 1u << at;
        co16_put(&a, at, 0xfffffff0u);
        co16_store(out, &a);
        for (uint32_t i = 0; i < 16; i++)
            assert_int_equal(out[i], i == at ? 0xfffffff0u : 5);
        assert_int_equal(co16_equal(&a, 0xfffffff0u), bit);
        assert_int_equal(co16_equal(&a, 5), 0xffffu & ~bit);
        assert_int_equal(co16_equal(&a, 6), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(floats_are_plain_c),
        cmocka_unit_test(floats_are_cut_and_turned),
        cmocka_unit_test(numbers_are_found_where_they_were_put),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
