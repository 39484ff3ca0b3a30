// Trees: triangles built per second, surface-area cost, bytes and peak, beside Embree's medium
// quality where that is installed, in alternated runs. Not a test: prints numbers.
// Then what a ray visits, from ten thousand triangles to as many thousands as the last argument
// says. With other work on the machine, OMP_WAIT_POLICY=passive keeps waiting threads from taking
// part. Usage: bench_build [thousand triangles [rounds [threads [most thousands]]]]

#include "accel/build.h"
#include "base/clock.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/parallel.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

#ifdef BENCH_EMBREE
#include <embree3/rtcore.h>
#endif

static uint64_t random_state = 1;

static float uniform(float lo, float hi)
{
    return lo + (hi - lo) * ((float)(co_hash64(random_state++) >> 40) * 0x1p-24f);
}

static CoMesh mesh_alloc(size_t points, size_t tris)
{
    CoMesh mesh = {.points = malloc(12 * points), .indices = malloc(12 * tris)};
    mesh.point_count = (uint32_t)points;
    mesh.tri_count = (uint32_t)tris;
    return mesh;
}

// A bumpy sheet of n x n quads rolled into a ball; triangles in rows.
static CoMesh mesh_ball(uint32_t tris)
{
    uint32_t n = (uint32_t)sqrt(tris / 2.0);
    CoMesh mesh = mesh_alloc((size_t)(n + 1) * (n + 1), 2 * (size_t)n * n);
    float *points = (float *)(uintptr_t)mesh.points;
    uint32_t *indices = (uint32_t *)(uintptr_t)mesh.indices;
    for (uint32_t i = 0; i <= n; i++) {
        for (uint32_t j = 0; j <= n; j++) {
            float theta = CO_PI * (float)i / (float)n, phi = 2.0f * CO_PI * (float)j / (float)n;
            float r = 1.0f + 0.05f * sinf(41.0f * theta) * sinf(29.0f * phi);
            co_vec3_store(
                points + 3 * ((size_t)i * (n + 1) + j),
                co_vec3(r * sinf(theta) * cosf(phi), r * cosf(theta), r * sinf(theta) * sinf(phi)));
        }
    }
    for (uint32_t q = 0; q < n * n; q++) {
        uint32_t a = q / n * (n + 1) + q % n;
        uint32_t quad[6] = {a, a + 1, a + n + 2, a, a + n + 2, a + n + 1};
        memcpy(indices + 6 * (size_t)q, quad, sizeof quad);
    }
    return mesh;
}

// Triangles that share nothing, about as large as they are apart, stretched along one axis.
static CoMesh mesh_soup(uint32_t tris, float stretch)
{
    CoMesh mesh = mesh_alloc(3 * (size_t)tris, tris);
    float *points = (float *)(uintptr_t)mesh.points, size = 1.0f / cbrtf((float)tris);
    uint32_t *indices = (uint32_t *)(uintptr_t)mesh.indices;
    for (uint32_t i = 0; i < 3 * tris; i++)
        indices[i] = i;
    for (uint32_t i = 0; i < tris; i++) {
        float center[3] = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
        for (uint32_t c = 0; c < 9; c++)
            points[9 * (size_t)i + c] =
                center[c % 3] + (c % 3 == i % 3 ? stretch : 1.0f) * size * uniform(-1, 1);
    }
    return mesh;
}

// The same triangles in random order.
static CoMesh mesh_shuffled(CoMesh mesh)
{
    uint32_t *indices = (uint32_t *)(uintptr_t)mesh.indices;
    for (uint32_t i = mesh.tri_count - 1; i > 0; i--) {
        uint32_t j = (uint32_t)(co_hash64(random_state++) % (i + 1)), moved[3];
        memcpy(moved, indices + 3 * (size_t)i, sizeof moved);
        memcpy(indices + 3 * (size_t)i, indices + 3 * (size_t)j, sizeof moved);
        memcpy(indices + 3 * (size_t)j, moved, sizeof moved);
    }
    return mesh;
}

// What a ray that meets the root is expected to touch.
typedef struct Cost {
    double nodes, leaves, blocks; // blocks of as many triangles as are tested at once: ours 8, 4
} Cost;

static double sah(Cost c)
{
    return c.nodes + c.blocks;
}

static Cost cost_of(const CoTree *tree)
{
    Cost cost = {1.0, 0.0, 0.0};
    double area = co_box_area(&tree->box);
    for (size_t n = 0; n < tree->node_count; n++) {
        for (int i = 0; i < CO_NODE_WIDTH; i++) {
            uint32_t ref = tree->nodes[n].child[i];
            CoBox box;
            if (ref == CO_REF_NONE)
                continue;
            for (int k = 0; k < 3; k++) {
                box.lo[k] = tree->nodes[n].planes[2 * k][i];
                box.hi[k] = tree->nodes[n].planes[2 * k + 1][i];
            }
            double p = co_box_area(&box) / area;
            if (ref & CO_REF_LEAF) {
                cost.leaves += p;
                cost.blocks += p;
            } else {
                cost.nodes += p;
            }
        }
    }
    return cost;
}

// Of this process, user and system.
static double cpu_seconds(void)
{
    struct rusage r;
    getrusage(RUSAGE_SELF, &r);
    return (double)(r.ru_utime.tv_sec + r.ru_stime.tv_sec) +
           1e-6 * (double)(r.ru_utime.tv_usec + r.ru_stime.tv_usec);
}

typedef struct Figures {
    double seconds, cpu; // the least of all rounds
    double bytes, peak;  // of the tree and of its making
    Cost cost;
} Figures;

static void run_own(const CoMesh *mesh, Figures *out)
{
    double start = co_clock_seconds(), cpu = cpu_seconds();
    CoBvh *bvh = co_bvh_create(mesh, NULL);
    out->seconds = fmin(out->seconds, co_clock_seconds() - start);
    out->cpu = fmin(out->cpu, cpu_seconds() - cpu);
    out->bytes = (double)co_bvh_bytes(bvh);
    out->peak = (double)co_memory_peak(CO_MEMORY_ACCEL);
    out->cost = cost_of(&bvh->tree);
    co_bvh_destroy(bvh);
}

#ifdef BENCH_EMBREE
typedef struct Meter {
    _Atomic long long live, peak;
} Meter;

static bool count_bytes(void *cookie, ssize_t bytes, bool post)
{
    Meter *meter = cookie;
    (void)post;
    long long live = (meter->live += bytes);
    if (live > meter->peak)
        meter->peak = live;
    return true;
}

static void run_embree(const CoMesh *mesh, uint32_t threads, Figures *out)
{
    char config[64];
    snprintf(config, sizeof config, "threads=%u,set_affinity=0", threads);
    RTCDevice device = rtcNewDevice(config);
    Meter meter = {0};
    rtcSetDeviceMemoryMonitorFunction(device, count_bytes, &meter);
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void *points = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                           12, mesh->point_count);
    void *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                            12, mesh->tri_count);
    memcpy(points, mesh->points, 12 * (size_t)mesh->point_count);
    memcpy(indices, mesh->indices, 12 * (size_t)mesh->tri_count);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    long long before = meter.live;
    meter.peak = before;
    double start = co_clock_seconds(), cpu = cpu_seconds();
    rtcCommitScene(scene);
    out->seconds = fmin(out->seconds, co_clock_seconds() - start);
    out->cpu = fmin(out->cpu, cpu_seconds() - cpu);
    out->bytes = (double)(meter.live - before);
    out->peak = (double)(meter.peak - before);
    rtcReleaseGeometry(geometry);
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
}

// Embree's builder over boxes, with the tree made to be measured.
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

static Cost embree_cost(const CoMesh *mesh)
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
#endif

static void print_figures(const char *who, uint32_t tris, const Figures *f)
{
    printf("  %-8s %6.2f Mtri/s, %5.0f CPU ns each  %6.1f bytes, peak %6.1f   nodes %6.2f leaves "
           "%6.2f "
           "blocks %6.2f sah %6.2f\n",
           who, tris / f->seconds * 1e-6, f->cpu * 1e9 / tris, f->bytes / tris, f->peak / tris,
           f->cost.nodes, f->cost.leaves, f->cost.blocks, sah(f->cost));
}

static void run(const char *title, CoMesh mesh, int rounds, uint32_t threads)
{
    Figures own = {.seconds = 1e30, .cpu = 1e30};
    printf("%s: %u triangles\n", title, mesh.tri_count);
#ifdef BENCH_EMBREE
    Figures embree = {.seconds = 1e30, .cpu = 1e30};
#endif
    for (int i = 0; i < rounds; i++) {
        co_worker_count_set(threads);
        run_own(&mesh, &own);
#ifdef BENCH_EMBREE
        run_embree(&mesh, threads, &embree);
#endif
    }
    print_figures("cohort", mesh.tri_count, &own);
#ifdef BENCH_EMBREE
    embree.cost = embree_cost(&mesh);
    print_figures("embree", mesh.tri_count, &embree);
    printf("  embree's time by ours %.2f, CPU time %.2f, our sah by embree's %.3f\n",
           embree.seconds / own.seconds, embree.cpu / own.cpu, sah(own.cost) / sah(embree.cost));
#endif
    free((float *)(uintptr_t)mesh.points);
    free((uint32_t *)(uintptr_t)mesh.indices);
}

enum {
    VISITS = 20000
};

// Rays between points of a ball twice as large, most of which meet the mesh.
static void fill_rays(CoRayBatch *rays)
{
    *rays = (CoRayBatch){.count = VISITS, .capacity = VISITS};
#define BENCH_ALLOC(type, name) rays->name = aligned_alloc(64, VISITS * sizeof(type));
    CO_RAY_FIELDS(BENCH_ALLOC)
#undef BENCH_ALLOC
    for (size_t i = 0; i < VISITS; i++) {
        CoVec3 from = co_normalize(co_vec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)));
        CoVec3 to = co_vec3(uniform(-0.5f, 0.5f), uniform(-0.5f, 0.5f), uniform(-0.5f, 0.5f));
        from = co_scale(from, 2.0f);
        rays->org_x[i] = from.x;
        rays->org_y[i] = from.y;
        rays->org_z[i] = from.z;
        rays->dir_x[i] = to.x - from.x;
        rays->dir_y[i] = to.y - from.y;
        rays->dir_z[i] = to.z - from.z;
        rays->tnear[i] = 0.0f;
        rays->tfar[i] = INFINITY;
    }
}

static double cpu_of_thread(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

#ifdef BENCH_EMBREE
// Nanoseconds of a ray, the least of five passes, robust mode.
static double time_embree(const CoMesh *mesh, const CoRayBatch *rays)
{
    RTCDevice device = rtcNewDevice(NULL);
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12,
                                   mesh->point_count),
           mesh->points, 12 * (size_t)mesh->point_count);
    memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12,
                                   mesh->tri_count),
           mesh->indices, 12 * (size_t)mesh->tri_count);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcCommitScene(scene);
    double least = INFINITY;
    for (int pass = 0; pass < 5; pass++) {
        double start = cpu_of_thread();
        for (size_t i = 0; i < VISITS; i++) {
            struct RTCIntersectContext context;
            rtcInitIntersectContext(&context);
            struct RTCRayHit r = {{rays->org_x[i], rays->org_y[i], rays->org_z[i], 0.0f,
                                   rays->dir_x[i], rays->dir_y[i], rays->dir_z[i], 0.0f, INFINITY,
                                   ~0u, 0, 0},
                                  {0, 0, 0, 0, 0, ~0u, ~0u, {~0u}}};
            rtcIntersect1(scene, &context, &r);
        }
        least = fmin(least, cpu_of_thread() - start);
    }
    rtcReleaseGeometry(geometry);
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
    return 1e9 * least / VISITS;
}
#endif

static void count_visits(uint32_t tris)
{
    CoMesh mesh = mesh_ball(tris);
    CoObject objects[2] = {{.mesh = &mesh, .bvh = co_bvh_create(&mesh, NULL)}, {.mesh = NULL}};
    objects[0].box_min = co_vec3(-2, -2, -2);
    objects[0].box_max = co_vec3(2, 2, 2);
    CoMat4d identity = co_mat4d_identity();
    CoInstance instance = {.object = 0, .to_group = co_affine_from_mat4d(&identity)};
    instance.to_object = instance.to_group;
    objects[1] = (CoObject){.top = co_top_create(&instance, 1, objects, NULL),
                            .instances = &instance,
                            .instance_count = 1};
    CoAccelScene scene = {objects, 2, 1};
    CoRayBatch rays;
    CoHitBatch hits = {.count = VISITS, .capacity = VISITS};
    fill_rays(&rays);
#define BENCH_ALLOC(type, name) hits.name = aligned_alloc(64, VISITS * sizeof(type));
    CO_HIT_FIELDS(BENCH_ALLOC)
#undef BENCH_ALLOC
    CoTraverseStats stats;
    double least = INFINITY;
    for (int pass = 0; pass < 5; pass++) {
        double start = cpu_of_thread();
        memset(&stats, 0, sizeof stats);
        co_accel_kernels(NULL)->traverse(&scene, &rays, NULL, &hits, 0, VISITS, false, &stats);
        least = fmin(least, cpu_of_thread() - start);
    }
    printf("  %9u triangles: %6.2f nodes, %6.2f triangle tests, %.0f ns per ray, %.1f bytes per "
           "triangle\n",
           mesh.tri_count, (double)stats.bottom_nodes / VISITS, (double)stats.triangles / VISITS,
           1e9 * least / VISITS, (double)co_bvh_bytes(objects[0].bvh) / mesh.tri_count);
    fflush(stdout);
    co_top_destroy((CoTop *)(uintptr_t)objects[1].top);
    co_bvh_destroy((CoBvh *)(uintptr_t)objects[0].bvh);
#ifdef BENCH_EMBREE
    printf("  embree, robust: %.0f ns per ray\n", time_embree(&mesh, &rays));
    fflush(stdout);
#endif
    free((float *)(uintptr_t)mesh.points);
    free((uint32_t *)(uintptr_t)mesh.indices);
#define BENCH_FREE(type, name) free(rays.name);
    CO_RAY_FIELDS(BENCH_FREE)
#undef BENCH_FREE
#define BENCH_FREE(type, name) free(hits.name);
    CO_HIT_FIELDS(BENCH_FREE)
#undef BENCH_FREE
}

int main(int argc, char **argv)
{
    uint32_t tris = 1000u * (uint32_t)(argc > 1 ? atoi(argv[1]) : 1000);
    int rounds = argc > 2 ? atoi(argv[2]) : 5;
    uint32_t threads = (uint32_t)(argc > 3 ? atoi(argv[3]) : 2);
    run("ball", mesh_ball(tris), rounds, threads);
    run("ball, shuffled", mesh_shuffled(mesh_ball(tris)), rounds, threads);
    run("soup", mesh_soup(tris, 1.0f), rounds, threads);
    run("splinters", mesh_soup(tris, 30.0f), rounds, threads);
    printf("visits\n");
    uint32_t most = 1000u * (uint32_t)(argc > 4 ? atoi(argv[4]) : 1000);
    for (uint32_t n = 10000; n <= most; n *= 10)
        count_visits(n);
    return 0;
}
