// A curved segment between two knots of a spline.
//
// Source: the reference's rules, each tried: a Bezier whose time would run backwards has both its
// handles shortened in proportion until it does not.

#include "stage/spline_segment.h"

#include <math.h>

static double bezier(double p0, double p1, double p2, double p3, double u)
{
    double v = 1 - u;
    return v * v * v * p0 + 3 * v * v * u * p1 + 3 * v * u * u * p2 + u * u * u * p3;
}

// Handles in time. It never runs backwards while, as parts of the segment, both are at most 1, or
// within an ellipse that touches 4/3; both go back to it in proportion. The reference stays a hair
// within the bound, by a fixed length, and takes a handle as short as that hair for none.
static void shorten(double span, double *out, double *in)
{
    const double margin = 1e-5, least = 1e-6;
    double first = *out / span, second = *in / span, a = first + least, b = second + least;
    if ((first <= 1 && second <= 1) || a * a + b * b + a * b - 2 * (a + b) + 1 <= 0)
        return;
    if (first < least) {
        *in = (1 - margin) * span;
    } else if (second < least) {
        *out = (1 - margin) * span;
    } else {
        double ratio = first / second;
        double most = (sqrt(ratio) + ratio + 1) / (ratio * ratio + ratio + 1);
        *out = fmax(ratio * most - margin, 0) * span;
        *in = fmax(most - margin, 0) * span;
    }
}

// By arithmetic alone, to be the same on every machine.
static double cube_root(double x)
{
    int exponent;
    double part = frexp(fabs(x), &exponent);
    if (x == 0 || !isfinite(x))
        return x;
    while (exponent % 3 != 0) {
        part *= 0.5;
        exponent++;
    }
    double root = 0.4 + 0.6 * part; // within an eighth of it
    for (int i = 0; i < 6; i++)
        root -= (root * root * root - part) / (3 * root * root);
    return copysign(ldexp(root, exponent / 3), x);
}

// Where the time of a Bezier segment passes zero. With one real root by Cardano's formula, which
// next to a vertical tangent is off by some 1e-6, as in the reference: there that is to be seen.
static double zero_of_time(double p0, double p1, double p2, double p3)
{
    double a = -p0 + 3 * p1 - 3 * p2 + p3;
    double b = (3 * p0 - 6 * p1 + 3 * p2) / a, c = (-3 * p0 + 3 * p1) / a, d = p0 / a;
    double p = (3 * c - b * b) / 3 / 3, half_q = (2 * b * b * b - 9 * b * c + 27 * d) / 27 / 2;
    double root = half_q * half_q + p * p * p, low = 0, high = 1;
    if (fabs(a) > 1e-10 && root > 0) {
        root = sqrt(root);
        return fmin(fmax(cube_root(root - half_q) - cube_root(root + half_q) - b / 3, 0), 1);
    }
    for (int i = 0; i < 60; i++) {
        double u = 0.5 * (low + high);
        if (bezier(p0, p1, p2, p3, u) < 0)
            low = u;
        else
            high = u;
    }
    return 0.5 * (low + high);
}

double co_spline_segment(const CoSplineKnot *a, const CoSplineKnot *b, bool is_hermite, double time)
{
    double span = b->time - a->time, end = co_spline_pre_value(b), u = (time - a->time) / span;
    double out = a->post.is_set ? fmax(a->post.width, 0) : 0;
    double in = b->pre.is_set ? fmax(b->pre.width, 0) : 0;
    if (is_hermite)
        out = in = span / 3;
    else
        shorten(span, &out, &in);
    double v1 = a->value + out * a->post.slope, v2 = end - in * b->pre.slope;
    if (!is_hermite)
        u = zero_of_time(a->time - time, a->time + out - time, b->time - in - time, b->time - time);
    return bezier(a->value, v1, v2, end, u);
}
