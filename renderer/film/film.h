// The film: sums of 128 bits per channel that do not depend on the order of additions.
//
// Units: S * 2^-64, S a power of two above the brightest emitter, fixed at creation. Two half-films
// (even and odd samples) give the error estimate. Ids and depths keep the lowest sample's value.
// Threads: adds may come from any thread at once; the rest from one.

#ifndef CO_FILM_FILM_H
#define CO_FILM_FILM_H

#include "cohort/render.h"
#include "math/vec.h"

typedef struct CoFilm CoFilm;

// aovs: CohortAov bits; color is always there, planes for the rest only if asked for.
// unit_exponent: S = 2^unit_exponent, -60 to 120. NULL with *err set on failure; caller destroys.
CoFilm *co_film_create(uint32_t width, uint32_t height, uint32_t aovs, int unit_exponent,
                       CohortError *err);
void co_film_destroy(CoFilm *film);

// Whether adds come from one thread at a time, which needs no locked additions. False after
// creation.
void co_film_set_alone(CoFilm *film, bool is_alone);

// Bytes that such a film takes.
uint64_t co_film_bytes(uint32_t width, uint32_t height, uint32_t aovs);

// pixel = y * width + x, y from the top. sample = absolute index; its lowest bit picks the half.
// NaN and infinite values are counted and dropped. Colors beyond S * 2^24, and alphas, normals and
// albedos beyond 2, are cut there and counted as saturations.
void co_film_add_color(CoFilm *film, uint32_t pixel, uint32_t sample, CoVec3 rgb);
void co_film_ask_ahead(const CoFilm *film, uint32_t pixel, uint32_t sample); // a color is to come
void co_film_add_alpha(CoFilm *film, uint32_t pixel, uint32_t sample, float alpha);

// What the camera ray of a sample met first.
typedef struct CoFirstHit {
    float depth, camera_depth;
    CoVec3 normal, albedo;
    int32_t prim_id, element_id;
} CoFirstHit;
// Once per sample that hit something. Normal and albedo are summed (filtered); the others keep the
// value of the lowest sample.
void co_film_add_first(CoFilm *film, uint32_t pixel, uint32_t sample, const CoFirstHit *hit);

// A round is complete: `samples` per pixel in total are in. Copies the open film to the shown one.
// cancelled rounds instead go back: co_film_revert.
bool co_film_complete(CoFilm *film, uint64_t samples, CohortError *err);
void co_film_revert(CoFilm *film);

// Of the last complete round. Layouts as cohort_render_aov; false when the AOV was not asked for.
// The error is estimated from the difference of the two halves; with one sample it is infinite.
uint64_t co_film_samples(const CoFilm *film);
bool co_film_resolve(const CoFilm *film, CohortAov aov, void *out);
double co_film_mean_error(const CoFilm *film); // mean over pixels of error / (mean + 0.01)
uint64_t co_film_saturations(const CoFilm *film);
uint64_t co_film_dropped(const CoFilm *film); // NaN and infinite values

// Complete round to and from a file (zlib or libdeflate compressed, checked by hash), replaced
// atomically. `key` says what the film belongs to: stage, seed and image settings. A file with
// another key, size, AOVs or unit, a foreign, truncated or damaged one is refused with a message
// that says which, and the film is left as it was. A failed save leaves an older file at `path` as
// it was.
bool co_film_save(const CoFilm *film, const char *path, uint64_t key, CohortError *err);
bool co_film_load(CoFilm *film, const char *path, uint64_t key, CohortError *err);

#endif
