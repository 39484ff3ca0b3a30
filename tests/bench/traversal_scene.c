#include "traversal_scene.h"

#include "base/clock.h"
#include "base/hash.h"
#include "base/parallel.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Meshes above this build one after the other, each on all threads, as in a commit.
#define LARGE_MESH 65536

// What a sheet of n x m quads looks like: (u, v) in [0, 1]^2.
typedef struct Sheet {
    CoVec3 (*at)(const struct Sheet *sheet, float u, float v);
    CoVec3 center, size;
    float angle, shape;
    uint32_t seed;
} Sheet;

static float uniform(uint32_t seed, uint32_t n)
{
    return (float)(co_hash64((uint64_t)seed << 32 | n) >> 40) * 0x1p-24f;
}

static void make_sheet(const Sheet *sheet, uint32_t n, uint32_t m, CoMesh *out)
{
    size_t count = (size_t)(n + 1) * (m + 1);
    // The reference reads whole vectors: room behind the last point.
    float *points = calloc(3 * count + 4, sizeof(float));
    uint32_t *indices = malloc(sizeof(uint32_t) * 6 * n * m);
    *out = (CoMesh){.points = points, .indices = indices, .tri_count = 2 * n * m};
    out->point_count = (uint32_t)count;
    out->box_min = co_vec3_splat(INFINITY);
    out->box_max = co_vec3_splat(-INFINITY);
    for (uint32_t i = 0; i < out->point_count; i++) {
        float u = (float)(i % (n + 1)) / (float)n, v = (float)(i / (n + 1)) / (float)m;
        CoVec3 p = sheet->at(sheet, u, v), lo = out->box_min, hi = out->box_max;
        co_vec3_store(points + 3 * (size_t)i, p);
        out->box_min = co_vec3(fminf(lo.x, p.x), fminf(lo.y, p.y), fminf(lo.z, p.z));
        out->box_max = co_vec3(fmaxf(hi.x, p.x), fmaxf(hi.y, p.y), fmaxf(hi.z, p.z));
    }
    for (uint32_t q = 0; q < n * m; q++) {
        uint32_t a = q / n * (n + 1) + q % n;
        uint32_t quad[6] = {a, a + 1, a + n + 2, a, a + n + 2, a + n + 1};
        memcpy(indices + 6 * (size_t)q, quad, sizeof quad);
    }
}

// Once around a square of half side 1, by u.
static void around_square(float u, float *x, float *z)
{
    float a = 4.0f * u;
    *x = a < 1 ? 2 * a - 1 : a < 2 ? 1 : a < 3 ? 5 - 2 * a : -1;
    *z = a < 1 ? -1 : a < 2 ? 2 * a - 3 : a < 3 ? 1 : 7 - 2 * a;
}

// The inside of a box, floor, walls and ceiling in one sheet, with shallow waves.
static CoVec3 room_point(const Sheet *sheet, float u, float v)
{
    float x, z, r = fminf(fminf(4 * v, 4 - 4 * v), 1), y = co_clamp(2 * v - 0.5f, 0, 1);
    around_square(u, &x, &z);
    float wave = 1.0f + 0.004f * sinf(60.0f * u) * sinf(50.0f * v);
    return co_vec3(sheet->size.x * x * r * wave, sheet->size.y * y, sheet->size.z * z * r * wave);
}

// From a rounded box to a sphere with ridges, by shape.
static CoVec3 furniture_point(const Sheet *sheet, float u, float v)
{
    float theta = CO_PI * v, phi = 2.0f * CO_PI * u, k = sheet->shape;
    CoVec3 d = co_vec3(sinf(theta) * cosf(phi), cosf(theta), sinf(theta) * sinf(phi));
    float largest = fmaxf(fmaxf(fabsf(d.x), fabsf(d.y)), fabsf(d.z));
    CoVec3 p = co_mul(co_scale(d, k / largest + (1.0f - k) * (1.0f + 0.08f * sinf(9.0f * phi))),
                      sheet->size);
    float c = cosf(sheet->angle), s = sinf(sheet->angle);
    return co_add(co_vec3(c * p.x + s * p.z, p.y, c * p.z - s * p.x), sheet->center);
}

// A block of the city: street, walls with windows, roof.
static CoVec3 block_point(const Sheet *sheet, float u, float v)
{
    float x, z, y = 0.0f, r = 1.0f - 1.2f * v;
    around_square(u, &x, &z);
    if (v > 0.15f) {
        float up = fminf((v - 0.15f) / 0.65f, 1.0f);
        r = 0.82f - 0.03f * sheet->shape * up;
        y = sheet->size.y * up;
        r -= 0.02f * fmaxf(sinf(40.0f * CO_PI * u) * sinf(24.0f * CO_PI * up), 0.0f);
        if (v > 0.8f)
            r *= 1.0f - 5.0f * (v - 0.8f);
        if (v > 0.8f)
            y += 0.3f * uniform(sheet->seed, (uint32_t)(u * 9.0f)) * fminf(20 * (v - 0.8f), 1);
    }
    return co_add(co_vec3(sheet->size.x * x * r, y, sheet->size.z * z * r), sheet->center);
}

// With room for a ground.
static void allocate(BenchScene *scene, uint32_t meshes)
{
    scene->mesh_count = meshes;
    scene->meshes = calloc(meshes + 1, sizeof *scene->meshes);
    scene->objects = calloc(meshes + 2, sizeof *scene->objects);
    scene->instances = calloc(meshes + 1, sizeof *scene->instances);
}

// 17 meshes: the room and what stands in it.
static void make_room(BenchScene *scene, uint32_t n, uint32_t m)
{
    allocate(scene, 17);
    Sheet room = {.at = room_point, .size = co_vec3(5, 4, 5)};
    make_sheet(&room, n, m, &scene->meshes[0]);
    for (uint32_t i = 1; i < 17; i++) {
        Sheet sheet = {.at = furniture_point, .angle = 6.0f * uniform(i, 0)};
        sheet.shape = (float)(i % 4) / 3.0f;
        sheet.size = co_vec3(0.2f + 0.6f * uniform(i, 1), 0.2f + 0.7f * uniform(i, 2),
                             0.2f + 0.6f * uniform(i, 3));
        sheet.center =
            co_vec3(8.0f * (uniform(i, 4) - 0.5f), sheet.size.y, 8.0f * (uniform(i, 5) - 0.5f));
        if (i % 3 == 0)
            sheet.center.y += 2.0f * uniform(i, 6);
        make_sheet(&sheet, n, m, &scene->meshes[i]);
    }
    scene->eye = co_vec3(-3.0f, 2.6f, -4.5f);
    scene->target = co_vec3(0.5f, 1.0f, 1.0f);
    scene->light_low = co_vec3(-1.0f, 3.8f, -1.0f);
    scene->light_high = co_vec3(1.0f, 3.8f, 1.0f);
}

typedef struct City {
    CoMesh *meshes;
    uint32_t side;
} City;

static void make_blocks(void *context, size_t begin, size_t end, uint32_t worker)
{
    City *city = context;
    (void)worker;
    for (uint32_t i = (uint32_t)begin; i < end; i++) {
        Sheet sheet = {.at = block_point, .seed = i, .shape = uniform(i, 100)};
        float height = uniform(i, 101);
        sheet.size = co_vec3(5.0f, 3.0f + 25.0f * height * height, 5.0f);
        sheet.center = co_vec3(10.0f * (float)(i % city->side), 0, 10.0f * (float)(i / city->side));
        make_sheet(&sheet, 100, 20, &city->meshes[i]);
    }
}

// Blocks of 4,000 triangles each.
static void make_city(BenchScene *scene, uint32_t side, uint32_t meshes)
{
    allocate(scene, meshes);
    City city = {scene->meshes, side};
    co_parallel_for(meshes, 16, make_blocks, &city);
    float width = 10.0f * (float)side;
    scene->eye = co_vec3(0.3f * width, 32.0f, -10.0f);
    scene->target = co_vec3(0.55f * width, 0.0f, 0.4f * width);
    scene->light_low = co_vec3(0.2f * width, 400.0f, 0.2f * width);
    scene->light_high = co_vec3(0.3f * width, 400.0f, 0.3f * width);
}

static void finish(BenchScene *scene)
{
    CoAffine identity = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    for (uint32_t i = 0; i < scene->mesh_count; i++) {
        const CoMesh *mesh = &scene->meshes[i];
        scene->objects[i] =
            (CoObject){.mesh = mesh, .box_min = mesh->box_min, .box_max = mesh->box_max};
        scene->instances[i] =
            (CoInstance){.object = i, .to_group = identity, .to_object = identity};
        scene->triangles += mesh->tri_count;
        scene->mesh_bytes += 12 * ((size_t)mesh->point_count + mesh->tri_count);
    }
    scene->own_triangles = scene->triangles;
    scene->path_count = scene->mesh_count;
    scene->accel = (CoAccelScene){scene->objects, scene->mesh_count + 1, scene->mesh_count};
}

// A flat square.
static CoVec3 ground_point(const Sheet *sheet, float u, float v)
{
    return co_add(co_vec3(sheet->size.x * (u - 0.5f), 0.0f, sheet->size.z * (v - 0.5f)),
                  sheet->center);
}

// Below everything, the last mesh.
static void add_ground(BenchScene *scene, float size)
{
    Sheet sheet = {.at = ground_point, .size = co_vec3_splat(size), .center = co_vec3(0, -1, 0)};
    make_sheet(&sheet, 1, 1, &scene->meshes[scene->mesh_count++]);
}

bool bench_scene_make(const char *name, double ground, BenchScene *out)
{
    *out = (BenchScene){.name = name, .up = co_vec3(0, 1, 0)};
    if (strcmp(name, "room_1m") == 0)
        make_room(out, 172, 172);
    else if (strcmp(name, "small") == 0)
        make_room(out, 29, 29);
    else if (strcmp(name, "city_10m") == 0)
        make_city(out, 50, 2500);
    else if (strcmp(name, "city_50m") == 0)
        make_city(out, 125, 12500);
    else
        return false;
    if (ground > 0.0)
        add_ground(out, (float)ground);
    finish(out);
    return true;
}

// Trees over the meshes of a stage, which keeps its own.
typedef struct Rebuild {
    const CoAccelScene *scene;
    uint32_t *list; // objects, large meshes last
    CoBvh **trees;
    CoBvhBlocks *blocks; // of each worker
    uint32_t count, small;
} Rebuild;

static void list_meshes(Rebuild *r)
{
    for (int pass = 0; pass < 2; pass++) {
        for (uint32_t i = 0; i < r->scene->object_count; i++) {
            const CoMesh *mesh = r->scene->objects[i].mesh;
            if (mesh && (mesh->tri_count > LARGE_MESH) == pass)
                r->list[r->count++] = i;
        }
        if (pass == 0)
            r->small = r->count;
    }
}

static void rebuild_meshes(void *context, size_t begin, size_t end, uint32_t worker)
{
    Rebuild *r = context;
    for (size_t i = begin; i < end; i++) {
        r->trees[i] = co_bvh_create(r->scene->objects[r->list[i]].mesh, NULL);
        if (r->trees[i] && i < r->small)
            co_bvh_pack(r->trees[i], &r->blocks[worker]);
    }
}

static double rebuild_objects(const CoAccelScene *scene)
{
    Rebuild r = {.scene = scene};
    r.list = calloc(scene->object_count, sizeof *r.list);
    r.trees = calloc(scene->object_count, sizeof(CoBvh *));
    r.blocks = calloc(co_worker_count(), sizeof *r.blocks);
    list_meshes(&r);
    double start = co_clock_seconds();
    co_parallel_for(r.small, 1, rebuild_meshes, &r);
    for (uint32_t i = r.small; i < r.count; i++)
        rebuild_meshes(&r, i, i + 1, 0);
    for (uint32_t w = 0; w < co_worker_count(); w++)
        co_bvh_blocks_close(&r.blocks[w]);
    for (uint32_t i = 0; i < scene->object_count; i++) {
        const CoObject *object = &scene->objects[i];
        if (object->top)
            co_top_destroy(
                co_top_create(object->instances, object->instance_count, scene->objects, NULL));
    }
    double seconds = co_clock_seconds() - start;
    for (uint32_t i = 0; i < r.count; i++)
        co_bvh_destroy(r.trees[i]);
    free(r.blocks);
    free(r.trees);
    free(r.list);
    return seconds;
}

double bench_scene_rebuild(BenchScene *scene)
{
    if (!scene->meshes)
        return rebuild_objects(&scene->accel);
    bench_scene_unbuild(scene);
    double start = co_clock_seconds();
    bench_scene_build(scene);
    return co_clock_seconds() - start;
}

typedef struct Builds {
    BenchScene *scene;
    CoBvhBlocks *blocks; // of each worker
} Builds;

static void build_meshes(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Builds *builds = context;
    for (size_t i = begin; i < end; i++) {
        CoBvh *bvh = co_bvh_create(&builds->scene->meshes[i], NULL);
        if (bvh)
            co_bvh_pack(bvh, &builds->blocks[worker]);
        builds->scene->objects[i].bvh = bvh;
    }
}

bool bench_scene_build(BenchScene *scene)
{
    uint32_t n = scene->mesh_count;
    CoBvhBlocks *blocks = calloc(co_worker_count(), sizeof *blocks);
    Builds builds = {scene, blocks};
    if (scene->meshes[0].tri_count > LARGE_MESH)
        for (uint32_t i = 0; i < n; i++)
            build_meshes(&builds, i, i + 1, 0);
    else
        co_parallel_for(n, 1, build_meshes, &builds);
    for (uint32_t w = 0; w < co_worker_count(); w++)
        co_bvh_blocks_close(&blocks[w]);
    free(blocks);
    for (uint32_t i = 0; i < n; i++)
        if (!scene->objects[i].bvh)
            return false;
    CoTop *top = co_top_create(scene->instances, n, scene->objects, NULL);
    scene->objects[n] = (CoObject){.top = top, .instances = scene->instances, .instance_count = n};
    return top != NULL;
}

void bench_scene_unbuild(BenchScene *scene)
{
    for (uint32_t i = 0; i < scene->mesh_count; i++) {
        co_bvh_destroy((CoBvh *)(uintptr_t)scene->objects[i].bvh);
        scene->objects[i].bvh = NULL;
    }
    co_top_destroy((CoTop *)(uintptr_t)scene->objects[scene->mesh_count].top);
    scene->objects[scene->mesh_count].top = NULL;
}

size_t bench_scene_tree_bytes(const BenchScene *scene)
{
    size_t bytes = 0;
    for (uint32_t i = 0; i < scene->accel.object_count; i++) {
        const CoObject *object = &scene->accel.objects[i];
        bytes += object->bvh ? co_bvh_bytes(object->bvh) : 0;
        bytes += object->top ? co_top_bytes(object->top) : 0;
    }
    return bytes;
}

void bench_scene_destroy(BenchScene *scene)
{
    if (!scene->meshes) // a stage's: lives until the end
        return;
    bench_scene_unbuild(scene);
    for (uint32_t i = 0; i < scene->mesh_count; i++) {
        free((void *)(uintptr_t)scene->meshes[i].points);
        free((void *)(uintptr_t)scene->meshes[i].indices);
    }
    free(scene->meshes);
    free(scene->objects);
    free(scene->instances);
}
