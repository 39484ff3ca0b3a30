// Decode, sort and traverse one batch.

#include "integrate/render_data.h"

#include "base/clock.h"
#include "base/error.h"
#include "base/parallel.h"
#include "sort/ray_sort.h"

// Light rays end at their emitter, camera rays at the far clip; the rest have no end. Only light rays
// stop at the first blocker, and only where every surface blocks.
static void bound_rays(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    CohortRender *render = context;
    CoActiveBatch *b = &render->batch;
    const CohortScene *scene = render->scene;
    for (size_t i = begin; i < end; i++) {
        CoRay ray;
        co_ray_decode(&b->records.words[i * render->ray_words], render->ray_options, &ray);
        b->rays.org_x[i] = ray.org.x;
        b->rays.org_y[i] = ray.org.y;
        b->rays.org_z[i] = ray.org.z;
        b->rays.dir_x[i] = ray.dir.x;
        b->rays.dir_y[i] = ray.dir.y;
        b->rays.dir_z[i] = ray.dir.z;
        b->rays.tnear[i] = ray.tnear;
        b->rays.record[i] = (uint32_t)i;
        float tfar = INFINITY;
        CoVec3 radiance;
        if (ray.kind == CO_RAY_LIGHT)
            tfar = co_light_ray_end(scene->lights, ray.org, ray.dir, ray.emitter, &radiance);
        else if (ray.kind == CO_RAY_CAMERA)
            tfar = co_camera_far(&scene->camera, ray.dir);
        b->rays.tfar[i] = tfar;
    }
}

// Whether a ray is a light ray stands in its record; asked again after the sort has moved it.
static void mark_occlusion(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    CohortRender *render = context;
    CoActiveBatch *b = &render->batch;
    bool can_stop = !render->scene->has_cutouts;
    for (size_t i = begin; i < end; i++) {
        const uint32_t *words = &b->records.words[(size_t)b->rays.record[i] * render->ray_words];
        b->occlusion[i] = can_stop && co_ray_kind(words) == CO_RAY_LIGHT;
    }
}

static void traverse(void *context, size_t begin, size_t end, uint32_t worker)
{
    CohortRender *render = context;
    CoActiveBatch *b = &render->batch;
    if (atomic_load_explicit(&render->cancel, memory_order_relaxed))
        return;
    size_t first = begin * CO_GROUP_RAYS, last = end * CO_GROUP_RAYS;
    if (last > b->rays.count)
        last = b->rays.count;
    render->kernels->traverse(&render->scene->accel, &b->rays, b->occlusion, &b->hits, first, last,
                              render->sorts_rays, &render->workers[worker].traverse);
    render->workers[worker].traced += last - first;
}

bool co_stage_trace(CohortRender *render, CohortError *err)
{
    CoActiveBatch *b = &render->batch;
    double start = co_clock_seconds();
    b->rays.count = b->hits.count = b->records.count;
    co_parallel_for(b->rays.count, 4096, bound_rays, render);
    if (render->sorts_rays && !co_sort_rays(&b->rays, render->settings.sorter, err))
        return false;
    co_parallel_for(b->rays.count, 16384, mark_occlusion, render);
    double sorted = co_clock_seconds();
    co_parallel_for((b->rays.count + CO_GROUP_RAYS - 1) / CO_GROUP_RAYS, 16, traverse, render);
    render->seconds_sort_rays += sorted - start;
    render->seconds_traverse += co_clock_seconds() - sorted;
    return true;
}
