// Lanes of width 8 with AVX-512 (F, VL, DQ): mask registers in place of vector masks.
// What each operation means stands in lane_scalar.h.

#ifndef CO_SIMD_LANE_AVX512_H
#define CO_SIMD_LANE_AVX512_H

#include <immintrin.h>
#include <stdint.h>

enum {
    CO_LANE_WIDTH = 8
};
typedef __m256 CoLane;
typedef __mmask8 CoLaneMask;

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
static inline CoLaneMask co_lane_lt(CoLane a, CoLane b)
{
    return _mm256_cmp_ps_mask(a, b, _CMP_LT_OQ);
}
static inline CoLaneMask co_lane_le(CoLane a, CoLane b)
{
    return _mm256_cmp_ps_mask(a, b, _CMP_LE_OQ);
}
static inline CoLaneMask co_lane_ne(CoLane a, CoLane b)
{
    return _mm256_cmp_ps_mask(a, b, _CMP_NEQ_UQ);
}
static inline CoLaneMask co_lane_and(CoLaneMask a, CoLaneMask b)
{
    return (__mmask8)(a & b);
}
static inline CoLaneMask co_lane_or(CoLaneMask a, CoLaneMask b)
{
    return (__mmask8)(a | b);
}
static inline CoLane co_lane_select(CoLaneMask m, CoLane a, CoLane b)
{
    return _mm256_mask_blend_ps(m, b, a);
}
static inline uint32_t co_lane_bits(CoLaneMask m)
{
    return m;
}
static inline CoLane co_lane_lookup8(const float *table, const uint8_t *index)
{
    __m128i bytes = _mm_loadl_epi64((const __m128i *)(const void *)index);
    return _mm256_permutevar8x32_ps(_mm256_loadu_ps(table), _mm256_cvtepu8_epi32(bytes));
}
static inline CoLane co_lane_load_bytes(const uint8_t *p)
{
    __m128i bytes = _mm_loadl_epi64((const __m128i *)(const void *)p);
    return _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(bytes));
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

enum {
    CO_WIDE_WIDTH = 16
};
typedef __m512 CoWide;
typedef __mmask16 CoWideMask;

static inline CoWide co_wide_load(const float *p)
{
    return _mm512_loadu_ps(p);
}
static inline void co_wide_store(float *p, CoWide a)
{
    _mm512_storeu_ps(p, a);
}
static inline CoWide co_wide_set1(float a)
{
    return _mm512_set1_ps(a);
}
static inline CoWide co_wide_add(CoWide a, CoWide b)
{
    return _mm512_add_ps(a, b);
}
static inline CoWide co_wide_sub(CoWide a, CoWide b)
{
    return _mm512_sub_ps(a, b);
}
static inline CoWide co_wide_mul(CoWide a, CoWide b)
{
    return _mm512_mul_ps(a, b);
}
static inline CoWide co_wide_div(CoWide a, CoWide b)
{
    return _mm512_div_ps(a, b);
}
static inline CoWide co_wide_min(CoWide a, CoWide b)
{
    return _mm512_min_ps(a, b);
}
static inline CoWide co_wide_max(CoWide a, CoWide b)
{
    return _mm512_max_ps(a, b);
}
static inline CoWide co_wide_muladd(CoWide a, CoWide b, CoWide c)
{
    return _mm512_fmadd_ps(a, b, c);
}
static inline CoWide co_wide_abs(CoWide a)
{
    return _mm512_andnot_ps(_mm512_set1_ps(-0.0f), a);
}
static inline CoWide co_wide_copysign(CoWide a, CoWide b)
{
    __m512 sign = _mm512_set1_ps(-0.0f);
    return _mm512_or_ps(_mm512_andnot_ps(sign, a), _mm512_and_ps(sign, b));
}
static inline CoWideMask co_wide_lt(CoWide a, CoWide b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ);
}
static inline CoWideMask co_wide_le(CoWide a, CoWide b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ);
}
static inline CoWideMask co_wide_ne(CoWide a, CoWide b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_NEQ_UQ);
}
static inline CoWideMask co_wide_and(CoWideMask a, CoWideMask b)
{
    return (__mmask16)(a & b);
}
static inline CoWide co_wide_select(CoWideMask m, CoWide a, CoWide b)
{
    return _mm512_mask_blend_ps(m, b, a);
}
static inline uint32_t co_wide_bits(CoWideMask m)
{
    return m;
}

#endif
