// Pixel filters: the densities drawn are the filters named, up to their radius and no further.

#include "sample/filter_table.h"
#include "sample/sample.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum {
    N = 1 << 16
};

static const double pi = 3.14159265358979323846;

static double profile(CohortFilter filter, double x)
{
    double ax = fabs(x);
    if (filter == COHORT_FILTER_BOX)
        return ax <= 0.5 ? 1.0 : 0.0;
    if (filter == COHORT_FILTER_GAUSSIAN)
        return ax <= 1.5 ? exp(-2.0 * x * x) - exp(-4.5) : 0.0;
    double t = pi * ax / 2.0;
    return ax <= 2.0 ? 0.35875 + 0.48829 * cos(t) + 0.14128 * cos(2.0 * t) + 0.01168 * cos(3.0 * t)
                     : 0.0;
}

static const CohortFilter filters[] = {COHORT_FILTER_BOX, COHORT_FILTER_GAUSSIAN,
                                       COHORT_FILTER_BLACKMAN_HARRIS};
static const double radii[] = {0.5, 1.5, 2.0};

static void moments_are_those_of_the_filter(void **state)
{
    (void)state;
    for (int f = 0; f < 3; f++) {
        double norm = 0.0, want2 = 0.0, want4 = 0.0, got1 = 0.0, got2 = 0.0, got4 = 0.0;
        for (int i = 0; i < N; i++) {
            double u = (i + 0.5) / N, x = radii[f] * (2.0 * u - 1.0);
            double w = profile(filters[f], x);
            norm += w;
            want2 += w * x * x;
            want4 += w * x * x * x * x;
            float dx, dy;
            co_filter_sample(filters[f], (float)u, 0.5f, &dx, &dy);
            assert_true(fabs((double)dx) <= radii[f]);
            got1 += (double)dx;
            got2 += (double)dx * (double)dx;
            got4 += pow((double)dx, 4.0);
        }
        assert_true(fabs(got1 / N) < 1e-4);
        assert_true(fabs(got2 / N / (want2 / norm) - 1.0) < 2e-3);
        assert_true(fabs(got4 / N / (want4 / norm) - 1.0) < 4e-3);
    }
}

static void the_running_area_is_inverted_everywhere(void **state)
{
    (void)state;
    for (int f = 1; f < 3; f++) {
        double norm = 0.0, area = 0.0, worst = 0.0;
        for (int i = 0; i < N; i++)
            norm += profile(filters[f], radii[f] * (2.0 * (i + 0.5) / N - 1.0));
        for (int i = 0; i < N; i++) {
            double x = radii[f] * (2.0 * (i + 1.0) / N - 1.0);
            area += profile(filters[f], x - radii[f] / N) / norm;
            float dx, dy;
            co_filter_sample(filters[f], 0.5f, (float)fmin(area, 1.0), &dx, &dy);
            // In terms of probability, not of place: the tails are flat.
            worst = fmax(worst, fabs((double)dy - x) * profile(filters[f], x));
        }
        assert_true(worst < 2e-3);
    }
}

static void offsets_rise_with_the_number(void **state)
{
    (void)state;
    for (int f = 0; f < 3; f++) {
        float previous = -3.0f;
        for (int i = 0; i < N; i++) {
            float dx, dy;
            co_filter_sample(filters[f], (float)i / N, (float)i / N, &dx, &dy);
            assert_true(dx >= previous && dx == dy);
            previous = dx;
        }
    }
}

static void ends_and_center_are_where_they_belong(void **state)
{
    (void)state;
    for (int f = 0; f < 3; f++) {
        float lo, mid, hi;
        co_filter_sample(filters[f], 0.0f, 0.5f, &lo, &mid);
        co_filter_sample(filters[f], 1.0f, 0.5f, &hi, &mid);
        assert_true(mid == 0.0f && lo == -hi);
        // The last strip's area is known to a few units of 1's last place only.
        assert_true((double)hi <= radii[f] && (double)hi > 0.998 * radii[f]);
    }
}

static void tables_are_the_profiles(void **state)
{
    (void)state;
    const float *density[] = {NULL, gaussian_density, blackman_harris_density};
    const float *area[] = {NULL, gaussian_area, blackman_harris_area};
    for (int f = 1; f < 3; f++) {
        double running = 0.0;
        for (int i = 0; i < FILTER_NODES; i++) {
            double w = profile(filters[f], radii[f] * i / 64.0) / profile(filters[f], 0.0);
            assert_true(fabs((double)(density[f][i] / density[f][0]) - w) < 1e-6);
            if (i > 0)
                running += (double)(density[f][i] + density[f][i - 1]) / 128.0;
            assert_true(fabs((double)area[f][i] - running) < 1e-6);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(moments_are_those_of_the_filter),
        cmocka_unit_test(the_running_area_is_inverted_everywhere),
        cmocka_unit_test(offsets_rise_with_the_number),
        cmocka_unit_test(ends_and_center_are_where_they_belong),
        cmocka_unit_test(tables_are_the_profiles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
