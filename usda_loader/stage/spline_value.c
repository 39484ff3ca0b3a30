// Attributes animated by curves: the value of a spline at a time.
//
// Source: the reference's spline rules, each tried: segments are held, linear, Bezier or Hermite; a
// Bezier whose time would run backwards has both its handles shortened in proportion until it does
// not; inner loops repeat a stretch of knots and hide the knots they cover; beyond its ends a
// spline is held, goes on straight, or loops as a whole.

#include "stage/stage_data.h"

#include "lex/number.h"

#include <math.h>
#include <string.h>

// A spline with its inner loops written out at their two ends: a time between these is first folded
// into the prototype.
typedef struct CoCurve {
    const CoSplineKnot *knots; // ascending
    size_t count;
    bool is_hermite, has_loop;
    double loop_begin, loop_end; // where the repetitions begin and end
    double start, length, step;  // the prototype, and by how much each repetition is higher
} CoCurve;

// ---- Tangents -----------------------------------------------------------------------------------
static CoSplineInterp interp_of(const CoSplineKnot *knot)
{
    return knot->has_interp ? knot->interp : CO_SPLINE_INTERP_HELD;
}

static double pre_value(const CoSplineKnot *knot)
{
    return knot->has_pre_value ? knot->pre_value : knot->value;
}

// The slope that eases a knot in between its neighbours: flat at extremes and where the curve breaks
// off: at the ends, at two values and at blocks.
static double eased_slope(const CoSplineKnot *knots, size_t count, size_t i)
{
    if (i == 0 || i + 1 == count || knots[i].has_pre_value ||
        interp_of(&knots[i]) == CO_SPLINE_INTERP_NONE ||
        interp_of(&knots[i - 1]) == CO_SPLINE_INTERP_NONE)
        return 0;
    double before = knots[i].time - knots[i - 1].time, after = knots[i + 1].time - knots[i].time;
    double left = (pre_value(&knots[i]) - knots[i - 1].value) / before;
    double right = (pre_value(&knots[i + 1]) - knots[i].value) / after;
    if (left * right <= 0)
        return 0;
    double u = before / (before + after), ease = u * (2 + u * (2 * u - 3));
    double slope = left + (right - left) * ease, most = 3 * fmin(fabs(left), fabs(right));
    return copysign(fmin(fabs(slope), most), left);
}

// A number as a knot of that type holds it.
static double held_number(CohortType type, double number)
{
    if (type == COHORT_TYPE_HALF)
        return (double)co_half_to_float(co_half_from_float((float)number));
    return type == COHORT_TYPE_FLOAT ? (double)(float)number : number;
}

static void hold(CoSplineKnot *knots, size_t count, CohortType type)
{
    for (size_t i = 0; i < count; i++) {
        CoSplineKnot *knot = &knots[i];
        knot->value = held_number(type, knot->value);
        knot->pre_value = held_number(type, knot->pre_value);
        knot->pre.slope = held_number(type, knot->pre.slope);
        knot->post.slope = held_number(type, knot->post.slope);
    }
}

static void ease(CoSplineKnot *knots, size_t count, CohortType type)
{
    for (size_t i = 0; i < count; i++) {
        double slope = held_number(type, eased_slope(knots, count, i));
        CoSplineTangent *pre = &knots[i].pre, *post = &knots[i].post;
        if (i > 0 && pre->is_set && !strcmp(pre->algorithm, "autoEase")) {
            pre->width = (knots[i].time - knots[i - 1].time) / 3;
            pre->slope = slope;
        }
        if (i + 1 < count && post->is_set && !strcmp(post->algorithm, "autoEase")) {
            post->width = (knots[i + 1].time - knots[i].time) / 3;
            post->slope = slope;
        }
    }
}

// ---- Segments -----------------------------------------------------------------------------------
static double bezier(double p0, double p1, double p2, double p3, double u)
{
    double v = 1 - u;
    return v * v * v * p0 + 3 * v * v * u * p1 + 3 * v * u * u * p2 + u * u * u * p3;
}

// Handles as parts of the segment. Time never runs backwards while both are at most 1, or within an
// ellipse that touches 4/3; both go back to it in proportion. The reference stays a hair within the
// bound, by a fixed length, and takes a handle as short as that hair for none.
static void shorten(double *out, double *in)
{
    const double margin = 1e-5, least = 1e-6;
    double a = *out + least, b = *in + least;
    if ((*out <= 1 && *in <= 1) || a * a + b * b + a * b - 2 * (a + b) + 1 <= 0)
        return;
    if (*out < least) {
        *in = 1 - margin;
    } else if (*in < least) {
        *out = 1 - margin;
    } else {
        double ratio = *out / *in;
        double most = (sqrt(ratio) + ratio + 1) / (ratio * ratio + ratio + 1);
        *out = fmax(ratio * most - margin, 0);
        *in = fmax(most - margin, 0);
    }
}

static double curve_value(const CoCurve *curve, const CoSplineKnot *a, const CoSplineKnot *b,
                          double time)
{
    double span = b->time - a->time, end = pre_value(b);
    double out = a->post.is_set ? fmax(a->post.width, 0) / span : 0;
    double in = b->pre.is_set ? fmax(b->pre.width, 0) / span : 0;
    if (curve->is_hermite)
        out = in = 1.0 / 3;
    else
        shorten(&out, &in);
    double v1 = a->value + out * span * a->post.slope, v2 = end - in * span * b->pre.slope;
    double at = (time - a->time) / span, low = 0, high = 1;
    for (int i = 0; i < 60; i++) {
        double u = 0.5 * (low + high);
        if (bezier(0, out, 1 - in, 1, u) < at)
            low = u;
        else
            high = u;
    }
    return bezier(a->value, v1, v2, end, 0.5 * (low + high));
}

// At a time from the first knot on and before the last, or, `from_left`, after the first and up to
// the last: what the values before it lead to. False in a block.
static bool value_within(const CoCurve *curve, double time, bool from_left, double *out)
{
    const CoSplineKnot *knots = curve->knots;
    size_t low = 0, high = curve->count - 1;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (from_left ? knots[middle].time < time : knots[middle].time <= time)
            low = middle;
        else
            high = middle;
    }
    const CoSplineKnot *a = &knots[low], *b = &knots[high];
    CoSplineInterp interp = interp_of(a);
    if (interp == CO_SPLINE_INTERP_NONE)
        return false;
    double u = (time - a->time) / (b->time - a->time);
    if (interp == CO_SPLINE_INTERP_HELD || u == 0)
        *out = a->value;
    else if (u >= 1)
        *out = pre_value(b);
    else if (interp == CO_SPLINE_INTERP_LINEAR)
        *out = (1 - u) * a->value + u * pre_value(b);
    else
        *out = curve_value(curve, a, b, time);
    return true;
}

static bool value_inside(const CoCurve *curve, double time, bool from_left, double *out)
{
    double rounds = 0, at = (time - curve->start) / curve->length;
    if (curve->has_loop && time >= curve->loop_begin && time <= curve->loop_end &&
        time != (from_left ? curve->loop_begin : curve->loop_end))
        rounds = from_left ? ceil(at) - 1 : floor(at);
    if (!value_within(curve, time - rounds * curve->length, from_left, out))
        return false;
    *out += rounds * curve->step;
    return true;
}

// ---- Beyond the ends ----------------------------------------------------------------------------
static double end_slope(const CoCurve *curve, bool is_post)
{
    size_t count = curve->count;
    if (count < 2)
        return 0;
    const CoSplineKnot *a = &curve->knots[is_post ? count - 2 : 0], *b = a + 1;
    const CoSplineKnot *end = is_post ? b : a;
    CoSplineInterp interp = interp_of(a);
    if (end->has_pre_value && end->pre_value != end->value)
        return 0;
    if (interp == CO_SPLINE_INTERP_LINEAR)
        return (pre_value(b) - a->value) / (b->time - a->time);
    if (interp != CO_SPLINE_INTERP_CURVE)
        return 0;
    return is_post ? b->pre.slope : a->post.slope;
}

// The whole spline over and over, each round as high above the one before as the ends differ.
static bool looped_value(const CoCurve *curve, const char *mode, double time, bool is_post,
                         double *out)
{
    const CoSplineKnot *first = &curve->knots[0], *last = &curve->knots[curve->count - 1];
    double length = last->time - first->time, rounds = floor((time - first->time) / length);
    double local = time - rounds * length, step = 0;
    if (!strcmp(mode, "loop repeat"))
        step = is_post ? last->value - first->value : pre_value(last) - pre_value(first);
    bool is_reversed = !strcmp(mode, "loop oscillate") && fmod(rounds, 2) != 0;
    if (is_reversed)
        local = first->time + last->time - local;
    if (!value_inside(curve, fmin(fmax(local, first->time), last->time), is_reversed, out))
        return false;
    *out += rounds * step;
    return true;
}

static bool value_outside(const CoCurve *curve, const CoSplineExtrapolation *how, double time,
                          bool is_post, double *out)
{
    const CoSplineKnot *end = &curve->knots[is_post ? curve->count - 1 : 0];
    const char *mode = how->mode;
    if (!strcmp(mode, "none"))
        return false;
    if (!strncmp(mode, "loop", 4) && curve->count > 1)
        return looped_value(curve, mode, time, is_post, out);
    double slope = !strcmp(mode, "sloped")   ? how->slope
                   : !strcmp(mode, "linear") ? end_slope(curve, is_post)
                                             : 0;
    *out = (is_post ? end->value : pre_value(end)) + slope * (time - end->time);
    return true;
}

static bool evaluate(const CoSpline *spline, const CoCurve *curve, double time, double *out)
{
    if (!curve->count)
        return false;
    if (time < curve->knots[0].time)
        return value_outside(curve, &spline->pre, time, false, out);
    if (time >= curve->knots[curve->count - 1].time)
        return value_outside(curve, &spline->post, time, true, out);
    return value_inside(curve, time, false, out);
}

// ---- Inner loops --------------------------------------------------------------------------------
// One round of the prototype, from its own knots.
static size_t put_round(const CoCurve *curve, const CoSpline *spline, double round,
                        CoSplineKnot *out, size_t count)
{
    for (size_t i = 0; i < spline->count; i++) {
        const CoSplineKnot *knot = &spline->knots[i];
        if (knot->time < curve->start || knot->time >= curve->start + curve->length)
            continue;
        out[count] = *knot;
        out[count].time += round * curve->length;
        out[count].value += round * curve->step;
        out[count++].pre_value += round * curve->step;
    }
    return count;
}

// The prototype must begin with a knot, and be repeated, or there is no loop.
static bool find_loop(CoCurve *curve, const CoSpline *spline, double *before, double *after)
{
    curve->start = spline->loop[0];
    curve->length = spline->loop[1] - spline->loop[0];
    curve->step = spline->loop[4];
    *before = fmax(spline->loop[2], 0);
    *after = fmax(spline->loop[3], 0);
    bool has_start = false;
    for (size_t i = 0; i < spline->count; i++)
        has_start |= spline->knots[i].time == curve->start;
    return spline->has_loop && has_start && curve->length > 0 && *before + *after > 0;
}

// Into room for 4 * count + 3 knots: what is before the loop, its first round, the prototype, its
// last round, and what is after. Where a round is left out that follows, its first knot still ends
// the one before.
static size_t write_out(const CoCurve *curve, const CoSpline *spline, double before, double after,
                        CoSplineKnot *out)
{
    size_t count = 0;
    for (size_t i = 0; i < spline->count && spline->knots[i].time < curve->loop_begin; i++)
        out[count++] = spline->knots[i];
    double rounds[] = {-before, 0, after};
    for (int k = 0; k < 3; k++) {
        if (k > 0 && rounds[k] == rounds[k - 1])
            continue;
        size_t first = count;
        count = put_round(curve, spline, rounds[k], out, count);
        double next = k == 0 && before > 0 ? 0 : after;
        if (next == rounds[k] + 1)
            continue;
        out[count] = out[first];
        out[count].time += curve->length;
        out[count].value += curve->step;
        out[count++].pre_value += curve->step;
    }
    for (size_t i = 0; i < spline->count; i++)
        if (spline->knots[i].time > curve->loop_end)
            out[count++] = spline->knots[i];
    return count;
}

// The curve of a spline, made once (with the lock held); NULL when memory is at an end.
static const CoCurve *make_curve(const CohortStage *stage, CohortType type,
                                 const CoSpline *spline)
{
    CoCurve *curve = co_stage_alloc(stage, 1, sizeof *curve);
    CoSplineKnot *eased = co_stage_alloc(stage, spline->count, sizeof *eased);
    if (!curve || !eased)
        return NULL;
    if (spline->count)
        memcpy(eased, spline->knots, spline->count * sizeof *eased);
    hold(eased, spline->count, type);
    ease(eased, spline->count, type);
    *curve = (CoCurve){
        .knots = eased, .count = spline->count, .is_hermite = !strcmp(spline->curve, "hermite")};
    double before, after;
    curve->has_loop = find_loop(curve, spline, &before, &after);
    if (!curve->has_loop)
        return curve;
    curve->loop_begin = curve->start - before * curve->length;
    curve->loop_end = curve->start + (after + 1) * curve->length;
    CoSplineKnot *knots = co_stage_alloc(stage, 4 * spline->count + 3, sizeof *knots);
    if (!knots)
        return NULL;
    CoSpline copy = *spline;
    copy.knots = eased;
    curve->count = write_out(curve, &copy, before, after, knots);
    curve->knots = knots;
    return curve;
}

// ---- Values -------------------------------------------------------------------------------------
static const CoCurve *find_curve(const CohortStage *stage, CohortType type,
                                 const CoValue *value)
{
    CoQueryKey key = {value->data, value, CO_QUERY_VALUE, 0};
    const CoAnswer *known = co_stage_find_answer(stage, &key);
    if (known)
        return known->data;
    const CoCurve *curve = make_curve(stage, type, value->data);
    if (curve)
        co_stage_keep_answer(stage, &key, &(CoAnswer){.data = curve});
    return curve;
}

static void put_number(CohortType type, double number, const CoSource *source, void *out)
{
    if (type == COHORT_TYPE_HALF)
        *(uint16_t *)out = co_half_from_float((float)number);
    else if (type == COHORT_TYPE_FLOAT)
        *(float *)out = (float)number;
    else
        *(double *)out =
            type == COHORT_TYPE_TIMECODE ? number * source->scale + source->offset : number;
}

// With the lock held; NULL in a block.
static const CoAnswer *answer_at(const CohortStage *stage, CohortType type,
                                 const CoValueSource *from, double time)
{
    const CoValue *value = &from->field->value;
    CoQueryKey key = {value->data, from->source, CO_QUERY_VALUE, time};
    const CoAnswer *answer = co_stage_find_answer(stage, &key);
    if (answer)
        return answer;
    const CoCurve *curve = find_curve(stage, type, value);
    double number;
    if (!curve || !evaluate(value->data, curve, time, &number))
        return NULL;
    void *data = co_stage_alloc(stage, 1, sizeof(double));
    if (!data)
        return NULL;
    put_number(type, number, from->source, data);
    return co_stage_keep_answer(stage, &key, &(CoAnswer){.data = data});
}

bool co_spline_value(const CohortStage *stage, const CoValueSource *from, double time,
                     CohortValue *out)
{
    CohortType type;
    bool is_array;
    const char *name = from->spec->type_name;
    if (!co_type_from_name(name, strlen(name), &type, &is_array) || is_array)
        return false;
    if (type != COHORT_TYPE_DOUBLE && type != COHORT_TYPE_FLOAT && type != COHORT_TYPE_HALF &&
        type != COHORT_TYPE_TIMECODE)
        return false;
    co_stage_lock(stage);
    const CoAnswer *answer = answer_at(stage, type, from, time);
    if (answer)
        *out = (CohortValue){type, false, 1, answer->data};
    co_stage_unlock(stage);
    return answer != NULL;
}
