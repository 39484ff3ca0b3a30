// Three-component vectors and 3x4 affine transforms in float32, and 4x4 matrices in double.
//
// Everything is written as plain multiplies and adds in a fixed order: the compiler may not
// contract them (-ffp-contract=off), so results are the same bits on every instruction set.

#ifndef CO_MATH_VEC_H
#define CO_MATH_VEC_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#define CO_PI 3.14159265358979323846f
#define CO_INV_PI 0.31830988618379067154f

typedef struct CoVec2 {
    float x, y;
} CoVec2;

typedef struct CoVec3 {
    float x, y, z;
} CoVec3;

static inline CoVec3 co_vec3(float x, float y, float z)
{
    CoVec3 v = {x, y, z};
    return v;
}

static inline CoVec3 co_vec3_splat(float s)
{
    return co_vec3(s, s, s);
}

static inline CoVec3 co_vec3_load(const float *p)
{
    return co_vec3(p[0], p[1], p[2]);
}

static inline void co_vec3_store(float *p, CoVec3 v)
{
    p[0] = v.x;
    p[1] = v.y;
    p[2] = v.z;
}

static inline CoVec3 co_add(CoVec3 a, CoVec3 b)
{
    return co_vec3(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline CoVec3 co_sub(CoVec3 a, CoVec3 b)
{
    return co_vec3(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline CoVec3 co_mul(CoVec3 a, CoVec3 b)
{
    return co_vec3(a.x * b.x, a.y * b.y, a.z * b.z);
}

static inline CoVec3 co_scale(CoVec3 a, float s)
{
    return co_vec3(a.x * s, a.y * s, a.z * s);
}

// a + b * s
static inline CoVec3 co_madd(CoVec3 a, CoVec3 b, float s)
{
    return co_add(a, co_scale(b, s));
}

static inline CoVec3 co_neg(CoVec3 a)
{
    return co_vec3(-a.x, -a.y, -a.z);
}

static inline CoVec3 co_lerp3(CoVec3 a, CoVec3 b, float t)
{
    return co_add(co_scale(a, 1.0f - t), co_scale(b, t));
}

static inline float co_dot(CoVec3 a, CoVec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline CoVec3 co_cross(CoVec3 a, CoVec3 b)
{
    return co_vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

static inline float co_length(CoVec3 a)
{
    return sqrtf(co_dot(a, a));
}

// As the machine's instruction has it (fminf and fmaxf are calls): b where either is not a number.
static inline float co_min(float a, float b)
{
    return a < b ? a : b;
}

static inline float co_max(float a, float b)
{
    return a > b ? a : b;
}

// Unit vector along a; the zero vector and non-finite vectors give (0, 0, 0).
static inline CoVec3 co_normalize(CoVec3 a)
{
    float d = co_dot(a, a);
    if (d > 1e-30f && d < 1e30f)
        return co_scale(a, 1.0f / sqrtf(d));
    // The square has left the range of floats, or a is no vector at all.
    float m = co_max(co_max(fabsf(a.x), fabsf(a.y)), fabsf(a.z));
    if (!(m > 0.0f) || !isfinite(a.x) || !isfinite(a.y) || !isfinite(a.z))
        return co_vec3(0.0f, 0.0f, 0.0f);
    a = co_vec3(a.x / m, a.y / m, a.z / m);
    return co_scale(a, 1.0f / sqrtf(co_dot(a, a)));
}

static inline float co_max3(CoVec3 a)
{
    return co_max(co_max(a.x, a.y), a.z);
}

static inline bool co_is_finite3(CoVec3 a)
{
    return isfinite(a.x) && isfinite(a.y) && isfinite(a.z);
}

static inline float co_clamp(float x, float lo, float hi)
{
    return x < lo ? lo : x > hi ? hi : x;
}

// Two unit vectors orthogonal to the unit vector n and each other, continuous but for n.z = -0
// (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
static inline void co_basis(CoVec3 n, CoVec3 *s, CoVec3 *t)
{
    float sign = copysignf(1.0f, n.z);
    float a = -1.0f / (sign + n.z);
    float b = n.x * n.y * a;
    *s = co_vec3(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x);
    *t = co_vec3(b, sign + n.y * n.y * a, -n.y);
}

// p' = (m[r][0] p.x + m[r][1] p.y + m[r][2] p.z) + m[r][3]: column vectors, one row per output.
typedef struct CoAffine {
    float m[3][4];
} CoAffine;

static inline CoVec3 co_affine_point(const CoAffine *a, CoVec3 p)
{
    return co_vec3((a->m[0][0] * p.x + a->m[0][1] * p.y + a->m[0][2] * p.z) + a->m[0][3],
                   (a->m[1][0] * p.x + a->m[1][1] * p.y + a->m[1][2] * p.z) + a->m[1][3],
                   (a->m[2][0] * p.x + a->m[2][1] * p.y + a->m[2][2] * p.z) + a->m[2][3]);
}

static inline CoVec3 co_affine_vector(const CoAffine *a, CoVec3 v)
{
    return co_vec3(a->m[0][0] * v.x + a->m[0][1] * v.y + a->m[0][2] * v.z,
                   a->m[1][0] * v.x + a->m[1][1] * v.y + a->m[1][2] * v.z,
                   a->m[2][0] * v.x + a->m[2][1] * v.y + a->m[2][2] * v.z);
}

// Multiplies by the transposed linear part: with the inverse transform, this maps normals.
static inline CoVec3 co_affine_transposed_vector(const CoAffine *a, CoVec3 v)
{
    return co_vec3(a->m[0][0] * v.x + a->m[1][0] * v.y + a->m[2][0] * v.z,
                   a->m[0][1] * v.x + a->m[1][1] * v.y + a->m[2][1] * v.z,
                   a->m[0][2] * v.x + a->m[1][2] * v.y + a->m[2][2] * v.z);
}

// USD's convention: row vectors, p' = p * m, translation in m[3][0..2].
typedef struct CoMat4d {
    double m[4][4];
} CoMat4d;

static inline CoMat4d co_mat4d_identity(void)
{
    CoMat4d r = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
    return r;
}

// Row vectors: the result applies a first, then b.
static inline CoMat4d co_mat4d_mul(const CoMat4d *a, const CoMat4d *b)
{
    CoMat4d r;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            r.m[i][j] = a->m[i][0] * b->m[0][j] + a->m[i][1] * b->m[1][j] +
                        a->m[i][2] * b->m[2][j] + a->m[i][3] * b->m[3][j];
    return r;
}

// Inverse of the affine part (last column taken as 0, 0, 0, 1). False, *out untouched, when the
// linear part is singular or not finite.
static inline bool co_mat4d_invert_affine(const CoMat4d *a, CoMat4d *out)
{
    const double(*m)[4] = a->m;
    double c00 = m[1][1] * m[2][2] - m[1][2] * m[2][1];
    double c01 = m[1][2] * m[2][0] - m[1][0] * m[2][2];
    double c02 = m[1][0] * m[2][1] - m[1][1] * m[2][0];
    double det = m[0][0] * c00 + m[0][1] * c01 + m[0][2] * c02;
    double inv = 1.0 / det;
    if (!isfinite(inv) || det == 0.0)
        return false;
    CoMat4d r = co_mat4d_identity();
    r.m[0][0] = c00 * inv;
    r.m[1][0] = c01 * inv;
    r.m[2][0] = c02 * inv;
    r.m[0][1] = (m[0][2] * m[2][1] - m[0][1] * m[2][2]) * inv;
    r.m[1][1] = (m[0][0] * m[2][2] - m[0][2] * m[2][0]) * inv;
    r.m[2][1] = (m[0][1] * m[2][0] - m[0][0] * m[2][1]) * inv;
    r.m[0][2] = (m[0][1] * m[1][2] - m[0][2] * m[1][1]) * inv;
    r.m[1][2] = (m[0][2] * m[1][0] - m[0][0] * m[1][2]) * inv;
    r.m[2][2] = (m[0][0] * m[1][1] - m[0][1] * m[1][0]) * inv;
    for (int j = 0; j < 3; j++)
        r.m[3][j] = -(m[3][0] * r.m[0][j] + m[3][1] * r.m[1][j] + m[3][2] * r.m[2][j]);
    *out = r;
    return true;
}

// The inverse of a transform that rays can be taken through; false, *out untouched, for others:
// what is not finite or singular, and scales beyond 1e18 either way, for which the square of a
// direction is no float.
static inline bool co_mat4d_invert_placement(const CoMat4d *m, CoMat4d *out)
{
    CoMat4d inverse;
    for (int i = 0; i < 16; i++)
        if (!isfinite(m->m[i / 4][i % 4]))
            return false;
    if (!co_mat4d_invert_affine(m, &inverse))
        return false;
    for (int i = 0; i < 3; i++) {
        const double *row = inverse.m[i];
        double square = row[0] * row[0] + row[1] * row[1] + row[2] * row[2];
        if (!(square > 1e-36) || !(square < 1e36))
            return false;
    }
    *out = inverse;
    return true;
}

// USD row-vector matrix to a column-vector affine, each entry rounded once.
static inline CoAffine co_affine_from_mat4d(const CoMat4d *a)
{
    CoAffine r;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++)
            r.m[i][j] = (float)a->m[j][i];
    return r;
}

#endif
