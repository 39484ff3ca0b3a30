// The film's memory, shared by the room's own files only.
//
// One array of 64-bit words: two counters, then a plane per channel. A copy of it holds the last
// complete round.

#ifndef CO_FILM_FILM_STATE_H
#define CO_FILM_FILM_STATE_H

#include "film/film.h"

#include <stdatomic.h>

// Value of one unit of the sums of alpha, normals and albedos.
#define CO_FILM_UNIT_BOUNDED 0x1p-30

// Planes in file order. Words per pixel: color [half][channel][low, high]; sums of normals and
// albedos one per component; the rest (sample << 32 | bits of the value), all ones where empty.
typedef enum CoFilmPlane {
    CO_PLANE_COLOR = 0,
    CO_PLANE_ALPHA,
    CO_PLANE_NORMAL,
    CO_PLANE_ALBEDO,
    CO_PLANE_DEPTH,
    CO_PLANE_CAMERA_DEPTH,
    CO_PLANE_PRIM_ID,
    CO_PLANE_ELEMENT_ID,
    CO_PLANE_COUNT
} CoFilmPlane;

enum {
    CO_FILM_SATURATIONS = 0,
    CO_FILM_DROPPED = 1,
    CO_FILM_COUNTERS = 8
};

struct CoFilm {
    uint32_t width, height, aovs;
    bool is_alone; // one thread adds
    int unit_exponent;
    float cap; // largest magnitude of a color that is added as it is
    size_t pixels, words;
    size_t plane[CO_PLANE_COUNT]; // first word, 0 where the plane is not there
    _Atomic uint64_t *open;       // the round that runs
    uint64_t *shown;              // the last complete one
    uint64_t samples;             // per pixel, in `shown`
};

#endif
