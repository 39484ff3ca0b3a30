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

// aovs: CohortAov bits. unit_exponent: S = 2^unit_exponent.
CoFilm *co_film_create(uint32_t width, uint32_t height, uint32_t aovs, int unit_exponent,
                       CohortError *err);
void co_film_destroy(CoFilm *film);

// pixel = y * width + x, y from the top. sample = absolute index; its lowest bit picks the half.
// NaN and infinite values are counted and dropped.
void co_film_add_color(CoFilm *film, uint32_t pixel, uint32_t sample, CoVec3 rgb);
void co_film_add_alpha(CoFilm *film, uint32_t pixel, uint32_t sample, float alpha);

// What the camera ray of a sample met first.
typedef struct CoFirstHit {
    float depth, camera_depth;
    CoVec3 normal, albedo;
    int32_t prim_id, element_id;
} CoFirstHit;
void co_film_add_first(CoFilm *film, uint32_t pixel, uint32_t sample, const CoFirstHit *hit);

// A round is complete: `samples` per pixel in total are in. Copies the open film to the shown one.
// cancelled rounds instead go back: co_film_revert.
bool co_film_complete(CoFilm *film, uint64_t samples, CohortError *err);
void co_film_revert(CoFilm *film);

// Of the last complete round. Layouts as cohort_render_aov.
uint64_t co_film_samples(const CoFilm *film);
bool co_film_resolve(const CoFilm *film, CohortAov aov, void *out);
double co_film_mean_error(const CoFilm *film); // mean over pixels of error / (mean + 0.01)
uint64_t co_film_saturations(const CoFilm *film);

// Complete round to and from a file (zlib or libdeflate compressed, checked by hash), replaced atomically.
// `key` says what the film belongs to; a file with another key is refused, naming `what`.
bool co_film_save(const CoFilm *film, const char *path, uint64_t key, CohortError *err);
bool co_film_load(CoFilm *film, const char *path, uint64_t key, CohortError *err);

#endif
