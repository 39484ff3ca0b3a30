// Words of patches as they are kept: packed at level 0, near at level 1 (patch.h), or as they are.

#include "base/parallel.h"
#include "geometry/subdivide.h"

#include <string.h>

#define GRAIN 1024u

uint32_t *co_subdivision_alloc_words(CoMeshBuild *build, const CoPatchTable *table, bool is_scratch)
{
    const size_t count = co_patch_word_count(table);
    // Kernels read all words of a quad, however many there are.
    const size_t room = table->stride < CO_PATCH_WORDS ? CO_PATCH_WORDS - table->stride : 0;
    return is_scratch ? co_mesh_scratch(build, count, sizeof(uint32_t))
                      : co_mesh_keep(build, count + room, sizeof(uint32_t));
}

static bool keep_plain(CoMeshBuild *build, CoPatchTable *table, const uint32_t *words)
{
    uint32_t *kept = co_subdivision_alloc_words(build, table, false);
    CO_MESH_CHECK_MEMORY(build, kept);
    memcpy(kept, words, co_patch_word_count(table) * sizeof *kept);
    table->words = kept;
    return true;
}

static bool keep_packed(CoMeshBuild *build, CoPatchTable *table, const uint32_t *words)
{
    const size_t pack_count = ((size_t)table->count + CO_PATCH_PACKED - 1) / CO_PATCH_PACKED;
    const size_t plain = co_patch_word_count(table) * sizeof *words;
    CoPatchPack *packs = co_mesh_scratch(build, pack_count, sizeof *packs);
    CO_MESH_CHECK_MEMORY(build, packs);
    const size_t bytes = co_patch_pack_measure(words, table->count, table->stride, packs);
    if (bytes >= plain || bytes + pack_count * sizeof *packs >= plain)
        return keep_plain(build, table, words);
    CoPatchPack *kept = co_mesh_keep(build, pack_count, sizeof *kept);
    CO_MESH_CHECK_MEMORY(build, kept);
    memcpy(kept, packs, pack_count * sizeof *kept);
    unsigned char *packed = co_mesh_keep(build, bytes, 1);
    CO_MESH_CHECK_MEMORY(build, packed);
    co_patch_pack_write(words, table->count, table->stride, kept, packed);
    table->packs = kept;
    table->packed = packed;
    return true;
}

// ---- Near --------------------------------------------------------------------------------------

typedef struct NearJob {
    const CoPatchTable *table;
    const uint32_t *words;
    CoPatchNear *nears;
} NearJob;

// Corners and middles of edges of a patch or face.
static void find_points(const NearJob *job, size_t k, uint32_t out[CO_PATCH_NEAR_POINTS])
{
    const uint32_t *words = job->words + k * job->table->stride;
    const uint32_t edge = job->table->fold ? 3 : CO_PATCH_EDGE;
    for (uint32_t c = 0; c < 3; c++) {
        out[c] = words[c];
        out[3 + c] = co_patch_word_point(words[edge + c], 1);
    }
}

// False where it is too far; INT16_MIN is taken.
static bool find_steps(const uint32_t point[3], int16_t steps[2])
{
    bool is_near = true;
    for (uint32_t c = 0; c < 2; c++) {
        const int64_t step = (int64_t)point[c + 1] - (int64_t)point[0];
        is_near = is_near && step >= -INT16_MAX && step <= INT16_MAX;
        steps[c] = (int16_t)(is_near ? step : CO_PATCH_FAR);
    }
    return is_near;
}

static void find_nears(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const NearJob *job = context;
    for (size_t k = begin; k < end; k++) {
        CoPatchNear *near = &job->nears[k];
        uint32_t points[CO_PATCH_NEAR_POINTS];
        find_points(job, k, points);
        near->corner = points[0];
        near->edge = points[3];
        bool is_near = find_steps(points, near->corners) && find_steps(points + 3, near->edges);
        if (!is_near)
            near->corners[0] = CO_PATCH_FAR;
    }
}

static bool keep_near(CoMeshBuild *build, CoPatchTable *table, const uint32_t *words)
{
    const size_t count = co_patch_word_count(table) / table->stride;
    NearJob job = {table, words, co_mesh_keep(build, count, sizeof *job.nears)};
    CO_MESH_CHECK_MEMORY(build, job.nears);
    co_parallel_for(count, GRAIN, find_nears, &job);
    size_t far_count = 0, far_bytes = CO_PATCH_NEAR_POINTS * sizeof *words;
    for (size_t k = 0; k < count; k++)
        far_count += job.nears[k].corners[0] == CO_PATCH_FAR;
    if (count * sizeof *job.nears + far_count * far_bytes >=
        count * table->stride * sizeof *words) {
        co_mesh_block_drop(&build->shading->blocks, job.nears);
        return keep_plain(build, table, words);
    }
    uint32_t *fars = far_count ? co_mesh_keep(build, far_count, far_bytes) : NULL;
    CO_MESH_CHECK(build, fars || far_count == 0, COHORT_ERROR_OUT_OF_MEMORY,
                  "out of memory while tessellating");
    for (size_t k = 0, next = 0; k < count && next < far_count; k++) {
        if (job.nears[k].corners[0] != CO_PATCH_FAR)
            continue;
        job.nears[k].corner = (uint32_t)next;
        find_points(&job, k, fars + CO_PATCH_NEAR_POINTS * next++);
    }
    table->nears = job.nears;
    table->fars = fars;
    // Inside each triangle that is split into three quads is one point.
    table->center = table->fold && count ? words[table->stride - 1] : 0;
    return true;
}

// ---- Which -------------------------------------------------------------------------------------

// Whether no kernel reads the words.
static bool is_packable(const CoPatchTable *table)
{
    return table->level == 0 && !table->fold;
}

// Whether patches or faces are three corners and the middles of three edges, and what follows.
static bool is_nearable(const CoPatchTable *table)
{
    bool is_split = table->fold && table->level == 0 && table->stride == CO_PATCH_WORDS_TRIANGULAR;
    return !table->is_mixed && (is_split || (table->is_triangular && table->level == 1));
}

bool co_subdivision_is_short(const CoPatchTable *table)
{
    return is_packable(table) || is_nearable(table);
}

bool co_subdivision_shorten_words(CoMeshBuild *build, CoPatchTable *table, const uint32_t *words)
{
    return is_packable(table) ? keep_packed(build, table, words) : keep_near(build, table, words);
}
