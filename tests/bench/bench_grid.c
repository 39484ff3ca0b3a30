// Subdivided meshes as patches, beside the same triangles loose and beside Embree's grids and
// triangles: bytes per triangle, build time, time per ray (CPU seconds, alternated, medians).
// Not a test: prints numbers.

#include "arguments.h"
#include "base/parallel.h"
#include "support/rays.h"
#include "timing.h"

#include <stdio.h>

#ifdef BENCH_EMBREE
#include "embree_mesh.h"
#endif

enum {
    RAYS = 1 << 18,
    LEVELS = 5,
    ROUNDS_MAX = 15
};

static const char usage[] = "usage: bench_grid [TRIANGLES [ROUNDS [LEVEL [SHAPE]]]]\n"
                            "  TRIANGLES  about so many at each level (1e6)\n"
                            "  ROUNDS     the median of which counts, at most 15 (5)\n"
                            "  LEVEL      of subdivision, 0 to 4 (all)\n"
                            "  SHAPE      of faces: quads, split (triangles under\n"
                            "             Catmull-Clark) or loop (quads)\n"
                            "BENCH_EMBREE_CONFIG in the environment configures Embree's device.\n";

static double cpu_seconds(void)
{
    return bench_seconds(CLOCK_PROCESS_CPUTIME_ID);
}

// What the cage is of.
typedef enum Shape {
    QUADS,
    SPLIT,
    LOOP
} Shape;

// A bumpy torus of n x n / 2 quads, or of twice as many triangles.
static CoMesh make_torus(int n, uint32_t level, Shape shape)
{
    const int each = shape == QUADS ? 1 : 2, corners = shape == QUADS ? 4 : 6;
    int m = n / 2, faces = n * m;
    float *points = malloc(sizeof(float) * 3 * (size_t)faces);
    int32_t *counts = malloc(sizeof(int32_t) * (size_t)(faces * each));
    int32_t *indices = malloc(sizeof(int32_t) * (size_t)(faces * corners));
    for (int k = 0; k < faces; k++) {
        int i = k % n, j = k / n, next = (i + 1) % n, up = (j + 1) % m;
        double a = 6.283185307179586 * i / n, b = 6.283185307179586 * j / m;
        double r = 1.0 + 0.1 * sin(9.0 * a) * cos(7.0 * b);
        const double p[3] = {(3 + r * cos(b)) * cos(a), (3 + r * cos(b)) * sin(a), r * sin(b)};
        const int32_t quad[4] = {j * n + i, j * n + next, up * n + next, up * n + i};
        const int32_t halves[6] = {quad[0], quad[1], quad[2], quad[0], quad[2], quad[3]};
        for (int c = 0; c < 3; c++)
            points[3 * k + c] = (float)p[c];
        for (int f = 0; f < each; f++)
            counts[each * k + f] = corners / each;
        memcpy(indices + corners * k, shape == QUADS ? quad : halves,
               (size_t)corners * sizeof *quad);
    }
    CohortMeshDesc desc = {.scheme =
                               shape == LOOP ? COHORT_SCHEME_LOOP : COHORT_SCHEME_CATMULL_CLARK,
                           .level = level,
                           .points = points,
                           .point_count = (size_t)faces,
                           .face_vertex_counts = counts,
                           .face_count = (size_t)(faces * each),
                           .face_vertex_indices = indices,
                           .face_vertex_index_count = (size_t)(faces * corners)};
    CoMesh mesh;
    CohortError err = {0};
    if (!co_mesh_create(&desc, &mesh, NULL, NULL, &err)) {
        fprintf(stderr, "%s\n", err.message);
        exit(1);
    }
    free(points);
    free(counts);
    free(indices);
    return mesh;
}

static CoMesh loosen(const CoMesh *mesh)
{
    uint32_t *indices = malloc(3 * sizeof *indices * mesh->tri_count);
    for (uint32_t tri = 0; tri < mesh->tri_count; tri++)
        co_mesh_triangle(mesh, tri, indices + 3 * (size_t)tri);
    CoMesh loose = *mesh;
    loose.indices = indices;
    loose.patches = NULL;
    return loose;
}

typedef struct Place {
    CoObject objects[2];
    CoInstance instance;
    CoAccelScene scene;
} Place;

static void place(Place *p, const CoMesh *mesh, const CoBvh *bvh)
{
    CoAffine identity = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    p->instance = (CoInstance){.to_group = identity, .to_object = identity};
    p->objects[0] =
        (CoObject){.mesh = mesh, .bvh = bvh, .box_min = mesh->box_min, .box_max = mesh->box_max};
    p->objects[1] = (CoObject){.top = co_top_create(&p->instance, 1, p->objects, NULL),
                               .instances = &p->instance,
                               .instance_count = 1};
    p->scene = (CoAccelScene){p->objects, 2, 1};
}

// Camera rays in tiles of 8 x 8, or rays of any direction from inside the hole and around.
static CoRayBatch make_rays(bool is_camera, Random *random)
{
    CoRayBatch rays = rays_alloc(RAYS);
    for (uint32_t i = 0; i < RAYS; i++) {
        uint32_t tile = i / 64, x = tile % 64 * 8 + i % 8, y = tile / 64 * 8 + i / 8 % 8;
        CoVec3 org = co_vec3(0.5f, -6.0f, 4.0f);
        CoVec3 dir = co_vec3(((float)x - 255.5f) / 300.0f, 1.0f, -0.7f + (255.5f - (float)y) / 300);
        if (!is_camera) {
            org = co_mul(random_vec3(random, -1, 1), co_vec3(4.0f, 4.0f, 1.5f));
            org.z += 1.5f;
            dir = random_vec3(random, -0.5f, 0.5f);
            dir.z -= 0.1f;
        }
        ray_set(&rays, i, org, dir);
    }
    return rays;
}

#ifdef BENCH_EMBREE
static ssize_t embree_bytes;

static bool count_bytes(void *cookie, ssize_t bytes, bool post)
{
    (void)cookie;
    (void)post;
    __atomic_add_fetch(&embree_bytes, bytes, __ATOMIC_RELAXED);
    return true;
}

// Grids of their own vertices, as Embree has them.
static RTCGeometry embree_grids(RTCDevice device, const CoMesh *mesh)
{
    const CoPatchTable *table = mesh->patches;
    uint32_t side = (1u << table->level) + 1, count = table->count;
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_GRID);
    float *points = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                            12, (size_t)count * side * side);
    struct RTCGrid *grids = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0,
                                                    RTC_FORMAT_GRID, sizeof *grids, count);
    for (uint32_t k = 0; k < count; k++) {
        uint32_t room[CO_PATCH_WORDS];
        const uint32_t *words = co_patch_words(table, k, room);
        grids[k] =
            (struct RTCGrid){k * side * side, side, (unsigned short)side, (unsigned short)side};
        for (uint32_t p = 0; p < side * side; p++, points += 3)
            memcpy(points,
                   mesh->points +
                       3 * (size_t)co_patch_point(table, words, side - 1, p % side, p / side),
                   12);
    }
    return geometry;
}

typedef struct EmbreeScene {
    RTCScene scene;
    double build_seconds;
    ssize_t bytes; // all that the device holds for it
} EmbreeScene;

static EmbreeScene embree_scene(RTCDevice device, const CoMesh *mesh)
{
    EmbreeScene out = {.bytes = embree_bytes};
    out.scene = embree_scene_of(device, mesh->patches ? embree_grids(device, mesh)
                                                      : embree_triangles(device, mesh));
    double start = cpu_seconds();
    rtcCommitScene(out.scene);
    out.build_seconds = cpu_seconds() - start;
    out.bytes = embree_bytes - out.bytes;
    return out;
}

static double trace_embree(RTCScene scene, const CoRayBatch *rays)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    double start = cpu_seconds();
    for (size_t i = 0; i < RAYS; i++)
        embree_intersect(scene, &context, rays, i);
    return cpu_seconds() - start;
}
#endif

static double trace(const CoAccelScene *scene, const CoRayBatch *rays, CoHitBatch *hits,
                    bool grouped, CoTraverseStats *stats)
{
    memset(stats, 0, sizeof *stats);
    double start = cpu_seconds();
    co_accel_kernels(NULL)->traverse(scene, rays, NULL, hits, 0, RAYS, grouped, stats);
    return cpu_seconds() - start;
}

static CoBvh *build(const CoMesh *mesh, double *seconds)
{
    double start = cpu_seconds();
    CoBvh *bvh = co_bvh_create(mesh, NULL);
    *seconds = cpu_seconds() - start;
    return bvh;
}

static void print_rays(const char *name, const Place *places, int rounds, bool is_camera,
                       void *const embree[2])
{
    Random random = {1};
    CoRayBatch rays = make_rays(is_camera, &random);
    CoHitBatch hits[2] = {hits_alloc(RAYS), hits_alloc(RAYS)};
    CoTraverseStats stats[2];
    double times[6][ROUNDS_MAX] = {{0.0}};
    for (int r = 0; r < rounds; r++) {
        for (int k = 0; k < 4; k++)
            times[k][r] = trace(&places[k % 2].scene, &rays, &hits[k % 2], k < 2, &stats[k % 2]);
#ifdef BENCH_EMBREE
        for (int k = 0; k < 2; k++)
            times[4 + k][r] = trace_embree(embree[k], &rays);
#endif
    }
    (void)embree;
    if (memcmp(hits[0].t, hits[1].t, 4 * RAYS) || memcmp(hits[0].tri, hits[1].tri, 4 * RAYS))
        printf("  DIFFERENT HITS\n");
    printf("  %-7s ns/ray: grouped %.0f loose %.0f, single %.0f loose %.0f, embree grid %.0f loose "
           "%.0f; nodes %.1f loose %.1f, triangles %.1f loose %.1f\n",
           name, 1e9 / RAYS * bench_median(times[0], rounds),
           1e9 / RAYS * bench_median(times[1], rounds), 1e9 / RAYS * bench_median(times[2], rounds),
           1e9 / RAYS * bench_median(times[3], rounds), 1e9 / RAYS * bench_median(times[4], rounds),
           1e9 / RAYS * bench_median(times[5], rounds), (double)stats[0].bottom_nodes / RAYS,
           (double)stats[1].bottom_nodes / RAYS, (double)stats[0].triangles / RAYS,
           (double)stats[1].triangles / RAYS);
    rays_free(&rays);
    hits_free(&hits[0]);
    hits_free(&hits[1]);
}

static void run(uint32_t level, double triangles, int rounds, Shape shape)
{
    // A triangle split in three quads has half as many triangles more.
    const double most = shape == SPLIT && level > 0 ? triangles / 1.5 : triangles;
    int n = (int)sqrt(most / (double)(1u << 2 * level)) / 2 * 2;
    double start = cpu_seconds(), times[3][ROUNDS_MAX] = {{0.0}};
    CoMesh meshes[2] = {make_torus(n, level, shape)};
    double tessellation = cpu_seconds() - start;
    meshes[1] = loosen(&meshes[0]);
    void *embree[2] = {NULL, NULL};
    double tris = meshes[0].tri_count, bytes[2] = {0.0, 0.0};
    CoMeshMemory memory;
    co_mesh_memory(&meshes[0], &memory);
#ifdef BENCH_EMBREE
    RTCDevice device = rtcNewDevice(getenv("BENCH_EMBREE_CONFIG"));
    rtcSetDeviceMemoryMonitorFunction(device, count_bytes, NULL);
    for (int r = 0; r < rounds; r++) {
        for (int k = 0; k < 2; k++) {
            // Grids are of quads.
            EmbreeScene scene = embree_scene(device, &meshes[shape == QUADS ? k : 1]);
            times[2][r] = k == 0 ? scene.build_seconds : times[2][r];
            bytes[k] = (double)scene.bytes;
            if (r + 1 < rounds)
                rtcReleaseScene(scene.scene);
            else
                embree[k] = scene.scene;
        }
    }
#endif
    CoBvh *bvhs[2] = {NULL, NULL};
    for (int r = 0; r < rounds; r++) {
        for (int k = 0; k < 2; k++) {
            co_bvh_destroy(bvhs[k]);
            bvhs[k] = build(&meshes[k], &times[k][r]);
        }
    }
    printf("level %u, %.0f triangles, tessellated in %.2f s\n", level, tris, tessellation);
    printf(
        "  bytes per triangle: %.2f + tree %.2f, loose %.2f + %.2f; embree grid %.2f, loose %.2f "
        "(no normals)\n",
        (double)meshes[0].bytes / tris, (double)co_bvh_bytes(bvhs[0]) / tris,
        (double)(meshes[0].bytes - memory.topology) / tris + 12.0,
        (double)co_bvh_bytes(bvhs[1]) / tris, bytes[0] / tris, bytes[1] / tris);
    printf("  build, million triangles per CPU second: %.1f, loose %.1f; embree grid %.1f\n",
           tris * 1e-6 / bench_median(times[0], rounds),
           tris * 1e-6 / bench_median(times[1], rounds),
           tris * 1e-6 / bench_median(times[2], rounds));
    Place places[2];
    for (int k = 0; k < 2; k++)
        place(&places[k], &meshes[k], bvhs[k]);
    print_rays("camera", places, rounds, true, embree);
    print_rays("random", places, rounds, false, embree);
#ifdef BENCH_EMBREE
    rtcReleaseScene(embree[0]);
    rtcReleaseScene(embree[1]);
    rtcReleaseDevice(device);
#endif
    for (int k = 0; k < 2; k++) {
        co_top_destroy((CoTop *)(uintptr_t)places[k].objects[1].top);
        co_bvh_destroy(bvhs[k]);
    }
    free((void *)(uintptr_t)meshes[1].indices);
    co_mesh_destroy(&meshes[0]);
}

int main(int argc, char **argv)
{
    double triangles = 1e6, rounds = 5, level = LEVELS;
    const char *shape = "quads";
    const BenchArgument arguments[] = {
        {.name = "TRIANGLES", .number = &triangles, .least = 1e5, .most = 1e9},
        {.name = "ROUNDS", .number = &rounds, .least = 1, .most = ROUNDS_MAX},
        {.name = "LEVEL", .number = &level, .most = LEVELS - 1},
        {.name = "SHAPE", .text = &shape, .words = "quads,split,loop"}};
    bench_arguments_read(argc, argv, usage, arguments, sizeof arguments / sizeof *arguments);
    bench_tell_of_embree();
    co_worker_count_set(1);
    for (uint32_t i = 0; i < LEVELS; i++)
        if (level >= LEVELS || (uint32_t)level == i)
            run(i, triangles, (int)rounds,
                shape[0] == 'q'   ? QUADS
                : shape[0] == 's' ? SPLIT
                                  : LOOP);
    return 0;
}
