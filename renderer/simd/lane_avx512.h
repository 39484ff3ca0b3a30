// Lanes of width 8 with AVX-512 (F, VL, DQ): mask registers in place of vector masks.
// What each operation means stands in lane_scalar.h.

#ifndef CO_SIMD_LANE_AVX512_H
#define CO_SIMD_LANE_AVX512_H

#include "simd/lane_256.h"

typedef __mmask8 CoLaneMask;

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
static inline CoLane co_lane_select(CoLaneMask m, CoLane a, CoLane b)
{
    return _mm256_mask_blend_ps(m, b, a);
}
static inline uint32_t co_lane_bits(CoLaneMask m)
{
    return m;
}
static inline CoLaneMask co_lane_mask(uint32_t bits)
{
    return (__mmask8)bits;
}
typedef __m512i CoLaneSets;
static inline CoLaneSets co_lane_sets_empty(void)
{
    return _mm512_setzero_si512();
}
static inline CoLaneSets co_lane_sets_put(CoLaneSets sets, CoLaneMask m, uint64_t bit)
{
    return _mm512_mask_or_epi64(sets, m, sets, _mm512_set1_epi64((long long)bit));
}
static inline void co_lane_sets_store(uint64_t *out, CoLaneSets sets)
{
    _mm512_storeu_si512(out, sets);
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
static inline CoWide co_wide_residue(CoWide a, CoWide b, CoWide p)
{
    return _mm512_fmsub_ps(a, b, p);
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
static inline CoWideMask co_wide_mask(uint32_t bits)
{
    return (__mmask16)bits;
}
static inline void co_wide_load_points(const float *points, const uint32_t *index, CoWide out[3])
{
    CoLane low[3], high[3];
    co_lane_load_points(points, index, low);
    co_lane_load_points(points, index + CO_LANE_WIDTH, high);
    for (int c = 0; c < 3; c++)
        out[c] = _mm512_insertf32x8(_mm512_castps256_ps512(low[c]), high[c], 1);
}
// Bits above the place do not count.
static inline CoWide co_wide_lookup16(const CoWide *table, const uint8_t *places, uint32_t i)
{
    __m512i low = _mm512_castsi256_si512(co_lane_places(places + i / 2));
    __m512i all = _mm512_inserti64x4(low, co_lane_places(places + i / 2 + 4), 1);
    return _mm512_permutexvar_ps(all, *table);
}

#endif
