// Values as numbers and text, with a fallback.

#include "stage/stage_data.h"

#include "lex/number.h"
#include "parse/types.h"

#include <string.h>

static double scalar_at(CoScalar scalar, const void *data, size_t i)
{
    switch (scalar) {
    case CO_SCALAR_BOOL:
    case CO_SCALAR_UCHAR:
        return ((const uint8_t *)data)[i];
    case CO_SCALAR_INT:
        return ((const int32_t *)data)[i];
    case CO_SCALAR_UINT:
        return ((const uint32_t *)data)[i];
    case CO_SCALAR_INT64:
        return (double)((const int64_t *)data)[i];
    case CO_SCALAR_UINT64:
        return (double)((const uint64_t *)data)[i];
    case CO_SCALAR_HALF:
        return (double)co_half_to_float(((const uint16_t *)data)[i]);
    case CO_SCALAR_FLOAT:
        return (double)((const float *)data)[i];
    case CO_SCALAR_DOUBLE:
        return ((const double *)data)[i];
    case CO_SCALAR_NONE:
    case CO_SCALAR_STRING:
    case CO_SCALAR_TOKEN:
    case CO_SCALAR_ASSET:
    case CO_SCALAR_PATH_EXPRESSION:
        break;
    }
    return 0;
}

static bool is_number(CoScalar scalar)
{
    return scalar >= CO_SCALAR_BOOL && scalar <= CO_SCALAR_DOUBLE;
}

bool cohort_prim_numbers(const CohortPrim *prim, const char *name, double time, double *out,
                         size_t count)
{
    CohortValue value;
    if (!cohort_prim_value(prim, name, time, &value))
        return false;
    const CoTypeInfo *info = co_type_info(value.type);
    if (!is_number(info->scalar) || !value.count)
        return false;
    size_t have = co_type_width(info) * (value.is_array ? value.count : 1);
    for (size_t i = 0; i < count && i < have; i++)
        out[i] = scalar_at(info->scalar, value.data, i);
    return true;
}

double cohort_prim_double(const CohortPrim *prim, const char *name, double time, double fallback)
{
    double number = fallback;
    return cohort_prim_numbers(prim, name, time, &number, 1) ? number : fallback;
}

bool cohort_prim_bool(const CohortPrim *prim, const char *name, double time, bool fallback)
{
    double number;
    return cohort_prim_numbers(prim, name, time, &number, 1) ? number != 0 : fallback;
}

const char *cohort_prim_token(const CohortPrim *prim, const char *name, double time,
                              const char *fallback)
{
    CohortValue value;
    if (!cohort_prim_value(prim, name, time, &value) || !value.count)
        return fallback;
    CoScalar scalar = co_type_info(value.type)->scalar;
    return scalar >= CO_SCALAR_STRING && scalar <= CO_SCALAR_PATH_EXPRESSION
               ? ((const CohortString *)value.data)->text
               : fallback;
}
