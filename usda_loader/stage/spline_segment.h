// A curved segment between two knots of a spline.

#ifndef CO_STAGE_SPLINE_SEGMENT_H
#define CO_STAGE_SPLINE_SEGMENT_H

#include "parse/layer.h"

static inline double co_spline_pre_value(const CoSplineKnot *knot)
{
    return knot->has_pre_value ? knot->pre_value : knot->value;
}

// The value at a time after knot a and before knot b. Handles that are not set have no width. Pure
// arithmetic: the same on every machine.
double co_spline_segment(const CoSplineKnot *a, const CoSplineKnot *b, bool is_hermite,
                         double time);

#endif
