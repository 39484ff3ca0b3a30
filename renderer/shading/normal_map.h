// Tangent-space normals to shading normals.

#ifndef CO_SHADING_NORMAL_MAP_H
#define CO_SHADING_NORMAL_MAP_H

#include "math/vec.h"

// ns, ng: unit shading and geometric normal, on the same side or not. dpds, dpdt: how the surface
// point moves with the texture coordinates; any length, need not be orthogonal, may be mirrored.
// n_tangent: x along growing s, y along growing t, z along ns; any length.
//
// Returns a unit normal on ns's side of ng, or ns where the tangents or n_tangent give none.
static inline CoVec3 co_normal_map(CoVec3 ns, CoVec3 ng, CoVec3 dpds, CoVec3 dpdt, CoVec3 n_tangent)
{
    CoVec3 tangent = co_normalize(co_madd(dpds, ns, -co_dot(dpds, ns)));
    CoVec3 bitangent = co_cross(ns, tangent);
    if (co_dot(bitangent, dpdt) < 0.0f)
        bitangent = co_neg(bitangent);
    CoVec3 local = co_normalize(n_tangent);
    if (co_dot(tangent, tangent) < 0.5f || co_dot(local, local) < 0.5f)
        return ns;
    CoVec3 n = co_scale(tangent, local.x);
    n = co_madd(co_madd(n, bitangent, local.y), ns, local.z);
    // A texel may point below the surface: it is raised to the horizon of ng, and a little above.
    float side = co_dot(ns, ng) < 0.0f ? -1.0f : 1.0f;
    float height = side * co_dot(n, ng);
    const float least = 1e-2f;
    if (height < least)
        n = co_madd(n, ng, side * (least - height));
    n = co_normalize(n);
    return co_dot(n, n) < 0.5f ? ns : n;
}

#endif
