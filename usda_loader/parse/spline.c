// name.spline = { bezier, pre: held, 1: 5; pre (0.5, 1); post curve (0.5, 1.5), ... }

#include "parse/parser.h"

#include <math.h>
#include <stdlib.h>

static bool parse_real(CoParser *p, double *out)
{
    CoNumber number;
    if (co_scan_number(&p->scan, &number) != CO_SCAN_OK)
        return co_parse_expected(p, "a number");
    *out = number.real;
    return true;
}

// A character with inline padding on both sides.
static bool parse_padded(CoParser *p, char c)
{
    co_scan_inline(&p->scan);
    if (!co_parse_char(p, c))
        return false;
    co_scan_inline(&p->scan);
    return true;
}

// Behind a loop: "(" time ")", or nothing.
static bool parse_boundary(CoParser *p, CoSplineExtrapolation *out)
{
    CoScan ahead = p->scan;
    co_scan_inline(&ahead);
    if (co_scan_peek(&ahead) != '(')
        return true;
    out->has_boundary = true;
    if (!parse_padded(p, '(') || !parse_real(p, &out->boundary))
        return false;
    co_scan_inline(&p->scan);
    return co_parse_char(p, ')');
}

static bool parse_extrapolation(CoParser *p, CoSplineExtrapolation *out)
{
    static const char *const words[] = {"none", "held", "linear"};
    static const char *const loops[][2] = {
        {"repeat", "loop repeat"}, {"reset", "loop reset"}, {"oscillate", "loop oscillate"}};
    if (!parse_padded(p, ':'))
        return false;
    *out = (CoSplineExtrapolation){.mode = ""}; // whatever may have been said before
    for (size_t i = 0; i < 3; i++)
        if (co_scan_word(&p->scan, words[i])) {
            out->mode = words[i];
            return true;
        }
    if (co_scan_word(&p->scan, "sloped")) {
        out->mode = "sloped";
        if (!parse_padded(p, '(') || !parse_real(p, &out->slope))
            return false;
        co_scan_inline(&p->scan);
        return co_parse_char(p, ')');
    }
    if (co_scan_word(&p->scan, "loop") && co_scan_gap(&p->scan))
        for (size_t i = 0; i < 3; i++)
            if (co_scan_word(&p->scan, loops[i][0])) {
                out->mode = loops[i][1];
                return parse_boundary(p, out);
            }
    return co_parse_expected(p, "none, held, linear, sloped(...) or loop repeat, reset, oscillate");
}

static bool parse_loop(CoParser *p, CoSpline *spline)
{
    if (!parse_padded(p, ':') || !parse_padded(p, '('))
        return false;
    for (int i = 0; i < 5; i++) {
        const char *start = p->scan.at;
        if (!parse_real(p, &spline->loop[i]))
            return false;
        if ((i == 2 || i == 3) && spline->loop[i] != trunc(spline->loop[i]))
            return co_parse_fail(p, start, "a spline loops a whole number of times");
        if (i < 4 && !parse_padded(p, ','))
            return false;
    }
    co_scan_inline(&p->scan);
    spline->has_loop = true;
    return co_parse_char(p, ')');
}

// "(" [width ","] slope ["," algorithm] ")"
static bool parse_tangent(CoParser *p, CoSplineTangent *out)
{
    *out = (CoSplineTangent){.is_set = true, .algorithm = ""};
    if (!parse_padded(p, '(') || !parse_real(p, &out->slope))
        return false;
    co_scan_inline(&p->scan);
    for (int part = 1; part < 3 && co_scan_char(&p->scan, ','); part++) {
        co_scan_inline(&p->scan);
        if (co_scan_word(&p->scan, "custom"))
            out->algorithm = "custom";
        else if (co_scan_word(&p->scan, "autoEase"))
            out->algorithm = "autoEase";
        else if (part == 2)
            return co_parse_expected(p, "custom or autoEase");
        if (out->algorithm[0]) {
            co_scan_inline(&p->scan);
            break;
        }
        out->has_width = true;
        out->width = out->slope;
        if (!parse_real(p, &out->slope))
            return false;
        co_scan_inline(&p->scan);
    }
    return co_parse_char(p, ')');
}

static bool parse_shape(CoParser *p, CoSplineKnot *knot)
{
    static const char *const modes[] = {"none", "held", "linear", "curve"};
    if (!co_scan_gap(&p->scan))
        return co_parse_expected(p, "a blank");
    for (size_t i = 0; i < 4; i++) {
        if (!co_scan_word(&p->scan, modes[i]))
            continue;
        knot->has_interp = true;
        knot->interp = (CoSplineInterp)i;
        CoScan ahead = p->scan;
        co_scan_inline(&ahead);
        return co_scan_peek(&ahead) != '(' || parse_tangent(p, &knot->post);
    }
    return co_parse_expected(p, "none, held, linear or curve");
}

// One of pre, post and custom data after a knot's ';'.
static bool parse_parameter(CoParser *p, CoSplineKnot *knot)
{
    if (co_scan_word(&p->scan, "pre")) {
        if (!co_scan_gap(&p->scan))
            return co_parse_expected(p, "a blank and '('");
        return parse_tangent(p, &knot->pre);
    }
    if (co_scan_word(&p->scan, "post"))
        return parse_shape(p, knot);
    if (co_scan_peek(&p->scan) != '{')
        return co_parse_expected(p, "pre, post or a dictionary");
    knot->custom_data = co_parse_alloc(p, 1, sizeof *knot->custom_data);
    return knot->custom_data && co_parse_dictionary(p, knot->custom_data);
}

static bool at_separator(const CoParser *p)
{
    int c = co_scan_peek(&p->scan);
    return c == ';' || c == '\n' || c == '\r';
}

static bool parse_parameters(CoParser *p, CoSplineKnot *knot)
{
    CoScan ahead = p->scan;
    if (!at_separator(p))
        return true;
    p->scan.at++;
    co_scan_inline(&p->scan);
    for (;;) {
        if (!parse_parameter(p, knot))
            return false;
        ahead = p->scan;
        co_scan_line(&ahead);
        if (ahead.at >= ahead.end || !(*ahead.at == ';' || *ahead.at == '\n' || *ahead.at == '\r'))
            return true;
        ahead.at++;
        co_scan_space(&ahead);
        p->scan.at = ahead.at;
        int c = co_scan_peek(&p->scan);
        if (c == '}' || c == ',')
            return true;
    }
}

static bool parse_knot(CoParser *p, CoSpline *spline)
{
    CoSplineKnot knot = {.pre.algorithm = "", .post.algorithm = ""};
    if (!parse_real(p, &knot.time) || !parse_padded(p, ':') || !parse_real(p, &knot.value))
        return false;
    co_scan_inline(&p->scan);
    if (co_scan_char(&p->scan, '&')) {
        knot.has_pre_value = true;
        knot.pre_value = knot.value;
        co_scan_inline(&p->scan);
        if (!parse_real(p, &knot.value))
            return false;
    }
    if (!parse_parameters(p, &knot))
        return false;
    CoSplineKnot *slot = co_parse_push(p, &spline->knots, spline->count, sizeof *slot);
    if (!slot)
        return false;
    *slot = knot;
    spline->count++;
    return true;
}

typedef struct Numbered {
    double time;
    size_t number;
} Numbered;

static int by_time(const void *a, const void *b)
{
    const Numbered *x = a, *y = b;
    if (isnan(x->time) != isnan(y->time))
        return isnan(x->time) ? 1 : -1;
    return x->time < y->time ? -1 : x->time > y->time ? 1 : x->number < y->number ? -1 : 1;
}

// Brings the knots into the order of their times; of two knots at one time the first stays.
static bool sort_knots(CoParser *p, CoSpline *spline)
{
    Numbered *order = co_parse_alloc(p, spline->count, sizeof *order);
    CoSplineKnot *knots = co_parse_alloc(p, spline->count, sizeof *knots);
    if (!order || !knots)
        return false;
    for (size_t i = 0; i < spline->count; i++)
        order[i] = (Numbered){spline->knots[i].time, i};
    qsort(order, spline->count, sizeof *order, by_time);
    size_t kept = 0;
    for (size_t i = 0; i < spline->count; i++)
        if (!kept || knots[kept - 1].time != order[i].time)
            knots[kept++] = spline->knots[order[i].number];
    spline->knots = knots;
    spline->count = kept;
    return true;
}

static bool spline_item(CoParser *p, void *context)
{
    CoSpline *spline = context;
    if (co_scan_word(&p->scan, "bezier")) {
        spline->curve = "bezier";
        return true;
    }
    if (co_scan_word(&p->scan, "hermite")) {
        spline->curve = "hermite";
        return true;
    }
    if (co_scan_word(&p->scan, "pre"))
        return parse_extrapolation(p, &spline->pre);
    if (co_scan_word(&p->scan, "post"))
        return parse_extrapolation(p, &spline->post);
    if (co_scan_word(&p->scan, "loop"))
        return parse_loop(p, spline);
    return parse_knot(p, spline);
}

bool co_parse_spline(CoParser *p, CoSpline *out)
{
    *out = (CoSpline){.curve = "", .pre.mode = "", .post.mode = ""};
    return co_parse_char(p, '{') && co_parse_list(p, '}', false, spline_item, out) &&
           sort_knots(p, out);
}
