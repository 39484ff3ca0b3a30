// Warps: in range, of the density they promise, and precise where angles are tiny.

#include "math/warp.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum {
    GRID = 256
};

static float at(int i)
{
    return ((float)i + 0.5f) / GRID;
}

static void the_disk_is_uniform(void **state)
{
    (void)state;
    double r2 = 0.0, x1 = 0.0, y1 = 0.0, xy = 0.0;
    for (int i = 0; i < GRID; i++)
        for (int j = 0; j < GRID; j++) {
            float x, y;
            co_warp_disk(at(i), at(j), &x, &y);
            assert_true(x * x + y * y <= 1.0f);
            r2 += (double)(x * x + y * y);
            x1 += (double)x;
            y1 += (double)y;
            xy += (double)(x * y);
        }
    const double n = (double)GRID * GRID;
    assert_true(fabs(r2 / n - 0.5) < 1e-4);
    assert_true(fabs(x1 / n) < 1e-4 && fabs(y1 / n) < 1e-4 && fabs(xy / n) < 1e-4);
    float x, y;
    co_warp_disk(0.5f, 0.5f, &x, &y);
    assert_true(x == 0.0f && y == 0.0f);
}

static void the_cosine_hemisphere_has_mean_two_thirds(void **state)
{
    (void)state;
    double mean = 0.0;
    for (int i = 0; i < GRID; i++)
        for (int j = 0; j < GRID; j++) {
            CoVec3 d = co_warp_cosine(at(i), at(j));
            assert_true(d.z >= 0.0f && fabsf(co_dot(d, d) - 1.0f) < 1e-6f);
            mean += (double)d.z;
        }
    assert_true(fabs(mean / ((double)GRID * GRID) - 2.0 / 3.0) < 5e-4);
}

static void cones_are_uniform_from_sphere_to_pinprick(void **state)
{
    (void)state;
    const float versines[] = {2.0f, 1.0f, 0.3f, 1e-6f, 1e-14f};
    for (int v = 0; v < 5; v++) {
        double sum = 0.0;
        for (int i = 0; i < GRID; i++)
            for (int j = 0; j < GRID; j++) {
                CoVec3 d = co_warp_cone(versines[v], at(i), at(j));
                assert_true(fabsf(co_dot(d, d) - 1.0f) < 2e-6f);
                // sin^2 = h (2 - h) with h uniform in [0, versine].
                sum += (double)d.x * (double)d.x + (double)d.y * (double)d.y;
            }
        double h = (double)versines[v];
        double expected = h - h * h / 3.0;
        assert_true(fabs(sum / ((double)GRID * GRID) - expected) < 1e-3 * expected);
    }
}

static void frames_go_there_and_back(void **state)
{
    (void)state;
    CoVec3 n = co_normalize(co_vec3(0.3f, -0.7f, -0.2f)), s, t;
    co_basis(n, &s, &t);
    CoVec3 v = co_vec3(1.0f, 2.0f, 3.0f);
    CoVec3 back = co_to_frame(s, t, n, co_from_frame(s, t, n, v));
    assert_true(co_length(co_sub(back, v)) < 1e-6f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_disk_is_uniform),
        cmocka_unit_test(the_cosine_hemisphere_has_mean_two_thirds),
        cmocka_unit_test(cones_are_uniform_from_sphere_to_pinprick),
        cmocka_unit_test(frames_go_there_and_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
