// Brings hits into shading order and looks up every texture they need, once for the whole batch.

#include "integrate/vertex.h"

#include "accel/paths.h"
#include "base/clock.h"
#include "base/error.h"
#include "base/parallel.h"
#include "sort/hit_sort.h"

static void name_objects(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    CohortRender *render = context;
    CoActiveBatch *b = &render->batch;
    uint32_t instance = COHORT_INVALID_ID, object = 0;
    for (size_t i = begin; i < end; i++) {
        CoHitRecord *hit = &b->hit_records[i];
        if (hit->instance != instance) {
            instance = hit->instance;
            object = co_accel_path_object(&render->scene->accel, instance);
        }
        hit->object = object;
        b->hit_object[i] = hit->object;
        b->hit_tri[i] = hit->tri;
        b->hit_order[i] = (uint32_t)i;
    }
}

static void gather_sorted(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    CoActiveBatch *b = context;
    for (size_t i = begin; i < end; i++)
        b->hit_sorted[i] = b->hit_records[b->hit_order[i]];
}

// Hits are grouped by mesh, then by triangle, which is face order (Eisenacher et al. 2013, 3.2).
static bool sort_hits(CohortRender *render, CohortError *err)
{
    CoActiveBatch *b = &render->batch;
    co_parallel_for(b->hit_count, 8192, name_objects, render);
    if (!render->sorts_hits)
        return true;
    if (!co_sort_hits(b->hit_object, b->hit_tri, b->hit_order, b->hit_count, &b->sort_scratch, err))
        return false;
    co_parallel_for(b->hit_count, 16384, gather_sorted, b);
    CoHitRecord *sorted = b->hit_sorted;
    b->hit_sorted = b->hit_records;
    b->hit_records = sorted;
    return true;
}

// Number of lookups a hit needs. A light ray only asks surfaces that may let it pass.
static uint32_t lookup_need(const CohortRender *render, const CoHitRecord *hit)
{
    const CohortScene *scene = render->scene;
    const CoMesh *mesh = scene->accel.objects[hit->object].mesh;
    uint32_t slot = co_mesh_face_material(mesh, co_mesh_tri_face(mesh, hit->tri));
    const CoMaterial *m = co_scene_material(scene, hit->object, slot);
    if (!m)
        return 0;
    const uint32_t *words = &render->batch.records.words[(size_t)hit->record * render->ray_words];
    if (!m->may_pass && co_ray_kind(words) == CO_RAY_LIGHT)
        return 0;
    return m->lookup_count;
}

enum {
    REQUEST_BLOCK = 4096
};

typedef struct RequestWork {
    CohortRender *render;
    size_t *sums; // lookups of each block, then where each starts
} RequestWork;

static size_t block_end(const CohortRender *render, size_t block)
{
    size_t end = (block + 1) * REQUEST_BLOCK;
    return end < render->batch.hit_count ? end : render->batch.hit_count;
}

static void count_lookups(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const RequestWork *work = context;
    for (size_t block = begin; block < end; block++) {
        size_t sum = 0;
        for (size_t i = block * REQUEST_BLOCK; i < block_end(work->render, block); i++)
            sum += lookup_need(work->render, &work->render->batch.hit_records[i]);
        work->sums[block] = sum;
    }
}

static void make_lookups(const CohortRender *render, CoPlacementMemo *memo, const CoHitRecord *hit,
                         CoLookup *out)
{
    CoRay ray;
    co_ray_decode_shading(&render->batch.records.words[(size_t)hit->record * render->ray_words],
                          render->ray_options, &ray);
    CoVertex vertex;
    co_vertex_make(render->scene, memo, hit, &ray, &vertex);
    float to_object = co_length(co_affine_vector(&vertex.placement->to_object, hit->dir));
    float width = render->settings.texture_level0 ? 0.0f : vertex.width * to_object;
    for (uint32_t k = 0; k < vertex.material->lookup_count; k++)
        co_material_lookup(render->scene, &vertex.material->lookups[k], vertex.hit.mesh, hit->tri,
                           hit->u, hit->v, &vertex.hit.surface, width, &out[k]);
}

static void fill_lookups(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const RequestWork *work = context;
    const CohortRender *render = work->render;
    CoPlacementMemo memo = {.instance = COHORT_INVALID_ID};
    for (size_t block = begin; block < end; block++) {
        size_t next = work->sums[block];
        for (size_t i = block * REQUEST_BLOCK; i < block_end(render, block); i++) {
            CoHitRecord *hit = &render->batch.hit_records[i];
            uint32_t need = lookup_need(render, hit);
            hit->first_lookup = (uint32_t)next;
            if (need)
                make_lookups(render, &memo, hit, &render->batch.lookups[next]);
            next += need;
        }
    }
}

static bool reserve_lookups(CoActiveBatch *b, size_t count, CohortError *err)
{
    CO_CHECK(count < UINT32_MAX, err, COHORT_ERROR_LIMIT,
             "%zu texture lookups in one batch: use a smaller --batch", count);
    b->lookup_count = count;
    if (count <= b->lookup_capacity)
        return true;
    co_free(CO_MEMORY_TEXTURE, b->lookups, b->lookup_capacity * sizeof *b->lookups);
    co_free(CO_MEMORY_TEXTURE, b->texels, b->lookup_capacity * sizeof *b->texels);
    b->lookups = co_alloc(CO_MEMORY_TEXTURE, count * sizeof *b->lookups);
    b->texels = co_alloc(CO_MEMORY_TEXTURE, count * sizeof *b->texels);
    b->lookup_capacity = count;
    if (b->lookups && b->texels)
        return true;
    co_free(CO_MEMORY_TEXTURE, b->lookups, count * sizeof *b->lookups);
    co_free(CO_MEMORY_TEXTURE, b->texels, count * sizeof *b->texels);
    b->lookups = NULL;
    b->texels = NULL;
    b->lookup_capacity = 0; // so that the next round asks again
    return CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY,
                   "out of memory for %zu texture lookups: use a smaller --batch", count);
}

static bool look_up(CohortRender *render, size_t *sums, size_t blocks, CohortError *err)
{
    RequestWork work = {render, sums};
    CoActiveBatch *b = &render->batch;
    co_parallel_for(blocks, 1, count_lookups, &work);
    size_t sum = 0;
    for (size_t i = 0; i < blocks; i++) {
        size_t n = sums[i];
        sums[i] = sum;
        sum += n;
    }
    if (!reserve_lookups(b, sum, err))
        return false;
    co_parallel_for(blocks, 1, fill_lookups, &work);
    render->lookup_batches += sum > 0;
    if (sum == 0)
        return true;
    CoLookupStats stats = {0};
    bool ok = co_textures_evaluate(render->scene->textures, b->lookups, sum, b->texels,
                                   render->sorts_hits ? CO_LOOKUP_SORTED : CO_LOOKUP_CACHED,
                                   &render->cancel, render->scratch, &stats, err);
    render->lookups.lookups += stats.lookups;
    render->lookups.requests += stats.requests;
    render->lookups.blocks_read += stats.blocks_read;
    render->lookups.blocks_twice += stats.blocks_twice;
    render->lookups.bytes_read += stats.bytes_read;
    return ok;
}

bool co_stage_request(CohortRender *render, CohortError *err)
{
    double start = co_clock_seconds();
    if (!sort_hits(render, err))
        return false;
    double sorted = co_clock_seconds();
    render->seconds_sort_hits += sorted - start;
    render->batch.lookup_count = 0;
    if (!render->scene->has_lookups || render->batch.hit_count == 0)
        return true;
    size_t blocks = (render->batch.hit_count + REQUEST_BLOCK - 1) / REQUEST_BLOCK;
    size_t *sums = co_alloc(CO_MEMORY_RAYS, blocks * sizeof *sums);
    CO_CHECK_MEMORY(sums, err);
    bool ok = look_up(render, sums, blocks, err);
    co_free(CO_MEMORY_RAYS, sums, blocks * sizeof *sums);
    render->seconds_texture += co_clock_seconds() - sorted;
    return ok;
}
