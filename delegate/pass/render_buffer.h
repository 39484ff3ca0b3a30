// Render buffers: pixels that the render thread writes while the host reads.
//
// A buffer has two images. The render thread writes the back one; a map, when it is the first,
// brings the newest complete one to the front. So neither ever waits for the other to finish.

#ifndef CO_DELEGATE_RENDER_BUFFER_H
#define CO_DELEGATE_RENDER_BUFFER_H

#include "cohort/delegate.h"

#include <pthread.h>

struct CohortRenderBuffer {
    CohortDelegate *delegate;
    CohortRenderBuffer *next; // in the delegate's list
    uint32_t width, height;
    CohortFormat format;
    size_t bytes; // of one image
    pthread_mutex_t lock;
    void *front, *back;
    bool is_fresh; // the back image is newer
    bool is_converged;
    uint32_t maps;
};

// Fills the buffer with an AOV's clear value.
void co_render_buffer_clear(CohortRenderBuffer *buffer, CohortAov aov);

// Takes the AOV of the render's last complete round. False when the render has no such AOV.
bool co_render_buffer_write(CohortRenderBuffer *buffer, const CohortRender *render, CohortAov aov,
                            bool is_converged);

#endif
