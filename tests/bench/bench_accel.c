// Millions of rays per second and thread through a room of 28 thousand triangles in 61 instances,
// camera and diffuse rays, per kernel; beside Embree where it is installed, in alternated runs.
// Not a test: prints numbers. Usage: bench_accel [rounds]

#include "accel/accel.h"
#include "base/clock.h"
#include "base/hash.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef BENCH_EMBREE
#include <embree3/rtcore.h>
#endif

enum {
    WIDTH = 512,
    RAYS = WIDTH * WIDTH,
    FURNITURE = 60,
    KINDS = 4,
    OBJECTS = KINDS + 2
};

static uint64_t random_state = 1;

static float uniform(void)
{
    return (float)(co_hash64(random_state++) >> 40) * 0x1p-24f;
}

static CoMesh grid_mesh(uint32_t n, uint32_t m, CoVec3 (*at)(float u, float v, float k), float k)
{
    float *points = malloc(sizeof(float) * 3 * (n + 1) * (m + 1));
    uint32_t *indices = malloc(sizeof(uint32_t) * 6 * n * m);
    CoMesh mesh = {.points = points, .indices = indices};
    mesh.point_count = (n + 1) * (m + 1);
    mesh.tri_count = 2 * n * m;
    mesh.box_min = co_vec3_splat(INFINITY);
    mesh.box_max = co_vec3_splat(-INFINITY);
    for (uint32_t i = 0; i < mesh.point_count; i++) {
        CoVec3 p = at((float)(i % (n + 1)) / (float)n, (float)(i / (n + 1)) / (float)m, k);
        co_vec3_store(points + 3 * i, p);
        mesh.box_min = co_vec3(fminf(mesh.box_min.x, p.x), fminf(mesh.box_min.y, p.y),
                               fminf(mesh.box_min.z, p.z));
        mesh.box_max = co_vec3(fmaxf(mesh.box_max.x, p.x), fmaxf(mesh.box_max.y, p.y),
                               fmaxf(mesh.box_max.z, p.z));
    }
    for (uint32_t q = 0; q < n * m; q++) {
        uint32_t a = q / n * (n + 1) + q % n;
        uint32_t quad[6] = {a, a + 1, a + n + 2, a, a + n + 2, a + n + 1};
        memcpy(indices + 6 * q, quad, sizeof quad);
    }
    return mesh;
}

// A rounded box to a sphere, by k.
static CoVec3 furniture_point(float u, float v, float k)
{
    float theta = CO_PI * v, phi = 2.0f * CO_PI * u;
    CoVec3 d = co_vec3(sinf(theta) * cosf(phi), cosf(theta), sinf(theta) * sinf(phi));
    float largest = fmaxf(fmaxf(fabsf(d.x), fabsf(d.y)), fabsf(d.z));
    return co_scale(d, k / largest + (1.0f - k) * (1.0f + 0.1f * sinf(9.0f * phi)));
}

// The inside of a box 10 x 4 x 10, four walls, floor and ceiling in one sheet.
static CoVec3 room_point(float u, float v, float k)
{
    (void)k;
    float a = 4.0f * u, x = a < 1 ? a : a < 2 ? 1 : a < 3 ? 3 - a : 0;
    float z = a < 1 ? 0 : a < 2 ? a - 1 : a < 3 ? 1 : 4 - a, r = fminf(fminf(4 * v, 4 - 4 * v), 1);
    float y = fminf(fmaxf(2 * v - 0.5f, 0), 1);
    return co_vec3(10.0f * (x - 0.5f) * r, 4.0f * y, 10.0f * (z - 0.5f) * r);
}

typedef struct Room {
    CoMesh meshes[KINDS + 1];
    CoObject objects[OBJECTS];
    CoInstance instances[FURNITURE + 1];
    CoAccelScene scene;
    size_t tris, bytes;
} Room;

static CoInstance place(uint32_t object, float angle, CoVec3 scale, CoVec3 offset)
{
    double c = cos((double)angle), s = sin((double)angle);
    CoMat4d m = {{{c * (double)scale.x, 0, -s * (double)scale.x, 0},
                  {0, (double)scale.y, 0, 0},
                  {s * (double)scale.z, 0, c * (double)scale.z, 0},
                  {(double)offset.x, (double)offset.y, (double)offset.z, 1}}};
    CoMat4d inverse = m;
    co_mat4d_invert_affine(&m, &inverse);
    CoInstance instance = {object, co_affine_from_mat4d(&m), co_affine_from_mat4d(&inverse)};
    return instance;
}

static void make_room(Room *room)
{
    room->meshes[KINDS] = grid_mesh(32, 32, room_point, 0.0f);
    for (uint32_t i = 0; i < KINDS; i++)
        room->meshes[i] = grid_mesh(20, 10 + 2 * i, furniture_point, (float)i / (KINDS - 1));
    for (uint32_t i = 0; i <= KINDS; i++) {
        CoMesh *mesh = &room->meshes[i];
        CoBvh *bvh = co_bvh_create(mesh, NULL);
        room->objects[i] = (CoObject){
            .mesh = mesh, .bvh = bvh, .box_min = mesh->box_min, .box_max = mesh->box_max};
    }
    for (uint32_t i = 0; i < FURNITURE; i++) {
        CoVec3 scale =
            co_vec3(0.1f + 0.5f * uniform(), 0.1f + 0.6f * uniform(), 0.1f + 0.5f * uniform());
        CoVec3 offset = co_vec3(8.4f * (uniform() - 0.5f), scale.y, 8.4f * (uniform() - 0.5f));
        if (i % 3 == 0)
            offset.y += 2.0f * uniform();
        room->instances[i] = place(i % KINDS, 6.0f * uniform(), scale, offset);
    }
    room->instances[FURNITURE] = place(KINDS, 0.0f, co_vec3_splat(1.0f), co_vec3_splat(0.0f));
    CoTop *top = co_top_create(room->instances, FURNITURE + 1, room->objects, NULL);
    room->objects[KINDS + 1] =
        (CoObject){.top = top, .instances = room->instances, .instance_count = FURNITURE + 1};
    room->scene = (CoAccelScene){room->objects, OBJECTS, KINDS + 1};
    for (uint32_t i = 0; i <= FURNITURE; i++)
        room->tris += room->objects[room->instances[i].object].mesh->tri_count;
}

// The same triangles as one mesh in world space.
static CoMesh flatten(const Room *room)
{
    size_t point = 0, index = 0;
    float *points = malloc(9 * sizeof(float) * room->tris);
    uint32_t *indices = malloc(3 * sizeof(uint32_t) * room->tris);
    CoMesh flat = {.points = points, .indices = indices};
    flat.box_min = co_vec3(-9.0f, -9.0f, -9.0f);
    flat.box_max = co_vec3(9.0f, 9.0f, 9.0f);
    for (uint32_t i = 0; i <= FURNITURE; i++) {
        const CoMesh *mesh = room->objects[room->instances[i].object].mesh;
        for (uint32_t k = 0; k < 3 * mesh->tri_count; k++)
            indices[index++] = (uint32_t)point + mesh->indices[k];
        for (uint32_t p = 0; p < mesh->point_count; p++)
            co_vec3_store(
                points + 3 * point++,
                co_affine_point(&room->instances[i].to_group, co_vec3_load(mesh->points + 3 * p)));
    }
    flat.point_count = (uint32_t)point;
    flat.tri_count = (uint32_t)room->tris;
    return flat;
}

static CoRayBatch alloc_rays(void)
{
    CoRayBatch rays = {.count = RAYS, .capacity = RAYS};
#define BENCH_ALLOC(type, name) rays.name = aligned_alloc(64, RAYS * sizeof(type));
    CO_RAY_FIELDS(BENCH_ALLOC)
#undef BENCH_ALLOC
    return rays;
}

static CoHitBatch alloc_hits(void)
{
    CoHitBatch hits = {.count = RAYS, .capacity = RAYS};
#define BENCH_ALLOC(type, name) hits.name = aligned_alloc(64, RAYS * sizeof(type));
    CO_HIT_FIELDS(BENCH_ALLOC)
#undef BENCH_ALLOC
    return hits;
}

static void set_ray(CoRayBatch *rays, size_t i, CoVec3 org, CoVec3 dir)
{
    float *fields[6] = {rays->org_x, rays->org_y, rays->org_z,
                        rays->dir_x, rays->dir_y, rays->dir_z};
    const float values[6] = {org.x, org.y, org.z, dir.x, dir.y, dir.z};
    for (int k = 0; k < 6; k++)
        fields[k][i] = values[k];
    rays->tnear[i] = 0.0f;
    rays->tfar[i] = INFINITY;
    rays->record[i] = (uint32_t)i;
}

// 8 x 8 tiles.
static void camera_rays(CoRayBatch *rays)
{
    for (uint32_t i = 0; i < RAYS; i++) {
        uint32_t tile = i / 64, x = tile % (WIDTH / 8) * 8 + i % 8,
                 y = tile / (WIDTH / 8) * 8 + i / 8 % 8;
        CoVec3 dir = co_vec3(((float)x + 0.5f) / WIDTH * 1.6f - 0.8f,
                             0.7f - ((float)y + 0.5f) / WIDTH * 1.6f, 1.0f);
        set_ray(rays, i, co_vec3(-2.0f, 2.2f, -4.6f), co_normalize(dir));
    }
}

typedef struct SortRay {
    float v[6];
} SortRay;

static int sort_axis;

static int compare_rays(const void *a, const void *b)
{
    float x = ((const SortRay *)a)->v[sort_axis], y = ((const SortRay *)b)->v[sort_axis];
    return (x > y) - (x < y);
}

// The paper's order: medians by origin down to 4096 rays, then by direction down to 64.
static void sort_rays(SortRay *rays, size_t count)
{
    if (count <= 64)
        return;
    int first = count > 4096 ? 0 : 3;
    float widest = -1.0f;
    for (int k = first; k < first + 3; k++) {
        float lo = INFINITY, hi = -INFINITY;
        for (size_t i = 0; i < count; i++) {
            lo = fminf(lo, rays[i].v[k]);
            hi = fmaxf(hi, rays[i].v[k]);
        }
        if (hi - lo > widest) {
            widest = hi - lo;
            sort_axis = k;
        }
    }
    qsort(rays, count, sizeof *rays, compare_rays);
    size_t half = count / 2 / 64 * 64;
    half = half ? half : 64;
    sort_rays(rays, half);
    sort_rays(rays + half, count - half);
}

static uint32_t bin_of(const SortRay *r)
{
    float x = fabsf(r->v[3]), y = fabsf(r->v[4]), z = fabsf(r->v[5]);
    uint32_t axis = x >= y && x >= z ? 0 : y >= z ? 1 : 2;
    return 2 * axis + (r->v[3 + axis] < 0.0f);
}

// Uniform directions from just before the camera rays' hits, in six bins, each sorted.
static void diffuse_rays(const CoRayBatch *from, const CoHitBatch *hits, CoRayBatch *rays,
                         bool sorted)
{
    SortRay *all = malloc(RAYS * sizeof *all), *binned = malloc(RAYS * sizeof *binned);
    for (size_t i = 0; i < RAYS; i++) {
        float t = isinf(hits->t[i]) ? 1.0f : hits->t[i] * 0.999f;
        CoVec3 d = co_vec3(uniform() - 0.5f, uniform() - 0.5f, uniform() - 0.5f);
        d = co_normalize(d);
        SortRay ray = {{from->org_x[i] + t * from->dir_x[i], from->org_y[i] + t * from->dir_y[i],
                        from->org_z[i] + t * from->dir_z[i], d.x, d.y, d.z}};
        all[i] = ray;
    }
    size_t used = 0;
    for (uint32_t bin = 0; bin < 6; bin++) {
        size_t first = used;
        for (size_t i = 0; i < RAYS; i++)
            if (bin_of(&all[i]) == bin)
                binned[used++] = all[i];
        sort_rays(binned + first, used - first);
    }
    const SortRay *order = sorted ? binned : all;
    for (size_t i = 0; i < RAYS; i++)
        set_ray(rays, i, co_vec3_load(order[i].v), co_vec3_load(order[i].v + 3));
    free(all);
    free(binned);
}

#ifdef BENCH_EMBREE
static RTCScene embree_scene(const CoMesh *mesh)
{
    RTCDevice device = rtcNewDevice("threads=1");
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *points = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                            12, mesh->point_count);
    uint32_t *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0,
                                                RTC_FORMAT_UINT3, 12, mesh->tri_count);
    memcpy(points, mesh->points, 12 * (size_t)mesh->point_count);
    memcpy(indices, mesh->indices, 12 * (size_t)mesh->tri_count);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcCommitScene(scene);
    return scene;
}

static double time_embree(RTCScene scene, const CoRayBatch *rays, CoHitBatch *hits)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    double start = co_clock_seconds();
    for (size_t i = 0; i < RAYS; i++) {
        struct RTCRayHit r = {{rays->org_x[i], rays->org_y[i], rays->org_z[i], 0.0f, rays->dir_x[i],
                               rays->dir_y[i], rays->dir_z[i], 0.0f, rays->tfar[i], ~0u, 0, 0},
                              {0, 0, 0, 0, 0, ~0u, ~0u, {~0u}}};
        rtcIntersect1(scene, &context, &r);
        hits->t[i] = r.ray.tfar;
    }
    return co_clock_seconds() - start;
}
#endif

static double time_kernel(const CoAccelKernels *kernels, const CoAccelScene *scene,
                          const CoRayBatch *rays, CoHitBatch *hits, bool grouped,
                          CoTraverseStats *stats)
{
    memset(stats, 0, sizeof *stats);
    double start = co_clock_seconds();
    kernels->traverse(scene, rays, NULL, hits, 0, RAYS, grouped, stats);
    return co_clock_seconds() - start;
}

static void report(const char *name, double seconds, const CoTraverseStats *s)
{
    printf("  %-16s %6.2f M/s  %5.0f ns", name, RAYS / seconds * 1e-6, seconds * 1e9 / RAYS);
    if (s)
        printf("  top nodes %5.2f of %5.2f, bottom nodes %5.2f, triangles %5.2f per ray",
               (double)s->top_nodes_grouped / RAYS, (double)s->top_nodes_single / RAYS,
               (double)s->bottom_nodes / RAYS, (double)s->triangles / RAYS);
    printf("\n");
}

// Kernels: by instruction set, single then grouped, in instances; then grouped in one mesh.
static void run(const Room *room, const Room *flat, const char *title, const CoRayBatch *rays,
                CoHitBatch *hits, int rounds)
{
    const char *const isas[4] = {"scalar", "sse42", "avx2", "avx512"};
    const char *const modes[3] = {"single", "grouped", "one mesh"};
    CoTraverseStats stats[12];
    double best[13];
    for (int k = 0; k < 13; k++)
        best[k] = 1e30;
#ifdef BENCH_EMBREE
    RTCScene embree = embree_scene(&flat->meshes[0]);
#endif
    for (int round = 0; round < rounds; round++) {
        for (int k = 0; k < 12; k++) {
            const CoAccelKernels *kernels = co_accel_kernels(isas[k / 3]);
            const CoAccelScene *scene = k % 3 == 2 ? &flat->scene : &room->scene;
            if (kernels)
                best[k] =
                    fmin(best[k], time_kernel(kernels, scene, rays, hits, k % 3 != 0, &stats[k]));
        }
#ifdef BENCH_EMBREE
        best[12] = fmin(best[12], time_embree(embree, rays, hits));
#endif
    }
    printf("%s\n", title);
    for (int k = 0; k < 12; k++) {
        char name[32];
        snprintf(name, sizeof name, "%s %s", isas[k / 3], modes[k % 3]);
        if (best[k] < 1e30)
            report(name, best[k], &stats[k]);
    }
    if (best[12] < 1e30) {
        report("embree one mesh", best[12], NULL);
        printf("  embree's time by ours: avx2 %.2f, one mesh %.2f; avx512 %.2f, one mesh %.2f\n",
               best[12] / best[7], best[12] / best[8], best[12] / best[10], best[12] / best[11]);
    }
}

int main(int argc, char **argv)
{
    int rounds = argc > 1 ? atoi(argv[1]) : 5;
    Room room;
    memset(&room, 0, sizeof room);
    make_room(&room);
    size_t own = 0, bytes = co_top_bytes(room.objects[KINDS + 1].top);
    for (uint32_t i = 0; i <= KINDS; i++) {
        own += room.meshes[i].tri_count;
        bytes += co_bvh_bytes(room.objects[i].bvh);
    }
    printf("%zu triangles, %zu of them distinct, %.1f bytes each\n", room.tris, own,
           (double)bytes / (double)own);
    Room flat;
    memset(&flat, 0, sizeof flat);
    flat.meshes[0] = flatten(&room);
    flat.objects[0] = (CoObject){.mesh = &flat.meshes[0],
                                 .bvh = co_bvh_create(&flat.meshes[0], NULL),
                                 .box_min = flat.meshes[0].box_min,
                                 .box_max = flat.meshes[0].box_max};
    flat.instances[0] = place(0, 0.0f, co_vec3_splat(1.0f), co_vec3_splat(0.0f));
    flat.objects[1] = (CoObject){.top = co_top_create(flat.instances, 1, flat.objects, NULL),
                                 .instances = flat.instances,
                                 .instance_count = 1};
    flat.scene = (CoAccelScene){flat.objects, 2, 1};
    printf("as one mesh %.1f bytes each\n",
           (double)co_bvh_bytes(flat.objects[0].bvh) / (double)room.tris);
    CoRayBatch camera = alloc_rays(), diffuse = alloc_rays();
    CoHitBatch hits = alloc_hits();
    camera_rays(&camera);
    run(&room, &flat, "camera rays", &camera, &hits, rounds);
    diffuse_rays(&camera, &hits, &diffuse, true);
    run(&room, &flat, "diffuse rays, sorted", &diffuse, &hits, rounds);
    camera_rays(&camera);
    CoTraverseStats stats;
    time_kernel(co_accel_kernels(NULL), &room.scene, &camera, &hits, true, &stats);
    diffuse_rays(&camera, &hits, &diffuse, false);
    run(&room, &flat, "diffuse rays, unsorted", &diffuse, &hits, rounds);
    return 0;
}
