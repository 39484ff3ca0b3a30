// Rays of bench_stability at edges and vertices of closed meshes.

#include "base/parallel.h"
#include "stability.h"

#ifdef BENCH_EMBREE
#include "embree_mesh.h"
#endif

typedef enum Target {
    TARGET_EDGES,    // three of four: a point of an edge; else its first vertex
    TARGET_VERTICES, // vertices alone
    TARGET_AXES      // along an axis, at lines and points of the box's lattice
} Target;

typedef struct Case {
    const char *name;
    Target target;
    CoVec3 scale;
    float offset;         // of the mesh, in radii (of the largest scale), along (1, -2, 0.5)
    float dir_lo, dir_hi; // exponents of ten of the directions' length; 0, 0: as aimed or unit
} Case;

static const Case cases[] = {
    {"edges", TARGET_EDGES, {1, 1, 1}, 0, 0, 0},
    {"vertices", TARGET_VERTICES, {1, 1, 1}, 0, 0, 0},
    {"moved 1e4 radii", TARGET_EDGES, {1, 1, 1}, 1e4f, 0, 0},
    {"moved 1e6 radii", TARGET_EDGES, {1, 1, 1}, 1e6f, 0, 0},
    {"scaled 1e-6", TARGET_EDGES, {1e-6f, 1e-6f, 1e-6f}, 0, 0, 0},
    {"scaled 1e7", TARGET_EDGES, {1e7f, 1e7f, 1e7f}, 0, 0, 0},
    {"slivers 1e6:1", TARGET_EDGES, {1, 1e-6f, 1}, 0, 0, 0},
    {"slivers, vertices", TARGET_VERTICES, {1, 1e-6f, 1}, 0, 0, 0},
    {"box along the axes", TARGET_AXES, {1, 1, 1}, 0, 0, 0},
    {"directions 1e-30 to 1e30", TARGET_EDGES, {1, 1, 1}, 0, -30, 30},
    {"denormal directions", TARGET_EDGES, {1, 1, 1}, 0, -44, -38},
    {"denormal mesh", TARGET_EDGES, {1e-38f, 1e-38f, 1e-38f}, 0, 0, 0},
};

typedef struct Run {
    const Case *it;
    const TestMesh *mesh;
    CoVec3 center;
    uint64_t first_block; // rays of a block depend on its number alone
    TestScene *scene;
    const CoAccelKernels *kernels;
#ifdef BENCH_EMBREE
    RTCScene embree; // NULL: Cohort
#endif
    CoRayBatch rays[WORKERS_MAX];
    CoHitBatch hits[WORKERS_MAX];
    Score scores[WORKERS_MAX];
} Run;

// A box of n x n quads a side, all points shared: lattice points of the surface by number.
static TestMesh mesh_box_lattice(uint32_t n)
{
    uint32_t side = n + 1, used = 0, tri = 0;
    uint32_t *ids = malloc(sizeof *ids * side * side * side);
    TestMesh m = mesh_alloc(side * side * side, 12 * n * n);
    for (uint32_t i = 0; i < side * side * side; i++) {
        uint32_t at[3] = {i % side, i / side % side, i / side / side};
        bool is_surface = false;
        for (int k = 0; k < 3; k++)
            is_surface |= at[k] == 0 || at[k] == n;
        if (!is_surface)
            continue;
        for (int k = 0; k < 3; k++)
            m.points[3 * used + (uint32_t)k] = -1.0f + 2.0f * (float)at[k] / (float)n;
        ids[i] = used++;
    }
    m.mesh.point_count = used;
    const uint32_t step[3] = {1, side, side * side};
    for (uint32_t f = 0; f < 6; f++) {
        uint32_t a = step[(f / 2 + 1) % 3], b = step[(f / 2 + 2) % 3];
        for (uint32_t q = 0; q < n * n; q++) {
            uint32_t at = (f % 2 ? n * step[f / 2] : 0) + q % n * a + q / n * b;
            uint32_t quad[2][3] = {{ids[at], ids[at + a], ids[at + a + b]},
                                   {ids[at], ids[at + a + b], ids[at + b]}};
            memcpy(m.indices + 3 * (size_t)tri, quad, sizeof quad);
            tri += 2;
        }
    }
    free(ids);
    mesh_box(&m);
    return m;
}

static CoVec3 case_center(const Case *it)
{
    float radius = fmaxf(it->scale.x, fmaxf(it->scale.y, it->scale.z));
    return co_scale(co_vec3(1.0f, -2.0f, 0.5f), it->offset * radius);
}

static TestMesh case_mesh(const Case *it)
{
    TestMesh m = it->target == TARGET_AXES ? mesh_box_lattice(8)
                                           : mesh_sphere(96, 1.0f, co_vec3_splat(0.0f));
    CoVec3 center = case_center(it);
    for (uint32_t i = 0; i < m.mesh.point_count; i++) {
        CoVec3 p = co_vec3_load(m.points + 3 * (size_t)i);
        co_vec3_store(m.points + 3 * (size_t)i, co_add(co_mul(p, it->scale), center));
    }
    mesh_box(&m);
    return m;
}

// At a line of the lattice or, half the time, at a point of it.
static void aim_along_axes(Random *random, CoVec3 *org, CoVec3 *dir)
{
    float at[3], along[3] = {0.0f, -0.0f, 0.0f};
    uint32_t bits = random_bits(random), axis = bits % 3, loose = (axis + 1 + (bits >> 8) % 2) % 3;
    for (int k = 0; k < 3; k++)
        at[k] = (float)(random_bits(random) % 9) / 4.0f - 1.0f;
    if (bits >> 16 & 1)
        at[loose] = random_float(random, -1.0f, 1.0f);
    along[axis] = bits >> 17 & 1 ? 1.0f : -1.0f;
    at[axis] = random_float(random, -0.9f, 0.9f);
    *org = co_vec3_load(at);
    *dir = co_vec3_load(along);
}

static void aim_at_mesh(const Run *run, Random *random, CoVec3 *org, CoVec3 *dir)
{
    const Case *it = run->it;
    const uint32_t *tri =
        run->mesh->indices + 3 * (random_bits(random) % run->mesh->mesh.tri_count);
    uint32_t c = random_bits(random);
    CoVec3 a = co_vec3_load(run->mesh->points + 3 * (size_t)tri[c % 3]);
    CoVec3 b = co_vec3_load(run->mesh->points + 3 * (size_t)tri[(c + 1) % 3]);
    bool is_vertex = it->target == TARGET_VERTICES || (c >> 8) % 4 == 0;
    float w = is_vertex ? 0.0f : random_float(random, 0.0f, 1.0f);
    *org = run->center;
    if ((c >> 16) % 3)
        *org = co_add(run->center, co_mul(it->scale, random_vec3(random, -0.3f, 0.3f)));
    *dir = co_sub(co_lerp3(a, b, w), *org);
    if (it->dir_lo < it->dir_hi) {
        // In double: the length of so short a direction is none in float.
        double length = sqrt((double)co_dot(*dir, *dir));
        double to = pow(10.0, (double)random_float(random, it->dir_lo, it->dir_hi)) / length;
        *dir = co_vec3((float)((double)dir->x * to), (float)((double)dir->y * to),
                       (float)((double)dir->z * to));
    } else if ((c >> 24) % 2 && co_dot(*dir, *dir) > 1e-30f) {
        *dir = co_normalize(*dir);
    }
}

static void make_rays(const Run *run, CoRayBatch *rays, uint64_t first)
{
    Random random = {first << 24}; // no two blocks share a number
    for (size_t i = 0; i < BLOCK; i++) {
        CoVec3 org, dir = co_vec3_splat(0.0f);
        // A direction may round to nothing among denormals: no ray.
        while (!(fabsf(dir.x) + fabsf(dir.y) + fabsf(dir.z) > 0.0f)) {
            if (run->it->target == TARGET_AXES)
                aim_along_axes(&random, &org, &dir);
            else
                aim_at_mesh(run, &random, &org, &dir);
        }
        ray_set(rays, i, org, dir);
    }
}

static void trace(const Run *run, const CoRayBatch *rays, CoHitBatch *hits)
{
#ifdef BENCH_EMBREE
    if (run->embree) {
        struct RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        for (size_t i = 0; i < BLOCK; i++)
            hits->tri[i] = embree_intersect(run->embree, &context, rays, i);
        return;
    }
#endif
    CoTraverseStats stats = {0};
    run->kernels->traverse(&run->scene->scene, rays, NULL, hits, 0, BLOCK, true, &stats);
}

static void run_blocks(void *context, size_t begin, size_t end, uint32_t worker)
{
    Run *run = context;
    CoRayBatch *rays = &run->rays[worker];
    CoHitBatch *hits = &run->hits[worker];
    Score *score = &run->scores[worker];
    if (!rays->capacity) {
        *rays = rays_alloc(BLOCK);
        *hits = hits_alloc(BLOCK);
    }
    for (size_t block = begin; block < end; block++) {
        make_rays(run, rays, run->first_block + block);
        trace(run, rays, hits);
        for (size_t i = 0; i < BLOCK; i++) {
            if (hits->tri[i] == COHORT_INVALID_ID) {
                score->leaks++;
                continue;
            }
            double ulps = miss_ulps(run->mesh, hits->tri[i], rays, i);
            score->false_hits += ulps > FALSE_HIT_ULPS;
            score->worst_ulps = fmax(score->worst_ulps, ulps);
        }
        score->rays += BLOCK;
    }
}

static Score run_rays(Run *run, uint64_t count)
{
    co_parallel_for(stability_blocks(count), 1, run_blocks, run);
    Score sum = stability_sum(run->scores);
    for (uint32_t i = 0; i < WORKERS_MAX; i++) {
        if (run->rays[i].capacity) {
            rays_free(&run->rays[i]);
            hits_free(&run->hits[i]);
        }
        run->rays[i].capacity = 0;
        run->scores[i] = (Score){0};
    }
    return sum;
}

static bool run_case(const Case *it, const StabilityRun *numbers)
{
    static Run run;
    TestMesh mesh = case_mesh(it);
    TestScene scene = {0};
    CoInstance instance = place(scene_add_mesh(&scene, &mesh), co_mat4d_identity());
    scene_add_group(&scene, &instance, 1);
    memset(&run, 0, sizeof run);
    run.it = it;
    run.mesh = &mesh;
    run.center = case_center(it);
    run.first_block = numbers->first_block;
    run.scene = &scene;
    run.kernels = co_accel_kernels(NULL);
    Score own = run_rays(&run, numbers->rays);
    stability_print(it->name, run.kernels->isa, own);
#ifdef BENCH_EMBREE
    RTCDevice device = rtcNewDevice("threads=1");
    run.embree = embree_scene_of(device, embree_triangles(device, &mesh.mesh));
    rtcCommitScene(run.embree);
    // Debian's Embree stops the program at directions that it takes for invalid.
    if (numbers->embree_rays && !(it->dir_lo < it->dir_hi))
        stability_print(it->name, "Embree, robust", run_rays(&run, numbers->embree_rays));
    rtcReleaseScene(run.embree);
    rtcReleaseDevice(device);
#endif
    scene_clear(&scene);
    mesh_free(&mesh);
    return own.leaks == 0 && own.false_hits == 0;
}

bool stability_is_case(const char *name)
{
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        if (strcmp(cases[i].name, name) == 0)
            return true;
    return false;
}

bool stability_edges(const char *only, const StabilityRun *run)
{
    bool is_clean = true;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        if (!only || strcmp(cases[i].name, only) == 0)
            is_clean = run_case(&cases[i], run) && is_clean;
    return is_clean;
}
