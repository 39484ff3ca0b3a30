// Shades the hits of a batch and feeds new rays back into the bins.

#include "integrate/vertex.h"

#include "base/clock.h"
#include "base/hash.h"
#include "base/parallel.h"

// A BSDF ray's cone: half angle of the solid angle 1 / pdf, times this. Narrow enough that blurred
// lookups stay within 1% of full-resolution ones, wide enough to read coarse levels after a diffuse
// bounce (docs/architecture.md, "Footprints").
#define SPREAD_PER_ROOT_PDF 0.15f

// Segments beyond a default path are subject to Russian roulette.
enum {
    ROULETTE_DEPTH = 7
};

// How many hits ahead records are asked for: a few hundred nanoseconds of shading each.
enum {
    PREFETCH_HITS = 4
};

typedef struct ShadeContext {
    CohortRender *render;
    CoEmitter emitter;
    CoWorkerCounts *counts;
    CoPlacementMemo memo;
} ShadeContext;

// Everything a vertex needs to make new rays.
typedef struct Scatter {
    const CoRay *ray;
    const CoVertex *vertex;
    CoBsdf bsdf;
    CoVec3 weight; // throughput up to here, pass-through decided
    CoVec3 origin; // where rays start
    CoVec3 normal; // as the record keeps it
    uint32_t normal_code;
    uint32_t n_bsdf, n_light;
    bool is_split;
    CoSampleKey key;
} Scatter;

void co_emit_flush(CoEmitter *emitter)
{
    CohortRender *render = emitter->render;
    CoWorkerCounts *counts = &render->workers[emitter->worker];
    CoRayQueue *queue = &emitter->queue;
    CoRayEncoded encoded;
    render->codes->encode(queue, render->ray_options, &encoded);
    counts->overflows += (uint64_t)__builtin_popcount(encoded.has_overflown);
    for (uint32_t i = 0; i < queue->count; i++) {
        bool is_kept = encoded.is_kept >> i & 1;
        counts->underflows += !is_kept;
        // A push that fails is remembered by the bins; the schedule reports it.
        if (is_kept &&
            co_ray_bins_push(render->bins, emitter->worker, encoded.words[i], encoded.bin[i]))
            counts->made[queue->kind[i]]++;
    }
    queue->count = 0;
}

static CoRayKey ray_key(CoSampleKey key)
{
    CoRayKey r = {key.pixel, key.sample, key.seed};
    return r;
}

static bool is_black(CoVec3 c)
{
    return !(co_max3(c) > 0.0f);
}

// Whether another surface lies where the ray has met one, which comes after it: the ray meets it
// next, see pass_ties.
static bool has_next(const CohortRender *render, const CoRay *ray, const CoHitRecord *hit)
{
    CoRayHit next = {hit->t, hit->u, hit->v, hit->instance, hit->tri};
    return render->kernels->next(&render->scene->accel, ray->org, ray->dir,
                                 co_trace_class(ray->kind), &next);
}

// Goes on behind a surface that let the ray pass: same origin, pdf and depth, t_min past the hit.
static void pass_through(ShadeContext *c, const CoRay *ray, const CoHitRecord *hit, CoVec3 weight,
                         CoSampleKey key)
{
    CoRay on = *ray;
    on.tnear = hit->t;
    uint32_t ties = ray->flags / CO_RAY_TIED & CO_RAY_TIED_MOST;
    on.flags = (ray->flags & (CO_RAY_TIED - 1)) | CO_RAY_PASSED;
    if (ties < CO_RAY_TIED_MOST && has_next(c->render, ray, hit)) {
        on.tnear = nextafterf(hit->t, 0.0f);
        on.flags |= (ties + 1) * CO_RAY_TIED;
    }
    on.weight = weight;
    CoRayKey rounding = ray_key(key);
    rounding.seed ^= co_hash32(hit->tri ^ co_hash32(hit->instance));
    co_emit(&c->emitter, &on, rounding);
}

static void shade_light_ray(ShadeContext *c, const CoRay *ray, const CoHitRecord *hit,
                            const CoVertex *vertex)
{
    CoVec3 through = co_vec3_splat(0.0f), emissive;
    CoBsdf bsdf;
    if (co_vertex_may_pass(vertex)) {
        co_vertex_bsdf(c->render->scene, vertex, &bsdf, &emissive);
        through = co_vertex_transmittance(vertex, &bsdf);
    }
    if (is_black(through)) {
        c->counts->blocked++;
        return;
    }
    c->counts->hit++;
    pass_through(c, ray, hit, co_mul(ray->weight, through), co_path_key(c->render, ray->path));
}

// Decides whether the ray goes straight on, with the probability p of the share that does: so a
// camera ray that stays counts as coverage. Where something is reflected too, p stays below 1; what
// stays carries 1 / (1 - p), the lobe that went through is taken out of the BSDF. A cut-out is all
// or nothing.
static bool passes(ShadeContext *c, const CoHitRecord *hit, Scatter *s)
{
    CoVec3 through = co_vertex_transmittance(s->vertex, &s->bsdf);
    if (is_black(through))
        return false;
    const CoMaterial *material = s->vertex->material;
    bool is_cutout = !material || material->opacity_threshold > 0.0f || material->opacity_presence;
    float reflecting = s->bsdf.p_diffuse + s->bsdf.p_specular + s->bsdf.p_coat;
    float most = !is_cutout && reflecting > 0.0f ? 0.98f : 1.0f;
    float p = fminf(co_max3(through), most);
    uint32_t primitive = co_hash32(hit->tri ^ co_hash32(hit->instance));
    if (co_sample_hash(s->key, primitive, (s->ray->depth << 8) | s->ray->branch) < p) {
        pass_through(c, s->ray, hit, co_scale(co_mul(s->weight, through), 1.0f / p), s->key);
        return true;
    }
    if (is_cutout)
        return false;
    s->weight = co_scale(s->weight, 1.0f / (1.0f - p));
    if (reflecting > 0.0f) {
        s->bsdf.p_diffuse /= reflecting;
        s->bsdf.p_specular /= reflecting;
        s->bsdf.p_coat /= reflecting;
    }
    s->bsdf.p_through = 0.0f;
    return false;
}

static void splat_first_hit(ShadeContext *c, const Scatter *s)
{
    const CohortRender *render = c->render;
    co_film_add_alpha(render->film, s->key.pixel, s->key.sample, 1.0f);
    if (!(render->settings.aovs & ~(uint32_t)(COHORT_AOV_COLOR | COHORT_AOV_ERROR)))
        return;
    const CoCamera *camera = &render->scene->camera;
    float z = co_camera_depth(camera, s->vertex->p), near = camera->clip_near,
          far = camera->clip_far, depth = 0.0f;
    if (camera->is_orthographic)
        depth = isfinite(far) ? (z - near) / (far - near) : 0.0f;
    else
        depth = isfinite(far) ? far / (far - near) * (1.0f - near / z) : 1.0f - near / z;
    CoFirstHit first = {
        .depth = co_clamp(depth, 0.0f, 1.0f),
        .camera_depth = z,
        .normal = s->bsdf.n,
        .albedo = co_bsdf_albedo(&s->bsdf, s->vertex->wo),
        .prim_id = co_placement_prim_id(render->scene, s->vertex->placement),
        .element_id = (int32_t)s->vertex->hit.surface.face,
    };
    co_film_add_first(render->film, s->key.pixel, s->key.sample, &first);
}

// How many rays of each kind leave the vertex. The split is at the first vertex that has a smooth
// lobe; the vertices before it are mirrors.
static void choose_counts(const CohortRender *render, Scatter *s)
{
    const CohortRenderSettings *set = &render->settings;
    bool has_smooth = co_bsdf_has_smooth(&s->bsdf);
    s->is_split = has_smooth && !(s->ray->flags & CO_RAY_HAS_SPLIT);
    s->n_bsdf = s->is_split ? set->first_hit_samples : 1;
    s->n_light = s->is_split ? set->light_samples : !set->no_light_samples_after_split;
    if (!has_smooth || co_lights_count(render->scene->lights) == 0)
        s->n_light = 0;
}

// The numbers of a decision, those of the direction first: the first two dimensions of Sobol' are
// the best distributed pair, and where there is nothing to choose no third is made. The split's
// rays share one set, and so do those that follow a branch.
static void draw(const CohortRender *render, const Scatter *s, CoDecision decision, uint32_t i,
                 uint32_t n, uint32_t count, float *u)
{
    if (s->is_split || !(s->ray->flags & CO_RAY_HAS_SPLIT))
        co_sample(s->key, s->ray->depth, 0, decision, i, n, count, u);
    else
        co_sample(s->key, s->ray->depth, 0, decision, s->ray->branch,
                  render->settings.first_hit_samples, count, u);
}

static void emit_light_sample(ShadeContext *c, const Scatter *s, uint32_t i)
{
    const CoLights *lights = c->render->scene->lights;
    float u[3] = {0}, pdf = 0.0f;
    CoLightSample sample;
    draw(c->render, s, CO_DECISION_LIGHT, i, s->n_light, co_lights_have_choice(lights) ? 3 : 2, u);
    if (!co_light_sample(lights, s->origin, s->normal, u[2], u[0], u[1], &sample))
        return;
    uint32_t code[2];
    CoVec3 wi = co_ray_snap_direction(sample.wi, code);
    CoVec3 f = co_bsdf_eval(&s->bsdf, s->vertex->wo, wi, &pdf);
    if (is_black(f))
        return;
    float p_light =
        (float)s->n_light * co_light_sample_pdf(lights, s->origin, s->normal, &sample, wi);
    if (!(p_light > 0.0f))
        return;
    float p_bsdf = sample.is_delta ? 0.0f : (float)s->n_bsdf * co_ray_quantize_pdf(pdf);
    CoRay ray = {.org = s->origin,
                 .dir = wi,
                 .weight = co_scale(co_mul(s->weight, f), 1.0f / (p_light + p_bsdf)),
                 .emitter = sample.emitter,
                 .path = s->ray->path,
                 .kind = CO_RAY_LIGHT,
                 .depth = s->ray->depth + 1,
                 .branch = s->is_split ? i : s->ray->branch,
                 .width = s->vertex->width,
                 .spread = s->ray->spread,
                 .code = {code[0], code[1]}};
    co_emit(&c->emitter, &ray, ray_key(s->key));
}

// Kills paths that carry little, before they cost a segment. Returns the survivor's scale or 0.
static float roulette(const CohortRender *render, const Scatter *s, CoVec3 weight, uint32_t branch)
{
    if (s->ray->depth + 1 < ROULETTE_DEPTH)
        return 1.0f;
    float n = (float)render->settings.first_hit_samples, u;
    float survive = co_clamp(co_max3(weight) * n, 0.05f, 1.0f);
    if (survive >= 1.0f)
        return 1.0f;
    co_sample(s->key, s->ray->depth, 0, CO_DECISION_ROULETTE, branch,
              render->settings.first_hit_samples, 1, &u);
    return u < survive ? 1.0f / survive : 0.0f;
}

static void emit_bsdf_sample(ShadeContext *c, const Scatter *s, uint32_t i)
{
    float u[3] = {0}, pdf = INFINITY;
    CoBsdfSample sample;
    draw(c->render, s, CO_DECISION_BSDF, i, s->n_bsdf, s->bsdf.is_lambert ? 2 : 3, u);
    if (!co_bsdf_sample(&s->bsdf, s->vertex->wo, u[2], u[0], u[1], &sample))
        return;
    uint32_t code[2];
    CoVec3 wi = co_ray_snap_direction(sample.wi, code);
    CoVec3 f = sample.weight;
    if (!sample.is_delta) {
        f = co_bsdf_eval(&s->bsdf, s->vertex->wo, wi, &pdf);
        if (!(pdf > 0.0f))
            return;
        f = co_scale(f, 1.0f / pdf);
    }
    uint32_t branch = s->is_split ? i : s->ray->branch;
    CoVec3 weight = co_scale(co_mul(s->weight, f), 1.0f / (float)s->n_bsdf);
    float survive = is_black(weight) ? 0.0f : roulette(c->render, s, weight, branch);
    if (survive == 0.0f)
        return;
    bool competes = !sample.is_delta && s->n_light > 0;
    uint32_t flags = s->ray->flags & CO_RAY_HAS_SPLIT;
    if (s->is_split && !sample.is_delta)
        flags |= CO_RAY_FROM_SPLIT;
    if (s->is_split)
        flags |= CO_RAY_HAS_SPLIT;
    float cone = sample.is_delta ? 0.0f : SPREAD_PER_ROOT_PDF / sqrtf(pdf);
    CoRay ray = {.org = s->origin,
                 .dir = wi,
                 .weight = co_scale(weight, survive),
                 .pdf = sample.is_delta ? INFINITY
                        : competes      ? co_ray_quantize_pdf(pdf)
                                        : 0.0f,
                 .normal = s->normal,
                 .path = s->ray->path,
                 .kind = CO_RAY_BSDF,
                 .depth = s->ray->depth + 1,
                 .branch = branch,
                 .width = s->vertex->width,
                 .spread = fmaxf(s->ray->spread, cone),
                 .flags = flags,
                 .code = {code[0], code[1]},
                 .normal_code = s->normal_code};
    co_emit(&c->emitter, &ray, ray_key(s->key));
}

static void scatter(ShadeContext *c, Scatter *s)
{
    const CohortRender *render = c->render;
    if (s->ray->depth >= render->settings.max_depth)
        return;
    choose_counts(render, s);
    s->origin = co_vertex_origin(s->vertex, s->bsdf.ng);
    s->normal = co_ray_snap_normal(s->bsdf.n, &s->normal_code);
    for (uint32_t i = 0; i < s->n_light; i++)
        emit_light_sample(c, s, i);
    for (uint32_t i = 0; i < s->n_bsdf; i++)
        emit_bsdf_sample(c, s, i);
}

static void shade_surface(ShadeContext *c, const CoRay *ray, const CoHitRecord *hit,
                          const CoVertex *vertex)
{
    CohortRender *render = c->render;
    Scatter s = {
        .ray = ray, .vertex = vertex, .weight = ray->weight, .key = co_path_key(render, ray->path)};
    CoVec3 emissive;
    c->counts->hit++;
    co_vertex_bsdf(render->scene, vertex, &s.bsdf, &emissive);
    if (passes(c, hit, &s))
        return;
    if (ray->kind == CO_RAY_CAMERA)
        splat_first_hit(c, &s);
    if (!is_black(emissive))
        co_film_add_color(render->film, s.key.pixel, s.key.sample, co_mul(s.weight, emissive));
    scatter(c, &s);
}

// Hits are in mesh order, their records in ray order: each is a miss unless asked for in time.
static void prefetch_record(const CohortRender *render, uint32_t record)
{
    const uint32_t *words = &render->batch.records.words[(size_t)record * render->ray_words];
    __builtin_prefetch(words);
    __builtin_prefetch(words + render->ray_words - 1);
}

static void shade_hits(void *context, size_t begin, size_t end, uint32_t worker)
{
    CohortRender *render = context;
    CoActiveBatch *b = &render->batch;
    ShadeContext c = {.render = render,
                      .emitter = {.render = render, .worker = worker},
                      .counts = &render->workers[worker],
                      .memo = {.instance = COHORT_INVALID_ID}};
    if (co_render_is_cancelled(render))
        return;
    for (size_t i = begin; i < end; i++) {
        const CoHitRecord *hit = &b->hit_records[i];
        const uint32_t *words = &b->records.words[(size_t)hit->record * render->ray_words];
        if (i + PREFETCH_HITS < end)
            prefetch_record(render, hit[PREFETCH_HITS].record);
        CoRay ray;
        // A ray that may pass goes back to the bins with all that it has.
        if (render->scene->has_cutouts)
            co_ray_decode(words, render->ray_options, &ray);
        else
            co_ray_decode_shading(words, render->ray_options, &ray);
        CoVertex vertex;
        vertex.hit.texels =
            b->lookup_count ? (const float(*)[4]) & b->texels[hit->first_lookup] : NULL;
        co_vertex_make(render->scene, &c.memo, hit, &ray, &vertex);
        if (ray.kind == CO_RAY_LIGHT)
            shade_light_ray(&c, &ray, hit, &vertex);
        else
            shade_surface(&c, &ray, hit, &vertex);
    }
    co_emit_flush(&c.emitter);
}

void co_stage_shade(CohortRender *render)
{
    double start = co_clock_seconds();
    co_parallel_for(render->batch.hit_count, 1024, shade_hits, render);
    render->seconds_shade += co_clock_seconds() - start;
}
