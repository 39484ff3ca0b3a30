// All lights of a scene: made once at commit, then read by every thread.

#include "light/light_internal.h"

#include "base/error.h"

// Importances kept between the two passes of a choice.
enum {
    CACHED = 64
};

static float brightest(const CoLight *light)
{
    float factor = 1.0f;
    if (light->image.pixels != NULL) {
        factor = 0.0f;
        for (uint32_t y = 0; y < light->image.height; y++)
            for (uint32_t x = 0; x < light->image.width; x++)
                factor = co_max(factor, co_max3(co_light_image_texel(&light->image, x, y)));
    }
    float tint =
        light->is_shaped && light->focus > 0.0f ? co_max(co_max3(light->focus_tint), 1.0f) : 1.0f;
    return co_max3(light->radiance) * factor * tint;
}

CoLights *co_lights_create(const CohortLightDesc *descs, const CoLightImage *images, uint32_t count,
                           const double frame[3], const float rgb_to_rendering[9],
                           float scene_radius, CohortError *err)
{
    (void)scene_radius;
    CoLights *lights = co_alloc_zero(CO_MEMORY_LIGHT, sizeof *lights);
    if (lights != NULL && count > 0)
        lights->lights = co_alloc_zero(CO_MEMORY_LIGHT, (size_t)count * sizeof *lights->lights);
    if (lights == NULL || (count > 0 && lights->lights == NULL)) {
        co_free(CO_MEMORY_LIGHT, lights, sizeof *lights);
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "no memory for %u lights", count);
        return NULL;
    }
    lights->count = count;
    lights->only = COHORT_INVALID_ID;
    for (uint32_t i = 0; i < count; i++) {
        CoLight *light = &lights->lights[i];
        const CoLightImage *image = images != NULL ? &images[i] : NULL;
        if (!co_light_setup(light, &descs[i], image, frame, rgb_to_rendering, err)) {
            co_lights_destroy(lights);
            return NULL;
        }
        if (light->is_active) {
            lights->only = lights->active_count++ == 0 ? i : COHORT_INVALID_ID;
            light->is_shadowless = descs[i].no_shadow;
            lights->shadowless_count += descs[i].no_shadow;
            lights->max_radiance = co_max(lights->max_radiance, brightest(light));
        }
    }
    return lights;
}

void co_lights_destroy(CoLights *lights)
{
    if (lights == NULL)
        return;
    for (uint32_t i = 0; i < lights->count; i++)
        co_light_teardown(&lights->lights[i]);
    co_free(CO_MEMORY_LIGHT, lights->lights, (size_t)lights->count * sizeof *lights->lights);
    co_free(CO_MEMORY_LIGHT, lights, sizeof *lights);
}

uint32_t co_lights_count(const CoLights *lights)
{
    return lights->active_count;
}

bool co_lights_have_choice(const CoLights *lights)
{
    return lights->only == COHORT_INVALID_ID;
}

float co_lights_max_radiance(const CoLights *lights)
{
    return lights->max_radiance;
}

bool co_light_is_dome(const CoLights *lights, uint32_t emitter)
{
    return emitter < lights->count && lights->lights[emitter].type == COHORT_LIGHT_DOME;
}

bool co_light_is_shadowless(const CoLights *lights, uint32_t emitter)
{
    return emitter < lights->count && lights->lights[emitter].is_shadowless;
}

bool co_lights_have_shadowless(const CoLights *lights)
{
    return lights->shadowless_count > 0;
}

// Sum over all lights, in their order; the first CACHED terms are kept.
static float total_importance(const CoLights *lights, CoVec3 org, CoVec3 n, float cache[CACHED])
{
    float total = 0.0f;
    for (uint32_t i = 0; i < lights->count; i++) {
        float importance = co_light_importance(&lights->lights[i], org, n);
        if (i < CACHED)
            cache[i] = importance;
        total += importance;
    }
    return total;
}

// *share: the probability of the choice.
static uint32_t choose(const CoLights *lights, CoVec3 org, CoVec3 n, float uc, float *share)
{
    *share = 1.0f;
    if (lights->only != COHORT_INVALID_ID)
        return lights->only;
    float cache[CACHED];
    float total = total_importance(lights, org, n, cache);
    float target = uc * total, running = 0.0f;
    uint32_t chosen = COHORT_INVALID_ID;
    for (uint32_t i = 0; i < lights->count; i++) {
        float importance = i < CACHED ? cache[i] : co_light_importance(&lights->lights[i], org, n);
        if (!(importance > 0.0f))
            continue;
        chosen = i; // also the last one standing, where rounding passes the end
        *share = importance / total;
        running += importance;
        if (target < running)
            break;
    }
    return chosen;
}

bool co_light_sample(const CoLights *lights, CoVec3 org, CoVec3 n, float uc, float u0, float u1,
                     CoLightSample *out)
{
    float share = 0.0f;
    uint32_t emitter = choose(lights, org, n, uc, &share);
    if (emitter == COHORT_INVALID_ID)
        return false;
    const CoLight *light = &lights->lights[emitter];
    CoLightSample sample = {.emitter = emitter, .is_delta = light->is_delta, .share = share};
    bool ok = true;
    switch (light->type) {
    case COHORT_LIGHT_RECT:
        ok = co_rect_light_sample(light, org, u0, u1, &sample.wi, &sample.density);
        break;
    case COHORT_LIGHT_DISK:
        ok = co_disk_light_sample(light, org, u0, u1, &sample.wi);
        break;
    case COHORT_LIGHT_SPHERE:
        ok = co_sphere_light_sample(light, org, u0, u1, &sample.wi);
        break;
    case COHORT_LIGHT_DISTANT:
        sample.wi = co_distant_light_sample(light, u0, u1);
        break;
    case COHORT_LIGHT_DOME:
        ok = co_dome_light_sample(light, n, u0, u1, &sample.wi);
        break;
    }
    if (ok)
        *out = sample;
    return ok;
}

static float direction_pdf(const CoLight *light, CoVec3 org, CoVec3 n, CoVec3 wi)
{
    switch (light->type) {
    case COHORT_LIGHT_RECT:
        return co_rect_light_pdf(light, org, wi);
    case COHORT_LIGHT_DISK:
        return co_light_plane_pdf(light, org, wi);
    case COHORT_LIGHT_SPHERE:
        return co_sphere_light_pdf(light, org, wi);
    case COHORT_LIGHT_DISTANT:
        return co_distant_light_pdf(light);
    case COHORT_LIGHT_DOME:
        break;
    }
    return co_dome_light_pdf(light, n, wi);
}

float co_light_pdf(const CoLights *lights, CoVec3 org, CoVec3 n, uint32_t emitter, CoVec3 wi)
{
    if (emitter >= lights->count)
        return 0.0f;
    if (emitter == lights->only)
        return direction_pdf(&lights->lights[emitter], org, n, wi);
    float cache[CACHED];
    float total = total_importance(lights, org, n, cache);
    const CoLight *light = &lights->lights[emitter];
    float own = emitter < CACHED ? cache[emitter] : co_light_importance(light, org, n);
    if (!(own > 0.0f))
        return 0.0f;
    return own / total * direction_pdf(light, org, n, wi);
}

float co_light_sample_pdf(const CoLights *lights, CoVec3 org, CoVec3 n, const CoLightSample *sample,
                          CoVec3 wi)
{
    if (sample->density > 0.0f)
        return sample->share * sample->density;
    return sample->share * direction_pdf(&lights->lights[sample->emitter], org, n, wi);
}

// Distance and radiance of a finite light; false where the ray misses it or meets its dark side.
static bool meet(const CoLight *light, CoVec3 org, CoVec3 dir, float *t, CoVec3 *radiance)
{
    float a = 0.0f, b = 0.0f;
    if (light->type == COHORT_LIGHT_SPHERE) {
        if (!co_sphere_light_meet(light, org, dir, t))
            return false;
    } else {
        if (!(co_light_plane_height(light, org) > 0.0f) ||
            !co_light_plane_meet(light, org, dir, t, &a, &b))
            return false;
        bool is_inside = light->type == COHORT_LIGHT_RECT ? fabsf(a) <= 1.0f && fabsf(b) <= 1.0f
                                                          : a * a + b * b <= 1.0f;
        if (!is_inside)
            return false;
    }
    *radiance = co_light_emission(light, dir, a, b);
    return true;
}

float co_light_ray_end(const CoLights *lights, CoVec3 org, CoVec3 dir, uint32_t emitter,
                       CoVec3 *radiance)
{
    *radiance = co_vec3_splat(0.0f);
    if (emitter >= lights->count || !lights->lights[emitter].is_active)
        return 0.0f;
    const CoLight *light = &lights->lights[emitter];
    float t = INFINITY, a = 0.0f, b = 0.0f;
    if (light->type == COHORT_LIGHT_DISTANT) {
        *radiance = co_scale(light->radiance, light->diffuse);
        return t;
    }
    if (light->type == COHORT_LIGHT_DOME) {
        *radiance = co_scale(co_dome_light_radiance(light, dir), light->diffuse);
        return t;
    }
    bool is_flat = light->type != COHORT_LIGHT_SPHERE;
    bool is_met = is_flat ? co_light_plane_meet(light, org, dir, &t, &a, &b)
                          : co_sphere_light_meet(light, org, dir, &t);
    if (!is_met)
        t = co_max(co_dot(co_sub(light->center, org), dir), 0.0f);
    if (is_flat && !(co_light_plane_height(light, org) > 0.0f))
        return t;
    CoVec3 emission =
        co_light_emission(light, dir, co_clamp(a, -1.0f, 1.0f), co_clamp(b, -1.0f, 1.0f));
    *radiance = co_scale(emission, light->diffuse);
    return t;
}

CoVec3 co_light_ray_radiance(const CoLights *lights, CoVec3 org, CoVec3 dir, uint32_t emitter)
{
    CoVec3 radiance = co_vec3_splat(0.0f);
    if (emitter >= lights->count)
        return radiance;
    const CoLight *light = &lights->lights[emitter];
    if (light->type != COHORT_LIGHT_RECT || light->image.pixels || light->is_shaped)
        co_light_ray_end(lights, org, dir, emitter, &radiance);
    else if (light->is_active && co_light_plane_height(light, org) > 0.0f)
        radiance = co_scale(light->radiance, light->diffuse); // wherever it is met
    return radiance;
}

// Whether the ray's line passes the ball around the light: most lights end here.
static bool may_meet(const CoLight *light, CoVec3 org, CoVec3 dir, float tfar)
{
    CoVec3 d = co_sub(light->center, org);
    float along = co_dot(d, dir);
    CoVec3 across = co_sub(d, co_scale(dir, along));
    float reach = light->bound + 1e-6f * fabsf(along);
    return co_dot(across, across) <= reach * reach && along >= -reach && along - reach <= tfar;
}

void co_light_collect(const CoLights *lights, CoVec3 org, CoVec3 dir, float tnear, float tfar,
                      CoLightHitFn *fn, void *context)
{
    for (uint32_t i = 0; i < lights->count; i++) {
        const CoLight *light = &lights->lights[i];
        if (!light->is_active || light->is_delta)
            continue;
        CoLightHit hit = {.emitter = i, .t = INFINITY, .diffuse = light->diffuse};
        if (light->type == COHORT_LIGHT_DOME || light->type == COHORT_LIGHT_DISTANT) {
            if (!isinf(tfar))
                continue;
            if (light->type == COHORT_LIGHT_DOME)
                hit.radiance = co_dome_light_radiance(light, dir);
            else if (co_distant_light_meet(light, dir))
                hit.radiance = light->radiance;
        } else if (!may_meet(light, org, dir, tfar) ||
                   !meet(light, org, dir, &hit.t, &hit.radiance) || !(hit.t > tnear) ||
                   !(hit.t < tfar)) {
            continue;
        }
        if (co_max3(hit.radiance) > 0.0f)
            fn(context, &hit);
    }
}
