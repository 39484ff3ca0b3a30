// Normal maps: flat, tilted, mirrored and skewed texture coordinates, and degenerate ones.

#include "math/vec.h"
#include "shading/normal_map.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static const CoVec3 up = {0, 0, 1}, along_x = {3, 0, 0}, along_y = {0, 5, 0};

static void assert_is(CoVec3 got, float x, float y, float z)
{
    CoVec3 want = co_normalize(co_vec3(x, y, z));
    assert_true(co_length(co_sub(got, want)) < 1e-6f);
}

static void a_flat_texel_changes_nothing(void **state)
{
    (void)state;
    CoVec3 ns = co_normalize(co_vec3(0.1f, 0.2f, 1.0f));
    CoVec3 n = co_normal_map(ns, up, along_x, along_y, co_vec3(0, 0, 1));
    assert_is(n, ns.x, ns.y, ns.z);
}

static void texels_tilt_along_the_texture(void **state)
{
    (void)state;
    assert_is(co_normal_map(up, up, along_x, along_y, co_vec3(0.6f, 0, 0.8f)), 0.6f, 0, 0.8f);
    assert_is(co_normal_map(up, up, along_x, along_y, co_vec3(0, 1.2f, 1.6f)), 0, 0.6f, 0.8f);
    // Texture turned by a quarter, and mirrored.
    assert_is(co_normal_map(up, up, along_y, co_neg(along_x), co_vec3(0.6f, 0, 0.8f)), 0, 0.6f,
              0.8f);
    CoVec3 flipped = co_normal_map(up, up, along_x, co_neg(along_y), co_vec3(0, 0.6f, 0.8f));
    assert_is(flipped, 0, -0.6f, 0.8f);
    CoVec3 skewed = co_normal_map(up, up, along_x, co_vec3(4, 1, 0), co_vec3(0, 0.6f, 0.8f));
    assert_is(skewed, 0, 0.6f, 0.8f);
}

static void normals_stay_on_their_side(void **state)
{
    (void)state;
    for (int flip = 0; flip < 2; flip++) {
        CoVec3 ng = flip ? co_neg(up) : up;
        for (int i = 0; i < 100; i++) {
            float x = (float)(i % 10) - 4.5f, y = (float)(i / 10) - 4.5f;
            CoVec3 n = co_normal_map(up, ng, along_x, along_y, co_vec3(x, y, -1.0f));
            assert_true(n.z > 0.0f && fabsf(co_length(n) - 1.0f) < 1e-5f);
        }
    }
}

static void degenerate_inputs_give_the_plain_normal(void **state)
{
    (void)state;
    const CoVec3 zero = {0, 0, 0}, bad = {NAN, 0, 1}, texel = {0.6f, 0, 0.8f};
    assert_is(co_normal_map(up, up, zero, along_y, texel), 0, 0, 1);
    assert_is(co_normal_map(up, up, up, along_y, texel), 0, 0, 1);
    assert_is(co_normal_map(up, up, along_x, along_y, zero), 0, 0, 1);
    assert_is(co_normal_map(up, up, along_x, along_y, bad), 0, 0, 1);
    assert_is(co_normal_map(up, up, bad, along_y, texel), 0, 0, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_flat_texel_changes_nothing),
        cmocka_unit_test(texels_tilt_along_the_texture),
        cmocka_unit_test(normals_stay_on_their_side),
        cmocka_unit_test(degenerate_inputs_give_the_plain_normal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
