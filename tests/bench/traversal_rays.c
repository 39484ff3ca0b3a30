#include "traversal_rays.h"

#include "base/parallel.h"
#include "support/rays.h"

#include <stdlib.h>
#include <string.h>

enum {
    CHUNK = 1 << 18, // paths at a time
    BOUNCES = 5,
    SIDE = 1024 // pixels of a sample; the next sample is jittered otherwise
};

static float uniform(uint64_t path, uint32_t what)
{
    return (float)(co_hash64(path << 8 | what) >> 40) * 0x1p-24f;
}

static void set_ray(CoRayBatch *rays, size_t i, CoVec3 org, CoVec3 dir, float tfar)
{
    ray_set(rays, i, org, dir);
    rays->tnear[i] = 0.0f;
    rays->tfar[i] = tfar;
    rays->record[i] = (uint32_t)i;
}

static void append(CoRayBatch *to, const CoRayBatch *from, size_t i)
{
    set_ray(to, to->count, ray_org(from, i), ray_dir(from, i), from->tfar[i]);
    to->count++;
}

// One bounce of a chunk of paths: the rays, the light rays from where they begin, and the hits.
typedef struct Wave {
    const BenchScene *scene;
    uint64_t first; // path
    uint32_t bounce;
    CoRayBatch rays[BOUNCES + 1], light[BOUNCES + 1];
    CoHitBatch hits;
    uint8_t alive[BOUNCES + 1][CHUNK];
} Wave;

static void camera_rays(void *context, size_t begin, size_t end, uint32_t worker)
{
    Wave *wave = context;
    const BenchScene *scene = wave->scene;
    CoVec3 forward = co_normalize(co_sub(scene->target, scene->eye));
    CoVec3 right = co_normalize(co_cross(forward, scene->up)), up = co_cross(right, forward);
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        uint64_t path = wave->first + i;
        uint32_t pixel = (uint32_t)(path % (SIDE * SIDE)), tile = pixel / 64;
        // Blocks of 64 x 64 pixels, tile by tile, all over the image: any part of them shows all of
        // it.
        uint32_t block = tile / 64 * 157 % (SIDE * SIDE / 4096), px = tile % 8 * 8 + pixel % 8;
        uint32_t py = tile / 8 % 8 * 8 + pixel / 8 % 8;
        px += block % (SIDE / 64) * 64;
        py += block / (SIDE / 64) * 64;
        float x = ((float)px + uniform(path, 0)) / SIDE - 0.5f;
        float y = ((float)py + uniform(path, 1)) / SIDE - 0.5f;
        CoVec3 dir = co_madd(co_madd(forward, right, x), up, -y);
        set_ray(&wave->rays[0], i, scene->eye, co_normalize(dir), INFINITY);
        wave->alive[0][i] = 1;
    }
}

static void trace_wave(void *context, size_t begin, size_t end, uint32_t worker)
{
    Wave *wave = context;
    CoTraverseStats stats = {0};
    (void)worker;
    co_accel_kernels(NULL)->traverse(&wave->scene->accel, &wave->rays[wave->bounce], NULL,
                                     &wave->hits, begin * 64, end * 64, true, &stats);
}

// Where a hit lies, on the side that the ray came from, and the normal there.
static CoVec3 surface(const BenchScene *scene, const CoRayBatch *rays, const CoHitBatch *hits,
                      size_t i, CoVec3 *normal)
{
    CoPlacement placement;
    co_accel_placement(&scene->accel, hits->instance[i], &placement);
    const CoMesh *mesh = scene->accel.objects[placement.object].mesh;
    uint32_t points[3];
    CoVec3 corner[3];
    co_mesh_triangle(mesh, hits->tri[i], points);
    for (size_t c = 0; c < 3; c++)
        corner[c] = co_affine_point(&placement.to_world,
                                    co_vec3_load(mesh->points + 3 * (size_t)points[c]));
    CoVec3 n = co_cross(co_sub(corner[1], corner[0]), co_sub(corner[2], corner[0]));
    n = co_normalize(co_dot(n, n) > 0.0f ? n : ray_dir(rays, i));
    *normal = co_dot(n, ray_dir(rays, i)) > 0.0f ? co_neg(n) : n;
    float u = hits->u[i], v = hits->v[i];
    CoVec3 p = co_madd(co_madd(co_scale(corner[0], 1 - u - v), corner[1], u), corner[2], v);
    return co_madd(p, *normal,
                   1e-5f * (1.0f + co_max3(co_vec3(fabsf(p.x), fabsf(p.y), fabsf(p.z)))));
}

static CoVec3 cosine_direction(CoVec3 n, float u, float v)
{
    CoVec3 s, t;
    co_basis(n, &s, &t);
    float phi = 2.0f * CO_PI * u, r = sqrtf(v);
    return co_normalize(
        co_madd(co_madd(co_scale(n, sqrtf(1.0f - v)), s, r * cosf(phi)), t, r * sinf(phi)));
}

static void bounce_rays(void *context, size_t begin, size_t end, uint32_t worker)
{
    Wave *wave = context;
    const BenchScene *scene = wave->scene;
    uint32_t from = wave->bounce, to = from + 1;
    CoVec3 span = co_sub(scene->light_high, scene->light_low);
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        wave->alive[to][i] = wave->alive[from][i] && wave->hits.tri[i] != COHORT_INVALID_ID;
        set_ray(&wave->rays[to], i, scene->eye, scene->up, 0.0f);
        if (!wave->alive[to][i])
            continue;
        uint64_t path = wave->first + i;
        uint32_t what = 8 * to;
        CoVec3 n, p = surface(scene, &wave->rays[from], &wave->hits, i, &n);
        CoVec3 dir = cosine_direction(n, uniform(path, what), uniform(path, what + 1));
        set_ray(&wave->rays[to], i, p, dir, INFINITY);
        CoVec3 place =
            co_vec3(uniform(path, what + 2), uniform(path, what + 3), uniform(path, what + 4));
        CoVec3 light = co_sub(co_add(scene->light_low, co_mul(span, place)), p);
        float distance = co_length(light);
        set_ray(&wave->light[to], i, p, co_scale(light, 1.0f / distance), 0.999f * distance);
    }
}

// Appends what the chunk found, path by path, until the batches are full.
static bool collect(const Wave *wave, BenchRays *out)
{
    size_t others = out->primary.capacity;
    for (size_t i = 0; i < CHUNK; i++) {
        if (out->primary.count < others)
            append(&out->primary, &wave->rays[0], i);
        for (uint32_t k = 1; k <= BOUNCES && wave->alive[k][i]; k++) {
            if (out->light.count < others)
                append(&out->light, &wave->light[k], i);
            if (out->diffuse.count < out->diffuse.capacity)
                append(&out->diffuse, &wave->rays[k], i);
        }
    }
    return out->primary.count == others && out->light.count == others &&
           out->diffuse.count == out->diffuse.capacity;
}

static bool reserve_wave(Wave *wave)
{
    bool is_good = co_hit_batch_reserve(&wave->hits, CHUNK, NULL);
    for (int k = 0; k <= BOUNCES; k++)
        is_good = is_good && co_ray_batch_reserve(&wave->rays[k], CHUNK, NULL) &&
                  co_ray_batch_reserve(&wave->light[k], CHUNK, NULL);
    return is_good;
}

bool bench_rays_make(const BenchScene *scene, size_t diffuse, size_t others, BenchRays *out)
{
    Wave *wave = calloc(1, sizeof *wave);
    *out = (BenchRays){.primary = {.count = 0}};
    bool is_good = wave && reserve_wave(wave) &&
                   co_ray_batch_reserve(&out->primary, others, NULL) &&
                   co_ray_batch_reserve(&out->light, others, NULL) &&
                   co_ray_batch_reserve(&out->diffuse, diffuse, NULL);
    if (wave)
        wave->scene = scene;
    bool is_full = false;
    for (; is_good && !is_full; wave->first += CHUNK) {
        size_t before = out->diffuse.count;
        co_parallel_for(CHUNK, 4096, camera_rays, wave);
        for (wave->bounce = 0; wave->bounce < BOUNCES; wave->bounce++) {
            co_parallel_for(CHUNK / 64, 64, trace_wave, wave);
            co_parallel_for(CHUNK, 4096, bounce_rays, wave);
        }
        is_full = collect(wave, out);
        is_good = is_full || out->diffuse.count > before || before == out->diffuse.capacity;
    }
    for (int k = 0; wave && k <= BOUNCES; k++) {
        co_ray_batch_clear(&wave->rays[k]);
        co_ray_batch_clear(&wave->light[k]);
    }
    if (wave)
        co_hit_batch_clear(&wave->hits);
    free(wave);
    return is_good;
}

void bench_rays_destroy(BenchRays *rays)
{
    co_ray_batch_clear(&rays->primary);
    co_ray_batch_clear(&rays->diffuse);
    co_ray_batch_clear(&rays->light);
}

bool bench_rays_copy(const CoRayBatch *from, size_t count, bool shuffle, CoRayBatch *out)
{
    count = count < from->count ? count : from->count;
    uint32_t *order = malloc(count * sizeof *order);
    if (!order || !co_ray_batch_reserve(out, count, NULL)) {
        free(order);
        return false;
    }
    for (size_t i = 0; i < count; i++)
        order[i] = (uint32_t)i;
    for (size_t i = count - 1; shuffle && i > 0; i--) {
        size_t j = co_hash64(i) % (i + 1);
        uint32_t held = order[i];
        order[i] = order[j];
        order[j] = held;
    }
    for (size_t i = 0; i < count; i++)
        append(out, from, order[i]);
    free(order);
    return true;
}
