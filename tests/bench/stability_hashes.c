// Hashes of bench_stability: hits on slivers and coincident quads, over all kernels and two trees.

#include "base/parallel.h"
#include "stability.h"

#include <inttypes.h>
#include <stdio.h>

enum {
    TREES = 2, // over the same triangles
    HASH_COLUMNS = 2 * TEST_ISA_COUNT * TREES
};

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

bool stability_hashes(const StabilityRun *numbers)
{
    static HashRun run;
    TestMesh strewn[TREES];
    run.mesh = mesh_slivers_and_quads();
    run.first_block = numbers->first_block;
    for (uint32_t i = 0; i < TREES; i++) {
        strewn[i] = mesh_strewn(&run.mesh, 900 * i, i);
        run.instances[i] = place(scene_add_mesh(&run.scenes[i], &strewn[i]), co_mat4d_identity());
        scene_add_group(&run.scenes[i], &run.instances[i], 1);
    }
    size_t blocks = stability_blocks(numbers->rays);
    co_parallel_for(blocks, 1, hash_blocks, &run);
    bool is_same = print_hashes(&run, blocks * BLOCK);
    for (uint32_t i = 0; i < TREES; i++) {
        scene_clear(&run.scenes[i]);
        mesh_free(&strewn[i]);
    }
    mesh_free(&run.mesh);
    return is_same;
}
