#include "traversal_embree.h"

#include "base/clock.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef BENCH_EMBREE
#include <embree3/rtcore.h>

struct BenchEmbree {
    RTCDevice device;
    RTCScene scene;
    size_t bytes;
};

static bool count_bytes(void *user, ssize_t bytes, bool post)
{
    BenchEmbree *embree = user;
    (void)post;
    __atomic_fetch_add(&embree->bytes, (size_t)bytes, __ATOMIC_RELAXED);
    return true;
}

static bool is_identity(const CoAffine *a)
{
    const CoAffine identity = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    return memcmp(a, &identity, sizeof identity) == 0;
}

// Points are shared where the mesh stands in world space already.
static void add_mesh(BenchEmbree *embree, const CoMesh *mesh, const CoAffine *to_world)
{
    RTCGeometry geometry = rtcNewGeometry(embree->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (is_identity(to_world)) {
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                   mesh->points, 0, 12, mesh->point_count);
    } else {
        float *points = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                RTC_FORMAT_FLOAT3, 12, mesh->point_count);
        for (size_t i = 0; i < mesh->point_count; i++)
            co_vec3_store(points + 3 * i,
                          co_affine_point(to_world, co_vec3_load(mesh->points + 3 * i)));
    }
    uint32_t *indices = NULL;
    if (mesh->indices)
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                   mesh->indices, 0, 12, mesh->tri_count);
    else
        indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12,
                                          mesh->tri_count);
    for (uint32_t i = 0; indices && i < mesh->tri_count; i++)
        co_mesh_triangle(mesh, i, indices + 3 * (size_t)i);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(embree->scene, geometry);
    rtcReleaseGeometry(geometry);
}

BenchEmbree *bench_embree_create(const BenchScene *scene, const char *isa, bool robust,
                                 uint32_t threads, double *seconds)
{
    char config[64];
    BenchEmbree *embree = calloc(1, sizeof *embree);
    snprintf(config, sizeof config, "isa=%s,threads=%u", isa, threads);
    if (!embree || !(embree->device = rtcNewDevice(config))) {
        free(embree);
        return NULL;
    }
    embree->scene = rtcNewScene(embree->device);
    rtcSetSceneFlags(embree->scene, robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    for (uint64_t i = 0; i < scene->path_count; i++) {
        CoPlacement placement;
        co_accel_placement(&scene->accel, (uint32_t)i, &placement);
        const CoMesh *mesh = scene->accel.objects[placement.object].mesh;
        if (mesh->tri_count > 0)
            add_mesh(embree, mesh, &placement.to_world);
    }
    rtcSetDeviceMemoryMonitorFunction(embree->device, count_bytes, embree);
    double start = co_clock_seconds();
    rtcCommitScene(embree->scene);
    *seconds = co_clock_seconds() - start;
    return embree;
}

void bench_embree_destroy(BenchEmbree *embree)
{
    if (!embree)
        return;
    rtcReleaseScene(embree->scene);
    rtcReleaseDevice(embree->device);
    free(embree);
}

size_t bench_embree_bytes(const BenchEmbree *embree)
{
    return embree->bytes;
}

bool bench_embree_has(const BenchEmbree *embree, uint32_t width)
{
    return width == 1 ||
           rtcGetDeviceProperty(embree->device, width == 8
                                                    ? RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED
                                                    : RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED);
}

static void trace_single(RTCScene scene, struct RTCIntersectContext *context, bool occlusion,
                         const CoRayBatch *rays, CoHitBatch *hits, size_t begin, size_t end)
{
    for (size_t i = begin; i < end; i++) {
        struct RTCRayHit r;
        r.ray = (struct RTCRay){rays->org_x[i],
                                rays->org_y[i],
                                rays->org_z[i],
                                rays->tnear[i],
                                rays->dir_x[i],
                                rays->dir_y[i],
                                rays->dir_z[i],
                                0.0f,
                                rays->tfar[i],
                                ~0u,
                                0,
                                0};
        if (occlusion) {
            rtcOccluded1(scene, context, &r.ray);
            hits->t[i] = r.ray.tfar < 0.0f ? 0.0f : INFINITY;
            continue;
        }
        r.hit.geomID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene, context, &r);
        bool is_hit = r.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        hits->t[i] = is_hit ? r.ray.tfar : INFINITY;
        hits->u[i] = r.hit.u;
        hits->v[i] = r.hit.v;
        hits->instance[i] = r.hit.geomID;
        hits->tri[i] = r.hit.primID;
    }
}

// The packets differ in their types alone.
#define TRACE_PACKET(n) \
    static void trace_packet##n(RTCScene scene, struct RTCIntersectContext *context, \
                                bool occlusion, const CoRayBatch *rays, CoHitBatch *hits, \
                                size_t begin, size_t end) \
    { \
        for (size_t i = begin; i < end; i += n) { \
            struct RTCRayHit##n r __attribute__((aligned(64))); \
            int valid[n] __attribute__((aligned(64))); \
            size_t count = end - i < n ? end - i : n; \
            for (size_t j = 0; j < n; j++) \
                valid[j] = j < count ? -1 : 0; \
            memcpy(r.ray.org_x, rays->org_x + i, count * 4); \
            memcpy(r.ray.org_y, rays->org_y + i, count * 4); \
            memcpy(r.ray.org_z, rays->org_z + i, count * 4); \
            memcpy(r.ray.dir_x, rays->dir_x + i, count * 4); \
            memcpy(r.ray.dir_y, rays->dir_y + i, count * 4); \
            memcpy(r.ray.dir_z, rays->dir_z + i, count * 4); \
            memcpy(r.ray.tnear, rays->tnear + i, count * 4); \
            memcpy(r.ray.tfar, rays->tfar + i, count * 4); \
            memset(r.ray.time, 0, sizeof r.ray.time); \
            memset(r.ray.mask, -1, sizeof r.ray.mask); \
            memset(r.ray.flags, 0, sizeof r.ray.flags); \
            memset(r.hit.geomID, -1, sizeof r.hit.geomID); \
            memset(r.hit.instID, -1, sizeof r.hit.instID); \
            if (occlusion) \
                rtcOccluded##n(valid, scene, context, &r.ray); \
            else \
                rtcIntersect##n(valid, scene, context, &r); \
            for (size_t j = 0; j < count; j++) { \
                bool is_hit = occlusion ? r.ray.tfar[j] < 0.0f : r.hit.geomID[j] != ~0u; \
                hits->t[i + j] = !is_hit ? INFINITY : occlusion ? 0.0f : r.ray.tfar[j]; \
            } \
            if (occlusion) \
                continue; \
            memcpy(hits->u + i, r.hit.u, count * 4); \
            memcpy(hits->v + i, r.hit.v, count * 4); \
            memcpy(hits->instance + i, r.hit.geomID, count * 4); \
            memcpy(hits->tri + i, r.hit.primID, count * 4); \
        } \
    }
TRACE_PACKET(8)
TRACE_PACKET(16)

void bench_embree_trace(const BenchEmbree *embree, uint32_t width, bool coherent, bool occlusion,
                        const CoRayBatch *rays, CoHitBatch *hits, size_t begin, size_t end)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    if (coherent)
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    if (width == 1)
        trace_single(embree->scene, &context, occlusion, rays, hits, begin, end);
    else if (width == 8)
        trace_packet8(embree->scene, &context, occlusion, rays, hits, begin, end);
    else
        trace_packet16(embree->scene, &context, occlusion, rays, hits, begin, end);
}

#else

BenchEmbree *bench_embree_create(const BenchScene *scene, const char *isa, bool robust,
                                 uint32_t threads, double *seconds)
{
    (void)scene;
    (void)isa;
    (void)robust;
    (void)threads;
    (void)seconds;
    return NULL;
}

void bench_embree_destroy(BenchEmbree *embree)
{
    (void)embree;
}

size_t bench_embree_bytes(const BenchEmbree *embree)
{
    (void)embree;
    return 0;
}

bool bench_embree_has(const BenchEmbree *embree, uint32_t width)
{
    (void)embree;
    (void)width;
    return false;
}

void bench_embree_trace(const BenchEmbree *embree, uint32_t width, bool coherent, bool occlusion,
                        const CoRayBatch *rays, CoHitBatch *hits, size_t begin, size_t end)
{
    (void)embree;
    (void)width;
    (void)coherent;
    (void)occlusion;
    (void)rays;
    (void)hits;
    (void)begin;
    (void)end;
}

#endif
