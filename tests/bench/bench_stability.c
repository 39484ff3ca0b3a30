// Billions of hard rays: leaks and false hits at shared edges and vertices of closed meshes, beside
// Embree where it is installed; hashes of hits on slivers and coincident quads over all kernels;
// random triangles against a brute-force search in double.
//
// Not a test: prints tables for docs/stability.md.
// Usage: bench_stability [--rays N] [--embree-rays N] [--case NAME] [--first-block N]
//   --rays: of each case (10 million; Embree 1 million); soups and hashes: a tenth,
//     cost, unused: a twentieth
//   --first-block: rays come in blocks of 16,384, numbered; other blocks are other rays
//
// Leak: a ray that starts inside a closed mesh and meets nothing. False hit: the ray's line passes
// the triangle it is said to meet by more than 4 units in the last place of the largest coordinate
// of the triangle as seen from the ray's origin, in double.

#include "../accel/exact.h"
#include "base/parallel.h"
#include "stability_cost.h"

#include <getopt.h>
#include <inttypes.h>
#include <stdio.h>

#ifdef BENCH_EMBREE
#include <embree3/rtcore.h>
#include <float.h>
#endif

enum {
    BLOCK = 1 << 14, // rays made, traced and judged at a time
    WORKERS_MAX = 64,
    TREES = 2, // over the same triangles
    HASH_COLUMNS = 2 * TEST_ISA_COUNT * TREES
};

#define FALSE_HIT_ULPS 4.0

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

typedef struct Score {
    uint64_t rays, leaks, false_hits;
    double worst_ulps; // by which a line passes the triangle it is said to meet
} Score;

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

#ifdef BENCH_EMBREE
static RTCScene embree_scene(const TestMesh *mesh)
{
    RTCScene scene = rtcNewScene(rtcNewDevice("threads=1"));
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(rtcGetSceneDevice(scene), RTC_GEOMETRY_TYPE_TRIANGLE);
    float *points = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                            12, mesh->mesh.point_count);
    uint32_t *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0,
                                                RTC_FORMAT_UINT3, 12, mesh->mesh.tri_count);
    memcpy(points, mesh->points, 12 * (size_t)mesh->mesh.point_count);
    memcpy(indices, mesh->indices, 12 * (size_t)mesh->mesh.tri_count);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcCommitScene(scene);
    return scene;
}

static void trace_embree(RTCScene scene, const CoRayBatch *rays, CoHitBatch *hits)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (size_t i = 0; i < BLOCK; i++) {
        struct RTCRayHit r = {{rays->org_x[i], rays->org_y[i], rays->org_z[i], 0.0f, rays->dir_x[i],
                               rays->dir_y[i], rays->dir_z[i], 0.0f, INFINITY, ~0u, 0, 0},
                              {0, 0, 0, 0, 0, ~0u, ~0u, {~0u}}};
        rtcIntersect1(scene, &context, &r);
        hits->tri[i] = r.hit.primID;
    }
}
#endif

static void trace(const Run *run, const CoRayBatch *rays, CoHitBatch *hits)
{
#ifdef BENCH_EMBREE
    if (run->embree) {
        trace_embree(run->embree, rays, hits);
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
    Score sum = {0};
    co_parallel_for((size_t)((count + BLOCK - 1) / BLOCK), 1, run_blocks, run);
    for (uint32_t i = 0; i < WORKERS_MAX; i++) {
        Score *score = &run->scores[i];
        sum.rays += score->rays;
        sum.leaks += score->leaks;
        sum.false_hits += score->false_hits;
        sum.worst_ulps = fmax(sum.worst_ulps, score->worst_ulps);
        if (run->rays[i].capacity) {
            rays_free(&run->rays[i]);
            hits_free(&run->hits[i]);
        }
        run->rays[i].capacity = 0;
        *score = (Score){0};
    }
    return sum;
}

static void print_score(const char *name, const char *who, Score score)
{
    printf("| %s | %s | %.3g | %" PRIu64 " | %" PRIu64 " | %.2f |\n", name, who, (double)score.rays,
           score.leaks, score.false_hits, score.worst_ulps);
    fflush(stdout);
}

static bool run_case(const Case *it, uint64_t first_block, uint64_t rays, uint64_t embree_rays)
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
    run.first_block = first_block;
    run.scene = &scene;
    run.kernels = co_accel_kernels(NULL);
    Score own = run_rays(&run, rays);
    print_score(it->name, run.kernels->isa, own);
#ifdef BENCH_EMBREE
    run.embree = embree_scene(&mesh);
    // Debian's Embree stops the program at directions that it takes for invalid.
    if (embree_rays && !(it->dir_lo < it->dir_hi))
        print_score(it->name, "Embree, robust", run_rays(&run, embree_rays));
    rtcReleaseScene(run.embree);
#else
    (void)embree_rays;
#endif
    scene_clear(&scene);
    mesh_free(&mesh);
    return own.leaks == 0 && own.false_hits == 0;
}

// ---- Random triangles
// ------------------------------------------------------------------------------

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
static bool run_soup_case(uint64_t first_block, uint64_t rays)
{
    static Run run;
    run.first_block = first_block;
    run.kernels = co_accel_kernels(NULL);
    Score sum = {0};
    co_parallel_for((size_t)((rays + BLOCK - 1) / BLOCK), 1, run_soups, &run);
    for (uint32_t i = 0; i < WORKERS_MAX; i++) {
        sum.rays += run.scores[i].rays;
        sum.leaks += run.scores[i].leaks;
        sum.false_hits += run.scores[i].false_hits;
        sum.worst_ulps = fmax(sum.worst_ulps, run.scores[i].worst_ulps);
    }
    print_score("soups", run.kernels->isa, sum);
    return sum.leaks == 0 && sum.false_hits == 0;
}

// ---- Hits as hashes
// ------------------------------------------------------------------------------

static uint64_t hash_hits(uint64_t hash, const CoHitBatch *hits)
{
    for (size_t i = 0; i < BLOCK; i++) {
        uint32_t bits[3];
        memcpy(&bits[0], &hits->t[i], 4);
        memcpy(&bits[1], &hits->u[i], 4);
        memcpy(&bits[2], &hits->v[i], 4);
        hash = co_hash64(hash ^ bits[0] ^ (uint64_t)bits[1] << 32);
        hash = co_hash64(hash ^ bits[2] ^ (uint64_t)hits->tri[i] << 32);
    }
    return hash;
}

// Ten coincident copies of each of the quads of a small sheet, then the slivers.
static TestMesh mesh_slivers_and_quads(void)
{
    enum {
        QUADS = 64,
        COPIES = 10
    };
    TestMesh slivers = mesh_slivers(3);
    uint32_t first_point = slivers.mesh.point_count, first_tri = slivers.mesh.tri_count;
    TestMesh m = mesh_alloc(first_point + 4 * QUADS, first_tri + 2 * QUADS * COPIES);
    memcpy(m.points, slivers.points, 3 * sizeof(float) * first_point);
    memcpy(m.indices, slivers.indices, 3 * sizeof(uint32_t) * first_tri);
    for (uint32_t q = 0; q < QUADS; q++) {
        for (uint32_t c = 0; c < 4; c++) {
            float *p = m.points + 3 * (size_t)(first_point + 4 * q + c);
            p[0] = (float)(q % 8 + (c == 1 || c == 2)) / 4.0f - 1.0f;
            p[1] = (float)(q / 8 + (c >= 2)) / 4.0f - 1.0f;
        }
        for (uint32_t copy = 0; copy < COPIES; copy++) {
            uint32_t a = first_point + 4 * q, tri = first_tri + 2 * (copy * QUADS + q);
            uint32_t quad[2][3] = {{a, a + 1, a + 2}, {a, a + 2, a + 3}};
            memcpy(m.indices + 3 * (size_t)tri, quad, sizeof quad);
        }
    }
    mesh_free(&slivers);
    mesh_box(&m);
    return m;
}

// Other trees over the same triangles: points strewn among them as triangles without area, which
// are never hit, move every split.
static TestMesh mesh_strewn(const TestMesh *mesh, uint32_t strewn, uint64_t seed)
{
    Random random = {seed};
    uint32_t points = mesh->mesh.point_count, tris = mesh->mesh.tri_count;
    TestMesh m = mesh_alloc(points, tris + strewn);
    memcpy(m.points, mesh->points, 3 * sizeof(float) * points);
    memcpy(m.indices, mesh->indices, 3 * sizeof(uint32_t) * tris);
    for (uint32_t i = tris; i < tris + strewn; i++) {
        uint32_t point = random_bits(&random) % SLIVERS;
        for (uint32_t c = 0; c < 3; c++)
            m.indices[3 * (size_t)i + c] = point;
    }
    mesh_box(&m);
    return m;
}

typedef struct HashRun {
    TestMesh mesh;
    TestScene scenes[TREES];
    CoInstance instances[TREES];
    uint64_t first_block;
    uint64_t sums[WORKERS_MAX][HASH_COLUMNS]; // of the blocks' hashes: any order gives the same
} HashRun;

static void hash_blocks(void *context, size_t begin, size_t end, uint32_t worker)
{
    HashRun *run = context;
    CoHitBatch hits = hits_alloc(BLOCK);
    for (size_t block = begin; block < end; block++) {
        uint64_t number = run->first_block + block;
        CoRayBatch rays = rays_along_slivers(&run->mesh, SLIVERS, BLOCK, number << 20);
        for (int k = 0; k < HASH_COLUMNS; k++) {
            const CoAccelKernels *kernels = co_accel_kernels(test_isas[k / 2 % TEST_ISA_COUNT]);
            const CoAccelScene *scene = &run->scenes[k / (2 * TEST_ISA_COUNT)].scene;
            CoTraverseStats stats = {0};
            if (!kernels)
                continue;
            kernels->traverse(scene, &rays, NULL, &hits, 0, BLOCK, k % 2, &stats);
            run->sums[worker][k] += hash_hits(number, &hits);
        }
        rays_free(&rays);
    }
    hits_free(&hits);
}

static bool print_hashes(const HashRun *run, uint64_t rays)
{
    bool is_same = true;
    uint64_t first = 0;
    printf("\n| kernel | tree | rays | hash of all hits |\n|---|---|---|---|\n");
    for (int k = 0; k < HASH_COLUMNS; k++) {
        uint64_t sum = 0;
        for (int worker = 0; worker < WORKERS_MAX; worker++)
            sum += run->sums[worker][k];
        if (!co_accel_kernels(test_isas[k / 2 % TEST_ISA_COUNT]))
            continue;
        first = k ? first : sum;
        is_same = is_same && sum == first;
        printf("| %s, %s | %d | %.4g | %016" PRIx64 " |\n", test_isas[k / 2 % TEST_ISA_COUNT],
               k % 2 ? "groups" : "single", 1 + k / (2 * TEST_ISA_COUNT), (double)rays, sum);
    }
    return is_same;
}

// The same rays through every kernel and tree, grouped and single. Prints one row each; false when
// hashes differ.
static bool run_hashes(uint64_t first_block, uint64_t count)
{
    static HashRun run;
    TestMesh strewn[TREES];
    run.mesh = mesh_slivers_and_quads();
    run.first_block = first_block;
    for (uint32_t i = 0; i < TREES; i++) {
        strewn[i] = mesh_strewn(&run.mesh, 900 * i, i);
        run.instances[i] = place(scene_add_mesh(&run.scenes[i], &strewn[i]), co_mat4d_identity());
        scene_add_group(&run.scenes[i], &run.instances[i], 1);
    }
    uint64_t blocks = (count + BLOCK - 1) / BLOCK;
    co_parallel_for((size_t)blocks, 1, hash_blocks, &run);
    bool is_same = print_hashes(&run, blocks * BLOCK);
    for (uint32_t i = 0; i < TREES; i++) {
        scene_clear(&run.scenes[i]);
        mesh_free(&strewn[i]);
    }
    mesh_free(&run.mesh);
    return is_same;
}

static bool is_named(const char *name, const char *want)
{
    return !want || strcmp(name, want) == 0;
}

int main(int argc, char **argv)
{
    const struct option options[] = {{"rays", required_argument, NULL, 'r'},
                                     {"embree-rays", required_argument, NULL, 'e'},
                                     {"case", required_argument, NULL, 'c'},
                                     {"first-block", required_argument, NULL, 'f'},
                                     {NULL, 0, NULL, 0}};
    uint64_t rays = 10000000, embree_rays = 1000000, first_block = 0;
    const char *only = NULL;
    for (int c; (c = getopt_long(argc, argv, "", options, NULL)) != -1;) {
        if (c == 'r')
            rays = strtoull(optarg, NULL, 10);
        else if (c == 'e')
            embree_rays = strtoull(optarg, NULL, 10);
        else if (c == 'f')
            first_block = strtoull(optarg, NULL, 10);
        else if (c == 'c')
            only = optarg;
        else
            return 2;
    }
    bool is_clean = true;
    printf(
        "| case | who | rays | leaks | false hits | farthest, ulps |\n|---|---|---|---|---|---|\n");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        if (is_named(cases[i].name, only))
            is_clean &= run_case(&cases[i], first_block, rays, embree_rays);
    if (is_named("soups", only))
        is_clean &= run_soup_case(first_block, rays / 10);
#ifdef BENCH_PLAIN
    if (is_named("cost", only) && co_accel_kernels("avx2"))
        stability_cost(rays / 20);
    if (is_named("unused", only) && co_accel_kernels("avx2"))
        stability_unused(rays / 20);
#endif
    if (is_named("hashes", only))
        is_clean &= run_hashes(first_block, rays / 10);
    return is_clean ? 0 : 1;
}
