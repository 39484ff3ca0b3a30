// What a render gives away: AOVs, statistics, and its film for another day.

#include "cohort/image.h"
#include "integrate/render_data.h"

#include "base/error.h"
#include "base/hash.h"
#include "shims/ocio.h"
#include "shims/oiio.h"
#include "shims/osd.h"

uint32_t cohort_aov_components(CohortAov aov)
{
    if (aov == COHORT_AOV_COLOR)
        return 4;
    return aov == COHORT_AOV_NORMAL || aov == COHORT_AOV_ALBEDO ? 3 : 1;
}

bool cohort_render_aov(const CohortRender *r, CohortAov aov, void *out)
{
    return (r->settings.aovs & (uint32_t)aov) && co_film_resolve(r->film, aov, out);
}

static void ray_stats(const CohortRender *r, CohortRenderStats *out)
{
    const CoWorkerCounts *t = &r->total;
    out->rays_camera = t->made[CO_RAY_CAMERA];
    out->rays_bsdf = t->made[CO_RAY_BSDF];
    out->rays_light = t->made[CO_RAY_LIGHT];
    out->rays_made = out->rays_camera + out->rays_bsdf + out->rays_light;
    out->rays_traced = t->traced;
    out->ends_hit = t->hit;
    out->ends_miss = t->miss;
    out->ends_blocked = t->blocked;
    out->ends_invalid = t->invalid;
    out->ends_light_reached = t->light_reached;
    out->weight_overflows = t->overflows;
    out->weight_underflows = t->underflows;
    out->groups = t->traverse.groups;
    out->top_nodes_grouped = t->traverse.top_nodes_grouped;
    out->top_nodes_single = t->traverse.top_nodes_single;
    out->ray_bytes = r->ray_words * 4;
}

static void bin_stats(const CohortRender *r, CohortRenderStats *out)
{
    CoRayBinStats bins;
    co_ray_bins_stats(r->bins, &bins);
    for (int i = 0; i < 6; i++)
        out->batches[i] = bins.batches[i];
    out->batches_drained = bins.drained;
    out->ready_depth_peak = bins.ready_depth_peak;
    out->bins_in_memory = bins.files_in_memory;
    out->bins_on_disk = bins.files_on_disk;
    out->bytes_written = bins.bytes_written;
    out->bytes_read = bins.bytes_read;
    out->wait_seconds = bins.wait_seconds;
}

void cohort_render_stats(const CohortRender *r, CohortRenderStats *out)
{
    CohortRenderStats zero = {0};
    *out = zero;
    out->rounds = r->rounds;
    out->samples_per_pixel = r->samples_done;
    ray_stats(r, out);
    bin_stats(r, out);
    out->texture_lookups = r->lookups.lookups;
    out->texture_requests = r->lookups.requests;
    out->texture_blocks_read = r->lookups.blocks_read;
    out->texture_blocks_twice = r->lookups.blocks_twice;
    out->film_saturations = co_film_saturations(r->film);
    out->film_dropped = co_film_dropped(r->film);
    out->seconds_camera = r->seconds_camera;
    out->seconds_sort_rays = r->seconds_sort_rays;
    out->seconds_traverse = r->seconds_traverse;
    out->seconds_sort_hits = r->seconds_sort_hits;
    out->seconds_texture = r->seconds_texture;
    out->seconds_shade = r->seconds_shade;
    out->seconds_total = r->spent_seconds;
    out->mean_error = r->mean_error;
    out->isa = r->kernels->isa;
}

// Everything that decides the pixels, and nothing of the schedule. The number of samples is left
// out: a film may be taken further than was first asked for.
static uint64_t film_key(const CohortRender *r, uint64_t stage_hash)
{
    const CohortRenderSettings *s = &r->settings;
    uint64_t words[] = {s->width,         s->height,
                        s->max_depth,     s->first_hit_samples,
                        s->light_samples, s->no_light_samples_after_split,
                        s->filter,        (uint64_t)s->hide_lights | (uint64_t)s->hide_domes << 1,
                        s->seed,          s->aovs,
                        s->texture_level0};
    return co_hash_bytes(words, sizeof words, stage_hash);
}

bool cohort_render_save(const CohortRender *r, const char *path, uint64_t stage_hash,
                        CohortError *err)
{
    return co_film_save(r->film, path, film_key(r, stage_hash), err);
}

bool cohort_render_resume(CohortRender *r, const char *path, uint64_t stage_hash, CohortError *err)
{
    CO_CHECK(r->samples_done == 0, err, COHORT_ERROR_ARGUMENT,
             "a render can be resumed only before its first round");
    if (!co_film_load(r->film, path, film_key(r, stage_hash), err))
        return false;
    r->samples_done = co_film_samples(r->film);
    r->mean_error = co_film_mean_error(r->film);
    return true;
}

void cohort_library_versions(CohortLibraryVersions *out)
{
    const CoAccelKernels *kernels = co_accel_kernels(NULL);
    out->opensubdiv = co_osd_version();
    out->openimageio = co_oiio_version();
    out->opencolorio = co_ocio_version();
    out->openexr = cohort_exr_library_version();
    out->isa = kernels ? kernels->isa : "none";
}
