// Four floats at once, for boxes: x, y, z and one that does not matter.
//
// Builders are not compiled per instruction set; what every x86-64 has is enough for them. min and
// max follow SSE: a < b ? a : b, hence the second operand when one is NaN. All operations round
// once, so both forms of this file give the same bits.

#ifndef CO_SIMD_LANES4_H
#define CO_SIMD_LANES4_H

#include <stdint.h>
#include <string.h>

#if defined(__SSE2__)
#include <emmintrin.h>

typedef __m128 Co4;

static inline Co4 co4_set1(float a)
{
    return _mm_set1_ps(a);
}

static inline Co4 co4_load(const float *p)
{
    return _mm_loadu_ps(p);
}

static inline void co4_store(float *p, Co4 a)
{
    _mm_storeu_ps(p, a);
}

static inline Co4 co4_min(Co4 a, Co4 b)
{
    return _mm_min_ps(a, b);
}

static inline Co4 co4_max(Co4 a, Co4 b)
{
    return _mm_max_ps(a, b);
}

static inline Co4 co4_add(Co4 a, Co4 b)
{
    return _mm_add_ps(a, b);
}

static inline Co4 co4_sub(Co4 a, Co4 b)
{
    return _mm_sub_ps(a, b);
}

static inline Co4 co4_mul(Co4 a, Co4 b)
{
    return _mm_mul_ps(a, b);
}

// Eight numbers, in registers: what is stored alone cannot be loaded together at once.
typedef struct Co8 {
    __m128i half[2];
} Co8;

static inline Co8 co8_set1(uint32_t a)
{
    Co8 r = {{_mm_set1_epi32((int)a), _mm_set1_epi32((int)a)}};
    return r;
}

static inline void co8_store(uint32_t out[8], const Co8 *a)
{
    memcpy(out, a, sizeof *a);
}

// One bit for each that is x.
static inline uint32_t co8_equal(const Co8 *a, uint32_t x)
{
    __m128i all = _mm_set1_epi32((int)x);
    int lo = _mm_movemask_ps(_mm_castsi128_ps(_mm_cmpeq_epi32(a->half[0], all)));
    int hi = _mm_movemask_ps(_mm_castsi128_ps(_mm_cmpeq_epi32(a->half[1], all)));
    return (uint32_t)lo | (uint32_t)hi << 4;
}

static inline void co8_put(Co8 *a, uint32_t at, uint32_t x)
{
    __m128i place = _mm_set1_epi32((int)at), all = _mm_set1_epi32((int)x);
    for (int i = 0; i < 2; i++) {
        __m128i is_there = _mm_cmpeq_epi32(
            place, _mm_add_epi32(_mm_setr_epi32(0, 1, 2, 3), _mm_set1_epi32(4 * i)));
        a->half[i] =
            _mm_or_si128(_mm_andnot_si128(is_there, a->half[i]), _mm_and_si128(is_there, all));
    }
}

// Toward zero; the values must fit.
static inline void co4_truncate(Co4 a, int32_t out[4])
{
    __m128i i = _mm_cvttps_epi32(a);
    memcpy(out, &i, sizeof i);
}

// x, y, z of a, and 0.
static inline Co4 co4_xyz(Co4 a)
{
    return _mm_and_ps(a, _mm_castsi128_ps(_mm_set_epi32(0, -1, -1, -1)));
}

// Rows become columns.
static inline void co4_transpose(Co4 m[4])
{
    _MM_TRANSPOSE4_PS(m[0], m[1], m[2], m[3]);
}

#else

typedef struct Co4 {
    float f[4];
} Co4;

#define CO4_LANES(expression) \
    Co4 r; \
    for (int i = 0; i < 4; i++) \
        r.f[i] = (expression); \
    return r

static inline Co4 co4_set1(float a)
{
    CO4_LANES(a);
}

static inline Co4 co4_load(const float *p)
{
    Co4 r;
    memcpy(&r, p, sizeof r);
    return r;
}

static inline void co4_store(float *p, Co4 a)
{
    memcpy(p, &a, sizeof a);
}

static inline Co4 co4_min(Co4 a, Co4 b)
{
    CO4_LANES(a.f[i] < b.f[i] ? a.f[i] : b.f[i]);
}

static inline Co4 co4_max(Co4 a, Co4 b)
{
    CO4_LANES(a.f[i] > b.f[i] ? a.f[i] : b.f[i]);
}

static inline Co4 co4_add(Co4 a, Co4 b)
{
    CO4_LANES(a.f[i] + b.f[i]);
}

static inline Co4 co4_sub(Co4 a, Co4 b)
{
    CO4_LANES(a.f[i] - b.f[i]);
}

static inline Co4 co4_mul(Co4 a, Co4 b)
{
    CO4_LANES(a.f[i] * b.f[i]);
}

typedef struct Co8 {
    uint32_t u[8];
} Co8;

static inline Co8 co8_set1(uint32_t a)
{
    Co8 r;
    for (int i = 0; i < 8; i++)
        r.u[i] = a;
    return r;
}

static inline void co8_store(uint32_t out[8], const Co8 *a)
{
    memcpy(out, a, sizeof *a);
}

static inline uint32_t co8_equal(const Co8 *a, uint32_t x)
{
    uint32_t bits = 0;
    for (int i = 0; i < 8; i++)
        bits |= (uint32_t)(a->u[i] == x) << i;
    return bits;
}

static inline void co8_put(Co8 *a, uint32_t at, uint32_t x)
{
    a->u[at] = x;
}

static inline void co4_truncate(Co4 a, int32_t out[4])
{
    for (int i = 0; i < 4; i++)
        out[i] = (int32_t)a.f[i];
}

static inline Co4 co4_xyz(Co4 a)
{
    CO4_LANES(i < 3 ? a.f[i] : 0.0f);
}

static inline void co4_transpose(Co4 m[4])
{
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < i; k++) {
            float moved = m[i].f[k];
            m[i].f[k] = m[k].f[i];
            m[k].f[i] = moved;
        }
    }
}

#undef CO4_LANES
#endif

#endif
