// Keeps a render within a limit of resident memory, without a change to any pixel.
//
// What the process holds when the render begins is measured: libraries, stage, geometry, trees,
// images of lights, the host's buffers. What the render adds is known from its settings but for
// three things that give way: texels that stay decoded, requests of lookups kept in core, and rays
// per batch. What they leave is for bins, which are on disk otherwise.

#include "integrate/render_data.h"

#include "base/error.h"
#include "base/memory.h"

// Stacks, queues, and what the libraries still allocate when images are written.
#define SLACK_BYTES ((uint64_t)6 << 20)

enum {
    LEAST_BATCH = 1024
};

// The batch's arrays, and its records and those that are paged in next, which are mapped.
static uint64_t bytes_per_ray(const CohortRender *r)
{
    const uint64_t arrays = 10 * sizeof(float) + 6 * sizeof(float) + 1;
    const uint64_t hits = 2 * sizeof(CoHitRecord) + 3 * sizeof(uint32_t), scratch = 64;
    return arrays + hits + scratch + 2 * r->ray_words * sizeof(uint32_t);
}

// The most lookups that one hit can need, and what each keeps through a batch: itself, its result
// and about two requests with their weights and places in the sort.
static uint64_t lookup_bytes_per_ray(const CohortScene *scene)
{
    uint32_t most = 0;
    for (uint32_t i = 0; i < scene->material_count; i++)
        if (scene->materials[i].lookup_count > most)
            most = scene->materials[i].lookup_count;
    return (uint64_t)most * (sizeof(CoLookup) + 4 * sizeof(float) + 336);
}

// The film, and what resolving and writing the pixels takes; the host has its buffers already.
static uint64_t image_bytes(const CohortRender *r)
{
    const CohortRenderSettings *s = &r->settings;
    uint64_t components = 0;
    for (uint32_t bit = 0; bit < 9; bit++)
        if (s->aovs & 1u << bit)
            components += cohort_aov_components((CohortAov)(1u << bit));
    return co_film_bytes(s->width, s->height, s->aovs) + 2 * sizeof(float) * components * r->pixels;
}

static uint64_t bins_bytes(const CohortRender *r)
{
    return ((uint64_t)1 << 20) + (uint64_t)r->worker_count * 6 * 1024 * r->ray_words * 4;
}

bool co_render_fit_memory(CohortRender *r, CohortError *err)
{
    CoTextures *textures = r->scene->textures;
    co_textures_limit(textures, 0, 0);
    uint64_t limit = r->settings.memory;
    if (!limit) {
        r->bin_memory = co_ray_bins_budget();
        return true;
    }
    bool has_lookups = r->scene->has_lookups;
    uint64_t fixed = co_memory_resident() + image_bytes(r) + bins_bytes(r) + SLACK_BYTES;
    if (has_lookups)
        fixed += co_textures_block_bytes(textures) * r->worker_count;
    uint64_t per_ray = bytes_per_ray(r) + lookup_bytes_per_ray(r->scene);
    uint64_t least = fixed + LEAST_BATCH * per_ray;
    CO_CHECK(least <= limit, err, COHORT_ERROR_LIMIT,
             "--memory %llu MB is too little: this scene needs at least %llu MB",
             (unsigned long long)(limit >> 20), (unsigned long long)((least >> 20) + 1));
    uint64_t left = limit - fixed;
    if (has_lookups) {
        uint64_t part = left / 3 + 1;
        co_textures_limit(textures, part, part);
        left -= part;
    }
    while (r->settings.batch > LEAST_BATCH && r->settings.batch * per_ray > left)
        r->settings.batch /= 2;
    uint64_t taken = r->settings.batch * per_ray;
    r->bin_memory = left > taken ? left - taken : 0;
    return true;
}
