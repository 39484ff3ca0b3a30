// The one background thread: drives one render, round by round, until it is done.
//
// States: down (no render), running, resting (a render but no thread in it: paused, stopped, done
// or failed), all changed under one lock. A run is numbered from its launch until the thread rests:
// who waits for the end of a run does not wait for the next one, which another thread may begin at
// once. The thread owns the render while it runs; the host's thread owns it while it rests, and
// alone creates and drops renders. Stop and continue may come from any thread.

#ifndef CO_DELEGATE_RENDER_THREAD_H
#define CO_DELEGATE_RENDER_THREAD_H

#include "index/index.h"

typedef struct CoRenderTarget {
    CohortRenderBuffer *buffer;
    CohortAov aov;
} CoRenderTarget;

enum {
    CO_RENDER_TARGETS = 16
};

CoRenderThread *co_render_thread_create(CohortError *err);
void co_render_thread_destroy(CoRenderThread *thread);

// Takes over a render, which it will destroy, and starts it.
bool co_render_thread_start(CoRenderThread *thread, CohortRender *render,
                            const CoRenderTarget *targets, size_t target_count,
                            CohortRoundFn *round_fn, void *round_cookie, CohortError *err);

// Goes on with a resting render; nothing when it is done, failed, down or being dropped. Ends a
// stop that was not waited for. Any thread but the render thread.
bool co_render_thread_continue(CoRenderThread *thread, CohortError *err);

// Makes the thread end; blocking: waits until it rests. Any thread, but
// not the render thread when blocking.
void co_render_thread_stop(CoRenderThread *thread, bool blocking);

// Stops and destroys the render: the scene may be edited after it.
void co_render_thread_drop(CoRenderThread *thread);

bool co_render_thread_has_render(CoRenderThread *thread);
bool co_render_thread_is_running(CoRenderThread *thread);
bool co_render_thread_is_done(CoRenderThread *thread); // target reached or failed
bool co_render_thread_wait(CoRenderThread *thread, double seconds);
bool co_render_thread_error(CoRenderThread *thread, CohortError *out);
bool co_render_thread_save(CoRenderThread *thread, const char *path, uint64_t stage_hash,
                           CohortError *err);

typedef struct CoRenderProgress {
    bool has_render;
    double fraction;         // 0 to 1, never falls during a render
    double seconds;          // since the start, rests included until the end
    CohortRenderStats stats; // of the last complete round
    CohortErrorCode error;
} CoRenderProgress;
void co_render_thread_progress(CoRenderThread *thread, CoRenderProgress *out);

#endif
