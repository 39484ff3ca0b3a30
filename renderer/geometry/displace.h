// Displacement: the points of a tessellated mesh moved along their normals, once.
//
// Each point is moved once, by one amount and along one normal, so faces that share it cannot come
// apart: not at creases, where their normals differ (the average by angle is taken), not at seams
// of texture coordinates or Ptex borders, where their values may (the lowest triangle's is taken).

#ifndef CO_GEOMETRY_DISPLACE_H
#define CO_GEOMETRY_DISPLACE_H

#include "geometry/mesh.h"

// A point, as a corner of the lowest triangle that has it.
typedef struct CoDisplacePoint {
    uint32_t tri;
    float u, v; // barycentrics of corners 1 and 2: 0 or 1
} CoDisplacePoint;

// Says how far points are moved, in object space, outward by the mesh's orientation. Called with
// more and more points in order; the mesh is as it was before all moves.
typedef bool CoDisplaceFn(void *cookie, const CoDisplacePoint *points, size_t count, float *amounts,
                          CohortError *err);

typedef struct CoDisplaceCounts {
    uint64_t moved;  // points
    uint64_t broken; // points that stay: the amount or the place is not finite
} CoDisplaceCounts;

// Moves the points of a mesh that has not been displaced before; finds its box and normals anew.
// Normals are smooth where they were smooth, and faceted meshes stay faceted. After a failure (of
// `fn`, or for want of memory) the mesh is as it was.
bool co_mesh_displace(CoMesh *mesh, CoDisplaceFn *fn, void *cookie, CoDisplaceCounts *counts,
                      CohortError *err);

#endif
