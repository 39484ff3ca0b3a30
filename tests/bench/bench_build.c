// Trees: triangles built per second, surface-area cost, bytes and peak, beside Embree's medium
// quality where that is installed, in alternated runs; then what a ray visits, from ten thousand
// triangles on. Not a test: prints numbers.

#include "accel/build.h"
#include "arguments.h"
#include "base/clock.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "build_figures.h"
#include "build_meshes.h"
#include "timing.h"

#include <stdio.h>

enum {
    VISITS = 20000 // rays
};

static const char usage[] =
    "usage: bench_build [THOUSANDS [ROUNDS [THREADS [MOST]]]]\n"
    "  THOUSANDS  of triangles (1000)\n"
    "  ROUNDS     the best of which counts (5)\n"
    "  THREADS    (2)\n"
    "  MOST       thousands of triangles among which visits are counted (1000)\n"
    "With other work on the machine, OMP_WAIT_POLICY=passive in the environment keeps waiting\n"
    "threads from taking part.\n";

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

static void run_own(const CoMesh *mesh, Figures *out)
{
    double start = co_clock_seconds(), cpu = bench_seconds(CLOCK_PROCESS_CPUTIME_ID);
    CoBvh *bvh = co_bvh_create(mesh, NULL);
    out->seconds = fmin(out->seconds, co_clock_seconds() - start);
    out->cpu = fmin(out->cpu, bench_seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu);
    out->bytes = (double)co_bvh_bytes(bvh);
    out->peak = (double)co_memory_peak(CO_MEMORY_ACCEL);
    out->cost = cost_of(&bvh->tree);
    co_bvh_destroy(bvh);
}

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
        build_embree(&mesh, threads, &embree);
#endif
    }
    print_figures("cohort", mesh.tri_count, &own);
#ifdef BENCH_EMBREE
    embree.cost = build_embree_cost(&mesh);
    print_figures("embree", mesh.tri_count, &embree);
    printf("  embree's time by ours %.2f, CPU time %.2f, our sah by embree's %.3f\n",
           embree.seconds / own.seconds, embree.cpu / own.cpu, sah(own.cost) / sah(embree.cost));
#endif
    bench_mesh_free(&mesh);
}

// Rays between points of a ball twice as large, most of which meet the mesh.
static CoRayBatch make_rays(Random *random)
{
    CoRayBatch rays = rays_alloc(VISITS);
    for (size_t i = 0; i < VISITS; i++) {
        CoVec3 from = co_scale(co_normalize(random_vec3(random, -1, 1)), 2.0f);
        ray_set(&rays, i, from, co_sub(random_vec3(random, -0.5f, 0.5f), from));
    }
    return rays;
}

static void count_visits(const char *title, CoMesh mesh, Random *random)
{
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
    CoRayBatch rays = make_rays(random);
    CoHitBatch hits = hits_alloc(VISITS);
    CoTraverseStats stats;
    double least = (double)INFINITY;
    for (int pass = 0; pass < 5; pass++) {
        double start = bench_seconds(CLOCK_THREAD_CPUTIME_ID);
        memset(&stats, 0, sizeof stats);
        co_accel_kernels(NULL)->traverse(&scene, &rays, NULL, &hits, 0, VISITS, false, &stats);
        least = fmin(least, bench_seconds(CLOCK_THREAD_CPUTIME_ID) - start);
    }
    printf(
        "  %-9s %9u triangles: %6.2f nodes, %6.2f triangle tests, %.0f ns per ray, %.1f bytes per "
        "triangle\n",
        title, mesh.tri_count, (double)stats.bottom_nodes / VISITS,
        (double)stats.triangles / VISITS, 1e9 * least / VISITS,
        (double)co_bvh_bytes(objects[0].bvh) / mesh.tri_count);
    fflush(stdout);
    co_top_destroy((CoTop *)(uintptr_t)objects[1].top);
    co_bvh_destroy((CoBvh *)(uintptr_t)objects[0].bvh);
#ifdef BENCH_EMBREE
    printf("  embree, robust: %.0f ns per ray\n", build_embree_trace(&mesh, &rays));
    fflush(stdout);
#endif
    bench_mesh_free(&mesh);
    rays_free(&rays);
    hits_free(&hits);
}

int main(int argc, char **argv)
{
    double thousands = 1000, rounds = 5, threads = 2, most = 1000;
    const BenchArgument arguments[] = {
        {.name = "THOUSANDS", .number = &thousands, .least = 1, .most = 1e6},
        {.name = "ROUNDS", .number = &rounds, .least = 1, .most = 1000},
        {.name = "THREADS", .number = &threads, .least = 1, .most = 64},
        {.name = "MOST", .number = &most, .most = 1e6}};
    bench_arguments_read(argc, argv, usage, arguments, sizeof arguments / sizeof *arguments);
    bench_tell_of_embree();
    uint32_t tris = 1000u * (uint32_t)thousands;
    Random random = {1};
    run("ball", bench_mesh_ball(tris), (int)rounds, (uint32_t)threads);
    run("ball, shuffled", bench_mesh_shuffled(bench_mesh_ball(tris), &random), (int)rounds,
        (uint32_t)threads);
    // Of ascending peaks, which are those of the process so far.
    run("house", bench_mesh_house(tris), (int)rounds, (uint32_t)threads);
    run("soup", bench_mesh_soup(tris, 1.0f, &random), (int)rounds, (uint32_t)threads);
    run("splinters", bench_mesh_soup(tris, 30.0f, &random), (int)rounds, (uint32_t)threads);
    run("splinters, turned", bench_mesh_turned(tris, 30.0f, &random), (int)rounds,
        (uint32_t)threads);
    printf("visits\n");
    for (double n = 10; n <= most; n *= 10)
        count_visits("ball", bench_mesh_ball(1000u * (uint32_t)n), &random);
    count_visits("soup", bench_mesh_soup(tris, 1.0f, &random), &random);
    count_visits("splinters", bench_mesh_soup(tris, 30.0f, &random), &random);
    count_visits("turned", bench_mesh_turned(tris, 30.0f, &random), &random);
    count_visits("house", bench_mesh_house(tris), &random);
    return 0;
}
