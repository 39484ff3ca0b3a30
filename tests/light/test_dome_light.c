// Domes: what is sampled is what shines, and the densities of all directions sum to 1.

#include "light_fixture.h"

enum {
    WIDTH = 16,
    HEIGHT = 8,
    GRID = 256
};

// Over the sphere, by equal areas.
static double total_density(const CoLight *light, CoVec3 n)
{
    double sum = 0.0;
    for (int i = 0; i < GRID * GRID; i++) {
        double up = 1.0 - 2.0 * (i / GRID + 0.5) / GRID, r = sqrt(1.0 - up * up);
        double around = 2.0 * test_pi * (i % GRID + 0.5) / GRID;
        CoVec3 wi = co_vec3((float)(r * sin(around)), (float)up, (float)(r * cos(around)));
        sum += (double)co_dome_light_pdf(light, n, wi) * 4.0 * test_pi / (GRID * GRID);
    }
    return sum;
}

static void densities_sum_to_one(void **state)
{
    (void)state;
    float pixels[HEIGHT][WIDTH][4] = {{{0}}};
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            pixels[y][x][1] = (float)((x * 7 + y * 5) % 11);
    const CoLightImage image = {pixels[0][0], WIDTH, HEIGHT};
    CohortLightDesc d = test_light(COHORT_LIGHT_DOME);
    test_turn(&d, 0, 40.0);
    CoLight plain = light_of(&d), textured = light_with(&d, &image);
    const CoVec3 n = co_normalize(co_vec3(1, 2, 3)), none = co_vec3(0, 0, 0);
    test_near(total_density(&plain, n), 1.0, 1e-3);
    test_near(total_density(&plain, none), 1.0, 1e-4);
    test_near(total_density(&textured, n), 1.0, 2e-3);
    // Strength, by which lights are chosen, is the mean over the sphere: green alone, of three.
    double mean = 0.0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            mean += (double)pixels[y][x][1] / (6.0 * WIDTH) *
                    (cos(test_pi * y / HEIGHT) - cos(test_pi * (y + 1) / HEIGHT));
    test_near((double)textured.strength, mean, 0.02);
    co_light_teardown(&textured);
}

static void one_bright_texel_draws_the_samples(void **state)
{
    (void)state;
    float pixels[HEIGHT][WIDTH][4] = {{{0}}};
    pixels[3][4][0] = 900.0f; // longitude +pi/2 is a quarter from the left, towards +X
    const CoLightImage image = {pixels[0][0], WIDTH, HEIGHT};
    CohortLightDesc d = test_light(COHORT_LIGHT_DOME);
    CoLight light = light_with(&d, &image);
    const CoVec3 n = co_vec3(0, 1, 0);
    double sum = 0.0;
    for (int i = 0; i < 64 * 64; i++) {
        float u0 = ((float)(i % 64) + 0.5f) / 64, u1 = ((float)(i / 64) + 0.5f) / 64;
        CoVec3 wi;
        assert_true(co_dome_light_sample(&light, n, u0, u1, &wi));
        float pdf = co_dome_light_pdf(&light, n, wi);
        assert_true(pdf > 0.0f && wi.x > 0.5f);
        sum += (double)(co_dome_light_radiance(&light, wi).x / pdf) / (64 * 64);
    }
    // Its light spreads over its neighbors but keeps its sum, but for the narrowing of rows.
    double area = 2.0 * test_pi / WIDTH * (cos(test_pi * 3 / HEIGHT) - cos(test_pi * 4 / HEIGHT));
    test_near(sum, 900.0 * area, 0.03);
    co_light_teardown(&light);
    assert_int_equal(co_memory_live(CO_MEMORY_LIGHT), 0);
}

static void a_plain_dome_is_one_color(void **state)
{
    (void)state;
    CohortLightDesc d = test_light(COHORT_LIGHT_DOME);
    d.color[2] = 0.5f;
    CoLight light = light_of(&d);
    CoVec3 c = co_dome_light_radiance(&light, co_normalize(co_vec3(1, -2, 0.5f)));
    assert_true(c.x == 1.0f && c.y == 1.0f && c.z == 0.5f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(densities_sum_to_one),
        cmocka_unit_test(one_bright_texel_draws_the_samples),
        cmocka_unit_test(a_plain_dome_is_one_color),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
