// What each value type is made of.

#ifndef CO_PARSE_TYPES_H
#define CO_PARSE_TYPES_H

#include "parse/layer.h"

typedef enum CoScalar {
    CO_SCALAR_NONE = 0, // no text of its own: opaque, or held by fields only
    CO_SCALAR_BOOL,
    CO_SCALAR_UCHAR,
    CO_SCALAR_INT,
    CO_SCALAR_UINT,
    CO_SCALAR_INT64,
    CO_SCALAR_UINT64,
    CO_SCALAR_HALF,
    CO_SCALAR_FLOAT,
    CO_SCALAR_DOUBLE,
    CO_SCALAR_STRING,
    CO_SCALAR_TOKEN,
    CO_SCALAR_ASSET,
    CO_SCALAR_PATH_EXPRESSION
} CoScalar;

// An element is rows x columns scalars; rows 0 is one plain tuple, columns 0 one scalar.
typedef struct CoTypeInfo {
    const char *name;
    CoScalar scalar;
    uint8_t rows, columns;
    bool is_quaternion; // text has the real part first, memory has it last
} CoTypeInfo;

enum {
    CO_ELEMENT_BYTES = 16 * sizeof(double) // of the largest element
};

const CoTypeInfo *co_type_info(CohortType type);
size_t co_scalar_size(CoScalar scalar);

// Scalars of one element: 1, 3, 16 ...
static inline unsigned co_type_width(const CoTypeInfo *info)
{
    return (info->rows ? info->rows : 1u) * (info->columns ? info->columns : 1u);
}

#endif
