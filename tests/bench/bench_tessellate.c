// Tessellation and displacement within one giant mesh: CPU time by triangle, and how much of it the
// calling thread does when there are two, which no load of the machine changes.

#include "arguments.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "geometry/displace.h"
#include "timing.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const char usage[] = "usage: bench_tessellate [SIDE [LEVEL]]\n"
                            "  SIDE   a torus of SIDE x SIDE quads (700)\n"
                            "  LEVEL  of subdivision (2)\n";

typedef struct Torus {
    float *points;
    int32_t *counts, *indices;
    size_t faces;
} Torus;

static bool make_torus(Torus *t, int side)
{
    t->faces = (size_t)side * (size_t)side;
    t->points = malloc(t->faces * 3 * sizeof *t->points);
    t->counts = malloc(t->faces * sizeof *t->counts);
    t->indices = malloc(t->faces * 4 * sizeof *t->indices);
    if (!t->points || !t->counts || !t->indices)
        return false;
    for (int f = 0; f < side * side; f++) {
        int i = f % side, j = f / side, next = (i + 1) % side, up = (j + 1) % side;
        double a = 6.283185307179586 * i / side, b = 6.283185307179586 * j / side;
        float *p = t->points + 3 * (size_t)f;
        p[0] = (float)((3 + cos(b)) * cos(a));
        p[1] = (float)((3 + cos(b)) * sin(a));
        p[2] = (float)sin(b);
        const int32_t v[] = {j * side + i, j * side + next, up * side + next, up * side + i};
        for (int k = 0; k < 4; k++)
            t->indices[4 * f + k] = v[k];
        t->counts[f] = 4;
    }
    return true;
}

static bool by_little(void *cookie, const CoDisplacePoint *points, size_t count, float *amounts,
                      CohortError *err)
{
    (void)cookie, (void)points, (void)err;
    for (size_t k = 0; k < count; k++)
        amounts[k] = 0.01f;
    return true;
}

static bool measure(const CohortMeshDesc *desc, uint32_t threads)
{
    double all[3], own[3];
    CoMesh mesh;
    CoDisplaceCounts counts;
    CohortError err = {0};
    co_worker_count_set(threads);
    all[0] = bench_seconds(CLOCK_PROCESS_CPUTIME_ID);
    own[0] = bench_seconds(CLOCK_THREAD_CPUTIME_ID);
    bool ok = co_mesh_create(desc, &mesh, NULL, NULL, &err);
    all[1] = bench_seconds(CLOCK_PROCESS_CPUTIME_ID);
    own[1] = bench_seconds(CLOCK_THREAD_CPUTIME_ID);
    ok = ok && co_mesh_displace(&mesh, by_little, NULL, &counts, &err);
    all[2] = bench_seconds(CLOCK_PROCESS_CPUTIME_ID);
    own[2] = bench_seconds(CLOCK_THREAD_CPUTIME_ID);
    if (!ok) {
        fprintf(stderr, "%s\n", err.message);
        return false;
    }
    double scale = 1e9 / mesh.tri_count;
    printf(
        "%u threads: tessellation %.0f ns a triangle, %.2f of it by the caller; displacement %.0f "
        "ns, %.2f; %.1f bytes, %.1f in memory\n",
        threads, (all[1] - all[0]) * scale, (own[1] - own[0]) / (all[1] - all[0]),
        (all[2] - all[1]) * scale, (own[2] - own[1]) / (all[2] - all[1]),
        (double)mesh.bytes / mesh.tri_count,
        (double)co_memory_live(CO_MEMORY_GEOMETRY) / mesh.tri_count);
    co_mesh_destroy(&mesh);
    return true;
}

int main(int argc, char **argv)
{
    double side = 700, level = 2;
    const BenchArgument arguments[] = {{.name = "SIDE", .number = &side, .least = 3, .most = 20000},
                                       {.name = "LEVEL", .number = &level, .most = 8}};
    bench_arguments_read(argc, argv, usage, arguments, sizeof arguments / sizeof *arguments);
    Torus torus;
    if (!make_torus(&torus, (int)side))
        return 1;
    CohortMeshDesc desc = {.path = "/torus",
                           .level = (uint32_t)level,
                           .points = torus.points,
                           .point_count = torus.faces,
                           .face_vertex_counts = torus.counts,
                           .face_count = torus.faces,
                           .face_vertex_indices = torus.indices,
                           .face_vertex_index_count = 4 * torus.faces};
    bool ok = true;
    for (int round = 0; ok && round < 3; round++)
        ok = measure(&desc, 1) && measure(&desc, 2);
    free(torus.points);
    free(torus.counts);
    free(torus.indices);
    return ok ? 0 : 1;
}
