#include "stability_cost.h"

#include "../accel/exact.h"
#include "plain_kernel.h"

#include <stdio.h>
#include <time.h>

enum {
    COST_ROUNDS = 9
};

typedef struct CostRow {
    const char *name;
    CoTraverseFn *traverse;
    double seconds[COST_ROUNDS];
    size_t hits;
} CostRow;

static double cpu_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int compare_doubles(const void *a, const void *b)
{
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

// Chords of a sphere of a million triangles, ray by ray: the kernels take turns.
void stability_cost(uint64_t count)
{
    CostRow rows[] = {{.name = "watertight", .traverse = co_accel_kernels("avx2")->traverse},
                      {.name = "float edges, not clamped", .traverse = bench_inexact_avx2},
                      {.name = "Moeller-Trumbore", .traverse = bench_moeller_avx2}};
    enum {
        ROWS = sizeof rows / sizeof *rows
    };
    TestMesh sphere = mesh_sphere(512, 1.0f, co_vec3_splat(0.0f));
    TestScene scene = {0};
    CoInstance instance = place(scene_add_mesh(&scene, &sphere), co_mat4d_identity());
    scene_add_group(&scene, &instance, 1);
    CoRayBatch rays = rays_alloc(count);
    CoHitBatch hits = hits_alloc(count);
    Random random = {5};
    for (size_t i = 0; i < count; i++) {
        CoVec3 org = random_vec3(&random, -0.5f, 0.5f);
        ray_set(&rays, i, org, co_normalize(random_vec3(&random, -1.0f, 1.0f)));
    }
    for (int round = -1; round < COST_ROUNDS; round++) {
        for (int k = 0; k < ROWS; k++) {
            CoTraverseStats stats = {0};
            double start = cpu_seconds();
            rows[k].traverse(&scene.scene, &rays, NULL, &hits, 0, count, false, &stats);
            if (round >= 0)
                rows[k].seconds[round] = cpu_seconds() - start;
            rows[k].hits = 0;
            for (size_t i = 0; i < count; i++)
                rows[k].hits += hits.tri[i] != COHORT_INVALID_ID;
        }
    }
    printf(
        "\n| triangle test | ns per ray | watertight over it | rays lost |\n|---|---|---|---|\n");
    for (int k = 0; k < ROWS; k++)
        qsort(rows[k].seconds, COST_ROUNDS, sizeof(double), compare_doubles);
    for (int k = 0; k < ROWS; k++) {
        double median = rows[k].seconds[COST_ROUNDS / 2];
        printf("| %s | %.0f | %.3f | %zu |\n", rows[k].name, 1e9 * median / (double)count,
               rows[0].seconds[COST_ROUNDS / 2] / median, count - rows[k].hits);
    }
    rays_free(&rays);
    hits_free(&hits);
    scene_clear(&scene);
    mesh_free(&sphere);
}
