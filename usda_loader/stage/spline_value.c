// Attributes animated by curves: the value of a spline at a time.
//
// Source: the reference's spline rules, each tried: segments are held, linear, Bezier or Hermite;
// inner loops repeat a stretch of knots and hide the knots they cover; beyond its ends a spline is
// held, goes on straight, or loops, as a whole or from or to a knot.

#include "stage/spline_segment.h"
#include "stage/stage_data.h"

#include "lex/number.h"

#include <math.h>
#include <string.h>

// A spline as it is evaluated: its knots in the numbers of its type, eased, and what of it repeats.
typedef struct CoCurve {
    const CoSplineKnot *knots; // ascending
    size_t count;
    bool is_hermite, has_loop;
    size_t first, last;             // the knots of the prototype
    double start, end, step;        // the prototype, and by how much each repetition is higher
    double before, after;           // repetitions
    double loop_begin, loop_end;    // where they begin and end
    double begin_time, end_time;    // of all knots, the repeated ones too
    bool begins_loop, ends_in_loop; // whether the outermost knots are repeated ones
} CoCurve;

// A time brought back to where the knots are.
typedef struct CoPlace {
    double time, offset; // offset: of the value
    bool from_left;      // what the values before that time lead to
} CoPlace;

// ---- Tangents -----------------------------------------------------------------------------------
static CoSplineInterp interp_of(const CoSplineKnot *knot)
{
    return knot->has_interp ? knot->interp : CO_SPLINE_INTERP_HELD;
}

// The slope that eases a knot in between its neighbors: flat at extremes and where the curve
// breaks off: at the ends, at two values and at blocks.
static double eased_slope(const CoSplineKnot *knots, size_t count, size_t i)
{
    if (i == 0 || i + 1 == count || knots[i].has_pre_value ||
        interp_of(&knots[i]) == CO_SPLINE_INTERP_NONE ||
        interp_of(&knots[i - 1]) == CO_SPLINE_INTERP_NONE)
        return 0;
    double before = knots[i].time - knots[i - 1].time, after = knots[i + 1].time - knots[i].time;
    double left = (co_spline_pre_value(&knots[i]) - knots[i - 1].value) / before;
    double right = (co_spline_pre_value(&knots[i + 1]) - knots[i].value) / after;
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
    // Volatile: of two such conversions side by side GCC 12 makes a vector, and then drops both.
    volatile float narrow = (float)number;
    return type == COHORT_TYPE_FLOAT ? (double)narrow : number;
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

// ---- Between knots ------------------------------------------------------------------------------
// False in a block.
static bool value_between(const CoCurve *curve, const CoSplineKnot *a, const CoSplineKnot *b,
                          double time, double *out)
{
    double slope;
    switch (interp_of(a)) {
    case CO_SPLINE_INTERP_NONE:
        return false;
    case CO_SPLINE_INTERP_HELD:
        *out = a->value;
        return true;
    case CO_SPLINE_INTERP_LINEAR:
        slope = (co_spline_pre_value(b) - a->value) / (b->time - a->time);
        *out = a->value + slope * (time - a->time);
        return true;
    case CO_SPLINE_INTERP_CURVE:
        break;
    }
    *out = co_spline_segment(a, b, curve->is_hermite, time);
    return true;
}

// The first knot at or after a time: an index up to the count.
static size_t search(const CoCurve *curve, double time)
{
    size_t low = 0, high = curve->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (curve->knots[middle].time < time)
            low = middle + 1;
        else
            high = middle;
    }
    return high;
}

static const CoSplineKnot *find_knot(const CoCurve *curve, double time)
{
    size_t i = search(curve, time);
    return i < curve->count && curve->knots[i].time == time ? &curve->knots[i] : NULL;
}

// There is nothing beyond an end that says so, nor where a loop is bounded by no knot.
static bool is_blocked(const CoCurve *curve, const CoSplineExtrapolation *how)
{
    return !strcmp(how->mode, "none") || (how->has_boundary && !find_knot(curve, how->boundary));
}

static bool value_at_knot(const CoSpline *spline, const CoCurve *curve, size_t i, bool from_left,
                          double *out)
{
    const CoSplineKnot *knot = &curve->knots[i];
    *out = from_left ? co_spline_pre_value(knot) : knot->value;
    if (from_left && i > 0 && interp_of(knot - 1) == CO_SPLINE_INTERP_HELD)
        *out = knot[-1].value;
    if (from_left)
        return i == 0 ? !is_blocked(curve, &spline->pre)
                      : interp_of(knot - 1) != CO_SPLINE_INTERP_NONE;
    return i + 1 == curve->count ? !is_blocked(curve, &spline->post)
                                 : interp_of(knot) != CO_SPLINE_INTERP_NONE;
}

// ---- Inner loops --------------------------------------------------------------------------------
// A knot of the prototype, `rounds` repetitions later.
static CoSplineKnot repeated(const CoCurve *curve, size_t i, double rounds)
{
    CoSplineKnot knot = curve->knots[i];
    knot.time += rounds * (curve->end - curve->start);
    knot.value += rounds * curve->step;
    knot.pre_value += rounds * curve->step;
    return knot;
}

// The prototype must begin with a knot, and be repeated, or there is no loop; nor is there one
// beside an end that loops from or to a knot.
static void find_loop(CoCurve *curve, const CoSpline *spline)
{
    curve->begin_time = curve->count ? curve->knots[0].time : 0;
    curve->end_time = curve->count ? curve->knots[curve->count - 1].time : 0;
    curve->start = spline->loop[0];
    curve->end = spline->loop[1];
    curve->before = fmin(fmax(spline->loop[2], 0), INT32_MAX);
    curve->after = fmin(fmax(spline->loop[3], 0), INT32_MAX);
    curve->step = spline->loop[4];
    if (!spline->has_loop || spline->pre.has_boundary || spline->post.has_boundary ||
        !(curve->end > curve->start) || curve->before + curve->after < 1)
        return;
    for (size_t i = 0; i < curve->count; i++) {
        if (curve->knots[i].time == curve->start) {
            curve->first = i;
            curve->has_loop = true;
        }
        if (curve->knots[i].time < curve->end)
            curve->last = i;
    }
    if (!curve->has_loop)
        return;
    curve->loop_begin = curve->start - curve->before * (curve->end - curve->start);
    curve->loop_end = curve->end + curve->after * (curve->end - curve->start);
    curve->begins_loop = curve->loop_begin < curve->begin_time;
    curve->ends_in_loop = curve->loop_end > curve->end_time;
    curve->begin_time = fmin(curve->begin_time, curve->loop_begin);
    curve->end_time = fmax(curve->end_time, curve->loop_end);
}

static void fold_loop(const CoCurve *curve, CoPlace *at)
{
    double length = curve->end - curve->start, rounds = 0;
    if (!curve->has_loop || at->time < curve->loop_begin || at->time > curve->loop_end)
        return;
    if (at->time < curve->start)
        rounds = -ceil((curve->start - at->time) / length);
    else if (at->time >= curve->end)
        rounds = trunc((at->time - curve->end) / length) + 1;
    at->time -= rounds * length;
    if (rounds != 0 && at->time >= curve->end) { // by rounding
        at->time -= length;
        rounds++;
    }
    at->time = fmax(at->time, rounds != 0 ? curve->start : at->time);
    at->offset += rounds * curve->step;
}

// Between knots: those on both sides, where one may be a repeated one.
static void find_neighbors(const CoCurve *curve, double time, size_t next, CoSplineKnot *a,
                           CoSplineKnot *b)
{
    if (next > 0)
        *a = curve->knots[next - 1];
    if (next < curve->count)
        *b = curve->knots[next];
    if (!curve->has_loop)
        return;
    if (time >= curve->start && time < curve->end) {
        if (next > curve->last)
            *b = repeated(curve, curve->first, 1);
    } else if (time < curve->loop_begin && b->time >= curve->loop_begin) {
        *b = repeated(curve, curve->first, -curve->before);
    } else if (time > curve->loop_end && a->time <= curve->loop_end) {
        *a = repeated(curve, curve->first, curve->after + 1);
    }
}

// ---- Beyond the ends ----------------------------------------------------------------------------
// The last knot and the one before it, seen from outside.
static void find_end(const CoCurve *curve, bool is_post, CoSplineKnot *end, CoSplineKnot *inner)
{
    size_t last = curve->count - 1;
    *end = curve->knots[is_post ? last : 0];
    *inner = curve->knots[is_post ? (last ? last - 1 : 0) : (last ? 1 : 0)];
    if (is_post && curve->ends_in_loop) {
        *end = repeated(curve, curve->first, curve->after + 1);
        *inner = repeated(curve, curve->last, curve->after);
    } else if (!is_post && curve->begins_loop) {
        *end = repeated(curve, curve->first, -curve->before);
        *inner = curve->last > curve->first ? repeated(curve, curve->first + 1, -curve->before)
                                            : repeated(curve, curve->first, 1 - curve->before);
    }
}

static double end_slope(const CoSplineKnot *end, const CoSplineKnot *inner, bool is_post)
{
    const CoSplineKnot *a = is_post ? inner : end, *b = is_post ? end : inner;
    if (end->has_pre_value)
        return 0;
    if (interp_of(a) == CO_SPLINE_INTERP_LINEAR)
        return (co_spline_pre_value(b) - a->value) / (b->time - a->time);
    if (interp_of(a) != CO_SPLINE_INTERP_CURVE)
        return 0;
    return is_post ? b->pre.slope : a->post.slope;
}

static bool value_outside(const CoCurve *curve, const CoSplineExtrapolation *how, double time,
                          bool is_post, double *out)
{
    CoSplineKnot end, inner;
    if (is_blocked(curve, how))
        return false;
    find_end(curve, is_post, &end, &inner);
    double slope = 0;
    if (!strcmp(how->mode, "sloped"))
        slope = how->slope;
    else if (!strcmp(how->mode, "linear") && curve->count > 1)
        slope = end_slope(&end, &inner, is_post);
    *out = (is_post ? end.value : co_spline_pre_value(&end)) + slope * (time - end.time);
    return true;
}

// The whole spline, or the part of it up to or from a knot, over and over, each round as high above
// the one before as its ends differ. At the seams the order of these operations decides on which
// side a time comes to lie.
static void fold_ends(const CoSpline *spline, const CoCurve *curve, CoPlace *at)
{
    bool is_post = at->time >= curve->end_time;
    const CoSplineExtrapolation *how = is_post ? &spline->post : &spline->pre;
    if ((!is_post && at->time >= curve->begin_time) || strncmp(how->mode, "loop", 4) ||
        is_blocked(curve, how))
        return;
    CoSplineKnot first, last, inner;
    find_end(curve, false, &first, &inner);
    find_end(curve, true, &last, &inner);
    first.time = curve->begin_time;
    last.time = curve->end_time;
    if (how->has_boundary)
        *(is_post ? &first : &last) = *find_knot(curve, how->boundary);
    double length = last.time - first.time;
    double past = is_post ? at->time - last.time : first.time - at->time;
    if (!(length > 0))
        return;
    double rounds = trunc(past / length);
    if (is_post || rounds != past / length)
        rounds++;
    at->time += is_post ? -rounds * length : rounds * length;
    if (!strcmp(how->mode, "loop repeat")) {
        at->offset += is_post
                          ? rounds * (last.value - first.value)
                          : -rounds * (co_spline_pre_value(&last) - co_spline_pre_value(&first));
    } else if (!strcmp(how->mode, "loop oscillate") && fmod(rounds, 2) != 0) {
        at->time = first.time + (length - (at->time - first.time));
        at->from_left = true;
    }
}

static bool evaluate(const CoSpline *spline, const CoCurve *curve, double time, double *out)
{
    if (!curve->count)
        return false;
    CoPlace at = {.time = time};
    fold_ends(spline, curve, &at);
    fold_loop(curve, &at);
    const CoSplineKnot *knots = curve->knots;
    size_t high = search(curve, at.time);
    bool is_known,
        in_prototype = curve->has_loop && at.time >= curve->start && at.time < curve->end;
    if (high < curve->count && knots[high].time == at.time) {
        is_known = value_at_knot(spline, curve, high, at.from_left, out);
    } else if (high == 0) {
        is_known = value_outside(curve, &spline->pre, at.time, false, out);
    } else if (high == curve->count && !in_prototype) {
        is_known = value_outside(curve, &spline->post, at.time, true, out);
    } else {
        CoSplineKnot a = {0}, b = {0};
        find_neighbors(curve, at.time, high, &a, &b);
        is_known = value_between(curve, &a, &b, at.time, out);
    }
    *out += is_known ? at.offset : 0;
    return is_known;
}

// The curve of a spline, made once (with the lock held); NULL when memory is at an end.
static const CoCurve *make_curve(const CohortStage *stage, CohortType type, const CoSpline *spline)
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
    find_loop(curve, spline);
    return curve;
}

// ---- Values -------------------------------------------------------------------------------------
static const CoCurve *find_curve(const CohortStage *stage, CohortType type, const CoValue *value)
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
