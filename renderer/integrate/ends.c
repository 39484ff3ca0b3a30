// Ends of rays: what they met on the way, and what becomes of those that met no surface.

#include "integrate/render_data.h"

#include "base/error.h"
#include "base/parallel.h"

float co_mis_emission(const CohortRender *render, const CoRay *ray, uint32_t emitter)
{
    if (ray->kind == CO_RAY_CAMERA || ray->pdf == 0.0f || !isfinite(ray->pdf))
        return 1.0f;
    bool at_split = ray->flags & CO_RAY_FROM_SPLIT;
    float n_bsdf = at_split ? (float)render->settings.first_hit_samples : 1.0f;
    float n_light = at_split ? (float)render->settings.light_samples : 1.0f;
    float p_light = co_light_pdf(render->scene->lights, ray->org, ray->normal, emitter, ray->dir);
    float p_bsdf = n_bsdf * ray->pdf;
    return p_bsdf / (p_bsdf + n_light * p_light);
}

// Most rays meet no light: the record is decoded when the first one is met.
typedef struct Collector {
    CohortRender *render;
    const uint32_t *words;
    bool is_camera, is_camera_miss, has_covered;
    bool is_shadowless; // collects those lights alone that no surface keeps back
} Collector;

static void collect(void *context, const CoLightHit *hit)
{
    Collector *c = context;
    const CoLights *lights = c->render->scene->lights;
    if (c->is_camera && c->render->settings.hide_domes && co_light_is_dome(lights, hit->emitter))
        return;
    if (!c->is_camera && co_light_is_shadowless(lights, hit->emitter) != c->is_shadowless)
        return;
    CoRay ray;
    co_ray_decode(c->words, c->render->ray_options, &ray);
    float share = co_mis_emission(c->render, &ray, hit->emitter);
    if (ray.kind != CO_RAY_CAMERA)
        share *= hit->diffuse;
    CoVec3 light = co_scale(co_mul(ray.weight, hit->radiance), share);
    uint32_t pixel, sample;
    co_path_split(c->render, ray.path, &pixel, &sample);
    co_film_add_color(c->render->film, pixel, sample, light);
    // Light behind all surfaces covers its pixel as a surface does: divided by the coverage of the
    // surfaces alone, their edges before a sky would be too bright.
    if (c->is_camera_miss && !c->has_covered)
        co_film_add_alpha(c->render->film, pixel, sample, 1.0f);
    c->has_covered = true;
}

static void keep_nearest(void *context, const CoLightHit *hit)
{
    CoLightHit *nearest = context;
    if (hit->t < nearest->t && co_max3(hit->radiance) > 0.0f)
        *nearest = *hit;
}

float co_camera_light_distance(const CohortRender *render, CoVec3 org, CoVec3 dir, float tnear)
{
    CoLightHit nearest = {.t = INFINITY};
    if (!render->settings.hide_lights && co_lights_count(render->scene->lights) > 0)
        co_light_collect(render->scene->lights, org, dir, tnear, INFINITY, keep_nearest, &nearest);
    return nearest.t;
}

static CoVec3 ray_origin(const CoRayBatch *rays, size_t i)
{
    return co_vec3(rays->org_x[i], rays->org_y[i], rays->org_z[i]);
}

static CoVec3 ray_direction(const CoRayBatch *rays, size_t i)
{
    return co_vec3(rays->dir_x[i], rays->dir_y[i], rays->dir_z[i]);
}

static void end_light_ray(CohortRender *render, size_t i, const uint32_t *words,
                          CoWorkerCounts *counts)
{
    const CoRayBatch *rays = &render->batch.rays;
    CoRay ray;
    co_ray_decode_shading(words, render->ray_options, &ray);
    CoVec3 radiance = co_light_ray_radiance(render->scene->lights, ray_origin(rays, i),
                                            ray_direction(rays, i), ray.emitter);
    uint32_t pixel, sample;
    co_path_split(render, ray.path, &pixel, &sample);
    co_film_add_color(render->film, pixel, sample, co_mul(ray.weight, radiance));
    counts->miss++;
    counts->light_reached++;
}

static void collect_lights(CohortRender *render, size_t i, const uint32_t *words)
{
    const CoRayBatch *rays = &render->batch.rays;
    bool is_camera = co_ray_kind(words) == CO_RAY_CAMERA;
    float t = render->batch.hits.t[i];
    if (render->settings.hide_lights && is_camera)
        return;
    Collector collector = {.render = render,
                           .words = words,
                           .is_camera = is_camera,
                           .is_camera_miss = is_camera && t == INFINITY};
    CoVec3 org = ray_origin(rays, i), dir = ray_direction(rays, i);
    float nearest = collector.is_camera_miss
                        ? co_camera_light_distance(render, org, dir, rays->tnear[i])
                        : INFINITY;
    // Up to and with the light that the camera sees there; the next float takes it in.
    if (nearest < INFINITY)
        t = nearest * (1.0f + 0x1p-23f);
    co_light_collect(render->scene->lights, org, dir, rays->tnear[i], t, collect, &collector);
    // A ray that goes on behind a cut-out has collected these where it began.
    bool is_first = !is_camera && rays->tnear[i] == 0.0f;
    if (!is_first || !co_lights_have_shadowless(render->scene->lights))
        return;
    collector.is_shadowless = true;
    co_light_collect(render->scene->lights, org, dir, 0.0f, INFINITY, collect, &collector);
}

// Settles ray i of the batch as far as that needs no surface; *hit receives what shading needs.
// Returns whether the ray goes on to shading.
static bool end_ray(CohortRender *render, size_t i, CoWorkerCounts *counts, CoHitRecord *hit)
{
    const CoActiveBatch *b = &render->batch;
    float t = b->hits.t[i];
    if (isnan(t)) {
        counts->invalid++;
        return false;
    }
    uint32_t record = b->rays.record[i];
    const uint32_t *words = &b->records.words[(size_t)record * render->ray_words];
    bool is_hit = t < INFINITY;
    if (co_ray_kind(words) == CO_RAY_LIGHT) {
        if (!is_hit)
            end_light_ray(render, i, words, counts);
        else if (b->flags[i] & CO_TRAVERSE_OCCLUSION)
            counts->blocked++;
        if (!is_hit || (b->flags[i] & CO_TRAVERSE_OCCLUSION))
            return false;
    } else {
        collect_lights(render, i, words);
    }
    if (!is_hit) {
        counts->miss++;
        return false;
    }
    CoHitRecord out = {t,
                       b->hits.u[i],
                       b->hits.v[i],
                       b->hits.instance[i],
                       0,
                       b->hits.tri[i],
                       record,
                       0,
                       ray_direction(&b->rays, i)};
    *hit = out;
    return true;
}

typedef struct EndsWork {
    CohortRender *render;
    size_t *counts; // hits of each block
} EndsWork;

enum {
    ENDS_BLOCK = 8192
};

// Records and sums of the film lie anywhere in memory; both are asked for before their turn comes.
enum {
    RECORDS_AHEAD = 24,
    SUMS_AHEAD = 12
};

static void ask_ahead(const CohortRender *render, size_t i, size_t last)
{
    const uint32_t *all = render->batch.records.words, *record = render->batch.rays.record;
    if (i + RECORDS_AHEAD < last)
        __builtin_prefetch(&all[(size_t)record[i + RECORDS_AHEAD] * render->ray_words + 4]);
    if (i + SUMS_AHEAD >= last)
        return;
    const uint32_t *words = &all[(size_t)record[i + SUMS_AHEAD] * render->ray_words];
    if (co_ray_kind(words) != CO_RAY_LIGHT)
        return;
    uint32_t pixel, sample;
    co_path_split(render, co_ray_path(words), &pixel, &sample);
    co_film_ask_ahead(render->film, pixel, sample);
}

// Each block packs its hits at its own start; pack_hits then closes the gaps, in block order.
static void end_rays(void *context, size_t begin, size_t end, uint32_t worker)
{
    const EndsWork *work = context;
    CohortRender *render = work->render;
    for (size_t block = begin; block < end; block++) {
        size_t first = block * ENDS_BLOCK, last = first + ENDS_BLOCK, n = 0;
        if (last > render->batch.rays.count)
            last = render->batch.rays.count;
        for (size_t i = first; i < last; i++) {
            ask_ahead(render, i, last);
            n += end_ray(render, i, &render->workers[worker], &render->batch.hit_sorted[first + n]);
        }
        work->counts[block] = n;
    }
}

static void copy_hits(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const EndsWork *work = context;
    CoActiveBatch *b = &work->render->batch;
    for (size_t block = begin; block < end; block++) {
        size_t first = work->counts[block], count = work->counts[block + 1] - first;
        for (size_t i = 0; i < count; i++)
            b->hit_records[first + i] = b->hit_sorted[block * ENDS_BLOCK + i];
    }
}

bool co_stage_ends(CohortRender *render, CohortError *err)
{
    size_t blocks = (render->batch.rays.count + ENDS_BLOCK - 1) / ENDS_BLOCK, sum = 0;
    size_t bytes = (blocks + 1) * sizeof(size_t);
    size_t *counts = co_alloc(CO_MEMORY_RAYS, bytes);
    CO_CHECK_MEMORY(counts, err);
    EndsWork work = {render, counts};
    co_parallel_for(blocks, 1, end_rays, &work);
    for (size_t i = 0; i < blocks; i++) {
        size_t n = counts[i];
        counts[i] = sum;
        sum += n;
    }
    counts[blocks] = sum;
    co_parallel_for(blocks, 4, copy_hits, &work);
    render->batch.hit_count = sum;
    co_free(CO_MEMORY_RAYS, counts, bytes);
    return true;
}
