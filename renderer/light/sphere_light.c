// Spheres, and ellipsoids as the unit sphere of a linear map.
//
// The visible cone is sampled uniformly in solid angle. A direction's density changes under a
// linear map A by |det A| / |A w|^3. Inside there is no light: UsdLux emits outwards.

#include "light/light_internal.h"
#include "math/warp.h"

// The light as seen from org in the space where it is a sphere of radius `radius` at `center`.
typedef struct Ball {
    CoVec3 center; // relative to org
    float radius, d2;
    bool is_inside;
} Ball;

static Ball ball_from(const CoLight *light, CoVec3 org)
{
    Ball ball;
    if (light->is_right_angled) {
        ball.center = co_sub(light->center, org);
        ball.radius = light->bound;
    } else {
        ball.center = co_affine_vector(&light->to_local, co_sub(light->center, org));
        ball.radius = 1.0f;
    }
    ball.d2 = co_dot(ball.center, ball.center);
    ball.is_inside = !(ball.d2 > ball.radius * ball.radius);
    return ball;
}

bool co_sphere_light_is_around(const CoLight *light, CoVec3 org)
{
    return ball_from(light, org).is_inside;
}

// 1 - cos of half the visible cone.
static float cone_versine(const Ball *ball)
{
    float sin2 = co_min(ball->radius / ball->d2 * ball->radius, 1.0f);
    return sin2 / (1.0f + sqrtf(1.0f - sin2));
}

static CoVec3 to_ball(const CoLight *light, CoVec3 dir, float *stretch)
{
    if (light->is_right_angled) {
        *stretch = 1.0f;
        return dir;
    }
    CoVec3 local = co_affine_vector(&light->to_local, dir);
    *stretch = co_length(local);
    return co_scale(local, 1.0f / *stretch);
}

static CoVec3 from_ball(const CoLight *light, CoVec3 v)
{
    if (light->is_right_angled)
        return v;
    CoVec3 world = co_scale(light->ex, v.x);
    return co_normalize(co_madd(co_madd(world, light->ey, v.y), light->ez, v.z));
}

// Distance along the unit direction to the near side, negative = none.
static float ball_distance(const Ball *ball, CoVec3 dir)
{
    float along = co_dot(ball->center, dir);
    CoVec3 across = co_sub(ball->center, co_scale(dir, along));
    float rest = ball->radius * ball->radius - co_dot(across, across);
    return rest >= 0.0f ? along - sqrtf(rest) : -1.0f;
}

bool co_sphere_light_sample(const CoLight *light, CoVec3 org, float u0, float u1, CoVec3 *wi)
{
    Ball ball = ball_from(light, org);
    if (ball.is_inside)
        return false;
    CoVec3 axis = co_normalize(ball.center), s, t;
    co_basis(axis, &s, &t);
    CoVec3 local = co_from_frame(s, t, axis, co_warp_cone(cone_versine(&ball), u0, u1));
    *wi = from_ball(light, co_normalize(local));
    return co_dot(*wi, *wi) > 0.5f;
}

float co_sphere_light_pdf(const CoLight *light, CoVec3 org, CoVec3 wi)
{
    Ball ball = ball_from(light, org);
    if (ball.is_inside)
        return 0.0f;
    float pdf = 1.0f / (2.0f * CO_PI * cone_versine(&ball)), stretch;
    if (light->is_right_angled)
        return pdf;
    to_ball(light, wi, &stretch);
    return pdf * light->to_local_det / (stretch * stretch * stretch);
}

bool co_sphere_light_meet(const CoLight *light, CoVec3 org, CoVec3 dir, float *t)
{
    Ball ball = ball_from(light, org);
    if (ball.is_inside)
        return false;
    float stretch;
    CoVec3 local = to_ball(light, dir, &stretch);
    float distance = ball_distance(&ball, local) / stretch;
    if (!(distance > 0.0f) || !isfinite(distance))
        return false;
    *t = distance;
    return true;
}
