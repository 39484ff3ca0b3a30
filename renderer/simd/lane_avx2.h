// Lanes of width 8 with AVX2. What each operation means stands in lane_scalar.h.

#ifndef CO_SIMD_LANE_AVX2_H
#define CO_SIMD_LANE_AVX2_H

#include "simd/lane_256.h"

typedef __m256 CoLaneMask;

static inline CoLaneMask co_lane_lt(CoLane a, CoLane b)
{
    return _mm256_cmp_ps(a, b, _CMP_LT_OQ);
}
static inline CoLaneMask co_lane_le(CoLane a, CoLane b)
{
    return _mm256_cmp_ps(a, b, _CMP_LE_OQ);
}
static inline CoLaneMask co_lane_ne(CoLane a, CoLane b)
{
    return _mm256_cmp_ps(a, b, _CMP_NEQ_UQ);
}
static inline CoLaneMask co_lane_and(CoLaneMask a, CoLaneMask b)
{
    return _mm256_and_ps(a, b);
}
static inline CoLane co_lane_select(CoLaneMask m, CoLane a, CoLane b)
{
    return _mm256_blendv_ps(b, a, m);
}
static inline uint32_t co_lane_bits(CoLaneMask m)
{
    return (uint32_t)_mm256_movemask_ps(m);
}
static inline CoLaneMask co_lane_mask(uint32_t bits)
{
    __m256i place = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
    return _mm256_castsi256_ps(
        _mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32((int)bits), place), place));
}
static inline CoLane co_lane_lookup16(const CoLane *table, const uint8_t *places, uint32_t i)
{
    __m256i at = co_lane_places(places + i / 2); // bit 3 chooses the half, bits above do not count
    __m256 low = _mm256_permutevar8x32_ps(table[0], at);
    __m256 high = _mm256_permutevar8x32_ps(table[1], at);
    return _mm256_blendv_ps(low, high, _mm256_castsi256_ps(_mm256_slli_epi32(at, 28)));
}
typedef struct CoLaneSets {
    __m256i low, high; // halves of the sets
} CoLaneSets;
static inline CoLaneSets co_lane_sets_empty(void)
{
    return (CoLaneSets){_mm256_setzero_si256(), _mm256_setzero_si256()};
}
static inline CoLaneSets co_lane_sets_put(CoLaneSets sets, CoLaneMask m, uint64_t bit)
{
    __m256i is_in = _mm256_castps_si256(m);
    __m256i low = _mm256_set1_epi32((int)(uint32_t)bit);
    __m256i high = _mm256_set1_epi32((int)(bit >> 32));
    sets.low = _mm256_or_si256(sets.low, _mm256_and_si256(is_in, low));
    sets.high = _mm256_or_si256(sets.high, _mm256_and_si256(is_in, high));
    return sets;
}
static inline void co_lane_sets_store(uint64_t *out, CoLaneSets sets)
{
    __m256i even = _mm256_unpacklo_epi32(sets.low, sets.high); // of lanes 0 1 4 5
    __m256i odd = _mm256_unpackhi_epi32(sets.low, sets.high);
    __m256i *to = (__m256i *)(void *)out;
    _mm256_storeu_si256(to, _mm256_permute2x128_si256(even, odd, 0x20));
    _mm256_storeu_si256(to + 1, _mm256_permute2x128_si256(even, odd, 0x31));
}

#endif
