// USD's built-in color spaces as numbers: published matrices, white stays white, and back again.

#include "color/rgb_space.h"

#include <math.h>
#include <string.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static const char *const names[] = {
    "lin_rec709_scene", "lin_p3d65_scene", "lin_rec2020_scene", "lin_adobergb_scene",
    "lin_ap0_scene",    "lin_ap1_scene",   "srgb_rec709_scene", "sRGB",
    "srgb_p3d65_scene", "srgb_ap1_scene",  "g18_rec709_scene",  "g22_rec709_scene",
    "g24_rec709_scene", "g22_ap1_scene",   "g22_adobergb_scene"};
enum {
    NAMES = sizeof names / sizeof *names
};

static const CoRgbSpace *space(const char *name)
{
    const CoRgbSpace *found = co_rgb_space_find(name);
    assert_non_null(found);
    return found;
}

static void assert_matrix(const float m[9], const double expected[9], double tolerance)
{
    for (int i = 0; i < 9; i++)
        if (!(fabs((double)m[i] - expected[i]) < tolerance))
            fail_msg("element %d is %.6f, expected %.6f", i, (double)m[i], expected[i]);
}

static void only_usds_names_are_known(void **state)
{
    (void)state;
    static const char *const others[] = {"", "srgb", "lin_rec709", "ACEScg", "LIN_AP1_SCENE"};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        assert_null(co_rgb_space_find(others[i]));
    static const char *const data[] = {"raw", "data", "identity", "unknown"};
    for (size_t i = 0; i < sizeof data / sizeof *data; i++)
        assert_true(space(data[i])->is_data);
    for (int i = 0; i < NAMES; i++)
        assert_false(space(names[i])->is_data);
}

// IEC 61966-2-1 for sRGB; ACEScg to Rec.709 by Bradford as in the ACES documents.
static void published_matrices(void **state)
{
    (void)state;
    static const double srgb_xyz[9] = {0.4124, 0.3576, 0.1805, 0.2126, 0.7152,
                                       0.0722, 0.0193, 0.1192, 0.9505};
    static const double ap1_rec709[9] = {1.70505,  -0.62179, -0.08326, -0.13026, 1.14080,
                                         -0.01055, -0.02400, -0.12897, 1.15297};
    static const double same[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    float m[9];
    co_rgb_space_matrix(space("sRGB"), space("lin_ciexyzd65_scene"), m);
    assert_matrix(m, srgb_xyz, 2e-4);
    co_rgb_space_matrix(space("lin_ap1_scene"), space("lin_rec709_scene"), m);
    assert_matrix(m, ap1_rec709, 2e-4);
    co_rgb_space_matrix(space("sRGB"), space("g22_rec709_scene"), m); // the curve is no matter
    assert_matrix(m, same, 1e-7);
}

static void white_is_white_and_ways_lead_back(void **state)
{
    (void)state;
    for (int a = 0; a < NAMES; a++)
        for (int b = 0; b < NAMES; b++) {
            float there[9], back[9], white[3] = {1, 1, 1}, color[3] = {0.7f, 0.1f, 0.4f};
            co_rgb_space_matrix(space(names[a]), space(names[b]), there);
            co_rgb_space_matrix(space(names[b]), space(names[a]), back);
            co_rgb_matrix_apply(there, white);
            for (int c = 0; c < 3; c++)
                assert_true(fabsf(white[c] - 1.0f) < 2e-6f);
            co_rgb_matrix_apply(there, color);
            co_rgb_matrix_apply(back, color);
            assert_true(fabsf(color[0] - 0.7f) < 4e-6f && fabsf(color[1] - 0.1f) < 4e-6f &&
                        fabsf(color[2] - 0.4f) < 4e-6f);
        }
}

static void matrices_without_inverse(void **state)
{
    (void)state;
    static const double flat[9] = {1, 2, 3, 2, 4, 6, 0, 0, 1}, zero[9];
    double out[9] = {7, 7, 7, 7, 7, 7, 7, 7, 7};
    assert_false(co_matrix3_invert(flat, out));
    assert_false(co_matrix3_invert(zero, out));
    assert_true(out[0] == 7.0 && out[8] == 7.0);
    static const double turn[9] = {0, 1, 0, 0, 0, 1, 2, 0, 0};
    double product[9];
    assert_true(co_matrix3_invert(turn, out));
    co_matrix3_mul(turn, out, product);
    for (int i = 0; i < 9; i++)
        assert_true(product[i] == (i % 4 == 0 ? 1.0 : 0.0));
}

static void curves_rise_and_mirror(void **state)
{
    (void)state;
    for (int i = 0; i < NAMES; i++) {
        const CoRgbSpace *s = space(names[i]);
        assert_true(co_rgb_space_decode(s, 0.0f) == 0.0f);
        assert_true(fabsf(co_rgb_space_decode(s, 1.0f) - 1.0f) < 1e-6f);
        float before = 0.0f;
        for (int k = 1; k <= 1000; k++) {
            float x = (float)k / 500.0f, y = co_rgb_space_decode(s, x); // to 2: brighter than white
            assert_true(y > before);
            assert_true(co_rgb_space_decode(s, -x) == -y);
            before = y;
        }
        assert_true(isnan(co_rgb_space_decode(s, NAN)));
        assert_true(isinf(co_rgb_space_decode(s, INFINITY)));
    }
    assert_true(fabsf(co_rgb_space_decode(space("sRGB"), 0.5f) - 0.21404114f) < 1e-6f);
    assert_true(fabsf(co_rgb_space_decode(space("g22_rec709_scene"), 0.5f) - 0.21763764f) < 1e-6f);
    assert_true(co_rgb_space_decode(space("sRGB"), 0.04045f) == 0.04045f / 12.92f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_usds_names_are_known),
        cmocka_unit_test(published_matrices),
        cmocka_unit_test(white_is_white_and_ways_lead_back),
        cmocka_unit_test(matrices_without_inverse),
        cmocka_unit_test(curves_rise_and_mirror),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
