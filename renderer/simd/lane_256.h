// Lanes of width 8 in 256-bit registers: all that AVX2 and AVX-512 have in common, which is
// everything but masks. What each operation means stands in lane_scalar.h.

#ifndef CO_SIMD_LANE_256_H
#define CO_SIMD_LANE_256_H

#include "simd/take_least.h"

#include <immintrin.h>
#include <stdint.h>

enum {
    CO_LANE_WIDTH = 8
};
typedef __m256 CoLane;

static inline CoLane co_lane_load(const float *p)
{
    return _mm256_loadu_ps(p);
}
static inline void co_lane_store(float *p, CoLane a)
{
    _mm256_storeu_ps(p, a);
}
static inline CoLane co_lane_set1(float a)
{
    return _mm256_set1_ps(a);
}
static inline CoLane co_lane_add(CoLane a, CoLane b)
{
    return _mm256_add_ps(a, b);
}
static inline CoLane co_lane_sub(CoLane a, CoLane b)
{
    return _mm256_sub_ps(a, b);
}
static inline CoLane co_lane_mul(CoLane a, CoLane b)
{
    return _mm256_mul_ps(a, b);
}
static inline CoLane co_lane_div(CoLane a, CoLane b)
{
    return _mm256_div_ps(a, b);
}
static inline CoLane co_lane_muladd(CoLane a, CoLane b, CoLane c)
{
    return _mm256_fmadd_ps(a, b, c);
}
static inline CoLane co_lane_residue(CoLane a, CoLane b, CoLane p)
{
    return _mm256_fmsub_ps(a, b, p);
}
static inline CoLane co_lane_min(CoLane a, CoLane b)
{
    return _mm256_min_ps(a, b);
}
static inline CoLane co_lane_max(CoLane a, CoLane b)
{
    return _mm256_max_ps(a, b);
}
static inline CoLane co_lane_abs(CoLane a)
{
    return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a);
}
static inline CoLane co_lane_copysign(CoLane a, CoLane b)
{
    __m256 sign = _mm256_set1_ps(-0.0f);
    return _mm256_or_ps(_mm256_andnot_ps(sign, a), _mm256_and_ps(sign, b));
}
// 8 places of 4 bits, each in the lowest of a lane.
static inline __m256i co_lane_places(const uint8_t *places)
{
    __m256i all = _mm256_broadcastd_epi32(_mm_loadu_si32(places));
    return _mm256_srlv_epi32(all, _mm256_setr_epi32(0, 4, 8, 12, 16, 20, 24, 28));
}
static inline CoLane co_lane_lookup8(const CoLane *table, const uint8_t *places, uint32_t i)
{
    return _mm256_permutevar8x32_ps(*table, co_lane_places(places + i / 2));
}
static inline CoLane co_lane_load_bytes(const uint8_t *p)
{
    __m128i bytes = _mm_loadl_epi64((const __m128i *)(const void *)p);
    return _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(bytes));
}
// As lane_scalar.h has it.
static inline void co_lane_along(const uint32_t words[9], const uint8_t *which,
                                 const uint8_t *steps, uint32_t *out)
{
    __m256i at = _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)(const void *)which));
    __m256i step = _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)(const void *)steps));
    __m256i low = _mm256_loadu_si256((const __m256i *)(const void *)words);
    __m256 word = _mm256_castsi256_ps(_mm256_permutevar8x32_epi32(low, at));
    __m256 ninth = _mm256_castsi256_ps(_mm256_set1_epi32((int)words[8]));
    word = _mm256_blendv_ps(word, ninth, _mm256_castsi256_ps(_mm256_slli_epi32(at, 28)));
    __m256i all = _mm256_castps_si256(word);
    __m256i on = _mm256_sign_epi32(step, _mm256_or_si256(all, _mm256_set1_epi32(1)));
    __m256i first = _mm256_and_si256(all, _mm256_set1_epi32(INT32_MAX));
    _mm256_storeu_si256((__m256i *)(void *)out, _mm256_add_epi32(first, on));
}
// Points k and k + 4 side by side.
static inline __m256 co_lane_point_pair(const float *points, const uint32_t *index)
{
    __m128 low = _mm_loadu_ps(points + 3 * (uint64_t)index[0]);
    __m128 high = _mm_loadu_ps(points + 3 * (uint64_t)index[4]);
    return _mm256_insertf128_ps(_mm256_castps128_ps256(low), high, 1);
}
static inline void co_lane_load_points(const float *points, const uint32_t *index, CoLane out[3])
{
    __m256 a = co_lane_point_pair(points, index), b = co_lane_point_pair(points, index + 1);
    __m256 c = co_lane_point_pair(points, index + 2), d = co_lane_point_pair(points, index + 3);
    __m256 ab = _mm256_unpacklo_ps(a, b), cd = _mm256_unpacklo_ps(c, d);
    out[0] = _mm256_shuffle_ps(ab, cd, 0x44);
    out[1] = _mm256_shuffle_ps(ab, cd, 0xee);
    out[2] = _mm256_shuffle_ps(_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d), 0x44);
}
#endif
