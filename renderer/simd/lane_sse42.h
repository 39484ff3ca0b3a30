// Lanes of width 4 with SSE4.2. What each operation means stands in lane_scalar.h.

#ifndef CO_SIMD_LANE_SSE42_H
#define CO_SIMD_LANE_SSE42_H

#include "simd/take_least.h"

#include <nmmintrin.h>
#include <stdint.h>

enum {
    CO_LANE_WIDTH = 4
};
typedef __m128 CoLane;
typedef __m128 CoLaneMask;

static inline CoLane co_lane_load(const float *p)
{
    return _mm_loadu_ps(p);
}
static inline void co_lane_store(float *p, CoLane a)
{
    _mm_storeu_ps(p, a);
}
static inline CoLane co_lane_set1(float a)
{
    return _mm_set1_ps(a);
}
static inline CoLane co_lane_add(CoLane a, CoLane b)
{
    return _mm_add_ps(a, b);
}
static inline CoLane co_lane_sub(CoLane a, CoLane b)
{
    return _mm_sub_ps(a, b);
}
static inline CoLane co_lane_mul(CoLane a, CoLane b)
{
    return _mm_mul_ps(a, b);
}
static inline CoLane co_lane_div(CoLane a, CoLane b)
{
    return _mm_div_ps(a, b);
}
static inline CoLane co_lane_muladd(CoLane a, CoLane b, CoLane c)
{
    return _mm_add_ps(_mm_mul_ps(a, b), c);
}
static inline CoLane co_lane_residue(CoLane a, CoLane b, CoLane p)
{
    __m128d low = _mm_mul_pd(_mm_cvtps_pd(a), _mm_cvtps_pd(b));
    __m128d high = _mm_mul_pd(_mm_cvtps_pd(_mm_movehl_ps(a, a)), _mm_cvtps_pd(_mm_movehl_ps(b, b)));
    low = _mm_sub_pd(low, _mm_cvtps_pd(p));
    high = _mm_sub_pd(high, _mm_cvtps_pd(_mm_movehl_ps(p, p)));
    return _mm_movelh_ps(_mm_cvtpd_ps(low), _mm_cvtpd_ps(high));
}
static inline CoLane co_lane_min(CoLane a, CoLane b)
{
    return _mm_min_ps(a, b);
}
static inline CoLane co_lane_max(CoLane a, CoLane b)
{
    return _mm_max_ps(a, b);
}
static inline CoLane co_lane_abs(CoLane a)
{
    return _mm_andnot_ps(_mm_set1_ps(-0.0f), a);
}
static inline CoLane co_lane_copysign(CoLane a, CoLane b)
{
    __m128 sign = _mm_set1_ps(-0.0f);
    return _mm_or_ps(_mm_andnot_ps(sign, a), _mm_and_ps(sign, b));
}
static inline CoLaneMask co_lane_lt(CoLane a, CoLane b)
{
    return _mm_cmplt_ps(a, b);
}
static inline CoLaneMask co_lane_le(CoLane a, CoLane b)
{
    return _mm_cmple_ps(a, b);
}
static inline CoLaneMask co_lane_ne(CoLane a, CoLane b)
{
    return _mm_cmpneq_ps(a, b);
}
static inline CoLaneMask co_lane_and(CoLaneMask a, CoLaneMask b)
{
    return _mm_and_ps(a, b);
}
static inline CoLane co_lane_select(CoLaneMask m, CoLane a, CoLane b)
{
    return _mm_blendv_ps(b, a, m);
}
static inline uint32_t co_lane_bits(CoLaneMask m)
{
    return (uint32_t)_mm_movemask_ps(m);
}
static inline CoLaneMask co_lane_mask(uint32_t bits)
{
    __m128i place = _mm_setr_epi32(1, 2, 4, 8);
    return _mm_castsi128_ps(
        _mm_cmpeq_epi32(_mm_and_si128(_mm_set1_epi32((int)bits), place), place));
}
typedef struct CoLaneSets {
    __m128i low, high; // halves of the sets
} CoLaneSets;
static inline CoLaneSets co_lane_sets_empty(void)
{
    return (CoLaneSets){_mm_setzero_si128(), _mm_setzero_si128()};
}
static inline CoLaneSets co_lane_sets_put(CoLaneSets sets, CoLaneMask m, uint64_t bit)
{
    __m128i is_in = _mm_castps_si128(m);
    __m128i low = _mm_set1_epi32((int)(uint32_t)bit), high = _mm_set1_epi32((int)(bit >> 32));
    sets.low = _mm_or_si128(sets.low, _mm_and_si128(is_in, low));
    sets.high = _mm_or_si128(sets.high, _mm_and_si128(is_in, high));
    return sets;
}
static inline void co_lane_sets_store(uint64_t *out, CoLaneSets sets)
{
    __m128i *to = (__m128i *)(void *)out;
    _mm_storeu_si128(to, _mm_unpacklo_epi32(sets.low, sets.high));
    _mm_storeu_si128(to + 1, _mm_unpackhi_epi32(sets.low, sets.high));
}
static inline CoLane co_lane_lookup16(const CoLane *table, const uint8_t *places, uint32_t i)
{
    const float *at = (const float *)table;
    uint32_t low = places[i / 2], high = places[i / 2 + 1];
    return _mm_setr_ps(at[low & 15], at[low >> 4], at[high & 15], at[high >> 4]);
}
#define co_lane_lookup8 co_lane_lookup16
static inline CoLane co_lane_load_bytes(const uint8_t *p)
{
    __m128i bytes = _mm_loadu_si32(p);
    return _mm_cvtepi32_ps(_mm_cvtepu8_epi32(bytes));
}
// As lane_scalar.h has it.
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
    __m128 a = _mm_loadu_ps(points + 3 * (uint64_t)index[0]);
    __m128 b = _mm_loadu_ps(points + 3 * (uint64_t)index[1]);
    __m128 c = _mm_loadu_ps(points + 3 * (uint64_t)index[2]);
    __m128 d = _mm_loadu_ps(points + 3 * (uint64_t)index[3]);
    __m128 ab = _mm_unpacklo_ps(a, b), cd = _mm_unpacklo_ps(c, d);
    out[0] = _mm_movelh_ps(ab, cd);
    out[1] = _mm_movehl_ps(cd, ab);
    out[2] = _mm_movelh_ps(_mm_unpackhi_ps(a, b), _mm_unpackhi_ps(c, d));
}
#endif
