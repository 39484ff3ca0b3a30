// One render: settings, bins, the active batch's arrays, film and counters.
//
// The stages of a batch, in the order of figure 2 of Eisenacher et al. 2013, one file each:
// camera.c makes rays; trace.c sorts, decodes and traverses a batch; ends.c settles misses, light
// rays and lights met on the way; request_textures.c sorts hits and looks textures up; shade.c
// evaluates materials and feeds new rays back into the bins.

#ifndef CO_INTEGRATE_RENDER_DATA_H
#define CO_INTEGRATE_RENDER_DATA_H

#include "cohort/render.h"
#include "film/film.h"
#include "integrate/scene_data.h"
#include "rays/ray_batch.h"
#include "rays/ray_kernels.h"
#include "rays/schedule.h"
#include "sample/sample.h"
#include "sort/ray_sort.h"

#include <stdatomic.h>

enum {
    CO_GROUP_RAYS = 64
};

// Per-worker counters, summed by the round; apart by a cache line.
typedef struct CoWorkerCounts {
    uint64_t made[3]; // by CoRayKind: records given to the bins
    uint64_t traced, hit, miss, blocked, invalid, light_reached, overflows, underflows;
    CoTraverseStats traverse;
    char pad[64];
} CoWorkerCounts;

// A hit that goes to shading, compact so that sorting it costs one gather.
typedef struct CoHitRecord {
    float t, u, v;
    uint32_t instance, object, tri;
    uint32_t record; // index of the ray's record in the batch
    uint32_t first_lookup;
    CoVec3 dir; // of the ray: it has been decoded once
} CoHitRecord;

// Arrays of the active batch, reused from batch to batch. capacity = rays of a bin.
typedef struct CoActiveBatch {
    CoRayRecords records;
    uint32_t *order; // [capacity] of the records, where rays are sorted
    CoRayBatch rays;
    CoHitBatch hits;
    uint8_t *flags;                             // [capacity] of co_traverse
    CoHitRecord *hit_records;                   // [capacity], in ray order, then in shading order
    CoHitRecord *hit_sorted;                    // [capacity]
    uint32_t *hit_object, *hit_tri, *hit_order; // [capacity] keys and result of the hit sort
    CoSortScratch sort_scratch;
    size_t hit_count;
    size_t capacity;
    CoLookup *lookups; // [lookup_count]
    float (*texels)[4];
    size_t lookup_count, lookup_capacity;
} CoActiveBatch;

struct CohortRender {
    const CohortScene *scene;
    CohortRenderSettings settings; // every default filled in
    const CoAccelKernels *kernels;
    const CoRayKernels *codes;
    CoRaySorter sorter;
    CoFilm *film;
    CoRayBins *bins;
    CoActiveBatch batch;
    CoWorkerCounts *workers;
    uint32_t worker_count;
    uint32_t ray_options, ray_words;
    CoWorkerCounts total;
    CoLookupStats lookups;
    uint64_t lookup_batches;
    bool sorts_rays, sorts_hits;
    bool groups_rays; // traverses 64 at a time; else ray by ray, as the unsorted modes do
    uint32_t pixels;
    uint64_t bin_memory; // bytes that bins may take before they go to disk
    char *scratch;       // kept copy of settings.scratch_folder, NULL = default

    // The open round.
    uint64_t samples_done;  // per pixel, complete rounds
    uint32_t round_samples; // per pixel, of the open round
    uint64_t camera_next;   // next path of the round to make
    uint64_t rounds;
    double last_round_seconds, start_seconds, spent_seconds;
    double seconds_camera, seconds_sort_rays, seconds_traverse, seconds_sort_hits, seconds_texture,
        seconds_shade;
    double mean_error;
    bool is_noise_reached;
    _Atomic double progress;
    volatile int cancel; // set by any thread, through co_render_is_cancelled's atomics
};

// A worker's way of making rays: they wait in the queue until it is full or flushed, then they are
// encoded and pushed, and counted. {render, worker} is ready.
typedef struct CoEmitter {
    CohortRender *render;
    uint32_t worker;
    CoRayQueue queue;
} CoEmitter;
void co_emit_flush(CoEmitter *emitter); // before the emitter goes

static inline void co_emit(CoEmitter *emitter, const CoRay *ray, CoRayKey key)
{
    if (co_ray_queue_add(&emitter->queue, ray, key))
        co_emit_flush(emitter);
}

static inline bool co_render_is_cancelled(const CohortRender *render)
{
    return __atomic_load_n(&render->cancel, __ATOMIC_RELAXED) != 0;
}

// Pixel and absolute sample of a path id of the open round. The samples of a pixel stand together:
// their rays meet the same surfaces and their light the same words of the film.
static inline void co_path_split(const CohortRender *render, uint32_t path, uint32_t *pixel,
                                 uint32_t *sample)
{
    *pixel = path / render->round_samples;
    *sample = (uint32_t)render->samples_done + path % render->round_samples;
}

static inline CoSampleKey co_path_key(const CohortRender *render, uint32_t path)
{
    CoSampleKey key;
    co_path_split(render, path, &key.pixel, &key.sample);
    key.seed = render->settings.seed;
    return key;
}

// Distance along a camera ray to the far clip plane from where the ray starts.
float co_camera_far(const CoCamera *camera, CoVec3 dir);

// Distance in front of the camera, along -Z of its frame, of a point.
float co_camera_depth(const CoCamera *camera, CoVec3 p);

// Distance to the first finite light that a camera ray shows, INFINITY if there is none.
float co_camera_light_distance(const CohortRender *render, CoVec3 org, CoVec3 dir, float tnear);

// MIS weight of emission met by a BSDF ray, or 1 where no light sample competed.
float co_mis_emission(const CohortRender *render, const CoRay *ray, uint32_t emitter);

// Brings the batch and what textures may keep down until the render fits settings.memory, and
// leaves to bins what is left. False with what it would need where that is not enough.
bool co_render_fit_memory(CohortRender *render, CohortError *err);

// The CohortHidden bit of rays by CoRayKind.
uint8_t co_trace_class(uint32_t kind);

// The stages.
void co_stage_camera(CohortRender *render, size_t count);
bool co_stage_trace(CohortRender *render, CohortError *err);
bool co_stage_ends(CohortRender *render, CohortError *err);
bool co_stage_request(CohortRender *render, CohortError *err);
void co_stage_shade(CohortRender *render);

#endif
