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

// Three, and 0.
static inline Co4 co4_load3(const float p[3])
{
    return _mm_movelh_ps(_mm_loadl_pi(_mm_setzero_ps(), (const void *)p), _mm_load_ss(p + 2));
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

// x where a < b, else y.
static inline Co4 co4_where_less(Co4 a, Co4 b, Co4 x, Co4 y)
{
    Co4 is_less = _mm_cmplt_ps(a, b);
    return _mm_or_ps(_mm_and_ps(is_less, x), _mm_andnot_ps(is_less, y));
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

static inline Co4 co4_div(Co4 a, Co4 b)
{
    return _mm_div_ps(a, b);
}

// x, y and z.
static inline void co4_store3(float p[3], Co4 a)
{
    _mm_storel_pi((void *)p, a);
    _mm_store_ss(p + 2, _mm_movehl_ps(a, a));
}

// Sixteen numbers, in registers: what is stored alone cannot be loaded together at once.
typedef struct Co16 {
    __m128i part[4];
} Co16;

static inline Co16 co16_set1(uint32_t a)
{
    __m128i all = _mm_set1_epi32((int)a);
    Co16 r = {{all, all, all, all}};
    return r;
}

static inline void co16_store(uint32_t out[16], const Co16 *a)
{
    memcpy(out, a, sizeof *a);
}

// One bit for each that is x.
static inline uint32_t co16_equal(const Co16 *a, uint32_t x)
{
    __m128i all = _mm_set1_epi32((int)x);
    __m128i lo =
        _mm_packs_epi32(_mm_cmpeq_epi32(a->part[0], all), _mm_cmpeq_epi32(a->part[1], all));
    __m128i hi =
        _mm_packs_epi32(_mm_cmpeq_epi32(a->part[2], all), _mm_cmpeq_epi32(a->part[3], all));
    return (uint32_t)_mm_movemask_epi8(_mm_packs_epi16(lo, hi));
}

static inline void co16_put(Co16 *a, uint32_t at, uint32_t x)
{
    __m128i place = _mm_set1_epi32((int)(at % 4)), all = _mm_set1_epi32((int)x);
    __m128i is_there = _mm_cmpeq_epi32(place, _mm_setr_epi32(0, 1, 2, 3));
    __m128i *part = &a->part[at / 4];
    *part = _mm_or_si128(_mm_andnot_si128(is_there, *part), _mm_and_si128(is_there, all));
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

// y, z, x of a, and its last.
static inline Co4 co4_yzx(Co4 a)
{
    return _mm_shuffle_ps(a, a, _MM_SHUFFLE(3, 0, 2, 1));
}

static inline float co4_first(Co4 a)
{
    return _mm_cvtss_f32(a);
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

static inline Co4 co4_load3(const float p[3])
{
    Co4 r = {{p[0], p[1], p[2], 0.0f}};
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

static inline Co4 co4_where_less(Co4 a, Co4 b, Co4 x, Co4 y)
{
    CO4_LANES(a.f[i] < b.f[i] ? x.f[i] : y.f[i]);
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

static inline Co4 co4_div(Co4 a, Co4 b)
{
    CO4_LANES(a.f[i] / b.f[i]);
}

static inline void co4_store3(float p[3], Co4 a)
{
    memcpy(p, &a, 3 * sizeof *p);
}

typedef struct Co16 {
    uint32_t u[16];
} Co16;

static inline Co16 co16_set1(uint32_t a)
{
    Co16 r;
    for (int i = 0; i < 16; i++)
        r.u[i] = a;
    return r;
}

static inline void co16_store(uint32_t out[16], const Co16 *a)
{
    memcpy(out, a, sizeof *a);
}

static inline uint32_t co16_equal(const Co16 *a, uint32_t x)
{
    uint32_t bits = 0;
    for (int i = 0; i < 16; i++)
        bits |= (uint32_t)(a->u[i] == x) << i;
    return bits;
}

static inline void co16_put(Co16 *a, uint32_t at, uint32_t x)
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

static inline Co4 co4_yzx(Co4 a)
{
    CO4_LANES(i < 3 ? a.f[(i + 1) % 3] : a.f[3]);
}

static inline float co4_first(Co4 a)
{
    return a.f[0];
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
