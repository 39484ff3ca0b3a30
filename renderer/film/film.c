#include "film/film_state.h"

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "math/bits.h"

#include <string.h>

// A sum may take 2^39 values at the cap before 128 bits are full: more than 2^31 samples split 255
// ways.
#define CAP_EXPONENT 24

// Alpha, normals and albedos are bounded, so that 64 bits hold 2^31 samples of them.
#define BOUND 2.0f

#define COPY_GRAIN ((size_t)1 << 17)

_Static_assert(sizeof(_Atomic uint64_t) == sizeof(uint64_t), "the open film is copied as words");

static const struct {
    uint32_t aov; // 0: always there
    uint32_t words;
    bool is_first;
} planes[CO_PLANE_COUNT] = {
    [CO_PLANE_COLOR] = {0, 12, false},
    [CO_PLANE_ALPHA] = {0, 1, false},
    [CO_PLANE_NORMAL] = {COHORT_AOV_NORMAL, 3, false},
    [CO_PLANE_ALBEDO] = {COHORT_AOV_ALBEDO, 3, false},
    [CO_PLANE_DEPTH] = {COHORT_AOV_DEPTH, 1, true},
    [CO_PLANE_CAMERA_DEPTH] = {COHORT_AOV_CAMERA_DEPTH, 1, true},
    [CO_PLANE_PRIM_ID] = {COHORT_AOV_PRIM_ID, 1, true},
    [CO_PLANE_ELEMENT_ID] = {COHORT_AOV_ELEMENT_ID, 1, true},
};

// --- life ---------------------------------------------------------------------------------------

static bool lay_out(CoFilm *film)
{
    size_t words = CO_FILM_COUNTERS, bytes;
    for (int p = 0; p < CO_PLANE_COUNT; p++) {
        size_t size;
        if (planes[p].aov && !(film->aovs & planes[p].aov))
            continue;
        film->plane[p] = words;
        if (!co_size_mul(film->pixels, planes[p].words, &size) ||
            __builtin_add_overflow(words, size, &words))
            return false;
    }
    film->words = words;
    return co_size_mul(words, sizeof(uint64_t), &bytes);
}

uint64_t co_film_bytes(uint32_t width, uint32_t height, uint32_t aovs)
{
    uint64_t words = 0;
    for (int p = 0; p < CO_PLANE_COUNT; p++)
        if (!planes[p].aov || (aovs & planes[p].aov))
            words += planes[p].words;
    return 2 * sizeof(uint64_t) * (words * width * height + CO_FILM_COUNTERS) + sizeof(CoFilm);
}

static void clear_shown(CoFilm *film)
{
    memset(film->shown, 0, film->words * sizeof *film->shown);
    for (int p = 0; p < CO_PLANE_COUNT; p++)
        if (planes[p].is_first && film->plane[p])
            memset(film->shown + film->plane[p], 0xff, film->pixels * sizeof *film->shown);
    film->samples = 0;
}

CoFilm *co_film_create(uint32_t width, uint32_t height, uint32_t aovs, int unit_exponent,
                       CohortError *err)
{
    CO_CHECK_NULL(width && height && unit_exponent >= -60 && unit_exponent <= 120, err,
                  COHORT_ERROR_ARGUMENT, "no film of %u x %u pixels in units of 2^%d", width,
                  height, unit_exponent);
    CoFilm *film = co_alloc_zero(CO_MEMORY_FILM, sizeof *film);
    CO_CHECK_NULL(film, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    film->width = width;
    film->height = height;
    film->aovs = aovs | COHORT_AOV_COLOR;
    film->unit_exponent = unit_exponent;
    film->pixels = (size_t)width * height;
    film->cap = ldexpf(1.0f, unit_exponent + CAP_EXPONENT); // infinite where no float can pass it
    if (lay_out(film)) {
        film->open = co_alloc(CO_MEMORY_FILM, film->words * sizeof *film->open);
        film->shown = co_alloc(CO_MEMORY_FILM, film->words * sizeof *film->shown);
    }
    if (!film->open || !film->shown) {
        co_film_destroy(film);
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "not enough memory for a film of %u x %u pixels",
                width, height);
        return NULL;
    }
    clear_shown(film);
    co_film_revert(film);
    return film;
}

void co_film_destroy(CoFilm *film)
{
    if (!film)
        return;
    co_free(CO_MEMORY_FILM, film->open, film->words * sizeof *film->open);
    co_free(CO_MEMORY_FILM, film->shown, film->words * sizeof *film->shown);
    co_free(CO_MEMORY_FILM, film, sizeof *film);
}

void co_film_set_alone(CoFilm *film, bool is_alone)
{
    film->is_alone = is_alone;
}

// --- adding -------------------------------------------------------------------------------------

static void count(CoFilm *film, int counter)
{
    atomic_fetch_add_explicit(&film->open[counter], 1, memory_order_relaxed);
}

// Relaxed order is enough: sums modulo 2^128 commute, and every carry out of the low word is seen
// by exactly one addition, which hands it on. Readers come after the parallel section has ended.
static void add_shared(_Atomic uint64_t *sum, uint64_t low, uint64_t high)
{
    uint64_t before = atomic_fetch_add_explicit(&sum[0], low, memory_order_relaxed);
    high += before + low < before;
    if (high)
        atomic_fetch_add_explicit(&sum[1], high, memory_order_relaxed);
}

// A locked addition waits for every store before it: three to six per color are a cost.
static void add_alone(_Atomic uint64_t *sum, uint64_t low, uint64_t high)
{
    uint64_t before = atomic_load_explicit(&sum[0], memory_order_relaxed);
    high += before + low < before;
    atomic_store_explicit(&sum[0], before + low, memory_order_relaxed);
    high += atomic_load_explicit(&sum[1], memory_order_relaxed);
    atomic_store_explicit(&sum[1], high, memory_order_relaxed);
}

// Adds round(value / 2^(unit_exponent - 64)), halves away from zero, with integers only. A float is
// mantissa * 2^shift units; the cap keeps shift at 64 or below.
static void add_fixed(const CoFilm *film, _Atomic uint64_t *sum, float value)
{
    int unit_exponent = film->unit_exponent;
    uint32_t bits = co_float_bits(value);
    uint32_t exponent = bits >> 23 & 255u;
    uint64_t mantissa = exponent ? (bits & 0x7fffffu) | 0x800000u : bits & 0x7fffffu;
    int shift = (exponent ? (int)exponent : 1) - 150 + 64 - unit_exponent;
    uint64_t low = 0, high = 0;
    if (shift >= 64) {
        high = mantissa << (shift - 64);
    } else if (shift > 0) {
        low = mantissa << shift;
        high = mantissa >> (64 - shift);
    } else if (shift > -25) {
        low = (mantissa + ((uint64_t)1 << -shift >> 1)) >> -shift;
    }
    if (bits >> 31) {
        low = ~low + 1;
        high = ~high + (low == 0);
    }
    if (!(low | high))
        return;
    if (film->is_alone)
        add_alone(sum, low, high);
    else
        add_shared(sum, low, high);
}

static size_t color_word(const CoFilm *film, uint32_t pixel, uint32_t sample)
{
    return film->plane[CO_PLANE_COLOR] + (size_t)pixel * 12 + (sample & 1u) * 6;
}

void co_film_ask_ahead(const CoFilm *film, uint32_t pixel, uint32_t sample)
{
    const _Atomic uint64_t *sum = film->open + color_word(film, pixel, sample);
    __builtin_prefetch(sum, 1);
    __builtin_prefetch(sum + 5, 1);
}

void co_film_add_color(CoFilm *film, uint32_t pixel, uint32_t sample, CoVec3 rgb)
{
    CO_ASSERT(pixel < film->pixels);
    if (!co_is_finite3(rgb)) {
        count(film, CO_FILM_DROPPED);
        return;
    }
    _Atomic uint64_t *sum = film->open + color_word(film, pixel, sample);
    const float channels[3] = {rgb.x, rgb.y, rgb.z};
    bool is_saturated = false;
    for (int c = 0; c < 3; c++) {
        float value = channels[c];
        if (fabsf(value) > film->cap) {
            value = copysignf(film->cap, value);
            is_saturated = true;
        }
        add_fixed(film, sum + (size_t)c * 2, value);
    }
    if (is_saturated)
        count(film, CO_FILM_SATURATIONS);
}

// NaN counts as dropped; beyond the bound counts as saturated.
static void add_bounded(CoFilm *film, _Atomic uint64_t *sum, float value)
{
    if (isnan(value)) {
        count(film, CO_FILM_DROPPED);
        return;
    }
    if (fabsf(value) > BOUND) {
        value = copysignf(BOUND, value);
        count(film, CO_FILM_SATURATIONS);
    }
    int64_t units = (int64_t)floor((double)value / CO_FILM_UNIT_BOUNDED + 0.5);
    if (film->is_alone)
        atomic_store_explicit(sum,
                              atomic_load_explicit(sum, memory_order_relaxed) + (uint64_t)units,
                              memory_order_relaxed);
    else if (units)
        atomic_fetch_add_explicit(sum, (uint64_t)units, memory_order_relaxed);
}

void co_film_add_alpha(CoFilm *film, uint32_t pixel, uint32_t sample, float alpha)
{
    CO_ASSERT(pixel < film->pixels);
    (void)sample;
    add_bounded(film, film->open + film->plane[CO_PLANE_ALPHA] + pixel, alpha);
}

// The value of the lowest sample wins, whoever comes first. A sample has one camera ray, so two
// additions never share a key.
static void keep_first(CoFilm *film, CoFilmPlane plane, uint32_t pixel, uint32_t sample,
                       uint32_t bits)
{
    if (!film->plane[plane])
        return;
    _Atomic uint64_t *slot = film->open + film->plane[plane] + pixel;
    uint64_t mine = (uint64_t)sample << 32 | bits;
    uint64_t held = atomic_load_explicit(slot, memory_order_relaxed);
    while (mine < held && !atomic_compare_exchange_weak_explicit(
                              slot, &held, mine, memory_order_relaxed, memory_order_relaxed))
        ;
}

static void add_vector(CoFilm *film, CoFilmPlane plane, uint32_t pixel, CoVec3 v)
{
    if (!film->plane[plane])
        return;
    _Atomic uint64_t *sum = film->open + film->plane[plane] + (size_t)pixel * 3;
    add_bounded(film, sum, v.x);
    add_bounded(film, sum + 1, v.y);
    add_bounded(film, sum + 2, v.z);
}

void co_film_add_first(CoFilm *film, uint32_t pixel, uint32_t sample, const CoFirstHit *hit)
{
    CO_ASSERT(pixel < film->pixels);
    add_vector(film, CO_PLANE_NORMAL, pixel, hit->normal);
    add_vector(film, CO_PLANE_ALBEDO, pixel, hit->albedo);
    keep_first(film, CO_PLANE_DEPTH, pixel, sample, co_float_bits(hit->depth));
    keep_first(film, CO_PLANE_CAMERA_DEPTH, pixel, sample, co_float_bits(hit->camera_depth));
    keep_first(film, CO_PLANE_PRIM_ID, pixel, sample, (uint32_t)hit->prim_id);
    keep_first(film, CO_PLANE_ELEMENT_ID, pixel, sample, (uint32_t)hit->element_id);
}

// --- rounds -------------------------------------------------------------------------------------

typedef struct Copy {
    void *to;
    const void *from;
} Copy;

static void copy_words(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Copy *copy = context;
    (void)worker;
    memcpy((uint64_t *)copy->to + begin, (const uint64_t *)copy->from + begin,
           (end - begin) * sizeof(uint64_t));
}

bool co_film_complete(CoFilm *film, uint64_t samples, CohortError *err)
{
    CO_CHECK(samples >= film->samples && samples <= (uint64_t)1 << 31, err, COHORT_ERROR_ARGUMENT,
             "%llu samples per pixel after %llu: a film takes up to 2^31",
             (unsigned long long)samples, (unsigned long long)film->samples);
    Copy copy = {film->shown, film->open};
    co_parallel_for(film->words, COPY_GRAIN, copy_words, &copy);
    film->samples = samples;
    return true;
}

void co_film_revert(CoFilm *film)
{
    Copy copy = {film->open, film->shown};
    co_parallel_for(film->words, COPY_GRAIN, copy_words, &copy);
}

uint64_t co_film_samples(const CoFilm *film)
{
    return film->samples;
}

uint64_t co_film_saturations(const CoFilm *film)
{
    return film->shown[CO_FILM_SATURATIONS];
}

uint64_t co_film_dropped(const CoFilm *film)
{
    return film->shown[CO_FILM_DROPPED];
}
