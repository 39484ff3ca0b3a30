// Whether two layers say the same, spec by spec and field by field. Lines do not count.

#ifndef TEST_SAME_LAYER_H
#define TEST_SAME_LAYER_H

#include "parse/layer.h"

bool same_layer(const CoLayer *a, const CoLayer *b);

#endif
