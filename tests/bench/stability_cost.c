// Costs of bench_stability: contests of kernels that take turns on the same rays.

#include "plain_kernel.h"
#include "stability.h"
#include "timing.h"

#include <stdio.h>

enum {
    COST_ROUNDS = 15,
    SPHERES = 64,
    SHORT_TURN = 4096 // else what the machine does beside is mistaken for a percent
};

typedef struct CostRow {
    const char *name;
    CoTraverseFn *traverse;
    double seconds[COST_ROUNDS];
    size_t hits;
} CostRow;

// A contest of kernels that take turns on the same rays.
typedef struct Cost {
    const CoAccelScene *scene;
    CoRayBatch rays;
    CoHitBatch hits;
    CostRow *rows;
    uint32_t count;
    bool grouped;
    size_t turn; // rays traced by one kernel before it is another's turn
} Cost;

static void take_turn(Cost *cost, CostRow *row, int round, size_t begin, size_t end)
{
    CoTraverseStats stats = {0};
    double start = bench_seconds(CLOCK_THREAD_CPUTIME_ID);
    row->traverse(cost->scene, &cost->rays, NULL, &cost->hits, begin, end, cost->grouped, &stats);
    if (round >= 0)
        row->seconds[round] += bench_seconds(CLOCK_THREAD_CPUTIME_ID) - start;
    for (size_t i = begin; i < end && round < 0; i++)
        row->hits += cost->hits.tri[i] != COHORT_INVALID_ID;
}

// Each is as often the first to meet rays as any other.
static void take_turns(Cost *cost)
{
    uint32_t first = 0;
    for (int round = -1; round < COST_ROUNDS; round++) {
        for (size_t begin = 0; begin < cost->rays.count; begin += cost->turn, first++) {
            size_t left = cost->rays.count - begin;
            size_t end = begin + (left < cost->turn ? left : cost->turn);
            for (uint32_t k = 0; k < cost->count; k++)
                take_turn(cost, &cost->rows[(first + k) % cost->count], round, begin, end);
        }
    }
}

// Chords of a sphere of a million triangles, ray by ray.
void stability_cost(uint64_t count)
{
    CostRow rows[] = {{.name = "watertight", .traverse = co_accel_kernels("avx2")->traverse},
                      {.name = "float edges, not clamped", .traverse = bench_inexact_avx2},
                      {.name = "Moeller-Trumbore", .traverse = bench_moeller_avx2}};
    TestMesh sphere = mesh_sphere(512, 1.0f, co_vec3_splat(0.0f));
    TestScene scene = {0};
    CoInstance instance = place(scene_add_mesh(&scene, &sphere), co_mat4d_identity());
    scene_add_group(&scene, &instance, 1);
    Cost cost = {&scene.scene, rays_alloc(count), hits_alloc(count), rows, 3, false, count};
    Random random = {5};
    for (size_t i = 0; i < count; i++) {
        CoVec3 org = random_vec3(&random, -0.5f, 0.5f);
        ray_set(&cost.rays, i, org, co_normalize(random_vec3(&random, -1.0f, 1.0f)));
    }
    take_turns(&cost);
    printf(
        "\n| triangle test | ns per ray | watertight over it | rays lost |\n|---|---|---|---|\n");
    for (int k = 0; k < 3; k++) {
        double seconds = bench_median(rows[k].seconds, COST_ROUNDS);
        printf("| %s | %.0f | %.3f | %zu |\n", rows[k].name, 1e9 * seconds / (double)count,
               bench_median(rows[0].seconds, COST_ROUNDS) / seconds, count - rows[k].hits);
    }
    rays_free(&cost.rays);
    hits_free(&cost.hits);
    scene_clear(&scene);
    mesh_free(&sphere);
}

// Bundles of 64 rays, as a group meets them when rays are sorted.
static void make_bundles(CoRayBatch *rays)
{
    Random random = {6};
    CoVec3 from = co_vec3_splat(0.0f), to = from;
    for (size_t i = 0; i < rays->count; i++) {
        if (i % 64 == 0) {
            from = random_vec3(&random, -4.0f, 4.0f);
            to = random_vec3(&random, -4.0f, 4.0f);
        }
        CoVec3 org = co_add(from, random_vec3(&random, -0.1f, 0.1f));
        ray_set(rays, i, org, co_sub(co_add(to, random_vec3(&random, -0.1f, 0.1f)), org));
    }
}

// Spheres, turned: no mesh stands in the group as it is.
static void add_spheres(TestScene *scene, const TestMesh *sphere, CoInstance instances[SPHERES])
{
    uint32_t mesh = scene_add_mesh(scene, sphere);
    for (uint32_t i = 0; i < SPHERES; i++) {
        CoVec3 at = co_vec3((float)(i % 4), (float)(i / 4 % 4), (float)(i / 16));
        at = co_scale(co_sub(at, co_vec3_splat(1.5f)), 2.5f);
        instances[i] = place(mesh, matrix(0.1 * i, co_vec3_splat(1.0f), at));
    }
    scene_add_group(scene, instances, SPHERES);
}

void stability_unused(uint64_t count)
{
    TestMesh sphere = mesh_sphere(128, 1.0f, co_vec3_splat(0.0f));
    TestScene scene = {0};
    CoInstance instances[SPHERES];
    add_spheres(&scene, &sphere, instances);
    CoRayBatch rays = rays_alloc(count);
    CoHitBatch hits = hits_alloc(count);
    make_bundles(&rays);
    printf("\n| kernel | rays | ns per ray | over that without options | hits, without |\n"
           "|---|---|---|---|---|\n");
    for (int k = 0; k < 4; k++) {
        const CoAccelKernels *kernels = co_accel_kernels(k < 2 ? "avx2" : "avx512");
        if (!kernels)
            continue;
        CostRow rows[] = {{.traverse = kernels->traverse},
                          {.traverse = k < 2 ? bench_bare_avx2 : bench_bare_avx512}};
        Cost cost = {&scene.scene, rays, hits, rows, 2, k % 2, SHORT_TURN};
        double ratios[COST_ROUNDS];
        take_turns(&cost);
        for (int i = 0; i < COST_ROUNDS; i++)
            ratios[i] = rows[0].seconds[i] / rows[1].seconds[i];
        printf("| %s | %s | %.0f | %.3f | %zu, %zu |\n", kernels->isa,
               k % 2 ? "in groups" : "one by one",
               1e9 * bench_median(rows[0].seconds, COST_ROUNDS) / (double)count,
               bench_median(ratios, COST_ROUNDS), rows[0].hits, rows[1].hits);
    }
    rays_free(&rays);
    hits_free(&hits);
    scene_clear(&scene);
    mesh_free(&sphere);
}
