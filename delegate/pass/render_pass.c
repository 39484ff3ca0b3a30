#include "pass/render_pass.h"

#include "base/error.h"
#include "base/hash.h"
#include "base/memory.h"
#include "pass/render_buffer.h"
#include "prims/dicing.h"
#include "prims/sync.h"

#include <stdio.h>
#include <string.h>

CohortRenderPass *cohort_render_pass_create(CohortRenderIndex *index, CohortError *err)
{
    CohortRenderPass *pass = co_alloc_zero(CO_MEMORY_DELEGATE, sizeof *pass);
    CO_CHECK_NULL(pass, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    pass->index = index;
    pass->next = index->delegate->passes;
    index->delegate->passes = pass;
    return pass;
}

// Any thread may ask which pass renders; only the host's changes it.
static void set_current(CohortDelegate *delegate, CohortRenderPass *pass)
{
    __atomic_store_n(&delegate->current, pass, __ATOMIC_RELEASE);
}

// Passes are destroyed after the render thread when the whole delegate goes.
static void drop_render_of(CohortDelegate *delegate, const CohortRenderPass *pass)
{
    if (delegate->current != pass)
        return;
    if (delegate->thread)
        co_render_thread_drop(delegate->thread);
    set_current(delegate, NULL);
}

void cohort_render_pass_destroy(CohortRenderPass *pass)
{
    if (!pass)
        return;
    CohortDelegate *delegate = pass->index->delegate;
    drop_render_of(delegate, pass);
    CohortRenderPass **link = &delegate->passes;
    while (*link != pass)
        link = &(*link)->next;
    *link = pass->next;
    co_free(CO_MEMORY_DELEGATE, pass, sizeof *pass);
}

void co_render_pass_unbind(CohortDelegate *delegate, const CohortRenderBuffer *buffer)
{
    for (CohortRenderPass *pass = delegate->passes; pass; pass = pass->next)
        for (size_t i = 0; i < pass->target_count; i++)
            if (pass->targets[i].buffer == buffer) {
                drop_render_of(delegate, pass);
                pass->target_count = 0;
                pass->has_started = false;
            }
}

// ---- Execute -----------------------------------------------------------------------------------

static bool check_binding(const CohortRenderPass *pass, const CohortRenderPassState *state,
                          size_t i, CohortError *err)
{
    const CohortAovBinding *binding = &state->bindings[i];
    const CohortRenderBuffer *first = state->bindings[0].buffer, *buffer = binding->buffer;
    CohortAovDescriptor aov = cohort_aov_descriptor(binding->name);
    CO_CHECK(aov.format != COHORT_FORMAT_NONE, err, COHORT_ERROR_ARGUMENT,
             "there is no AOV named \"%.80s\"", binding->name ? binding->name : "");
    CO_CHECK(buffer && buffer->format == aov.format, err, COHORT_ERROR_ARGUMENT,
             "the buffer of AOV %s must have that AOV's format", aov.name);
    CO_CHECK(buffer->delegate == pass->index->delegate, err, COHORT_ERROR_ARGUMENT,
             "the buffer of AOV %s is another delegate's", aov.name);
    CO_CHECK(buffer->width == first->width && buffer->height == first->height, err,
             COHORT_ERROR_ARGUMENT, "the buffers of a render pass must have one size");
    for (size_t k = 0; k < i; k++)
        CO_CHECK(state->bindings[k].buffer != buffer, err, COHORT_ERROR_ARGUMENT,
                 "AOVs %s and %s share a buffer", state->bindings[k].name, aov.name);
    return true;
}

static bool read_state(const CohortRenderPass *pass, const CohortRenderPassState *state,
                       CoRenderTarget *targets, CohortError *err)
{
    CO_CHECK(state->binding_count && state->binding_count <= CO_RENDER_TARGETS, err,
             COHORT_ERROR_ARGUMENT, "a render pass binds 1 to %d AOVs", (int)CO_RENDER_TARGETS);
    for (size_t i = 0; i < state->binding_count; i++) {
        if (!state->bindings[0].buffer || !check_binding(pass, state, i, err))
            return CO_FAIL(err, COHORT_ERROR_ARGUMENT, "an AOV is bound to no buffer");
        targets[i] = (CoRenderTarget){.buffer = state->bindings[i].buffer,
                                      .aov = cohort_aov_descriptor(state->bindings[i].name).aov};
    }
    return true;
}

static uint64_t hash_text(uint64_t hash, const char *text)
{
    return text ? co_hash_bytes(text, strlen(text), hash) : co_hash64(hash);
}

static uint64_t hash_view(uint64_t hash, const CohortRenderPassState *state)
{
    hash = co_hash_combine(hash, (uint64_t)state->conform);
    hash = co_hash_combine(hash, state->disable_depth_of_field);
    return co_hash_bytes(&state->pixel_aspect_ratio, sizeof state->pixel_aspect_ratio, hash);
}

// Two states with one hash start the same render. Buffers count by address and size.
static uint64_t hash_state(const CohortRenderPassState *state, const CoRenderTarget *targets)
{
    uint64_t hash = hash_text(1, state->camera);
    hash = hash_text(hash, state->resume_file);
    hash = co_hash_combine(hash, state->stage_hash);
    hash = hash_view(hash, state);
    for (size_t i = 0; i < state->binding_count; i++) {
        hash = co_hash_combine(hash, (uint64_t)targets[i].aov);
        hash = co_hash_combine(hash, (uint64_t)(uintptr_t)targets[i].buffer);
        hash = co_hash_combine(hash, targets[i].buffer->width);
        hash = co_hash_combine(hash, targets[i].buffer->height);
    }
    return hash;
}

static bool set_camera(CohortRenderPass *pass, const CohortRenderPassState *state, CohortError *err)
{
    CohortRenderIndex *index = pass->index;
    const CoPrim *prim = co_index_find(index, state->camera);
    CO_CHECK(prim && prim->type == COHORT_PRIM_CAMERA, err, COHORT_ERROR_ARGUMENT,
             "there is no camera at %.180s", state->camera ? state->camera : "(no path)");
    CO_CHECK(!prim->is_nowhere, err, COHORT_ERROR_SCENE,
             "camera %.180s has a transform that cannot be used", state->camera);
    CohortCameraDesc desc;
    co_camera_desc(prim, state, pass->targets[0].buffer->width, pass->targets[0].buffer->height,
                   &desc);
    if (index->has_camera_set && memcmp(&desc, &index->camera_set, sizeof desc) == 0)
        return true;
    co_render_thread_drop(index->delegate->thread);
    CO_CHECK(cohort_scene_set_camera(index->scene, &desc, err), err, COHORT_ERROR_SCENE,
             "camera %.180s cannot be used", state->camera);
    memcpy(&index->camera_set, &desc, sizeof desc);
    index->has_camera_set = true;
    index->needs_commit = true;
    index->counts.cameras_set++;
    return true;
}

// What a film of this pass stands for: two films with one key may be taken for each other.
static uint64_t film_key(const CohortRenderPass *pass, uint64_t stage_hash)
{
    return co_hash_combine(pass->film_hash, stage_hash);
}

// Makes a render, from a saved film where one is named, and starts it.
static bool start(CohortRenderPass *pass, const char *resume_file, uint64_t stage_hash,
                  CohortError *err)
{
    CohortDelegate *delegate = pass->index->delegate;
    CohortRenderSettings settings;
    co_settings_render(&delegate->settings, &settings);
    settings.width = pass->targets[0].buffer->width;
    settings.height = pass->targets[0].buffer->height;
    settings.aovs = COHORT_AOV_COLOR;
    for (size_t i = 0; i < pass->target_count; i++)
        settings.aovs |= (uint32_t)pass->targets[i].aov;
    pass->film_hash = co_hash_combine(pass->view_hash, co_settings_film_hash(&delegate->settings));
    CohortRender *render = cohort_render_create(pass->index->scene, &settings, err);
    if (!render)
        return false;
    if (resume_file &&
        !cohort_render_resume(render, resume_file, film_key(pass, stage_hash), err)) {
        cohort_render_destroy(render);
        return false;
    }
    for (size_t i = 0; i < pass->target_count; i++)
        co_render_buffer_clear(pass->targets[i].buffer, pass->targets[i].aov);
    pass->index->counts.render_starts++;
    return co_render_thread_start(delegate->thread, render, pass->targets, pass->target_count,
                                  delegate->round_fn, delegate->round_cookie, err);
}

bool cohort_render_pass_execute(CohortRenderPass *pass, const CohortRenderPassState *state,
                                CohortError *err)
{
    CohortDelegate *delegate = pass->index->delegate;
    CoRenderTarget targets[CO_RENDER_TARGETS];
    if (!read_state(pass, state, targets, err))
        return false;
    uint64_t hash = hash_state(state, targets);
    bool is_same = pass->has_started && delegate->current == pass && hash == pass->state_hash &&
                   delegate->settings.image_version == pass->image_version;
    if (is_same && !co_index_is_dirty(pass->index) && co_render_thread_has_render(delegate->thread))
        return true;
    pass->has_started = false;
    memcpy(pass->targets, targets, state->binding_count * sizeof *targets);
    pass->target_count = state->binding_count;
    pass->state_hash = hash;
    pass->view_hash = hash_view(1, state);
    pass->image_version = delegate->settings.image_version;
    set_current(delegate, pass);
    pass->has_started = cohort_render_index_pull(pass->index, err) &&
                        set_camera(pass, state, err) &&
                        co_dicing_update(pass->index, targets[0].buffer->width, err) &&
                        cohort_render_index_sync(pass->index, err);
    if (!pass->has_started)
        return false;
    co_render_thread_drop(delegate->thread);
    pass->has_started = start(pass, state->resume_file, state->stage_hash, err);
    return pass->has_started;
}

// ---- State -------------------------------------------------------------------------------------

static CoRenderThread *thread_of(const CohortRenderPass *pass)
{
    CohortDelegate *delegate = pass->index->delegate;
    bool is_current = __atomic_load_n(&delegate->current, __ATOMIC_ACQUIRE) == pass;
    return is_current ? delegate->thread : NULL;
}

bool cohort_render_pass_is_converged(const CohortRenderPass *pass)
{
    CoRenderThread *thread = thread_of(pass);
    return thread && co_render_thread_is_done(thread);
}

bool cohort_render_pass_wait(CohortRenderPass *pass, double seconds)
{
    CoRenderThread *thread = thread_of(pass);
    return thread && co_render_thread_wait(thread, seconds);
}

bool cohort_render_pass_error(const CohortRenderPass *pass, CohortError *out)
{
    CoRenderThread *thread = thread_of(pass);
    return thread && co_render_thread_error(thread, out);
}

bool cohort_render_pass_camera(const CohortRenderPass *pass, CohortCameraDesc *out)
{
    if (pass->index->delegate->current != pass || !pass->index->has_camera_set)
        return false;
    memcpy(out, &pass->index->camera_set, sizeof *out);
    return true;
}

bool cohort_render_pass_save(CohortRenderPass *pass, const char *path, uint64_t stage_hash,
                             CohortError *err)
{
    CoRenderThread *thread = thread_of(pass);
    CO_CHECK(thread, err, COHORT_ERROR_ARGUMENT, "there is no render to save");
    return co_render_thread_save(thread, path, film_key(pass, stage_hash), err);
}

bool cohort_delegate_pause(CohortDelegate *delegate)
{
    co_render_thread_stop(delegate->thread, true);
    return true;
}

bool cohort_delegate_resume(CohortDelegate *delegate)
{
    return co_render_thread_continue(delegate->thread, NULL);
}

bool cohort_delegate_restart(CohortDelegate *delegate)
{
    CohortRenderPass *pass = delegate->current;
    if (!pass || !pass->has_started)
        return false;
    co_render_thread_drop(delegate->thread);
    return cohort_render_index_sync(pass->index, NULL) && start(pass, NULL, 0, NULL);
}

void cohort_delegate_stop(CohortDelegate *delegate, bool blocking)
{
    co_render_thread_stop(delegate->thread, blocking);
}

void cohort_delegate_set_stop_flag(CohortDelegate *delegate, const volatile int *stop)
{
    delegate->stop = stop;
}

void cohort_delegate_set_round_callback(CohortDelegate *delegate, CohortRoundFn *fn, void *cookie)
{
    delegate->round_fn = fn;
    delegate->round_cookie = cookie;
}
