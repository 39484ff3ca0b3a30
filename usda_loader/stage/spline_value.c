// Attributes animated by curves: the value of a spline at a time.
//
// Source: the reference's spline rules: segments are held, linear, Bezier or Hermite; a Bezier's
// time-axis handles are shortened so that time never runs backwards.

#include "stage/stage_data.h"

#include <math.h>
#include <string.h>

static double bezier(double p0, double p1, double p2, double p3, double u)
{
    double v = 1 - u;
    return v * v * v * p0 + 3 * v * v * u * p1 + 3 * v * u * u * p2 + u * u * u * p3;
}

static double curve_value(const CoSpline *spline, const CoSplineKnot *a, const CoSplineKnot *b,
                          double end, double time)
{
    double span = b->time - a->time;
    bool is_hermite = !strcmp(spline->curve, "hermite");
    double out_width = is_hermite ? span / 3 : a->post.is_set ? a->post.width : 0;
    double in_width = is_hermite ? span / 3 : b->pre.is_set ? b->pre.width : 0;
    // Handles that reach over each other are shortened in proportion.
    if (out_width + in_width > span) {
        double shrink = span / (out_width + in_width);
        out_width *= shrink;
        in_width *= shrink;
    }
    double t1 = a->time + out_width, t2 = b->time - in_width;
    double v1 = a->value + out_width * a->post.slope, v2 = end - in_width * b->pre.slope;
    double low = 0, high = 1;
    for (int i = 0; i < 60; i++) {
        double u = 0.5 * (low + high);
        if (bezier(a->time, t1, t2, b->time, u) < time)
            low = u;
        else
            high = u;
    }
    return bezier(a->value, v1, v2, end, 0.5 * (low + high));
}

static bool evaluate(const CoSpline *spline, double time, double *out)
{
    const CoSplineKnot *knots = spline->knots;
    size_t count = spline->count;
    if (!count)
        return false;
    if (time <= knots[0].time) {
        *out =
            time == knots[0].time || !knots[0].has_pre_value ? knots[0].value : knots[0].pre_value;
        return true;
    }
    CoSplineInterp interp = CO_SPLINE_INTERP_HELD;
    size_t i = 0;
    for (;; i++) {
        if (knots[i].has_interp)
            interp = knots[i].interp;
        if (i + 1 == count || time < knots[i + 1].time)
            break;
    }
    *out = knots[i].value;
    if (i + 1 == count || interp == CO_SPLINE_INTERP_HELD || time == knots[i].time)
        return true;
    if (interp == CO_SPLINE_INTERP_NONE)
        return false;
    const CoSplineKnot *b = &knots[i + 1];
    double end = b->has_pre_value ? b->pre_value : b->value;
    double u = (time - knots[i].time) / (b->time - knots[i].time);
    *out = interp == CO_SPLINE_INTERP_LINEAR ? (1 - u) * knots[i].value + u * end
                                             : curve_value(spline, &knots[i], b, end, time);
    return true;
}

bool co_spline_value(const CohortStage *stage, const CoSpec *spec, const CoValue *value,
                     double time, CohortValue *out)
{
    double number;
    CohortType type;
    bool is_array;
    if (!co_type_from_name(spec->type_name, strlen(spec->type_name), &type, &is_array) ||
        is_array || !evaluate(value->data, time, &number))
        return false;
    if (type != COHORT_TYPE_DOUBLE && type != COHORT_TYPE_FLOAT && type != COHORT_TYPE_TIMECODE)
        return false;
    CoQueryKey key = {value->data, NULL, CO_QUERY_VALUE, time};
    co_stage_lock(stage);
    const CoAnswer *answer = co_stage_find_answer(stage, &key);
    void *data = answer ? NULL : co_stage_alloc(stage, 1, sizeof(double));
    if (data) {
        if (type == COHORT_TYPE_FLOAT)
            *(float *)data = (float)number;
        else
            *(double *)data = number;
        answer = co_stage_keep_answer(stage, &key, &(CoAnswer){.data = data});
    }
    if (answer)
        *out = (CohortValue){type, false, 1, answer->data};
    co_stage_unlock(stage);
    return answer != NULL;
}
