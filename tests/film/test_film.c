// The film: exact sums in any order, first hits, rounds, AOVs, the error estimate, hostile values.

#include "base/hash.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "film/film.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#define ALL_AOVS 0x1ffu
#define SIDE 8u
#define PIXELS (SIDE * SIDE)
#define ADDS 20000u

typedef struct Order {
    CoFilm *film;
    uint32_t multiplier; // odd: a permutation of the powers of two below 2^15
} Order;

static float random_float(uint32_t key, uint32_t what)
{
    return (float)(co_hash32(key * 16 + what) >> 8) * 0x1p-24f;
}

// The splat number i, the same whoever adds it.
static void add_one(CoFilm *film, uint32_t i)
{
    uint32_t pixel = co_hash32(i) % PIXELS, sample = i / 7;
    float scale = ldexpf(1.0f, (int)(i % 60) - 40);
    CoVec3 rgb = {scale * random_float(i, 0), -scale * random_float(i, 1), random_float(i, 2)};
    co_film_add_color(film, pixel, sample, rgb);
    co_film_add_alpha(film, pixel, sample, random_float(i, 3));
    CoFirstHit hit = {.depth = random_float(i, 4),
                      .camera_depth = random_float(i, 5),
                      .normal = {random_float(i, 6) - 0.5f, random_float(i, 7), -1.0f},
                      .albedo = {random_float(i, 8), 1.0f, 0.0f},
                      .prim_id = (int32_t)(i % 100),
                      .element_id = (int32_t)i};
    if (i % 7 == 0)
        co_film_add_first(film, pixel, sample, &hit);
}

static void add_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Order *order = context;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        uint32_t splat = ((uint32_t)i * order->multiplier) & 0x7fffu;
        if (splat < ADDS)
            add_one(order->film, splat);
    }
}

static size_t aov_bytes(CohortAov aov)
{
    size_t components = aov == COHORT_AOV_COLOR                                ? 4
                        : aov == COHORT_AOV_NORMAL || aov == COHORT_AOV_ALBEDO ? 3
                                                                               : 1;
    return components * PIXELS * sizeof(float);
}

static uint64_t film_hash(const CoFilm *film)
{
    float out[PIXELS * 4];
    uint64_t hash = 0;
    for (uint32_t bit = 1; bit <= COHORT_AOV_ERROR; bit <<= 1) {
        assert_true(co_film_resolve(film, (CohortAov)bit, out));
        hash = co_hash_bytes(out, aov_bytes((CohortAov)bit), hash);
    }
    return hash;
}

static void every_order_and_thread_count_gives_the_same_bits(void **state)
{
    (void)state;
    uint64_t expected = 0;
    const uint32_t multipliers[] = {1, 0x7fff, 12345, 30001};
    for (uint32_t threads = 1; threads <= 8; threads *= 2)
        for (int i = 0; i < 4; i++) {
            CoFilm *film = co_film_create(SIDE, SIDE, ALL_AOVS, 10, NULL);
            Order order = {film, multipliers[i]};
            co_worker_count_set(threads);
            co_film_set_alone(film, threads == 1 && i % 2 == 0);
            co_parallel_for(0x8000, 64, add_range, &order);
            assert_true(co_film_complete(film, ADDS / 7, NULL));
            uint64_t hash = film_hash(film);
            assert_true(expected == 0 || hash == expected);
            expected = hash;
            co_film_destroy(film);
        }
    co_worker_count_set(0);
    assert_int_equal(co_memory_live(CO_MEMORY_FILM), 0);
}

static CoFilm *single_pixel(uint32_t aovs, int unit_exponent)
{
    CoFilm *film = co_film_create(1, 1, aovs, unit_exponent, NULL);
    assert_non_null(film);
    return film;
}

static void sums_cancel_exactly_and_keep_small_values(void **state)
{
    (void)state;
    CoFilm *film = single_pixel(0, 4);
    float color[4];
    const float values[] = {1e6f, 3e-7f, -1e6f, 12.5f, 1e8f, -12.5f, -1e8f, 1e-8f};
    for (int i = 0; i < 8; i++)
        co_film_add_color(film, 0, (uint32_t)i % 2, co_vec3(values[i], -values[i], 0));
    assert_true(co_film_complete(film, 1, NULL));
    assert_true(co_film_resolve(film, COHORT_AOV_COLOR, color));
    assert_true(fabs((double)color[0] - 3.1e-7) < 4e-14);
    assert_true(color[1] == -color[0] && color[2] == 0.0f);
    assert_int_equal(co_film_saturations(film), 0);
    co_film_destroy(film);
}

static void every_exponent_comes_back(void **state)
{
    (void)state;
    for (int e = -40; e <= 20; e++) {
        CoFilm *film = single_pixel(0, 0);
        float color[4], value = ldexpf(1.3333334f, e);
        for (uint32_t sample = 0; sample < 3; sample++)
            co_film_add_color(film, 0, sample, co_vec3(value, -value, value));
        co_film_complete(film, 3, NULL);
        co_film_resolve(film, COHORT_AOV_COLOR, color);
        assert_true(color[0] == value && color[1] == -value && color[2] == value);
        co_film_destroy(film);
    }
}

static void hostile_values_are_counted(void **state)
{
    (void)state;
    CoFilm *film = single_pixel(ALL_AOVS, 0);
    float color[4];
    co_film_add_color(film, 0, 0, co_vec3(NAN, 0, 0));
    co_film_add_color(film, 0, 0, co_vec3(0, INFINITY, 0));
    co_film_add_alpha(film, 0, 0, NAN);
    for (int i = 0; i < 100; i++)
        co_film_add_color(film, 0, 0, co_vec3(3e38f, -3e38f, 1));
    co_film_add_alpha(film, 0, 0, INFINITY);
    co_film_complete(film, 1, NULL);
    assert_int_equal(co_film_dropped(film), 3);
    assert_int_equal(co_film_saturations(film), 101);
    co_film_resolve(film, COHORT_AOV_COLOR, color);
    assert_true(color[0] == 100.0f * 0x1p24f && color[1] == -color[0]);
    assert_true(color[2] == 100.0f && color[3] == 2.0f);
    co_film_destroy(film);
}

static void first_hits_keep_the_lowest_sample(void **state)
{
    (void)state;
    CoFilm *film = co_film_create(2, 1, ALL_AOVS, 0, NULL);
    const uint32_t samples[] = {5, 3, 9};
    for (int i = 0; i < 3; i++) {
        CoFirstHit hit = {.depth = 0.1f * (float)samples[i],
                          .camera_depth = -(float)samples[i],
                          .normal = {0, 0, -1},
                          .albedo = {0.5f, 0.25f, 1},
                          .prim_id = (int32_t)samples[i],
                          .element_id = -7};
        co_film_add_first(film, 1, samples[i], &hit);
    }
    co_film_complete(film, 6, NULL);
    float value[6];
    int32_t id[2];
    co_film_resolve(film, COHORT_AOV_DEPTH, value);
    assert_true(value[0] == 1.0f && value[1] == 0.1f * 3.0f);
    co_film_resolve(film, COHORT_AOV_CAMERA_DEPTH, value);
    assert_true(isinf(value[0]) && value[0] > 0 && value[1] == -3.0f);
    co_film_resolve(film, COHORT_AOV_PRIM_ID, id);
    assert_true(id[0] == -1 && id[1] == 3);
    co_film_resolve(film, COHORT_AOV_ELEMENT_ID, id);
    assert_true(id[0] == -1 && id[1] == -7);
    co_film_resolve(film, COHORT_AOV_NORMAL, value);
    assert_true(value[2] == 0.0f && value[5] == -0.5f);
    co_film_resolve(film, COHORT_AOV_ALBEDO, value);
    assert_true(value[3] == 0.25f && value[4] == 0.125f && value[5] == 0.5f);
    co_film_resolve(film, COHORT_AOV_SAMPLE_COUNT, value);
    assert_true(value[0] == 6.0f);
    co_film_destroy(film);
}

static void only_complete_rounds_are_shown(void **state)
{
    (void)state;
    CoFilm *film = single_pixel(0, 0);
    float color[4];
    co_film_resolve(film, COHORT_AOV_COLOR, color);
    assert_true(color[0] == 0.0f && color[3] == 0.0f && co_film_samples(film) == 0);
    co_film_add_color(film, 0, 0, co_vec3(1, 1, 1));
    co_film_complete(film, 1, NULL);
    co_film_add_color(film, 0, 1, co_vec3(5, 5, 5));
    co_film_resolve(film, COHORT_AOV_COLOR, color);
    assert_true(color[0] == 1.0f);
    co_film_revert(film);
    co_film_add_color(film, 0, 1, co_vec3(3, 3, 3));
    co_film_complete(film, 2, NULL);
    co_film_resolve(film, COHORT_AOV_COLOR, color);
    assert_true(color[0] == 2.0f && co_film_samples(film) == 2);
    CohortError err = {0};
    assert_false(co_film_complete(film, 1, &err));
    assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
    assert_false(co_film_complete(film, ((uint64_t)1 << 31) + 1, NULL));
    co_film_destroy(film);
}

// Gaussian-like noise of known variance: the mean square of the estimate is the variance of the
// mean.
static void error_is_right_in_the_mean_square(void **state)
{
    (void)state;
    const uint32_t side = 100, counts[] = {2, 3, 16};
    for (int k = 0; k < 3; k++) {
        CoFilm *film = co_film_create(side, side, COHORT_AOV_ERROR, 0, NULL);
        for (uint32_t pixel = 0; pixel < side * side; pixel++)
            for (uint32_t sample = 0; sample < counts[k]; sample++) {
                float v = random_float(pixel, sample);
                co_film_add_color(film, pixel, sample, co_vec3(v, v, v));
            }
        co_film_complete(film, counts[k], NULL);
        float error[10000];
        co_film_resolve(film, COHORT_AOV_ERROR, error);
        double sum = 0, relative = 0;
        for (uint32_t i = 0; i < side * side; i++) {
            sum += (double)error[i] * (double)error[i];
            relative += (double)error[i];
        }
        double expected = 1.0 / 12.0 / counts[k];
        assert_true(fabs(sum / (side * side) / expected - 1.0) < 0.06);
        assert_true(co_film_mean_error(film) > relative / (side * side));
        co_film_destroy(film);
    }
    CoFilm *film = single_pixel(COHORT_AOV_ERROR, 0);
    float error;
    co_film_add_color(film, 0, 0, co_vec3(1, 1, 1));
    co_film_complete(film, 1, NULL);
    assert_true(co_film_resolve(film, COHORT_AOV_ERROR, &error) && isinf(error));
    assert_true(isinf(co_film_mean_error(film)));
    co_film_destroy(film);
}

static void what_was_not_asked_for_is_not_there(void **state)
{
    (void)state;
    CoFilm *film = single_pixel(COHORT_AOV_NORMAL, 0);
    float out[4];
    CoFirstHit hit = {.normal = {1, 0, 0}, .albedo = {NAN, 0, 0}, .depth = 1};
    co_film_add_first(film, 0, 0, &hit);
    co_film_complete(film, 1, NULL);
    assert_int_equal(co_film_dropped(film), 0);
    assert_true(co_film_resolve(film, COHORT_AOV_NORMAL, out) && out[0] == 1.0f);
    assert_true(co_film_resolve(film, COHORT_AOV_COLOR, out));
    assert_false(co_film_resolve(film, COHORT_AOV_DEPTH, out));
    assert_false(co_film_resolve(film, COHORT_AOV_ALBEDO, out));
    assert_false(co_film_resolve(film, COHORT_AOV_ERROR, out));
    assert_false(co_film_resolve(film, (CohortAov)(COHORT_AOV_COLOR | COHORT_AOV_NORMAL), out));
    co_film_destroy(film);
}

static void impossible_films_are_refused(void **state)
{
    (void)state;
    CohortError err = {0};
    assert_null(co_film_create(0, 4, 0, 0, &err));
    assert_int_equal(err.code, COHORT_ERROR_ARGUMENT);
    assert_null(co_film_create(4, 4, 0, 1000, NULL));
    err = (CohortError){0};
    assert_null(co_film_create(UINT32_MAX, UINT32_MAX, ALL_AOVS, 0, &err));
    assert_int_equal(err.code, COHORT_ERROR_OUT_OF_MEMORY);
    for (uint64_t n = 1; n <= 3; n++) {
        co_memory_fail_after(n);
        assert_null(co_film_create(4, 4, ALL_AOVS, 0, NULL));
        co_memory_fail_after(0);
    }
    assert_int_equal(co_memory_live(CO_MEMORY_FILM), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_order_and_thread_count_gives_the_same_bits),
        cmocka_unit_test(sums_cancel_exactly_and_keep_small_values),
        cmocka_unit_test(every_exponent_comes_back),
        cmocka_unit_test(hostile_values_are_counted),
        cmocka_unit_test(first_hits_keep_the_lowest_sample),
        cmocka_unit_test(only_complete_rounds_are_shown),
        cmocka_unit_test(error_is_right_in_the_mean_square),
        cmocka_unit_test(what_was_not_asked_for_is_not_there),
        cmocka_unit_test(impossible_films_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
