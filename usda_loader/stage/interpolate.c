// Values between two time samples.

#include "stage/stage_data.h"

#include "compose/fields.h"
#include "lex/number.h"
#include "math/elementary.h"
#include "parse/types.h"

#include <math.h>
#include <string.h>

bool co_value_can_interpolate(const CoValue *a, const CoValue *b)
{
    if (a->type != b->type || a->is_array != b->is_array || a->count != b->count)
        return false;
    switch (co_type_info(a->type)->scalar) {
    case CO_SCALAR_HALF:
    case CO_SCALAR_FLOAT:
    case CO_SCALAR_DOUBLE:
        return true;
    case CO_SCALAR_NONE:
    case CO_SCALAR_BOOL:
    case CO_SCALAR_UCHAR:
    case CO_SCALAR_INT:
    case CO_SCALAR_UINT:
    case CO_SCALAR_INT64:
    case CO_SCALAR_UINT64:
    case CO_SCALAR_STRING:
    case CO_SCALAR_TOKEN:
    case CO_SCALAR_ASSET:
    case CO_SCALAR_PATH_EXPRESSION:
        break;
    }
    return false;
}

// Round to nearest, ties to even, from a double, as one rounding.
static uint16_t half_from_double(double value)
{
    uint16_t sign = signbit(value) ? 0x8000 : 0;
    double magnitude = fabs(value);
    if (isnan(value))
        return (uint16_t)(sign | 0x7e00);
    if (magnitude >= 65520.0)
        return (uint16_t)(sign | 0x7c00);
    if (magnitude < 0x1p-14)
        return (uint16_t)(sign | (uint16_t)nearbyint(magnitude * 0x1p24));
    int exponent;
    double fraction = frexp(magnitude, &exponent);              // in [0.5, 1)
    uint32_t mantissa = (uint32_t)nearbyint(fraction * 2048.0); // in [1024, 2048]
    return (uint16_t)(sign | (((uint32_t)(exponent + 13) << 10) + mantissa));
}

static double read_scalar(CoScalar scalar, const void *data, size_t i)
{
    if (scalar == CO_SCALAR_HALF)
        return (double)co_half_to_float(((const uint16_t *)data)[i]);
    return scalar == CO_SCALAR_FLOAT ? (double)((const float *)data)[i] : ((const double *)data)[i];
}

static void write_scalar(CoScalar scalar, void *data, size_t i, double value)
{
    if (scalar == CO_SCALAR_HALF)
        ((uint16_t *)data)[i] = half_from_double(value);
    else if (scalar == CO_SCALAR_FLOAT)
        ((float *)data)[i] = (float)value;
    else
        ((double *)data)[i] = value;
}

// The shorter way round between two rotations, at constant speed.
static void slerp(CoScalar scalar, const void *a, const void *b, size_t at, double u, void *out)
{
    double p[4], q[4], dot = 0;
    for (size_t i = 0; i < 4; i++) {
        p[i] = read_scalar(scalar, a, at + i);
        q[i] = read_scalar(scalar, b, at + i);
        dot += p[i] * q[i];
    }
    double side = dot < 0 ? -1 : 1;
    double s0 = 1 - u, s1 = u;
    if (1 - side * dot > 1e-5) {
        double theta = (double)co_acosf((float)(side * dot)), sine, cosine;
        // One Newton step on cos(theta) = dot brings the angle from float to double.
        co_sincos_d(theta, &sine, &cosine);
        theta += (cosine - side * dot) / sine;
        co_sincos_d(theta, &sine, &cosine);
        double unused;
        co_sincos_d((1 - u) * theta, &s0, &unused);
        co_sincos_d(u * theta, &s1, &unused);
        s0 /= sine;
        s1 /= sine;
    }
    for (size_t i = 0; i < 4; i++)
        write_scalar(scalar, out, at + i, s0 * p[i] + side * s1 * q[i]);
}

void co_value_interpolate(const CoValue *a, const CoValue *b, double u, void *out)
{
    const CoTypeInfo *info = co_type_info(a->type);
    size_t count = a->count * co_type_width(info);
    if (info->is_quaternion) {
        for (size_t i = 0; i < count; i += 4)
            slerp(info->scalar, a->data, b->data, i, u, out);
        return;
    }
    for (size_t i = 0; i < count; i++)
        write_scalar(info->scalar, out, i,
                     (1 - u) * read_scalar(info->scalar, a->data, i) +
                         u * read_scalar(info->scalar, b->data, i));
}
