// From sums to AOVs: what a pixel without samples shows, means of any count, and their errors.

#include "base/parallel.h"
#include "film/film.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#define ALL_AOVS 0x1ffu

static CoFilm *make_film(uint32_t width, uint32_t height)
{
    CoFilm *film = co_film_create(width, height, ALL_AOVS, 0, NULL);
    assert_non_null(film);
    return film;
}

// Before the first round, and where nothing was hit.
static void empty_pixels_say_so(void **state)
{
    (void)state;
    CoFilm *film = make_film(1, 1);
    for (uint64_t samples = 0; samples < 3; samples += 2) {
        float out[4];
        int32_t id;
        if (samples)
            assert_true(co_film_complete(film, samples, NULL));
        assert_true(co_film_resolve(film, COHORT_AOV_COLOR, out));
        assert_true(out[0] == 0.0f && out[1] == 0.0f && out[2] == 0.0f && out[3] == 0.0f);
        assert_true(co_film_resolve(film, COHORT_AOV_DEPTH, out) && out[0] == 1.0f);
        assert_true(co_film_resolve(film, COHORT_AOV_CAMERA_DEPTH, out) && isinf(out[0]));
        assert_true(co_film_resolve(film, COHORT_AOV_PRIM_ID, &id) && id == -1);
        assert_true(co_film_resolve(film, COHORT_AOV_ELEMENT_ID, &id) && id == -1);
        assert_true(co_film_resolve(film, COHORT_AOV_NORMAL, out) && out[2] == 0.0f);
        assert_true(co_film_resolve(film, COHORT_AOV_SAMPLE_COUNT, out));
        assert_true(out[0] == (float)samples);
        // No sample and one say nothing about their error; two that agree say none.
        assert_true(co_film_resolve(film, COHORT_AOV_ERROR, out));
        assert_true(samples ? out[0] == 0.0f : isinf(out[0]) != 0);
    }
    co_film_destroy(film);
}

// Colors may be negative (filters, camera spaces): sums of either sign come back, small ones too.
static void means_keep_their_sign(void **state)
{
    (void)state;
    static const float values[] = {1.0f, -1.0f, 0.75f, -0.75f, 0x1p-40f, -0x1p-40f, 100.0f};
    for (size_t i = 0; i < sizeof values / sizeof *values; i++)
        for (uint32_t samples = 1; samples <= 4; samples *= 2) {
            CoFilm *film = make_film(1, 1);
            float v = values[i], out[4];
            for (uint32_t sample = 0; sample < samples; sample++) {
                co_film_add_color(film, 0, sample, co_vec3(v, -v, 0.0f));
                co_film_add_alpha(film, 0, sample, 0.5f);
            }
            assert_true(co_film_complete(film, samples, NULL));
            assert_true(co_film_resolve(film, COHORT_AOV_COLOR, out));
            assert_true(out[0] == v && out[1] == -v && out[2] == 0.0f && out[3] == 0.5f);
            co_film_destroy(film);
        }
}

// The halves are the even and the odd samples, which differ by one where the count is odd:
// (a - b)^2 n_a n_b / n^2 of the means of both.
static void errors_weigh_both_halves(void **state)
{
    (void)state;
    for (uint32_t samples = 2; samples <= 5; samples++) {
        CoFilm *film = make_film(1, 1);
        for (uint32_t sample = 0; sample < samples; sample++) {
            float v = sample % 2 ? 1.0f : 0.25f;
            co_film_add_color(film, 0, sample, co_vec3(v, v, v));
        }
        assert_true(co_film_complete(film, samples, NULL));
        double n = (double)samples, odd = (double)(samples / 2), even = n - odd;
        double mean = (odd + 0.25 * even) / n;
        double want = 0.75 * sqrt(even * odd) / n;
        float error;
        assert_true(co_film_resolve(film, COHORT_AOV_ERROR, &error));
        assert_true(fabs((double)error - want) < 1e-6);
        assert_true(fabs(co_film_mean_error(film) - want / (mean + 0.01)) < 1e-6);
        co_film_destroy(film);
    }
}

// A pixel that is negative in the mean counts as black in the relative error.
static void negative_means_are_black(void **state)
{
    (void)state;
    CoFilm *film = make_film(1, 1);
    co_film_add_color(film, 0, 0, co_vec3(-3.0f, -3.0f, -3.0f));
    co_film_add_color(film, 0, 1, co_vec3(-1.0f, -1.0f, -1.0f));
    assert_true(co_film_complete(film, 2, NULL));
    assert_true(fabs(co_film_mean_error(film) - 1.0 / 0.01) < 1e-9); // sqrt(1 * 1) / 2 * |-3 - -1|
    co_film_destroy(film);
}

// More pixels than one task: each is where it belongs, whoever resolves it.
static void every_pixel_is_in_its_place(void **state)
{
    (void)state;
    enum {
        WIDTH = 200,
        HEIGHT = 101
    };
    static int32_t ids[WIDTH * HEIGHT];
    static float normals[3 * WIDTH * HEIGHT];
    CoFilm *film = make_film(WIDTH, HEIGHT);
    for (uint32_t pixel = 0; pixel < WIDTH * HEIGHT; pixel++) {
        CoFirstHit hit = {.prim_id = (int32_t)pixel, .normal = {0, (float)(pixel % 3) - 1.0f, 0}};
        co_film_add_first(film, pixel, 0, &hit);
    }
    assert_true(co_film_complete(film, 1, NULL));
    for (uint32_t threads = 1; threads <= 3; threads += 2) {
        co_worker_count_set(threads);
        memset(ids, 0xff, sizeof ids);
        assert_true(co_film_resolve(film, COHORT_AOV_PRIM_ID, ids));
        assert_true(co_film_resolve(film, COHORT_AOV_NORMAL, normals));
        for (int32_t pixel = 0; pixel < WIDTH * HEIGHT; pixel++) {
            assert_int_equal(ids[pixel], pixel);
            assert_true(normals[3 * pixel + 1] == (float)(pixel % 3) - 1.0f);
        }
    }
    co_worker_count_set(0);
    co_film_destroy(film);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(empty_pixels_say_so),         cmocka_unit_test(means_keep_their_sign),
        cmocka_unit_test(errors_weigh_both_halves),    cmocka_unit_test(negative_means_are_black),
        cmocka_unit_test(every_pixel_is_in_its_place),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
