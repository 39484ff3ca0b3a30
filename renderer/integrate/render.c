// The render: rounds of samples, each a run of batches until every bin is empty.

#include "integrate/render_data.h"

#include "base/clock.h"
#include "base/error.h"
#include "base/mapped_file.h"
#include "base/parallel.h"
#include "light/light.h"

#include <string.h>
#include <unistd.h>

#define TAG CO_MEMORY_RAYS

// Scenes whose geometry and trees fit the inner caches trace as fast unsorted: hits are met in mesh
// order, so rays leave them in one. Sorting is skipped.
#define SORT_PAYS_BYTES ((uint64_t)1 << 20)

static uint32_t or_default(uint32_t value, uint32_t fallback)
{
    return value ? value : fallback;
}

static bool check_settings(const CohortRenderSettings *s, CohortError *err)
{
    CO_CHECK(s->width <= 65536 && s->height <= 65536, err, COHORT_ERROR_ARGUMENT,
             "%u x %u pixels: at most 65536 a side", s->width, s->height);
    CO_CHECK((uint64_t)s->width * s->height < UINT32_MAX, err, COHORT_ERROR_ARGUMENT,
             "%u x %u is more pixels than fit one image: at most 2^32 - 2", s->width, s->height);
    CO_CHECK(s->spp <= 1u << 31, err, COHORT_ERROR_ARGUMENT, "%u samples: at most 2^31", s->spp);
    CO_CHECK(s->max_depth <= 1023, err, COHORT_ERROR_ARGUMENT, "path length %u: at most 1023",
             s->max_depth);
    CO_CHECK(s->first_hit_samples <= 255 && s->light_samples <= 255, err, COHORT_ERROR_ARGUMENT,
             "at most 255 samples at the split");
    CO_CHECK(!s->batch || (s->batch >= 1u << 8 && s->batch <= 1u << 26), err, COHORT_ERROR_ARGUMENT,
             "batch of %u rays: 256 to 67108864", s->batch);
    CO_CHECK(!(s->noise < 0.0) && !(s->time_limit_seconds < 0.0), err, COHORT_ERROR_ARGUMENT,
             "noise and time limit cannot be negative");
    return true;
}

static void fill_defaults(CohortRenderSettings *s)
{
    s->width = or_default(s->width, 1280);
    s->height = or_default(s->height, 720);
    s->spp = or_default(s->spp, 64);
    s->max_depth = or_default(s->max_depth, 6);
    s->first_hit_samples = or_default(s->first_hit_samples, 1);
    s->light_samples = or_default(s->light_samples, 1);
    s->batch = or_default(s->batch, 1u << 22);
    s->aovs |= COHORT_AOV_COLOR;
}

static bool alloc_batch(CoActiveBatch *b, size_t n, CohortError *err)
{
    b->capacity = n;
    b->order = co_alloc(TAG, n * sizeof *b->order);
    b->flags = co_alloc(TAG, n);
    b->hit_records = co_alloc(TAG, n * sizeof *b->hit_records);
    b->hit_sorted = co_alloc(TAG, n * sizeof *b->hit_sorted);
    b->hit_object = co_alloc(TAG, n * sizeof *b->hit_object);
    b->hit_tri = co_alloc(TAG, n * sizeof *b->hit_tri);
    b->hit_order = co_alloc(TAG, n * sizeof *b->hit_order);
    CO_CHECK(b->order && b->flags && b->hit_records && b->hit_sorted && b->hit_object &&
                 b->hit_tri && b->hit_order,
             err, COHORT_ERROR_OUT_OF_MEMORY,
             "out of memory for a batch of %zu rays: use a smaller --batch", n);
    return co_ray_batch_reserve(&b->rays, n, err) && co_hit_batch_reserve(&b->hits, n, err);
}

static void free_batch(CoActiveBatch *b)
{
    size_t n = b->capacity;
    co_ray_batch_clear(&b->rays);
    co_hit_batch_clear(&b->hits);
    co_free(TAG, b->order, n * sizeof *b->order);
    co_free(TAG, b->flags, n);
    co_free(TAG, b->hit_records, n * sizeof *b->hit_records);
    co_free(TAG, b->hit_sorted, n * sizeof *b->hit_sorted);
    co_free(TAG, b->hit_object, n * sizeof *b->hit_object);
    co_free(TAG, b->hit_tri, n * sizeof *b->hit_tri);
    co_free(TAG, b->hit_order, n * sizeof *b->hit_order);
    co_sort_scratch_clear(&b->sort_scratch);
    co_free(CO_MEMORY_TEXTURE, b->lookups, b->lookup_capacity * sizeof *b->lookups);
    co_free(CO_MEMORY_TEXTURE, b->texels, b->lookup_capacity * sizeof *b->texels);
}

// A power of two above anything a path can carry: the brightest emitter, emissive surfaces
// included.
static int film_exponent(const CohortScene *scene)
{
    float brightest = 1.0f;
    if (co_lights_count(scene->lights))
        brightest = fmaxf(brightest, co_lights_max_radiance(scene->lights));
    for (uint32_t i = 0; i < scene->material_count; i++)
        for (int k = 0; k < 3; k++)
            brightest = fmaxf(brightest, scene->materials[i].inputs[CO_INPUT_EMISSIVE].value[k]);
    // Tiny lights are very bright and light little: 20 of the 24 bits of headroom above S go to
    // them.
    float exponent = isfinite(brightest) ? (float)ilogbf(brightest) + 1.0f : 120.0f;
    exponent -= co_clamp(exponent - 20.0f, 0.0f, 20.0f);
    return (int)co_clamp(exponent, 0.0f, 120.0f);
}

static void choose_sort(CohortRender *r)
{
    const CohortSceneCounts *c = &r->scene->counts;
    CohortSort sort = r->settings.sort;
    bool pays = c->geometry_bytes + c->accel_bytes > SORT_PAYS_BYTES;
    r->sorts_rays =
        sort == COHORT_SORT_RAYS || sort == COHORT_SORT_BOTH || (sort == COHORT_SORT_AUTO && pays);
    // Rays of a small scene in the order of their bins share enough of the top level as they are.
    r->groups_rays = r->sorts_rays || sort == COHORT_SORT_AUTO;
    r->sorts_hits =
        sort == COHORT_SORT_HITS || sort == COHORT_SORT_BOTH || sort == COHORT_SORT_AUTO;
}

// A folder that is named must do, even if all of the render should fit into memory.
static bool keep_scratch_folder(CohortRender *r, const char *folder, CohortError *err)
{
    if (!folder)
        return true;
    size_t length = strlen(folder) + 1;
    r->scratch = co_alloc(TAG, length);
    CO_CHECK_MEMORY(r->scratch, err);
    memcpy(r->scratch, folder, length);
    int fd = co_scratch_file(folder, 0, err);
    if (fd >= 0)
        close(fd);
    return fd >= 0;
}

static bool create_parts(CohortRender *r, CohortError *err)
{
    const CohortRenderSettings *s = &r->settings;
    r->kernels = co_accel_kernels(s->isa);
    r->codes = co_ray_kernels(s->isa);
    r->sorter = (CoRaySorter){s->sorter, co_ray_keys(s->isa)};
    CO_CHECK(r->kernels && r->codes, err, COHORT_ERROR_ARGUMENT,
             "this machine has no instruction set \"%s\"; scalar, sse42, avx2, avx512 are known",
             s->isa ? s->isa : "");
    if (!keep_scratch_folder(r, s->scratch_folder, err))
        return false;
    r->settings.isa = NULL;
    r->settings.scratch_folder = NULL;
    r->workers = co_alloc_zero(TAG, r->worker_count * sizeof *r->workers);
    CO_CHECK_MEMORY(r->workers, err);
    r->film = co_film_create(s->width, s->height, s->aovs, film_exponent(r->scene), err);
    if (!r->film)
        return false;
    co_film_set_alone(r->film, r->worker_count == 1);
    r->bins =
        co_ray_bins_create(s->batch, r->ray_words, r->worker_count, r->bin_memory, r->scratch, err);
    if (!r->bins)
        return false;
    return alloc_batch(&r->batch, s->batch, err);
}

CohortRender *cohort_render_create(const CohortScene *scene, const CohortRenderSettings *settings,
                                   CohortError *err)
{
    CO_CHECK_NULL(scene->is_committed, err, COHORT_ERROR_ARGUMENT,
                  "the scene has edits that are not committed");
    if (!check_settings(settings, err))
        return NULL;
    CohortRender *r = co_alloc_zero(TAG, sizeof *r);
    CO_CHECK_NULL(r, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for a render");
    r->scene = scene;
    r->settings = *settings;
    fill_defaults(&r->settings);
    co_worker_count_set(r->settings.threads);
    r->worker_count = co_worker_count();
    r->pixels = r->settings.width * r->settings.height;
    r->ray_options = scene->has_cutouts ? CO_RAY_OPTION_TNEAR : 0;
    r->ray_words = co_ray_words(r->ray_options);
    r->start_seconds = co_clock_seconds();
    choose_sort(r);
    if (!co_render_fit_memory(r, err) || !create_parts(r, err)) {
        cohort_render_destroy(r);
        return NULL;
    }
    return r;
}

void cohort_render_destroy(CohortRender *r)
{
    if (!r)
        return;
    co_ray_bins_destroy(r->bins);
    co_film_destroy(r->film);
    free_batch(&r->batch);
    co_free(TAG, r->workers, r->worker_count * sizeof *r->workers);
    if (r->scratch)
        co_free(TAG, r->scratch, strlen(r->scratch) + 1);
    co_free(TAG, r, sizeof *r);
}

void cohort_render_cancel(CohortRender *r)
{
    __atomic_store_n(&r->cancel, 1, __ATOMIC_RELAXED);
}

// Samples of the next round, within what is left of the time limit.
static uint32_t next_round(const CohortRender *r)
{
    uint32_t last = r->rounds ? r->round_samples : 0;
    uint64_t want =
        co_schedule_round(r->samples_done, r->settings.spp, r->pixels, last, r->last_round_seconds);
    double limit = r->settings.time_limit_seconds;
    if (limit > 0.0 && last > 0 && r->last_round_seconds > 0.0) {
        double fits = (limit - r->spent_seconds) * (double)last / r->last_round_seconds;
        want = fits < (double)want ? (uint64_t)fmax(fits, 1.0) : want;
    }
    return (uint32_t)want;
}

static void note_progress(CohortRender *r)
{
    uint64_t paths = (uint64_t)r->round_samples * r->pixels;
    double within = paths ? (double)r->camera_next / (double)paths * (double)r->round_samples : 0.0;
    double by_samples = ((double)r->samples_done + 0.98 * within) / (double)r->settings.spp;
    double limit = r->settings.time_limit_seconds;
    double by_time = limit > 0.0 ? (co_clock_seconds() - r->start_seconds) / limit : 0.0;
    double p = fmax(by_samples, fmin(by_time, 0.99));
    if (p > atomic_load(&r->progress))
        atomic_store(&r->progress, p);
}

double cohort_render_progress(const CohortRender *r)
{
    return atomic_load(&r->progress);
}

static bool process_batch(CohortRender *r, CohortError *err)
{
    // A cancelled traversal leaves hits unset: nothing may read them.
    bool ok = co_stage_trace(r, err) && !co_render_is_cancelled(r) && co_stage_ends(r, err) &&
              co_stage_request(r, err);
    if (ok)
        co_stage_shade(r);
    co_ray_bins_recycle(r->bins, &r->batch.records);
    return ok || CO_FAIL(err, COHORT_ERROR_CANCELLED, "the render was stopped");
}

static void make_camera_rays(CohortRender *r, uint64_t paths)
{
    double start = co_clock_seconds();
    uint64_t left = paths - r->camera_next;
    co_stage_camera(r, left < r->settings.batch ? (size_t)left : r->settings.batch);
    r->seconds_camera += co_clock_seconds() - start;
    note_progress(r);
}

static bool run_round(CohortRender *r, CohortError *err)
{
    uint64_t paths = (uint64_t)r->round_samples * r->pixels;
    for (;;) {
        CoScheduleStep step =
            co_schedule_next(r->bins, r->camera_next < paths, &r->batch.records, err);
        if (step == CO_SCHEDULE_DONE || step == CO_SCHEDULE_FAILED)
            return step == CO_SCHEDULE_DONE;
        if (step == CO_SCHEDULE_CAMERA)
            make_camera_rays(r, paths);
        else if (!process_batch(r, err))
            return false;
        CO_CHECK(!co_render_is_cancelled(r), err, COHORT_ERROR_CANCELLED, "the render was stopped");
    }
}

static uint64_t committed_rays(const CohortRender *r)
{
    CoRayBinStats stats;
    co_ray_bins_stats(r->bins, &stats);
    uint64_t sum = 0;
    for (int i = 0; i < CO_RAY_BINS; i++)
        sum += stats.committed[i];
    return sum;
}

static void add_counts(CoWorkerCounts *sum, const CoWorkerCounts *w)
{
    for (int k = 0; k < 3; k++)
        sum->made[k] += w->made[k];
    sum->traced += w->traced;
    sum->hit += w->hit;
    sum->miss += w->miss;
    sum->blocked += w->blocked;
    sum->invalid += w->invalid;
    sum->light_reached += w->light_reached;
    sum->overflows += w->overflows;
    sum->underflows += w->underflows;
    sum->traverse.groups += w->traverse.groups;
    sum->traverse.top_nodes_grouped += w->traverse.top_nodes_grouped;
    sum->traverse.top_nodes_single += w->traverse.top_nodes_single;
    sum->traverse.bottom_nodes += w->traverse.bottom_nodes;
    sum->traverse.triangles += w->traverse.triangles;
    sum->traverse.invalid += w->traverse.invalid;
}

// No ray is lost: what the bins took in this round has been traced and has ended, once each. The
// two sides are counted apart, by the bins and by the stages.
static bool settle_counts(CohortRender *r, uint64_t committed_before, CohortError *err)
{
    CoWorkerCounts round = {0};
    for (uint32_t i = 0; i < r->worker_count; i++)
        add_counts(&round, &r->workers[i]);
    memset(r->workers, 0, r->worker_count * sizeof *r->workers);
    add_counts(&r->total, &round);
    uint64_t made = round.made[0] + round.made[1] + round.made[2];
    uint64_t committed = committed_rays(r) - committed_before;
    uint64_t ended = round.hit + round.miss + round.blocked + round.invalid;
    CO_CHECK(made == committed && committed == round.traced && committed == ended, err,
             COHORT_ERROR_INTERNAL,
             "rays were lost: %llu made, %llu in bins, %llu traced, %llu ended",
             (unsigned long long)made, (unsigned long long)committed,
             (unsigned long long)round.traced, (unsigned long long)ended);
    return true;
}

bool cohort_render_round(CohortRender *r, CohortError *err)
{
    if (cohort_render_is_done(r))
        return true;
    double start = co_clock_seconds();
    co_worker_count_set(r->worker_count);
    uint32_t previous = r->round_samples;
    uint64_t committed = committed_rays(r);
    r->round_samples = next_round(r);
    r->camera_next = 0;
    bool ok = run_round(r, err) && settle_counts(r, committed, err) &&
              co_film_complete(r->film, r->samples_done + r->round_samples, err);
    double seconds = co_clock_seconds() - start;
    r->spent_seconds += seconds;
    if (!ok) {
        co_film_revert(r->film);
        co_ray_bins_reset(r->bins);
        memset(r->workers, 0, r->worker_count * sizeof *r->workers);
        r->round_samples = previous;
        __atomic_store_n(&r->cancel, 0, __ATOMIC_RELAXED);
        return false;
    }
    r->last_round_seconds = seconds;
    r->samples_done += r->round_samples;
    r->rounds++;
    r->mean_error = co_film_mean_error(r->film);
    r->is_noise_reached =
        r->settings.noise > 0.0 && r->samples_done >= 4 && r->mean_error <= r->settings.noise;
    r->camera_next = 0;
    note_progress(r);
    if (cohort_render_is_done(r))
        atomic_store(&r->progress, 1.0);
    return true;
}

bool cohort_render_is_done(const CohortRender *r)
{
    double limit = r->settings.time_limit_seconds;
    return r->samples_done >= r->settings.spp || r->is_noise_reached ||
           (limit > 0.0 && r->samples_done > 0 && r->spent_seconds >= limit);
}
