// Which light to sample: each by an estimate of the irradiance it could give at the point.

#include "light/light_internal.h"
#include "math/elementary.h"

// The largest cosine to n over a cone around d (of length `dist`) that holds a ball of radius
// `bound`. The slack keeps lights near the horizon alive: n has been quantized, and may be a
// shading normal.
static float facing(CoVec3 n, CoVec3 d, float dist, float bound)
{
    const float slack = 0.03f;
    if (co_dot(n, n) < 0.25f || !(dist > bound))
        return 1.0f;
    float cosine = co_clamp(co_dot(n, d) / dist, -1.0f, 1.0f);
    float sin_cone = bound / dist, cos_cone = sqrtf(1.0f - sin_cone * sin_cone);
    if (cosine >= cos_cone)
        return 1.0f;
    float best = cosine * cos_cone + sqrtf(1.0f - cosine * cosine) * sin_cone;
    return fminf(fmaxf(best, 0.0f) + slack, 1.0f);
}

// A point safely outside the cone receives next to nothing; not zero, lest rounding decide.
static float cone_factor(const CoLight *light, CoVec3 d, float dist)
{
    if (!light->is_shaped || light->cone_outer >= CO_PI || !(dist > light->bound))
        return 1.0f;
    float off = co_acosf(-co_dot(light->axis, d) / dist);
    float reach = light->cone_outer + co_asinf(light->bound / dist);
    return off > reach + 0.01f ? 1e-3f : 1.0f;
}

static float flat_size(const CoLight *light, CoVec3 org, float d2, float dist)
{
    float height = co_light_plane_height(light, org);
    if (!(height > 0.0f))
        return 0.0f;
    float near2 = 0.25f * light->bound * light->bound;
    float cosine = fminf((height + 0.2f * light->bound) / fmaxf(dist, 1e-30f), 1.0f);
    return fminf(light->area * cosine / fmaxf(d2, near2), 2.0f * CO_PI);
}

static float ball_size(const CoLight *light, float d2)
{
    float sin2 = light->bound * light->bound / d2;
    if (!(sin2 < 1.0f))
        return 4.0f * CO_PI;
    return 2.0f * CO_PI * sin2 / (1.0f + sqrtf(1.0f - sin2));
}

static float distant_importance(const CoLight *light, CoVec3 n)
{
    CoVec3 back = co_neg(light->axis);
    if (light->is_delta)
        return light->strength * facing(n, back, 1.0f, 0.0f);
    float v = light->versine;
    float sine = v < 1.0f ? sqrtf(v * (2.0f - v)) : 1.0f;
    return light->strength * 2.0f * CO_PI * v * facing(n, back, 1.0f, sine);
}

float co_light_importance(const CoLight *light, CoVec3 org, CoVec3 n)
{
    if (!light->is_active)
        return 0.0f;
    if (light->type == COHORT_LIGHT_DOME)
        return light->strength * CO_PI;
    if (light->type == COHORT_LIGHT_DISTANT)
        return distant_importance(light, n);
    CoVec3 d = co_sub(light->center, org);
    float d2 = co_dot(d, d), dist = sqrtf(d2);
    float size =
        light->type == COHORT_LIGHT_SPHERE ? ball_size(light, d2) : flat_size(light, org, d2, dist);
    if (!(size > 0.0f))
        return 0.0f;
    float result = light->strength * size * facing(n, d, dist, light->bound);
    result *= cone_factor(light, d, dist);
    return result <= 1e36f ? result : 1e36f;
}
