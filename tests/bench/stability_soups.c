// Soups of bench_stability: 48 triangles each, every hit judged against all of them.

#include "base/parallel.h"
#include "stability.h"

typedef struct Run {
    uint64_t first_block;
    const CoAccelKernels *kernels;
    Score scores[WORKERS_MAX];
} Run;

// Soups of 48 triangles, one per block of rays, each hit judged against all of them in double.
static void run_soups(void *context, size_t begin, size_t end, uint32_t worker)
{
    Run *run = context;
    Score *score = &run->scores[worker];
    CoRayBatch rays = rays_alloc(BLOCK);
    CoHitBatch hits = hits_alloc(BLOCK);
    CoTraverseStats stats = {0};
    for (size_t block = begin; block < end; block++) {
        Random random = {(run->first_block + block) << 24};
        TestMesh soup = mesh_soup(48, block % 2 ? 0.1f : 1.0f, random.state);
        TestScene scene = {0};
        CoInstance instance = place(scene_add_mesh(&scene, &soup), co_mat4d_identity());
        scene_add_group(&scene, &instance, 1);
        for (size_t i = 0; i < BLOCK; i++) {
            CoVec3 org = random_vec3(&random, -2.0f, 2.0f);
            ray_set(&rays, i, org, co_sub(random_vec3(&random, -1.0f, 1.0f), org));
        }
        run->kernels->traverse(&scene.scene, &rays, NULL, &hits, 0, BLOCK, block % 3, &stats);
        for (size_t i = 0; i < BLOCK; i++) {
            ExactVerdict verdict = exact_judge(&soup, &rays, &hits, i);
            score->leaks += !verdict.is_nearest;
            score->false_hits += verdict.miss_ulps > FALSE_HIT_ULPS;
            score->worst_ulps = fmax(score->worst_ulps, verdict.t_ulps);
        }
        score->rays += BLOCK;
        scene_clear(&scene);
        mesh_free(&soup);
    }
    rays_free(&rays);
    hits_free(&hits);
}

// Here a leak is a hit that is not the nearest, and what is farthest is the distance from the
// plane.
bool stability_soups(const StabilityRun *numbers)
{
    static Run run;
    run.first_block = numbers->first_block;
    run.kernels = co_accel_kernels(NULL);
    co_parallel_for(stability_blocks(numbers->rays), 1, run_soups, &run);
    Score sum = stability_sum(run.scores);
    stability_print("soups", run.kernels->isa, sum);
    return sum.leaks == 0 && sum.false_hits == 0;
}
