// Rays that leave a surface where others have met it.

#ifndef TEST_VERTEX_SUPPORT_H
#define TEST_VERTEX_SUPPORT_H

#include "integrate/vertex.h"
#include "support/rays.h"

// The vertex where ray i of a batch ended, which must have met something.
static inline CoVertex vertex_of_hit(const CohortScene *scene, CoPlacementMemo *memo,
                                     const CoRayBatch *rays, const CoHitBatch *hits, size_t i)
{
    CoHitRecord record = {.tri = hits->tri[i],
                          .u = hits->u[i],
                          .v = hits->v[i],
                          .t = hits->t[i],
                          .dir = ray_dir(rays, i)};
    CoRay ray = {.org = ray_org(rays, i)};
    CoVertex vertex = {0};
    co_vertex_make(scene, memo, &record, &ray, &vertex);
    return vertex;
}

// On the normal's side; `grazing` is how much of its height it is robbed of.
static inline CoVec3 direction_above(Random *random, CoVec3 normal, float grazing)
{
    CoVec3 dir = random_direction(random);
    if (grazing > 0.0f)
        dir = co_normalize(co_madd(dir, normal, -co_dot(dir, normal) * grazing));
    return co_dot(dir, normal) < 0.0f ? co_neg(dir) : dir;
}

#endif
