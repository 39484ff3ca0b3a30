// Sort, decode and traverse one batch.

#include "integrate/render_data.h"

#include "base/clock.h"
#include "base/parallel.h"
#include "sort/ray_sort.h"

enum {
    DECODED_RAYS = 1024, // before they are traversed
    // Groups that follow each other meet the same nodes: a thread that takes many in a row finds
    // more of them in its own cache.
    TASK_RAYS = 16 * DECODED_RAYS
};

uint8_t co_trace_class(uint32_t kind)
{
    static const uint8_t classes[] = {[CO_RAY_CAMERA] = COHORT_HIDDEN_FROM_CAMERA,
                                      [CO_RAY_BSDF] = COHORT_HIDDEN_FROM_INDIRECT,
                                      [CO_RAY_LIGHT] = COHORT_HIDDEN_FROM_SHADOW};
    return classes[kind];
}

// Light rays end at their emitter, where they start if nothing blocks it, camera rays at the far
// clip or at the light they show: a lamp in the picture hides what is behind it, though it blocks
// no other ray. The rest have no end.
static void bound_ray(const CohortRender *render, const uint32_t *words, uint32_t kind, size_t i)
{
    const CoRayBatch *rays = &render->batch.rays;
    const CohortScene *scene = render->scene;
    if (kind == CO_RAY_BSDF)
        return;
    CoVec3 dir = co_vec3(rays->dir_x[i], rays->dir_y[i], rays->dir_z[i]);
    CoVec3 org = co_vec3(rays->org_x[i], rays->org_y[i], rays->org_z[i]);
    if (kind == CO_RAY_CAMERA) {
        float light = co_camera_light_distance(render, org, dir, rays->tnear[i]);
        rays->tfar[i] = fminf(co_camera_far(&scene->camera, dir), light);
    } else {
        CoVec3 radiance;
        uint32_t emitter = co_ray_emitter(words);
        float t = co_light_ray_end(scene->lights, org, dir, emitter, &radiance);
        rays->tfar[i] = co_light_is_shadowless(scene->lights, emitter) ? 0.0f : t;
    }
}

// Decodes rays in the order of the batch. What else a ray is stands in its record, which is near by
// then. Only light rays stop at the first blocker, and only where every surface blocks.
static void prepare_rays(CohortRender *render, size_t begin, size_t end)
{
    CoActiveBatch *b = &render->batch;
    bool can_stop = !render->scene->has_cutouts;
    render->codes->decode(&b->records, render->sorts_rays ? b->order : NULL, render->ray_options,
                          begin, end, &b->rays);
    for (size_t i = begin; i < end; i++) {
        const uint32_t *words = &b->records.words[(size_t)b->rays.record[i] * render->ray_words];
        uint32_t kind = co_ray_kind(words);
        bound_ray(render, words, kind, i);
        b->flags[i] = co_trace_class(kind);
        if (can_stop && kind == CO_RAY_LIGHT)
            b->flags[i] |= CO_TRAVERSE_OCCLUSION;
    }
}

// Rays that have passed some of several cut-outs at one distance meet the next of them.
static void pass_ties(const CohortRender *render, size_t begin, size_t end)
{
    const CoActiveBatch *b = &render->batch;
    const CoRayBatch *rays = &b->rays;
    for (size_t i = begin; i < end; i++) {
        const uint32_t *words = &b->records.words[(size_t)rays->record[i] * render->ray_words];
        CoRayHit hit = {b->hits.t[i], b->hits.u[i], b->hits.v[i], b->hits.instance[i],
                        b->hits.tri[i]};
        CoVec3 org = co_vec3(rays->org_x[i], rays->org_y[i], rays->org_z[i]);
        CoVec3 dir = co_vec3(rays->dir_x[i], rays->dir_y[i], rays->dir_z[i]);
        uint32_t left = hit.instance == COHORT_INVALID_ID ? 0 : co_ray_ties(words);
        for (; left; left--)
            render->kernels->next(&render->scene->accel, org, dir, b->flags[i], &hit);
        b->hits.u[i] = hit.u;
        b->hits.v[i] = hit.v;
        b->hits.instance[i] = hit.instance;
        b->hits.tri[i] = hit.tri;
    }
}

// Some rays, traversed while what was decoded is still in the inner cache.
static void trace_rays(CohortRender *render, size_t first, size_t last, uint32_t worker)
{
    CoActiveBatch *b = &render->batch;
    prepare_rays(render, first, last);
    render->kernels->traverse(&render->scene->accel, &b->rays, b->flags, &b->hits, first, last,
                              render->groups_rays, &render->workers[worker].traverse);
    if (render->scene->has_cutouts)
        pass_ties(render, first, last);
    render->workers[worker].traced += last - first;
}

static void trace_groups(void *context, size_t begin, size_t end, uint32_t worker)
{
    CohortRender *render = context;
    size_t last = end * CO_GROUP_RAYS, count = render->batch.rays.count;
    last = last < count ? last : count;
    for (size_t i = begin * CO_GROUP_RAYS; i < last; i += DECODED_RAYS) {
        if (co_render_is_cancelled(render))
            return;
        trace_rays(render, i, last - i < DECODED_RAYS ? last : i + DECODED_RAYS, worker);
    }
}

bool co_stage_trace(CohortRender *render, CohortError *err)
{
    CoActiveBatch *b = &render->batch;
    double start = co_clock_seconds();
    if (render->sorts_rays &&
        !co_sort_rays(&b->records, render->sorter, &b->sort_scratch, b->order, err))
        return false;
    co_ray_batch_begin(&b->rays, b->records.count);
    b->hits.count = b->rays.count;
    size_t groups = (b->rays.count + CO_GROUP_RAYS - 1) / CO_GROUP_RAYS;
    double sorted = co_clock_seconds();
    co_parallel_for_tapered(groups, TASK_RAYS / CO_GROUP_RAYS, DECODED_RAYS / CO_GROUP_RAYS,
                            trace_groups, render);
    render->seconds_sort_rays += sorted - start;
    render->seconds_traverse += co_clock_seconds() - sorted;
    return true;
}
