#include "compose/fields.h"

#include "lex/number.h"

bool co_value_double(const CoValue *value, double *out)
{
    if (value->is_array || !value->data)
        return false;
    switch ((int)value->type) {
    case COHORT_TYPE_BOOL:
    case COHORT_TYPE_UCHAR:
        *out = *(const uint8_t *)value->data;
        return true;
    case COHORT_TYPE_INT:
        *out = *(const int32_t *)value->data;
        return true;
    case COHORT_TYPE_UINT:
        *out = *(const uint32_t *)value->data;
        return true;
    case COHORT_TYPE_INT64:
        *out = (double)*(const int64_t *)value->data;
        return true;
    case COHORT_TYPE_UINT64:
        *out = (double)*(const uint64_t *)value->data;
        return true;
    case COHORT_TYPE_HALF:
        *out = (double)co_half_to_float(*(const uint16_t *)value->data);
        return true;
    case COHORT_TYPE_FLOAT:
        *out = (double)*(const float *)value->data;
        return true;
    case COHORT_TYPE_DOUBLE:
    case COHORT_TYPE_TIMECODE:
        *out = *(const double *)value->data;
        return true;
    default:
        return false;
    }
}

const CohortString *co_value_text(const CoValue *value)
{
    switch ((int)value->type) {
    case COHORT_TYPE_STRING:
    case COHORT_TYPE_TOKEN:
    case COHORT_TYPE_ASSET:
    case COHORT_TYPE_PATH_EXPRESSION:
        return value->is_array ? NULL : value->data;
    default:
        return NULL;
    }
}

bool co_value_bool(const CoValue *value, bool *out)
{
    double number;
    if (!co_value_double(value, &number))
        return false;
    *out = number != 0;
    return true;
}

const CoDict *co_value_dict(const CoValue *value)
{
    return value->type == COHORT_TYPE_DICTIONARY || value->type == COHORT_TYPE_VARIANT_SELECTION
               ? value->data
               : NULL;
}

const CoListOp *co_value_list_op(const CoValue *value)
{
    return value->type >= COHORT_TYPE_TOKEN_LIST_OP && value->type <= COHORT_TYPE_PAYLOAD_LIST_OP
               ? value->data
               : NULL;
}

const CoTimeSamples *co_value_samples(const CoValue *value)
{
    return value->type == COHORT_TYPE_TIME_SAMPLES ? value->data : NULL;
}
