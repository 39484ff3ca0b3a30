// What the measuring programs ask of Embree alike: a mesh in a tree of its own, and one ray.

#ifndef BENCH_EMBREE_MESH_H
#define BENCH_EMBREE_MESH_H

#include "geometry/mesh.h"
#include "rays/ray_batch.h"

#include <embree3/rtcore.h>
#include <string.h>

// Copies of the points and indices, of which there must be some.
static inline RTCGeometry embree_triangles(RTCDevice device, const CoMesh *mesh)
{
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12,
                                   mesh->point_count),
           mesh->points, 12 * (size_t)mesh->point_count);
    memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12,
                                   mesh->tri_count),
           mesh->indices, 12 * (size_t)mesh->tri_count);
    return geometry;
}

// A robust scene of one geometry, which it takes; its tree is left to rtcCommitScene.
static inline RTCScene embree_scene_of(RTCDevice device, RTCGeometry geometry)
{
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    return scene;
}

// The triangle that ray i meets, ~0u for none.
static inline uint32_t embree_intersect(RTCScene scene, struct RTCIntersectContext *context,
                                        const CoRayBatch *rays, size_t i)
{
    struct RTCRayHit r = {{rays->org_x[i], rays->org_y[i], rays->org_z[i], 0.0f, rays->dir_x[i],
                           rays->dir_y[i], rays->dir_z[i], 0.0f, rays->tfar[i], ~0u, 0, 0},
                          {0, 0, 0, 0, 0, ~0u, ~0u, {~0u}}};
    rtcIntersect1(scene, context, &r);
    return r.hit.primID;
}

#endif
