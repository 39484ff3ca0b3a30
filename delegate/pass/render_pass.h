// A render pass: a camera and AOVs, and what was last started with them.

#ifndef CO_DELEGATE_RENDER_PASS_H
#define CO_DELEGATE_RENDER_PASS_H

#include "index/index.h"
#include "pass/render_thread.h"

struct CohortRenderPass {
    CohortRenderIndex *index;
    CohortRenderPass *next; // in the delegate's list
    uint64_t state_hash;    // of the state last executed
    uint64_t image_version; // of the settings then
    uint64_t view_hash;     // of what in that state changes the image
    uint64_t film_hash;     // of all that does but the scene, as last started
    CoRenderTarget targets[CO_RENDER_TARGETS];
    size_t target_count; // 0: never executed, or a buffer was destroyed
    bool has_started;
};

// Makes a buffer safe to destroy: the render that writes it is dropped.
void co_render_pass_unbind(CohortDelegate *delegate, const CohortRenderBuffer *buffer);

#endif
