// Decode, sort and traverse one batch.

#include "integrate/render_data.h"

#include "base/clock.h"
#include "base/parallel.h"
#include "sort/ray_sort.h"

// Light rays end at their emitter, where they start if nothing blocks it, camera rays at the far clip or at the light they show: a lamp in the
// picture hides what is behind it, though it blocks no other ray. The rest have no end.
static void decode_rays(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    CohortRender *render = context;
    CoActiveBatch *b = &render->batch;
    const CohortScene *scene = render->scene;
    render->codes->decode(&b->records, NULL, render->ray_options, begin, end, &b->rays);
    for (size_t i = begin; i < end; i++) {
        const uint32_t *words = &b->records.words[i * render->ray_words];
        uint32_t kind = co_ray_kind(words);
        if (kind == CO_RAY_CAMERA) {
            CoVec3 dir = co_vec3(b->rays.dir_x[i], b->rays.dir_y[i], b->rays.dir_z[i]);
            CoVec3 org = co_vec3(b->rays.org_x[i], b->rays.org_y[i], b->rays.org_z[i]);
            float light = co_camera_light_distance(render, org, dir, b->rays.tnear[i]);
            b->rays.tfar[i] = fminf(co_camera_far(&scene->camera, dir), light);
        } else if (kind == CO_RAY_LIGHT) {
            CoVec3 org = co_vec3(b->rays.org_x[i], b->rays.org_y[i], b->rays.org_z[i]);
            CoVec3 dir = co_vec3(b->rays.dir_x[i], b->rays.dir_y[i], b->rays.dir_z[i]);
            CoVec3 radiance;
            uint32_t emitter = co_ray_emitter(words);
            float t = co_light_ray_end(scene->lights, org, dir, emitter, &radiance);
            b->rays.tfar[i] = co_light_is_shadowless(scene->lights, emitter) ? 0.0f : t;
        }
    }
}

// Only light rays stop at the first blocker, and only where every surface blocks. What rays are stands
// in their records; asked after the sort has moved them.
static void mark_rays(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    CohortRender *render = context;
    CoActiveBatch *b = &render->batch;
    static const uint8_t classes[] = {[CO_RAY_CAMERA] = COHORT_HIDDEN_FROM_CAMERA,
                                      [CO_RAY_BSDF] = COHORT_HIDDEN_FROM_INDIRECT,
                                      [CO_RAY_LIGHT] = COHORT_HIDDEN_FROM_SHADOW};
    bool can_stop = !render->scene->has_cutouts;
    for (size_t i = begin; i < end; i++) {
        const uint32_t *words = &b->records.words[(size_t)b->rays.record[i] * render->ray_words];
        uint32_t kind = co_ray_kind(words);
        b->flags[i] = classes[kind];
        if (can_stop && kind == CO_RAY_LIGHT)
            b->flags[i] |= CO_TRAVERSE_OCCLUSION;
    }
}

static void traverse(void *context, size_t begin, size_t end, uint32_t worker)
{
    CohortRender *render = context;
    CoActiveBatch *b = &render->batch;
    if (co_render_is_cancelled(render))
        return;
    size_t first = begin * CO_GROUP_RAYS, last = end * CO_GROUP_RAYS;
    if (last > b->rays.count)
        last = b->rays.count;
    render->kernels->traverse(&render->scene->accel, &b->rays, b->flags, &b->hits, first, last,
                              render->groups_rays, &render->workers[worker].traverse);
    render->workers[worker].traced += last - first;
}

bool co_stage_trace(CohortRender *render, CohortError *err)
{
    CoActiveBatch *b = &render->batch;
    double start = co_clock_seconds();
    co_ray_batch_begin(&b->rays, b->records.count);
    b->hits.count = b->rays.count;
    co_parallel_for(b->rays.count, 4096, decode_rays, render);
    if (render->sorts_rays && !co_sort_rays(&b->rays, render->settings.sorter, &b->sort_scratch, err))
        return false;
    co_parallel_for(b->rays.count, 16384, mark_rays, render);
    double sorted = co_clock_seconds();
    co_parallel_for((b->rays.count + CO_GROUP_RAYS - 1) / CO_GROUP_RAYS, 16, traverse, render);
    render->seconds_sort_rays += sorted - start;
    render->seconds_traverse += co_clock_seconds() - sorted;
    return true;
}
