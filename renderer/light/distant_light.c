// Distant lights: a cone of directions around the way back to the light; parallel when it has no
// width.

#include "light/light_internal.h"
#include "math/warp.h"

CoVec3 co_distant_light_sample(const CoLight *light, float u0, float u1)
{
    CoVec3 back = co_neg(light->axis), s, t;
    if (light->is_delta)
        return back;
    co_basis(back, &s, &t);
    return co_normalize(co_from_frame(s, t, back, co_warp_cone(light->versine, u0, u1)));
}

float co_distant_light_pdf(const CoLight *light)
{
    return light->is_delta ? 1.0f : 1.0f / (2.0f * CO_PI * light->versine);
}

bool co_distant_light_meet(const CoLight *light, CoVec3 dir)
{
    if (light->is_delta)
        return false;
    // 1 - cos from the difference of the two unit vectors, which keeps its digits.
    CoVec3 d = co_add(dir, light->axis);
    return light->versine >= 2.0f || 0.5f * co_dot(d, d) <= light->versine;
}
