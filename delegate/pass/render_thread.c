#include "pass/render_thread.h"

#include "base/clock.h"
#include "base/error.h"
#include "pass/render_buffer.h"

#include <errno.h>
#include <pthread.h>
#include <string.h>

// How often a waiting stop repeats its cancel: one that comes just before a round may be lost.
#define CANCEL_INTERVAL_NS 5000000L

struct CoRenderThread {
    pthread_mutex_t lock;
    pthread_cond_t changed; // on every change of what follows
    pthread_t thread, self; // for joining; as the running thread knows itself
    bool is_joinable;       // a thread was started and not joined
    bool is_running;        // it has not yet come to rest
    bool must_stop;
    bool is_done, is_failed;
    CohortRender *render;
    CoRenderTarget targets[CO_RENDER_TARGETS];
    size_t target_count;
    CohortRoundFn *round_fn;
    void *round_cookie;
    CohortError error;
    CohortRenderStats stats;
    double started, ended, best_fraction;
    const char *save_path; // a save that waits for the end of the round
    uint64_t save_hash;
    CohortError save_error;
    bool save_ok;
};

CoRenderThread *co_render_thread_create(CohortError *err)
{
    CoRenderThread *t = co_alloc_zero(CO_MEMORY_DELEGATE, sizeof *t);
    CO_CHECK_NULL(t, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    pthread_mutex_init(&t->lock, NULL);
    pthread_cond_init(&t->changed, NULL);
    return t;
}

void co_render_thread_destroy(CoRenderThread *t)
{
    if (!t)
        return;
    co_render_thread_drop(t);
    pthread_cond_destroy(&t->changed);
    pthread_mutex_destroy(&t->lock);
    co_free(CO_MEMORY_DELEGATE, t, sizeof *t);
}

// ---- On the thread -----------------------------------------------------------------------------

// Brings a complete round to the buffers and the host.
static void publish(CoRenderThread *t)
{
    bool is_done = cohort_render_is_done(t->render);
    for (size_t i = 0; i < t->target_count; i++)
        co_render_buffer_write(t->targets[i].buffer, t->render, t->targets[i].aov, is_done);
    CohortRenderStats stats = {0};
    cohort_render_stats(t->render, &stats);
    pthread_mutex_lock(&t->lock);
    t->stats = stats;
    double seconds = co_clock_seconds() - t->started;
    pthread_mutex_unlock(&t->lock);
    CohortRoundInfo info = {.round = stats.rounds,
                            .samples_per_pixel = stats.samples_per_pixel,
                            .seconds = seconds,
                            .is_done = is_done};
    if (t->round_fn)
        t->round_fn(t->round_cookie, &info);
}

// With the lock held: does what a waiting cohort_render_pass_save asked for.
static void serve_save(CoRenderThread *t)
{
    if (!t->save_path)
        return;
    t->save_ok = cohort_render_save(t->render, t->save_path, t->save_hash, &t->save_error);
    t->save_path = NULL;
    pthread_cond_broadcast(&t->changed);
}

static void *run(void *argument)
{
    CoRenderThread *t = argument;
    CohortError error = {0};
    bool ok = true;
    pthread_mutex_lock(&t->lock);
    t->self = pthread_self();
    while (ok && !t->must_stop && !cohort_render_is_done(t->render)) {
        pthread_mutex_unlock(&t->lock);
        ok = cohort_render_round(t->render, &error);
        if (ok)
            publish(t);
        pthread_mutex_lock(&t->lock);
        serve_save(t);
        if (!ok && error.code == COHORT_ERROR_CANCELLED) {
            memset(&error, 0, sizeof error);
            ok = true;
        }
    }
    if (!ok) {
        t->is_failed = true;
        t->error = error;
    }
    t->is_done = t->is_failed || cohort_render_is_done(t->render);
    t->is_running = false;
    t->ended = co_clock_seconds();
    pthread_cond_broadcast(&t->changed);
    pthread_mutex_unlock(&t->lock);
    return NULL;
}

// ---- On the host's thread ----------------------------------------------------------------------

static void join(CoRenderThread *t)
{
    if (t->is_joinable)
        pthread_join(t->thread, NULL);
    t->is_joinable = false;
}

static bool launch(CoRenderThread *t, CohortError *err)
{
    join(t);
    pthread_mutex_lock(&t->lock);
    t->must_stop = false;
    t->is_running = t->is_joinable = pthread_create(&t->thread, NULL, run, t) == 0;
    bool ok = t->is_running;
    pthread_mutex_unlock(&t->lock);
    return ok || CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "the render thread could not be started");
}

bool co_render_thread_start(CoRenderThread *t, CohortRender *render, const CoRenderTarget *targets,
                            size_t target_count, CohortRoundFn *round_fn, void *round_cookie,
                            CohortError *err)
{
    co_render_thread_drop(t);
    pthread_mutex_lock(&t->lock);
    t->render = render;
    memcpy(t->targets, targets, target_count * sizeof *targets);
    t->target_count = target_count;
    t->round_fn = round_fn;
    t->round_cookie = round_cookie;
    t->is_done = t->is_failed = false;
    t->best_fraction = 0.0;
    t->started = co_clock_seconds();
    memset(&t->error, 0, sizeof t->error);
    cohort_render_stats(render, &t->stats);
    pthread_mutex_unlock(&t->lock);
    return launch(t, err);
}

bool co_render_thread_continue(CoRenderThread *t, CohortError *err)
{
    pthread_mutex_lock(&t->lock);
    // A stop that was not waited for may still be under way: it must end before it can be undone.
    bool must_wait = t->is_running && t->must_stop;
    pthread_mutex_unlock(&t->lock);
    if (must_wait)
        co_render_thread_stop(t, true);
    pthread_mutex_lock(&t->lock);
    bool can_go_on = t->render && !t->is_running && !t->is_done;
    pthread_mutex_unlock(&t->lock);
    return !can_go_on || launch(t, err);
}

void co_render_thread_stop(CoRenderThread *t, bool blocking)
{
    pthread_mutex_lock(&t->lock);
    t->must_stop = true;
    if (t->is_running)
        cohort_render_cancel(t->render);
    while (blocking && t->is_running) {
        struct timespec until;
        clock_gettime(CLOCK_REALTIME, &until);
        until.tv_nsec += CANCEL_INTERVAL_NS;
        until.tv_sec += until.tv_nsec / 1000000000L;
        until.tv_nsec %= 1000000000L;
        pthread_cond_timedwait(&t->changed, &t->lock, &until);
        if (t->is_running)
            cohort_render_cancel(t->render);
    }
    pthread_mutex_unlock(&t->lock);
    if (blocking)
        join(t);
}

void co_render_thread_drop(CoRenderThread *t)
{
    co_render_thread_stop(t, true);
    pthread_mutex_lock(&t->lock);
    CohortRender *render = t->render;
    t->render = NULL;
    t->target_count = 0;
    t->is_done = false;
    pthread_mutex_unlock(&t->lock);
    if (render)
        cohort_render_destroy(render);
}

// ---- Any thread --------------------------------------------------------------------------------

bool co_render_thread_has_render(CoRenderThread *t)
{
    pthread_mutex_lock(&t->lock);
    bool has_render = t->render != NULL;
    pthread_mutex_unlock(&t->lock);
    return has_render;
}

bool co_render_thread_is_running(CoRenderThread *t)
{
    pthread_mutex_lock(&t->lock);
    bool is_running = t->is_running;
    pthread_mutex_unlock(&t->lock);
    return is_running;
}

bool co_render_thread_is_done(CoRenderThread *t)
{
    pthread_mutex_lock(&t->lock);
    bool is_done = t->is_done;
    pthread_mutex_unlock(&t->lock);
    return is_done;
}

bool co_render_thread_wait(CoRenderThread *t, double seconds)
{
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    double limit = seconds < 1e8 ? seconds : 1e8;
    if (limit > 0.0) {
        long whole = (long)limit;
        until.tv_nsec += (long)((limit - (double)whole) * 1e9);
        until.tv_sec += whole + until.tv_nsec / 1000000000L;
        until.tv_nsec %= 1000000000L;
    }
    pthread_mutex_lock(&t->lock);
    int result = 0;
    while (t->is_running && result != ETIMEDOUT)
        result = seconds < 0.0 ? pthread_cond_wait(&t->changed, &t->lock)
                               : pthread_cond_timedwait(&t->changed, &t->lock, &until);
    bool is_done = t->is_done;
    pthread_mutex_unlock(&t->lock);
    return is_done;
}

bool co_render_thread_error(CoRenderThread *t, CohortError *out)
{
    pthread_mutex_lock(&t->lock);
    bool is_failed = t->render && t->is_failed;
    if (is_failed)
        *out = t->error;
    pthread_mutex_unlock(&t->lock);
    return is_failed;
}

bool co_render_thread_save(CoRenderThread *t, const char *path, uint64_t stage_hash,
                           CohortError *err)
{
    pthread_mutex_lock(&t->lock);
    bool ok = false;
    if (!t->render) {
        CO_FAIL(err, COHORT_ERROR_ARGUMENT, "there is no render to save");
    } else if (!t->is_running || pthread_equal(pthread_self(), t->self)) {
        ok = cohort_render_save(t->render, path, stage_hash, err);
    } else {
        memset(&t->save_error, 0, sizeof t->save_error);
        t->save_ok = false;
        t->save_hash = stage_hash;
        t->save_path = path;
        while (t->save_path && t->is_running)
            pthread_cond_wait(&t->changed, &t->lock);
        if (t->save_path)
            serve_save(t);
        ok = t->save_ok;
        if (!ok && err && err->code == COHORT_OK)
            *err = t->save_error;
    }
    pthread_mutex_unlock(&t->lock);
    return ok;
}

void co_render_thread_progress(CoRenderThread *t, CoRenderProgress *out)
{
    pthread_mutex_lock(&t->lock);
    memset(out, 0, sizeof *out);
    out->has_render = t->render != NULL;
    if (t->render) {
        double fraction = cohort_render_progress(t->render);
        if (t->is_done && !t->is_failed)
            fraction = 1.0;
        // NaN fails both comparisons; a cancelled round may take progress back.
        if (fraction > t->best_fraction)
            t->best_fraction = fraction < 1.0 ? fraction : 1.0;
        out->fraction = t->best_fraction;
        out->seconds = (t->is_running ? co_clock_seconds() : t->ended) - t->started;
        out->stats = t->stats;
        out->error = t->is_failed ? t->error.code : COHORT_OK;
    }
    pthread_mutex_unlock(&t->lock);
}
