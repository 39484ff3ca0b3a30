// What the light room's files share: one prepared light, and one set of functions per type.

#ifndef CO_LIGHT_LIGHT_INTERNAL_H
#define CO_LIGHT_LIGHT_INTERNAL_H

#include "light/light.h"

#include "base/memory.h"

// Distribution of a dome's image over its directions: rows by their share, then cells within a row.
// Cells are k x k texels, so that a large image keeps a small table.
typedef struct CoDome {
    uint32_t width, height, texels_per_cell; // in cells
    double *cos_edges;                       // [height + 1], 1 at the top pole to -1
    float *row_edges;                        // [height + 1] running share of the rows
    float *cell_edges;                       // [height][width + 1] running share within a row
} CoDome;

// One light, in the render frame.
typedef struct CoLight {
    CohortLightType type;
    bool is_active; // can contribute anywhere
    bool is_delta;  // distant, parallel
    bool is_shaped; // focus or cone
    bool is_shadowless;
    bool is_right_angled; // rect: edges orthogonal; sphere: round
    float diffuse;
    CoVec3 radiance; // where texture and shaping are 1; irradiance for delta lights
    float strength;  // mean of the channels and of the texture, for selection
    CoVec3 center;
    CoVec3 axis;           // unit, the way the light shines (-Z)
    CoVec3 normal;         // rect, disk: unit, of the side that emits
    CoVec3 ex, ey;         // rect: half edges; disk, ellipsoid: what the map makes of the unit axes
    CoVec3 dir_x, dir_y;   // rect: ex and ey made unit
    double half_x, half_y; // rect: lengths of ex and ey
    CoVec3 ez;             // ellipsoid: the third
    CoVec3 ux, uy;         // dual to ex and ey: a = ux . (p - center) is 1 at the edge
    float area, inv_area;
    float bound;       // radius of a sphere around center that holds the light
    CoAffine to_local; // ellipsoid: to the unit sphere; dome: rotation to its own axes
    float to_local_det;
    float versine;                       // distant: 1 - cos(half angle)
    float focus, cone_outer, cone_inner; // cone angles in radians; outer >= pi = none
    CoVec3 focus_tint;
    CoLightImage image;
    CoDome dome;
} CoLight;

struct CoLights {
    CoLight *lights;
    uint32_t count, active_count, shadowless_count;
    uint32_t only; // the light that is active, if it is one alone; else COHORT_INVALID_ID
    float max_radiance;
};

// light_setup.c. Leaves the light inactive where co_light_problem() names a reason or nothing
// shines.
bool co_light_setup(CoLight *light, const CohortLightDesc *desc, const CoLightImage *image,
                    const double frame[3], const float rgb_to_rendering[9], CohortError *err);
void co_light_teardown(CoLight *light);

// emission.c. Radiance sent back along a ray of direction `dir` that meets the light at (a, b),
// each in [-1, 1] over a rect.
CoVec3 co_light_emission(const CoLight *light, CoVec3 dir, float a, float b);
// Bilinear between texel centers. x, y in texels; columns wrap or clamp, rows clamp; what is not
// finite or negative counts as 0.
CoVec3 co_light_image_lookup(const CoLightImage *image, float x, float y, bool wrap);
CoVec3 co_light_image_texel(const CoLightImage *image, uint32_t x, uint32_t y);

// select.c. Estimate of what the light sends to org: never 0 where it contributes.
float co_light_importance(const CoLight *light, CoVec3 org, CoVec3 n);

// rect_light.c, disk_light.c. Where the ray's line meets the plane: t > 0 and finite, or false. (a,
// b) as above. Whether that is inside the light is the caller's to ask.
bool co_light_plane_meet(const CoLight *light, CoVec3 org, CoVec3 dir, float *t, float *a,
                         float *b);
// Height of org over the side that emits; nothing is received at 0 or below.
float co_light_plane_height(const CoLight *light, CoVec3 org);
// Solid-angle density of a direction under uniform sampling of the flat light's area.
float co_light_plane_pdf(const CoLight *light, CoVec3 org, CoVec3 wi);

// *density is set, as co_rect_light_pdf has it, where it does not depend on wi.
bool co_rect_light_sample(const CoLight *light, CoVec3 org, float u0, float u1, CoVec3 *wi,
                          float *density);
float co_rect_light_pdf(const CoLight *light, CoVec3 org, CoVec3 wi);

bool co_disk_light_sample(const CoLight *light, CoVec3 org, float u0, float u1, CoVec3 *wi);

// sphere_light.c
bool co_sphere_light_is_around(const CoLight *light, CoVec3 org);
bool co_sphere_light_sample(const CoLight *light, CoVec3 org, float u0, float u1, CoVec3 *wi);
float co_sphere_light_pdf(const CoLight *light, CoVec3 org, CoVec3 wi);
bool co_sphere_light_meet(const CoLight *light, CoVec3 org, CoVec3 dir, float *t);

// distant_light.c
CoVec3 co_distant_light_sample(const CoLight *light, float u0, float u1);
float co_distant_light_pdf(const CoLight *light);
bool co_distant_light_meet(const CoLight *light, CoVec3 dir);

// dome_light.c. Sampling of a dome without an image follows the cosine around n.
bool co_dome_light_build(CoLight *light, CohortError *err);
void co_dome_light_clear(CoLight *light);
bool co_dome_light_sample(const CoLight *light, CoVec3 n, float u0, float u1, CoVec3 *wi);
float co_dome_light_pdf(const CoLight *light, CoVec3 n, CoVec3 wi);
CoVec3 co_dome_light_radiance(const CoLight *light, CoVec3 dir);

// blackbody.c. Linear Rec.709 of luminance 1, kelvin clamped to [1000, 10000].
CoVec3 co_blackbody_rgb(float kelvin);

#endif
