// Vectors: normalizing anything, frames, and affine inverses.

#include "math/vec.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static void normalizing_ends_in_a_unit_or_zero(void **state)
{
    (void)state;
    const float values[] = {0.0f, 1.0f, -2.0f, 1e-40f, 1e-20f, 1e20f, 3.4e38f, NAN, INFINITY};
    for (int i = 0; i < 729; i++) {
        CoVec3 v = co_vec3(values[i % 9], values[i / 9 % 9], values[i / 81]);
        CoVec3 n = co_normalize(v);
        float l = co_length(n);
        bool is_zero = co_max3(v) == 0.0f && v.x == 0.0f && v.y == 0.0f && v.z == 0.0f;
        if (!co_is_finite3(v) || is_zero)
            assert_true(n.x == 0.0f && n.y == 0.0f && n.z == 0.0f);
        else
            assert_true(fabsf(l - 1.0f) < 1e-4f);
    }
}

static void a_basis_is_orthonormal(void **state)
{
    (void)state;
    for (int i = 0; i < 1000; i++) {
        CoVec3 n =
            co_vec3((float)(i % 10) - 4.5f, (float)(i / 10 % 10) - 4.5f, (float)(i / 100) - 4.5f);
        CoVec3 s, t;
        n = co_normalize(n);
        co_basis(n, &s, &t);
        CoVec3 cross = co_cross(s, t);
        assert_true(fabsf(co_dot(s, t)) < 1e-6f && fabsf(co_dot(s, n)) < 1e-6f);
        assert_true(co_length(co_sub(cross, n)) < 1e-6f);
    }
}

static void inverses_undo(void **state)
{
    (void)state;
    CoMat4d m = {{{2, 1, 0, 0}, {0, 3, 1, 0}, {1, 0, 4, 0}, {5, 6, 7, 1}}}, inverse;
    assert_true(co_mat4d_invert_affine(&m, &inverse));
    CoMat4d product = co_mat4d_mul(&m, &inverse);
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            assert_true(fabs(product.m[i][j] - (i == j ? 1.0 : 0.0)) < 1e-14);
    CoMat4d flat = {{{1, 0, 0, 0}, {0, 0, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
    assert_false(co_mat4d_invert_affine(&flat, &inverse));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(normalizing_ends_in_a_unit_or_zero),
        cmocka_unit_test(a_basis_is_orthonormal),
        cmocka_unit_test(inverses_undo),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
