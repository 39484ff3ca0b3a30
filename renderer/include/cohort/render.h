// Rendering a committed scene in rounds (Eisenacher et al. 2013, section 3 and figure 2).
//
// A round adds some samples to every pixel and is complete when all its rays have ended. Only
// complete rounds are shown, saved, counted or resumed from. The pixels depend on the scene and on
// the settings marked "image" only: never on threads, batch, sort, memory, ISA or where it stopped.
//
// Threads: one thread drives a render; cohort_render_cancel may be called from any.

#ifndef COHORT_RENDER_H
#define COHORT_RENDER_H

#include "cohort/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct CohortRender CohortRender;

typedef enum CohortSort {
    COHORT_SORT_AUTO = 0, // rays and hits, but skips the ray sort where it does not pay
    COHORT_SORT_NONE,
    COHORT_SORT_RAYS,
    COHORT_SORT_HITS,
    COHORT_SORT_BOTH
} CohortSort;

typedef enum CohortSorter {
    COHORT_SORTER_FAST = 0, // key-based, when it traverses as well as the exact one
    COHORT_SORTER_EXACT     // recursive median partition, section 3.1
} CohortSorter;

typedef enum CohortFilter {
    COHORT_FILTER_BLACKMAN_HARRIS = 0, // radius 2 pixels
    COHORT_FILTER_BOX,                 // width 1 pixel
    COHORT_FILTER_GAUSSIAN             // radius 1.5 pixels
} CohortFilter;

// AOVs as bits. Color is always there.
typedef enum CohortAov {
    COHORT_AOV_COLOR = 1 << 0, // 4 floats, premultiplied RGBA, filtered; seen lights cover
    COHORT_AOV_DEPTH = 1 << 1, // 1 float, clip space [0, 1], first sample that hit, 1 = none
    COHORT_AOV_CAMERA_DEPTH =
        1 << 2,                     // 1 float, distance along -Z, first sample that hit, inf = none
    COHORT_AOV_NORMAL = 1 << 3,     // 3 floats, world, filtered
    COHORT_AOV_ALBEDO = 1 << 4,     // 3 floats, filtered
    COHORT_AOV_PRIM_ID = 1 << 5,    // int32, -1 = none
    COHORT_AOV_ELEMENT_ID = 1 << 6, // int32 face of the cage, -1 = none
    COHORT_AOV_SAMPLE_COUNT = 1 << 7, // 1 float
    COHORT_AOV_ERROR = 1 << 8         // 1 float, estimated standard error of the mean of R, G, B
} CohortAov;

// Zero is the default of every field.
typedef struct CohortRenderSettings {
    // Image: these decide the pixels.
    uint32_t width, height;     // pixels, 0 = 1280 x 720
    uint32_t spp;               // samples per pixel, 0 = 64; up to 2^31
    uint32_t max_depth;         // path length in segments, the camera's is 1; 0 = 6; most 1023
    uint32_t first_hit_samples; // BSDF rays at the split, 0 = 1; most 255
    uint32_t light_samples;     // light samples at the split, 0 = 1; most 255
    bool no_light_samples_after_split; // --preset paper
    CohortFilter filter;
    bool hide_lights; // from the camera's own rays
    bool hide_domes;  // the same for dome lights alone
    uint32_t seed;
    uint32_t aovs;       // CohortAov bits
    double noise;        // stop at a round whose mean relative error is below this, 0 = off
    bool texture_level0; // look textures up at full resolution: for references

    // Schedule: these never change a pixel.
    double time_limit_seconds; // stop at the first round that ends after it, 0 = off
    uint32_t batch;            // rays per bin, 0 = 2^22; 2^8 to 2^26
    uint64_t memory;           // bytes, 0 = no limit
    uint32_t threads;          // 0 = all
    CohortSort sort;
    CohortSorter sorter;
    const char *isa;            // "scalar", "sse42", "avx2", "avx512"; NULL = best
    const char *scratch_folder; // NULL = $TMPDIR or /tmp
} CohortRenderSettings;

// Counted on both sides and by kind; all since create.
typedef struct CohortRenderStats {
    uint64_t rounds, samples_per_pixel;
    uint64_t rays_made, rays_camera, rays_bsdf, rays_light; // committed to bins
    uint64_t rays_traced, ends_hit, ends_miss, ends_blocked, ends_invalid;
    uint64_t ends_light_reached;                  // light-sample rays that met their emitter
    uint64_t weight_overflows, weight_underflows; // of the 36-byte record
    uint64_t batches[6], batches_drained;
    uint32_t ready_depth_peak;             // most full batches waiting at once
    uint32_t bins_in_memory, bins_on_disk; // most at once
    uint64_t bytes_written, bytes_read;    // of bins on disk
    double wait_seconds;                   // for a batch to be paged in
    uint32_t ray_bytes;                    // 36, 40 or 44
    uint64_t groups, top_nodes_grouped,
        top_nodes_single; // node fetches: by 64-groups; as single rays would
    uint64_t texture_lookups, texture_requests, texture_blocks_read, texture_blocks_twice;
    uint64_t film_saturations, film_dropped; // values beyond its sums; that were not finite
    double seconds_camera, seconds_sort_rays, seconds_traverse, seconds_sort_hits, seconds_texture,
        seconds_shade, seconds_total;
    double mean_error; // mean relative error estimate after the last round
    const char *isa;   // static
} CohortRenderStats;

// Prepares a render. The scene must be committed, outlive the render and stay unedited meanwhile.
// The settings are copied. NULL with COHORT_ERROR_ARGUMENT for a setting out of its range, _LIMIT
// where `memory` is too little (the message says what would do), _OUT_OF_MEMORY, or a scratch
// folder's fault.
CohortRender *cohort_render_create(const CohortScene *scene, const CohortRenderSettings *settings,
                                   CohortError *err);
void cohort_render_destroy(CohortRender *render); // NULL is allowed

// Renders one round. Returns false on error or cancellation; the film then holds the last complete
// round, and after a cancellation (COHORT_ERROR_CANCELLED) the call may be repeated. Other errors:
// _OUT_OF_MEMORY, _FILE_WRITE and _FILE_READ of scratch files, _INTERNAL where rays were lost.
bool cohort_render_round(CohortRender *render, CohortError *err);

// True when the target (samples, time or noise) is reached.
bool cohort_render_is_done(const CohortRender *render);

// Makes the round that runs, or else the next one, return soon with COHORT_ERROR_CANCELLED, once.
// Any thread, any time.
void cohort_render_cancel(CohortRender *render);

// Fraction of the target reached, 0 to 1, rising within a round too. Any thread.
double cohort_render_progress(const CohortRender *render);

// Of the complete rounds so far; between rounds.
void cohort_render_stats(const CohortRender *render, CohortRenderStats *out);

// Copies one AOV of the last complete round. `out` holds width * height * components floats (int32
// bits for the ids), rows from top to bottom. False when the AOV was not asked for.
bool cohort_render_aov(const CohortRender *render, CohortAov aov, void *out);
uint32_t cohort_aov_components(CohortAov aov); // floats per pixel: 1, 3 or 4

// Writes the film of the last complete round so that a later render of the same scene and image
// settings can go on from it; replaces `path` atomically. stage_hash: whatever tells the caller's
// scenes apart. COHORT_ERROR_FILE_WRITE leaves an older file as it was.
bool cohort_render_save(const CohortRender *render, const char *path, uint64_t stage_hash,
                        CohortError *err);
// Goes on from such a file, before the first round. Refuses another size, seed, settings or stage
// by name (COHORT_ERROR_ARGUMENT), and files that are not there or damaged (_FILE_NOT_FOUND,
// _FILE_READ).
bool cohort_render_resume(CohortRender *render, const char *path, uint64_t stage_hash,
                          CohortError *err);

// What Cohort was built with, and the instruction set it would choose. Static strings.
typedef struct CohortLibraryVersions {
    const char *opensubdiv, *openimageio, *opencolorio, *openexr, *isa;
} CohortLibraryVersions;
void cohort_library_versions(CohortLibraryVersions *out);

#ifdef __cplusplus
}
#endif

#endif
