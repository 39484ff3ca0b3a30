// Embree's side of bench_build: trees, their cost, and rays through them.

#include "accel/build.h"
#include "base/clock.h"
#include "build_figures.h"
#include "embree_mesh.h"
#include "timing.h"

#include <stdatomic.h>
#include <stdio.h>

typedef struct Meter {
    atomic_llong live, peak;
} Meter;

static bool count_bytes(void *cookie, ssize_t bytes, bool post)
{
    Meter *meter = cookie;
    (void)post;
    long long live = atomic_fetch_add(&meter->live, bytes) + bytes;
    if (live > atomic_load(&meter->peak))
        atomic_store(&meter->peak, live);
    return true;
}

void build_embree(const CoMesh *mesh, uint32_t threads, Figures *out)
{
    char config[64];
    snprintf(config, sizeof config, "threads=%u,set_affinity=0", threads);
    RTCDevice device = rtcNewDevice(config);
    Meter meter;
    atomic_init(&meter.live, 0);
    atomic_init(&meter.peak, 0);
    rtcSetDeviceMemoryMonitorFunction(device, count_bytes, &meter);
    RTCScene scene = embree_scene_of(device, embree_triangles(device, mesh));
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    long long before = atomic_load(&meter.live);
    atomic_store(&meter.peak, before);
    double start = co_clock_seconds(), cpu = bench_seconds(CLOCK_PROCESS_CPUTIME_ID);
    rtcCommitScene(scene);
    out->seconds = fmin(out->seconds, co_clock_seconds() - start);
    out->cpu = fmin(out->cpu, bench_seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu);
    out->bytes = (double)(atomic_load(&meter.live) - before);
    out->peak = (double)(atomic_load(&meter.peak) - before);
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
}

// Nodes of the tree that Embree's builder makes to be measured.
typedef struct Node {
    struct RTCBounds boxes[CO_NODE_WIDTH];
    struct Node *children[CO_NODE_WIDTH];
    unsigned count; // of children; of triangles with LEAF
} Node;
enum {
    LEAF = 1 << 16
};

static void *make_node(RTCThreadLocalAllocator allocator, unsigned count, void *cookie)
{
    Node *node = rtcThreadLocalAlloc(allocator, sizeof(Node), 16);
    (void)cookie;
    node->count = count;
    return node;
}

static void *make_leaf(RTCThreadLocalAllocator allocator, const struct RTCBuildPrimitive *prims,
                       size_t count, void *cookie)
{
    Node *node = rtcThreadLocalAlloc(allocator, sizeof(Node), 16);
    (void)cookie;
    (void)prims;
    node->count = LEAF | (unsigned)count;
    return node;
}

static void set_children(void *at, void **children, unsigned count, void *cookie)
{
    Node *node = at;
    (void)cookie;
    for (unsigned i = 0; i < count; i++)
        node->children[i] = children[i];
}

static void set_boxes(void *at, const struct RTCBounds **boxes, unsigned count, void *cookie)
{
    Node *node = at;
    (void)cookie;
    for (unsigned i = 0; i < count; i++)
        node->boxes[i] = *boxes[i];
}

static double area_of(const struct RTCBounds *b)
{
    CoBox box = {{b->lower_x, b->lower_y, b->lower_z}, {b->upper_x, b->upper_y, b->upper_z}};
    return co_box_area(&box);
}

static void add_cost(const Node *node, double area, double root, Cost *cost)
{
    if (node->count & LEAF) {
        cost->leaves += area / root;
        cost->blocks += area / root * (((node->count & ~(unsigned)LEAF) + 3) / 4);
        return;
    }
    cost->nodes += area / root;
    for (unsigned i = 0; i < node->count; i++)
        add_cost(node->children[i], area_of(&node->boxes[i]), root, cost);
}

Cost build_embree_cost(const CoMesh *mesh)
{
    RTCDevice device = rtcNewDevice(NULL);
    RTCBVH bvh = rtcNewBVH(device);
    struct RTCBuildPrimitive *prims = aligned_alloc(32, mesh->tri_count * sizeof *prims);
    CoBox all;
    co_box_empty(&all);
    for (uint32_t i = 0; i < mesh->tri_count; i++) {
        CoBox b;
        co_box_empty(&b);
        for (int c = 0; c < 3; c++) {
            const float *p = mesh->points + 3 * (size_t)mesh->indices[3 * (size_t)i + (size_t)c];
            co_box_extend(&b, p, p);
        }
        co_box_extend(&all, b.lo, b.hi);
        prims[i] =
            (struct RTCBuildPrimitive){b.lo[0], b.lo[1], b.lo[2], 0, b.hi[0], b.hi[1], b.hi[2], i};
    }
    struct RTCBuildArguments a = rtcDefaultBuildArguments();
    a.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
    a.maxBranchingFactor = CO_NODE_WIDTH;
    a.maxDepth = 60;
    a.sahBlockSize = 4;
    a.minLeafSize = 4;
    a.maxLeafSize = 28;
    a.bvh = bvh;
    a.primitives = prims;
    a.primitiveCount = a.primitiveArrayCapacity = mesh->tri_count;
    a.createNode = make_node;
    a.setNodeChildren = set_children;
    a.setNodeBounds = set_boxes;
    a.createLeaf = make_leaf;
    Cost cost = {0.0, 0.0, 0.0};
    double root = co_box_area(&all);
    add_cost(rtcBuildBVH(&a), root, root, &cost);
    rtcReleaseBVH(bvh);
    rtcReleaseDevice(device);
    free(prims);
    return cost;
}

double build_embree_trace(const CoMesh *mesh, const CoRayBatch *rays)
{
    RTCDevice device = rtcNewDevice(NULL);
    RTCScene scene = embree_scene_of(device, embree_triangles(device, mesh));
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcCommitScene(scene);
    double least = (double)INFINITY;
    for (int pass = 0; pass < 5; pass++) {
        double start = bench_seconds(CLOCK_THREAD_CPUTIME_ID);
        for (size_t i = 0; i < rays->count; i++)
            embree_intersect(scene, &context, rays, i);
        least = fmin(least, bench_seconds(CLOCK_THREAD_CPUTIME_ID) - start);
    }
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
    return 1e9 * least / (double)rays->count;
}
