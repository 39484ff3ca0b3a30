// Values of the reader as the renderer's floats and integers.

#include "stage_adapter/adapter.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

bool co_starts_with(const char *text, const char *prefix)
{
    return strncmp(text, prefix, strlen(prefix)) == 0;
}

// ---- Numbers -----------------------------------------------------------------------------------

typedef enum Scalar {
    SCALAR_NONE = 0,
    SCALAR_HALF,
    SCALAR_FLOAT,
    SCALAR_DOUBLE,
    SCALAR_INT,
    SCALAR_BOOL
} Scalar;

typedef struct Layout {
    Scalar scalar;
    uint32_t components;
} Layout;

// The types that primvars, shader inputs and geometry use; others hold no numbers here.
static Layout layout_of(CohortType type)
{
    static const struct {
        CohortType type;
        Layout layout;
    } table[] = {
        {COHORT_TYPE_BOOL, {SCALAR_BOOL, 1}},         {COHORT_TYPE_INT, {SCALAR_INT, 1}},
        {COHORT_TYPE_INT2, {SCALAR_INT, 2}},          {COHORT_TYPE_INT3, {SCALAR_INT, 3}},
        {COHORT_TYPE_INT4, {SCALAR_INT, 4}},          {COHORT_TYPE_HALF, {SCALAR_HALF, 1}},
        {COHORT_TYPE_HALF2, {SCALAR_HALF, 2}},        {COHORT_TYPE_HALF3, {SCALAR_HALF, 3}},
        {COHORT_TYPE_HALF4, {SCALAR_HALF, 4}},        {COHORT_TYPE_POINT3H, {SCALAR_HALF, 3}},
        {COHORT_TYPE_NORMAL3H, {SCALAR_HALF, 3}},     {COHORT_TYPE_VECTOR3H, {SCALAR_HALF, 3}},
        {COHORT_TYPE_COLOR3H, {SCALAR_HALF, 3}},      {COHORT_TYPE_COLOR4H, {SCALAR_HALF, 4}},
        {COHORT_TYPE_TEXCOORD2H, {SCALAR_HALF, 2}},   {COHORT_TYPE_TEXCOORD3H, {SCALAR_HALF, 3}},
        {COHORT_TYPE_QUATH, {SCALAR_HALF, 4}},        {COHORT_TYPE_FLOAT, {SCALAR_FLOAT, 1}},
        {COHORT_TYPE_FLOAT2, {SCALAR_FLOAT, 2}},      {COHORT_TYPE_FLOAT3, {SCALAR_FLOAT, 3}},
        {COHORT_TYPE_FLOAT4, {SCALAR_FLOAT, 4}},      {COHORT_TYPE_POINT3F, {SCALAR_FLOAT, 3}},
        {COHORT_TYPE_NORMAL3F, {SCALAR_FLOAT, 3}},    {COHORT_TYPE_VECTOR3F, {SCALAR_FLOAT, 3}},
        {COHORT_TYPE_COLOR3F, {SCALAR_FLOAT, 3}},     {COHORT_TYPE_COLOR4F, {SCALAR_FLOAT, 4}},
        {COHORT_TYPE_TEXCOORD2F, {SCALAR_FLOAT, 2}},  {COHORT_TYPE_TEXCOORD3F, {SCALAR_FLOAT, 3}},
        {COHORT_TYPE_QUATF, {SCALAR_FLOAT, 4}},       {COHORT_TYPE_DOUBLE, {SCALAR_DOUBLE, 1}},
        {COHORT_TYPE_TIMECODE, {SCALAR_DOUBLE, 1}},   {COHORT_TYPE_DOUBLE2, {SCALAR_DOUBLE, 2}},
        {COHORT_TYPE_DOUBLE3, {SCALAR_DOUBLE, 3}},    {COHORT_TYPE_DOUBLE4, {SCALAR_DOUBLE, 4}},
        {COHORT_TYPE_POINT3D, {SCALAR_DOUBLE, 3}},    {COHORT_TYPE_NORMAL3D, {SCALAR_DOUBLE, 3}},
        {COHORT_TYPE_VECTOR3D, {SCALAR_DOUBLE, 3}},   {COHORT_TYPE_COLOR3D, {SCALAR_DOUBLE, 3}},
        {COHORT_TYPE_COLOR4D, {SCALAR_DOUBLE, 4}},    {COHORT_TYPE_TEXCOORD2D, {SCALAR_DOUBLE, 2}},
        {COHORT_TYPE_TEXCOORD3D, {SCALAR_DOUBLE, 3}}, {COHORT_TYPE_QUATD, {SCALAR_DOUBLE, 4}},
    };
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++)
        if (table[i].type == type)
            return table[i].layout;
    return (Layout){SCALAR_NONE, 0};
}

static float half_to_float(uint16_t half)
{
    uint32_t exponent = (half >> 10) & 31, mantissa = half & 1023;
    float value;
    if (exponent == 31)
        value = mantissa ? NAN : INFINITY;
    else if (exponent == 0)
        value = ldexpf((float)mantissa, -24);
    else
        value = ldexpf((float)(mantissa | 1024), (int)exponent - 25);
    return half & 0x8000 ? -value : value;
}

static float number_at(Scalar scalar, const void *data, size_t i)
{
    switch (scalar) {
    case SCALAR_HALF:
        return half_to_float(((const uint16_t *)data)[i]);
    case SCALAR_FLOAT:
        return ((const float *)data)[i];
    case SCALAR_DOUBLE:
        return (float)((const double *)data)[i];
    case SCALAR_INT:
        return (float)((const int32_t *)data)[i];
    case SCALAR_BOOL:
        return ((const uint8_t *)data)[i] ? 1.0f : 0.0f;
    case SCALAR_NONE:
        break;
    }
    return 0.0f;
}

bool co_values_floats(const CohortValue *value, CohortPull *pull, CoFloats *out)
{
    Layout layout = layout_of(value->type);
    if (layout.scalar == SCALAR_NONE)
        return false;
    *out =
        (CoFloats){.values = value->data, .count = value->count, .components = layout.components};
    if (layout.scalar == SCALAR_FLOAT)
        return true;
    size_t total;
    if (__builtin_mul_overflow(value->count, (size_t)layout.components, &total))
        return false;
    float *copy = cohort_pull_array(pull, total, sizeof *copy);
    for (size_t i = 0; copy && i < total; i++)
        copy[i] = number_at(layout.scalar, value->data, i);
    out->values = copy;
    return copy != NULL;
}

bool co_values_read(const CohortAdapter *adapter, const CohortPrim *prim, const char *name,
                    CohortPull *pull, CoFloats *out)
{
    CohortValue value;
    return cohort_prim_value(prim, name, adapter->time, &value) &&
           co_values_floats(&value, pull, out);
}

const int32_t *co_values_ints(const CohortAdapter *adapter, const CohortPrim *prim,
                              const char *name, size_t *count)
{
    CohortValue value;
    *count = 0;
    if (!cohort_prim_value(prim, name, adapter->time, &value) || value.type != COHORT_TYPE_INT)
        return NULL;
    *count = value.count;
    return value.data;
}

// ---- Text --------------------------------------------------------------------------------------

const char *co_values_text(const CohortValue *value)
{
    bool is_text = value->type == COHORT_TYPE_TOKEN || value->type == COHORT_TYPE_STRING ||
                   value->type == COHORT_TYPE_ASSET;
    const CohortString *text = value->data;
    return is_text && value->count && text->text ? text->text : "";
}

void co_values_describe(const CohortValue *value, char *out, size_t size)
{
    Layout layout = layout_of(value->type);
    if (value->is_array && value->count > 1) {
        snprintf(out, size, "%zu elements", value->count);
        return;
    }
    if (layout.scalar == SCALAR_NONE || value->count == 0) {
        snprintf(out, size, "%s", co_values_text(value));
        return;
    }
    size_t used = 0;
    for (uint32_t i = 0; i < layout.components && used < size; i++) {
        int n = snprintf(out + used, size - used, i ? ", %g" : "%g",
                         (double)number_at(layout.scalar, value->data, i));
        used += n > 0 ? (size_t)n : 0;
    }
}
