// Pixel filters by importance sampling: every splat then lands in its own pixel with weight one.

#include "math/vec.h"
#include "sample/filter_table.h"
#include "sample/sample.h"

// Inverts the running area of a piecewise linear density over [0, 1] at u in [0, 1]: monotone, so
// the stratification of u survives.
static float invert(const float *density, const float *area, float u)
{
    int i = 0;
    for (int step = 32; step > 0; step >>= 1)
        if (i + step < FILTER_NODES - 1 && area[i + step] <= u)
            i += step;
    // Area gained at offset d: w0 d + (w1 - w0) d^2 / (2 h). The root in its stable form.
    const float h = 1.0f / (FILTER_NODES - 1);
    float a = co_max(u - area[i], 0.0f), w0 = density[i], w1 = density[i + 1];
    float under_root = co_max(w0 * w0 + 2.0f * (w1 - w0) / h * a, 0.0f);
    float denominator = w0 + sqrtf(under_root);
    float d = denominator > 0.0f ? 2.0f * a / denominator : h;
    return (float)i * h + co_min(d, h);
}

static float offset(CohortFilter filter, float u)
{
    float t = 2.0f * u - 1.0f;
    switch (filter) {
    case COHORT_FILTER_BOX:
        return 0.5f * t;
    case COHORT_FILTER_GAUSSIAN:
        return copysignf(1.5f * invert(gaussian_density, gaussian_area, fabsf(t)), t);
    case COHORT_FILTER_BLACKMAN_HARRIS:
        break;
    }
    return copysignf(2.0f * invert(blackman_harris_density, blackman_harris_area, fabsf(t)), t);
}

void co_filter_sample(CohortFilter filter, float u0, float u1, float *dx, float *dy)
{
    *dx = offset(filter, u0);
    *dy = offset(filter, u1);
}
