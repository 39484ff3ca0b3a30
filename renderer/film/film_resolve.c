// From sums to the values of an AOV.
#include "film/film_state.h"

#include "base/parallel.h"

#define GRAIN 4096

typedef struct Resolve {
    const CoFilm *film;
    void *out;
    CohortAov aov;
} Resolve;

// Two's complement to double; the sign goes first so that small negative sums keep their digits.
static double wide_value(uint64_t low, uint64_t high)
{
    bool is_negative = high >> 63;
    if (is_negative) {
        low = ~low + 1;
        high = ~high + (low == 0);
    }
    double value = (double)high * 0x1p64 + (double)low;
    return is_negative ? -value : value;
}

static double color_sum(const CoFilm *film, size_t pixel, int channel, int half)
{
    const uint64_t *sum = film->shown + film->plane[CO_PLANE_COLOR] + pixel * 12 +
                          (size_t)half * 6 + (size_t)channel * 2;
    return wide_value(sum[0], sum[1]) * ldexp(1.0, film->unit_exponent - 64);
}

static double color_mean(const CoFilm *film, size_t pixel, int channel)
{
    if (film->samples == 0)
        return 0.0;
    const uint64_t *a = film->shown + film->plane[CO_PLANE_COLOR] + pixel * 12 + channel * 2;
    const uint64_t *b = a + 6;
    uint64_t low = a[0] + b[0], high = a[1] + b[1] + (low < a[0]);
    return wide_value(low, high) * ldexp(1.0, film->unit_exponent - 64) / (double)film->samples;
}

static double bounded_mean(const CoFilm *film, CoFilmPlane plane, size_t index)
{
    int64_t sum = (int64_t)film->shown[film->plane[plane] + index];
    return film->samples ? (double)sum * CO_FILM_UNIT_BOUNDED / (double)film->samples : 0.0;
}

// Standard error of the mean of (R + G + B) / 3, from the difference of the two halves:
// Var(a - b) = s^2 (1/n_a + 1/n_b) and Var(mean) = s^2 / n, so Var(mean) is estimated by
// (a - b)^2 n_a n_b / n^2. One sample says nothing about its error: infinity.
static double pixel_error(const CoFilm *film, size_t pixel)
{
    double n = (double)film->samples;
    double odd = floor(n / 2.0), even = n - odd;
    if (odd < 1.0)
        return (double)INFINITY;
    double difference = 0.0;
    for (int c = 0; c < 3; c++)
        difference += color_sum(film, pixel, c, 0) / even - color_sum(film, pixel, c, 1) / odd;
    return fabs(difference) / 3.0 * sqrt(even * odd) / n;
}

double co_film_mean_error(const CoFilm *film)
{
    double sum = 0.0;
    for (size_t pixel = 0; pixel < film->pixels; pixel++) {
        double mean = 0.0;
        for (int c = 0; c < 3; c++)
            mean += color_mean(film, pixel, c) / 3.0;
        sum += pixel_error(film, pixel) / (fmax(mean, 0.0) + 0.01);
    }
    return sum / (double)film->pixels;
}

static void resolve_first(const Resolve *r, CoFilmPlane plane, uint32_t none, size_t begin,
                          size_t end)
{
    const uint64_t *slots = r->film->shown + r->film->plane[plane];
    uint32_t *out = r->out;
    for (size_t pixel = begin; pixel < end; pixel++)
        out[pixel] = slots[pixel] == UINT64_MAX ? none : (uint32_t)slots[pixel];
}

static void resolve_vectors(const Resolve *r, CoFilmPlane plane, size_t begin, size_t end)
{
    float *out = r->out;
    for (size_t i = begin * 3; i < end * 3; i++)
        out[i] = (float)bounded_mean(r->film, plane, i);
}

static void resolve_color(const Resolve *r, size_t begin, size_t end)
{
    float *out = r->out;
    for (size_t pixel = begin; pixel < end; pixel++) {
        for (int c = 0; c < 3; c++)
            out[pixel * 4 + (size_t)c] = (float)color_mean(r->film, pixel, c);
        out[pixel * 4 + 3] = (float)bounded_mean(r->film, CO_PLANE_ALPHA, pixel);
    }
}

#define BITS_ONE 0x3f800000u      // 1.0f
#define BITS_INFINITY 0x7f800000u // INFINITY
#define BITS_MINUS_ONE UINT32_MAX // -1 as int32

static void resolve_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Resolve *r = context;
    float *out = r->out;
    (void)worker;
    switch (r->aov) {
    case COHORT_AOV_COLOR:
        resolve_color(r, begin, end);
        break;
    case COHORT_AOV_DEPTH:
        resolve_first(r, CO_PLANE_DEPTH, BITS_ONE, begin, end);
        break;
    case COHORT_AOV_CAMERA_DEPTH:
        resolve_first(r, CO_PLANE_CAMERA_DEPTH, BITS_INFINITY, begin, end);
        break;
    case COHORT_AOV_NORMAL:
        resolve_vectors(r, CO_PLANE_NORMAL, begin, end);
        break;
    case COHORT_AOV_ALBEDO:
        resolve_vectors(r, CO_PLANE_ALBEDO, begin, end);
        break;
    case COHORT_AOV_PRIM_ID:
        resolve_first(r, CO_PLANE_PRIM_ID, BITS_MINUS_ONE, begin, end);
        break;
    case COHORT_AOV_ELEMENT_ID:
        resolve_first(r, CO_PLANE_ELEMENT_ID, BITS_MINUS_ONE, begin, end);
        break;
    case COHORT_AOV_SAMPLE_COUNT:
        for (size_t pixel = begin; pixel < end; pixel++)
            out[pixel] = (float)r->film->samples;
        break;
    case COHORT_AOV_ERROR:
        for (size_t pixel = begin; pixel < end; pixel++)
            out[pixel] = (float)pixel_error(r->film, pixel);
        break;
    }
}

bool co_film_resolve(const CoFilm *film, CohortAov aov, void *out)
{
    uint32_t bit = (uint32_t)aov;
    if ((film->aovs & bit) == 0 || (bit & (bit - 1)) || bit > COHORT_AOV_ERROR)
        return false;
    Resolve resolve = {film, out, aov};
    co_parallel_for(film->pixels, GRAIN, resolve_range, &resolve);
    return true;
}
