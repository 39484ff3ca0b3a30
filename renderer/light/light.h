// Lights of a committed scene (UsdLux), sampled, met by rays, and with one pdf for both sides.
//
// Lights are no surfaces: they cast no shadow. A ray collects, with its weight, the emission of
// every finite light it crosses before its first surface, and of dome and distant lights when it
// finds none.

#ifndef CO_LIGHT_LIGHT_H
#define CO_LIGHT_LIGHT_H

#include "cohort/scene.h"
#include "math/vec.h"

typedef struct CoLights CoLights;

// A dome's or rect's image, read at commit; NULL pixels = none.
typedef struct CoLightImage {
    const float *pixels; // [height][width][4], rows from the top; must outlive the lights
    uint32_t width, height;
} CoLightImage;

// descs in the order of light ids, images beside them (NULL: none); `frame` = world to render frame
// translation (render = world - frame); rgb_to_rendering: 3x3 row-major Rec.709 -> rendering space
// for color temperature. scene_radius: of the scene's box in the render frame; selection, which
// works in irradiance at the point, does not need it. NULL when out of memory.
//
// Radiance follows UsdLux: intensity * 2^exposure / sizeFactor * color * temperature * texture *
// shaping. Rect and disk emit to one side, along -Z; spheres outwards, so that inside one there is
// none of its light. Sizes are those of the transformed shape: a disk may
// become an ellipse, a rect a parallelogram, a sphere an ellipsoid. Shaping concerns rect, disk and
// sphere. A dome's transform counts by its rotation alone.
CoLights *co_lights_create(const CohortLightDesc *descs, const CoLightImage *images, uint32_t count,
                           const double frame[3], const float rgb_to_rendering[9],
                           float scene_radius, CohortError *err);
void co_lights_destroy(CoLights *lights);

// Why a light will contribute nothing, or other than authored, as a sentence without a subject;
// NULL when all is well. For the one who reports: co_lights_create is silent about it.
const char *co_light_problem(const CohortLightDesc *desc);

uint32_t co_lights_count(const CoLights *lights);   // those that can contribute
bool co_lights_have_choice(const CoLights *lights); // more than one: co_light_sample then reads uc
// Brightest radiance any light can show, for the film's unit; irradiance for delta distant lights.
float co_lights_max_radiance(const CoLights *lights);

bool co_light_is_dome(const CoLights *lights, uint32_t emitter);
// Whether surfaces do not keep this light from others (CohortLightDesc.no_shadow), or any light.
bool co_light_is_shadowless(const CoLights *lights, uint32_t emitter);
bool co_lights_have_shadowless(const CoLights *lights);

typedef struct CoLightSample {
    uint32_t emitter;
    CoVec3 wi;     // unit, towards the light
    bool is_delta; // distant light of angle 0: pdf is a probability, not a density
    float share;   // probability with which the emitter was chosen
    float density; // of wi among this emitter's, where it is the same for all; else 0
} CoLightSample;

// Chooses a light and a direction from `org` (on a surface with normal n; n = 0 in none). False
// when nothing can be received there.
bool co_light_sample(const CoLights *lights, CoVec3 org, CoVec3 n, float uc, float u0, float u1,
                     CoLightSample *out);

// Solid-angle pdf with which co_light_sample makes direction wi by this emitter, selection included
// (the probability, for delta lights). The one function for both sides of multiple importance
// sampling. wi must meet the emitter, or have been aimed at it: that is not tested again, since a
// small light's own samples may miss it by rounding.
float co_light_pdf(const CoLights *lights, CoVec3 org, CoVec3 n, uint32_t emitter, CoVec3 wi);

// co_light_pdf for a sample that has just been made at the same org and n, bit for bit, without
// choosing again. wi: the sample's, or what became of it in a record.
float co_light_sample_pdf(const CoLights *lights, CoVec3 org, CoVec3 n, const CoLightSample *sample,
                          CoVec3 wi);

// Where a ray aimed at `emitter` ends: the distance to it (INFINITY for dome and distant), by
// intersection, or by closest approach where rounding misses it. *radiance = what it sends back
// along the ray, times the light's diffuse multiplier. (0 from behind a one-sided light.)
float co_light_ray_end(const CoLights *lights, CoVec3 org, CoVec3 dir, uint32_t emitter,
                       CoVec3 *radiance);

// The radiance of co_light_ray_end alone.
CoVec3 co_light_ray_radiance(const CoLights *lights, CoVec3 org, CoVec3 dir, uint32_t emitter);

// Calls fn for every emitter the ray (not delta lights) meets with tnear < t < tfar; dome and
// distant lights only when tfar is infinite.
typedef struct CoLightHit {
    uint32_t emitter;
    float t;         // INFINITY: dome, distant
    CoVec3 radiance; // without the diffuse multiplier
    float diffuse;   // the light's diffuse multiplier: for all rays but the camera's
} CoLightHit;
typedef void CoLightHitFn(void *context, const CoLightHit *hit);
void co_light_collect(const CoLights *lights, CoVec3 org, CoVec3 dir, float tnear, float tfar,
                      CoLightHitFn *fn, void *context);

#endif
