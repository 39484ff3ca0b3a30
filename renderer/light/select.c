// Which light to sample: each by an estimate of the irradiance it could give at the point.

#include "light/light_internal.h"
#include "math/elementary.h"

// One square root and one division per light: this runs over all of them at every vertex.

// At least the largest cosine to n over the cone of sine `sin_cone` around the unit direction whose
// cosine is given: cos(a - b) <= cos(a) + sin(b). The slack keeps lights near the horizon alive: n
// has been quantized, and may be a shading normal.
static float facing(CoVec3 n, float cosine, float sin_cone)
{
    const float slack = 0.03f;
    if (co_dot(n, n) < 0.25f)
        return 1.0f;
    return co_min(co_max(cosine + sin_cone, 0.0f) + slack, 1.0f);
}

// A point safely outside the cone receives next to nothing; not zero, lest rounding decide.
static float cone_factor(const CoLight *light, CoVec3 d, float dist)
{
    if (light->cone_outer >= CO_PI || !(dist > light->bound))
        return 1.0f;
    float off = co_acosf(-co_dot(light->axis, d) / dist);
    float reach = light->cone_outer + co_asinf(light->bound / dist);
    return off > reach + 0.01f ? 1e-3f : 1.0f;
}

// Solid angle of a flat light, about; 0 behind it.
static float flat_size(const CoLight *light, CoVec3 org, float inv_dist)
{
    float height = co_light_plane_height(light, org);
    if (!(height > 0.0f))
        return 0.0f;
    float cosine = co_min((height + 0.2f * light->bound) * inv_dist, 1.0f);
    return co_min(light->area * cosine * inv_dist * inv_dist, 2.0f * CO_PI);
}

// Solid angle of a ball; 1 - cos = sin^2 (1 + sin^2) / 2, about, exact where it touches org.
static float ball_size(float sin_cone)
{
    float sin2 = sin_cone * sin_cone;
    return sin2 < 1.0f ? CO_PI * sin2 * (1.0f + sin2) : 4.0f * CO_PI;
}

static float distant_importance(const CoLight *light, CoVec3 n)
{
    float cosine = -co_dot(light->axis, n);
    if (light->is_delta)
        return light->strength * facing(n, cosine, 0.0f);
    float v = light->versine;
    float sine = v < 1.0f ? sqrtf(v * (2.0f - v)) : 1.0f;
    return light->strength * 2.0f * CO_PI * v * facing(n, cosine, sine);
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
    float dist = sqrtf(co_dot(d, d)), inv_dist = 1.0f / co_max(dist, 1e-15f);
    float sin_cone = light->bound * inv_dist;
    if (light->type == COHORT_LIGHT_SPHERE && sin_cone >= 1.0f &&
        co_sphere_light_is_around(light, org))
        return 0.0f;
    float size =
        light->type == COHORT_LIGHT_SPHERE ? ball_size(sin_cone) : flat_size(light, org, inv_dist);
    if (!(size > 0.0f))
        return 0.0f;
    float result = light->strength * size * facing(n, co_dot(n, d) * inv_dist, sin_cone);
    if (light->is_shaped)
        result *= cone_factor(light, d, dist);
    return co_min(result, 1e36f);
}
