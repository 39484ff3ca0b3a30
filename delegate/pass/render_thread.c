#include "pass/render_thread.h"

#include "base/clock.h"
#include "base/error.h"
#include "pass/render_buffer.h"

#include <errno.h>
#include <pthread.h>
#include <string.h>

struct CoRenderThread {
    pthread_mutex_t lock;
    pthread_cond_t changed; // on every change of what follows
    pthread_t thread;       // from the first start to destroy, which alone joins it
    bool has_thread, must_exit;
    uint64_t run;     // number of the last run: from a launch until the thread rests
    bool is_running;  // that run has not ended
    bool must_stop;   // it is to end
    bool is_dropping; // the render is about to go: no new run
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
    pthread_mutex_lock(&t->lock);
    t->must_exit = true;
    pthread_cond_broadcast(&t->changed);
    pthread_mutex_unlock(&t->lock);
    if (t->has_thread)
        pthread_join(t->thread, NULL);
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

// With the lock held, except during a round: one run.
static void run_rounds(CoRenderThread *t)
{
    CohortError error = {0};
    bool ok = true;
    if (cohort_render_is_done(t->render)) { // a film resumed that has all its samples
        pthread_mutex_unlock(&t->lock);
        publish(t);
        pthread_mutex_lock(&t->lock);
    }
    while (ok && !t->must_stop && !cohort_render_is_done(t->render)) {
        pthread_mutex_unlock(&t->lock);
        ok = cohort_render_round(t->render, &error);
        if (ok)
            publish(t);
        pthread_mutex_lock(&t->lock);
        serve_save(t);
        // A cancel that came too late for the run before hits this one, which renders on.
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
}

static void *work(void *argument)
{
    CoRenderThread *t = argument;
    pthread_mutex_lock(&t->lock);
    while (!t->must_exit)
        if (t->is_running)
            run_rounds(t);
        else
            pthread_cond_wait(&t->changed, &t->lock);
    pthread_mutex_unlock(&t->lock);
    return NULL;
}

// ---- Runs: begun, ended and waited for with the lock held --------------------------------------

static bool launch(CoRenderThread *t, CohortError *err)
{
    if (!t->has_thread)
        t->has_thread = pthread_create(&t->thread, NULL, work, t) == 0;
    CO_CHECK(t->has_thread, err, COHORT_ERROR_OUT_OF_MEMORY,
             "the render thread could not be started");
    t->run++;
    t->is_running = true;
    t->must_stop = false;
    pthread_cond_broadcast(&t->changed);
    return true;
}

static void ask_to_stop(CoRenderThread *t)
{
    if (!t->is_running)
        return;
    t->must_stop = true;
    cohort_render_cancel(t->render);
}

// Another thread may begin the next run before this one wakes: only the one now is waited for.
static void wait_for_end_of_run(CoRenderThread *t)
{
    for (uint64_t run = t->run; t->is_running && t->run == run;)
        pthread_cond_wait(&t->changed, &t->lock);
}

// ---- On the host's thread ----------------------------------------------------------------------

bool co_render_thread_start(CoRenderThread *t, CohortRender *render, const CoRenderTarget *targets,
                            size_t target_count, CohortRoundFn *round_fn, void *round_cookie,
                            CohortError *err)
{
    co_render_thread_drop(t);
    pthread_mutex_lock(&t->lock);
    t->render = render;
    if (target_count)
        memcpy(t->targets, targets, target_count * sizeof *targets);
    t->target_count = target_count;
    t->round_fn = round_fn;
    t->round_cookie = round_cookie;
    t->is_done = t->is_failed = false;
    t->best_fraction = 0.0;
    t->started = co_clock_seconds();
    memset(&t->error, 0, sizeof t->error);
    cohort_render_stats(render, &t->stats);
    bool ok = launch(t, err);
    pthread_mutex_unlock(&t->lock);
    return ok;
}

void co_render_thread_drop(CoRenderThread *t)
{
    pthread_mutex_lock(&t->lock);
    t->is_dropping = true;
    ask_to_stop(t);
    wait_for_end_of_run(t);
    CohortRender *render = t->render;
    t->render = NULL;
    t->target_count = 0;
    t->is_done = t->is_dropping = false;
    pthread_mutex_unlock(&t->lock);
    if (render)
        cohort_render_destroy(render);
}

// ---- Any thread --------------------------------------------------------------------------------

bool co_render_thread_continue(CoRenderThread *t, CohortError *err)
{
    pthread_mutex_lock(&t->lock);
    // A stop that was not waited for may still be under way: it must end before it can be undone.
    if (t->is_running && t->must_stop)
        wait_for_end_of_run(t);
    bool can_go_on = t->render && !t->is_running && !t->is_done && !t->is_dropping;
    bool ok = !can_go_on || launch(t, err);
    pthread_mutex_unlock(&t->lock);
    return ok;
}

void co_render_thread_stop(CoRenderThread *t, bool blocking)
{
    pthread_mutex_lock(&t->lock);
    ask_to_stop(t);
    if (blocking)
        wait_for_end_of_run(t);
    pthread_mutex_unlock(&t->lock);
}

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
    for (uint64_t run = t->run; t->is_running && t->run == run && result != ETIMEDOUT;)
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
    } else if (!t->is_running || pthread_equal(pthread_self(), t->thread)) {
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
