#include "build_meshes.h"

#include <string.h>

static CoMesh mesh_alloc(size_t points, size_t tris)
{
    CoMesh mesh = {.points = malloc(12 * points), .indices = malloc(12 * tris)};
    mesh.point_count = (uint32_t)points;
    mesh.tri_count = (uint32_t)tris;
    return mesh;
}

CoMesh bench_mesh_ball(uint32_t tris)
{
    uint32_t n = (uint32_t)sqrt(tris / 2.0);
    CoMesh mesh = mesh_alloc((size_t)(n + 1) * (n + 1), 2 * (size_t)n * n);
    float *points = (float *)(uintptr_t)mesh.points;
    uint32_t *indices = (uint32_t *)(uintptr_t)mesh.indices;
    for (uint32_t i = 0; i <= n; i++) {
        for (uint32_t j = 0; j <= n; j++) {
            float theta = CO_PI * (float)i / (float)n, phi = 2.0f * CO_PI * (float)j / (float)n;
            float r = 1.0f + 0.05f * sinf(41.0f * theta) * sinf(29.0f * phi);
            co_vec3_store(
                points + 3 * ((size_t)i * (n + 1) + j),
                co_vec3(r * sinf(theta) * cosf(phi), r * cosf(theta), r * sinf(theta) * sinf(phi)));
        }
    }
    for (uint32_t q = 0; q < n * n; q++) {
        uint32_t a = q / n * (n + 1) + q % n;
        uint32_t quad[6] = {a, a + 1, a + n + 2, a, a + n + 2, a + n + 1};
        memcpy(indices + 6 * (size_t)q, quad, sizeof quad);
    }
    return mesh;
}

CoMesh bench_mesh_soup(uint32_t tris, float stretch, Random *random)
{
    CoMesh mesh = mesh_alloc(3 * (size_t)tris, tris);
    float *points = (float *)(uintptr_t)mesh.points, size = 1.0f / cbrtf((float)tris);
    uint32_t *indices = (uint32_t *)(uintptr_t)mesh.indices;
    for (uint32_t i = 0; i < 3 * tris; i++)
        indices[i] = i;
    for (uint32_t i = 0; i < tris; i++) {
        float center[3] = {random_float(random, -1, 1), random_float(random, -1, 1),
                           random_float(random, -1, 1)};
        for (uint32_t c = 0; c < 9; c++)
            points[9 * (size_t)i + c] = center[c % 3] + (c % 3 == i % 3 ? stretch : 1.0f) * size *
                                                            random_float(random, -1, 1);
    }
    return mesh;
}

CoMesh bench_mesh_shuffled(CoMesh mesh, Random *random)
{
    uint32_t *indices = (uint32_t *)(uintptr_t)mesh.indices;
    for (uint32_t i = mesh.tri_count - 1; i > 0; i--) {
        uint32_t j = (uint32_t)(co_hash64(random->state++) % (i + 1)), moved[3];
        memcpy(moved, indices + 3 * (size_t)i, sizeof moved);
        memcpy(indices + 3 * (size_t)i, indices + 3 * (size_t)j, sizeof moved);
        memcpy(indices + 3 * (size_t)j, moved, sizeof moved);
    }
    return mesh;
}

void bench_mesh_free(CoMesh *mesh)
{
    free((float *)(uintptr_t)mesh->points);
    free((uint32_t *)(uintptr_t)mesh->indices);
}
