// The place of the least of eight numbers, by SSE4.1's minimum: for all widths but the scalar one.
// What it means stands in lane_scalar.h.

#ifndef CO_SIMD_TAKE_LEAST_H
#define CO_SIMD_TAKE_LEAST_H

#include <smmintrin.h>
#include <stdint.h>

static inline uint32_t co_take_least(uint16_t v[8])
{
    __m128i all = _mm_loadu_si128((const __m128i *)(const void *)v);
    uint32_t place = (uint32_t)_mm_extract_epi16(_mm_minpos_epu16(all), 1);
    __m128i at =
        _mm_cmpeq_epi16(_mm_set1_epi16((short)place), _mm_setr_epi16(0, 1, 2, 3, 4, 5, 6, 7));
    all = _mm_or_si128(all, at);
    _mm_storeu_si128((__m128i *)(void *)v, all);
    return place | (uint32_t)_mm_cvtsi128_si32(_mm_minpos_epu16(all)) << 16;
}

#endif
