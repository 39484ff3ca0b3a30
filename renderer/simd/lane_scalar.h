// Lanes of width 1: the specification of the others.

#ifndef CO_SIMD_LANE_SCALAR_H
#define CO_SIMD_LANE_SCALAR_H

#include "simd/residue.h"

#include <stdint.h>

enum {
    CO_LANE_WIDTH = 1
};
typedef float CoLane;
typedef uint32_t CoLaneMask; // 0 or 1

static inline CoLane co_lane_load(const float *p)
{
    return *p;
}
static inline void co_lane_store(float *p, CoLane a)
{
    *p = a;
}
static inline CoLane co_lane_set1(float a)
{
    return a;
}
static inline CoLane co_lane_add(CoLane a, CoLane b)
{
    return a + b;
}
static inline CoLane co_lane_sub(CoLane a, CoLane b)
{
    return a - b;
}
static inline CoLane co_lane_mul(CoLane a, CoLane b)
{
    return a * b;
}
static inline CoLane co_lane_div(CoLane a, CoLane b)
{
    return a / b;
}
// a * b + c, with one rounding or two.
static inline CoLane co_lane_muladd(CoLane a, CoLane b, CoLane c)
{
    return a * b + c;
}
static inline CoLane co_lane_residue(CoLane a, CoLane b, CoLane p)
{
    return co_float_residue(a, b, p);
}
static inline CoLane co_lane_min(CoLane a, CoLane b)
{
    return a < b ? a : b;
}
static inline CoLane co_lane_max(CoLane a, CoLane b)
{
    return a > b ? a : b;
}
static inline CoLane co_lane_abs(CoLane a)
{
    return __builtin_fabsf(a);
}
// The magnitude of a with the sign of b.
static inline CoLane co_lane_copysign(CoLane a, CoLane b)
{
    return __builtin_copysignf(a, b);
}
static inline CoLaneMask co_lane_lt(CoLane a, CoLane b)
{
    return a < b;
}
static inline CoLaneMask co_lane_le(CoLane a, CoLane b)
{
    return a <= b;
}
static inline CoLaneMask co_lane_ne(CoLane a, CoLane b)
{
    return a != b;
}
static inline CoLaneMask co_lane_and(CoLaneMask a, CoLaneMask b)
{
    return a & b;
}
// a where m, else b.
static inline CoLane co_lane_select(CoLaneMask m, CoLane a, CoLane b)
{
    return m ? a : b;
}
// One bit per lane, lane 0 lowest.
static inline uint32_t co_lane_bits(CoLaneMask m)
{
    return m;
}
// The other way; bits beyond the lanes do not matter.
static inline CoLaneMask co_lane_mask(uint32_t bits)
{
    return bits & 1u;
}
// Per lane a set of up to 64 things, from none on.
typedef uint64_t CoLaneSets;
static inline CoLaneSets co_lane_sets_empty(void)
{
    return 0;
}
// Puts one thing, a bit, into the sets of the lanes m.
static inline CoLaneSets co_lane_sets_put(CoLaneSets sets, CoLaneMask m, uint64_t bit)
{
    return sets | (m ? bit : 0);
}
static inline void co_lane_sets_store(uint64_t *out, CoLaneSets sets)
{
    *out = sets;
}
// Of a table of 16 numbers those for lanes i on, a multiple of the width; places are 4 bits each,
// the lower of a byte first. Reads places of 16.
static inline CoLane co_lane_lookup16(const CoLane *table, const uint8_t *places, uint32_t i)
{
    return table[places[i / 2] >> 4 * (i & 1) & 15];
}
// The same, places below 8.
#define co_lane_lookup8 co_lane_lookup16
// Bytes as numbers.
static inline CoLane co_lane_load_bytes(const uint8_t *p)
{
    return (float)*p;
}
// Points as lanes of x, y and z: lane k is points[3 index[k] ..]. Reads one float behind each.
// Of CO_LANE_WIDTH runs of numbers, up from a word or, where its highest bit is set, down from the
// rest of it, the number that is so many steps on.
static inline void co_lane_along(const uint32_t words[9], const uint8_t *which,
                                 const uint8_t *steps, uint32_t *out)
{
    for (int k = 0; k < CO_LANE_WIDTH; k++) {
        const uint32_t word = words[which[k]], first = word & INT32_MAX;
        out[k] = word >> 31 ? first - steps[k] : first + steps[k];
    }
}
static inline void co_lane_load_points(const float *points, const uint32_t *index, CoLane out[3])
{
    for (int c = 0; c < 3; c++)
        out[c] = points[3 * (uint64_t)*index + (uint64_t)c];
}
// Least of eight, the first of those that are equal: makes it 0xffff and returns its place, with
// the least of what is left then in the upper 16 bits.
static inline uint32_t co_take_least(uint16_t v[8])
{
    uint32_t place = 0, left = 0;
    for (uint32_t i = 1; i < 8; i++)
        place = v[i] < v[place] ? i : place;
    v[place] = 0xffff;
    for (uint32_t i = 1; i < 8; i++)
        left = v[i] < v[left] ? i : left;
    return place | (uint32_t)v[left] << 16;
}

#endif
