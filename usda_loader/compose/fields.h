// Reading the values of layer.h as plain C types.

#ifndef CO_COMPOSE_FIELDS_H
#define CO_COMPOSE_FIELDS_H

#include "parse/layer.h"

// A scalar number of any plain type, as double.
bool co_value_double(const CoValue *value, double *out);

// Text of a scalar string, token, asset or path expression; NULL for others.
const CohortString *co_value_text(const CoValue *value);

bool co_value_bool(const CoValue *value, bool *out);

// NULL unless the value is of that kind.
const CoDict *co_value_dict(const CoValue *value);
const CoListOp *co_value_list_op(const CoValue *value);
const CoTimeSamples *co_value_samples(const CoValue *value);

#endif
