// Flat lights: what rects and disks share, and the disk (an ellipse when scaled unevenly).

#include "light/light_internal.h"
#include "math/warp.h"

float co_light_plane_height(const CoLight *light, CoVec3 org)
{
    return co_dot(light->normal, co_sub(org, light->center));
}

bool co_light_plane_meet(const CoLight *light, CoVec3 org, CoVec3 dir, float *t, float *a, float *b)
{
    CoVec3 to_center = co_sub(light->center, org);
    float distance = co_dot(light->normal, to_center) / co_dot(light->normal, dir);
    if (!(distance > 0.0f) || !isfinite(distance))
        return false;
    // From the center, not from org: the light is small where it is far.
    CoVec3 p = co_sub(co_scale(dir, distance), to_center);
    *t = distance;
    *a = co_dot(light->ux, p);
    *b = co_dot(light->uy, p);
    return true;
}

float co_light_plane_pdf(const CoLight *light, CoVec3 org, CoVec3 wi)
{
    float t, a, b;
    float cosine = -co_dot(light->normal, wi);
    if (!(cosine > 0.0f) || !co_light_plane_meet(light, org, wi, &t, &a, &b))
        return 0.0f;
    return t / cosine * light->inv_area * t;
}

bool co_disk_light_sample(const CoLight *light, CoVec3 org, float u0, float u1, CoVec3 *wi)
{
    float x, y;
    co_warp_disk(u0, u1, &x, &y);
    CoVec3 to = co_sub(light->center, org);
    to = co_madd(co_madd(to, light->ex, x), light->ey, y);
    *wi = co_normalize(to);
    return co_dot(*wi, light->normal) < 0.0f;
}
