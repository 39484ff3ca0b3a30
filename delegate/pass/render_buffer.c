#include "pass/render_buffer.h"

#include "base/error.h"
#include "base/memory.h"
#include "index/index.h"
#include "pass/render_pass.h"

#include <string.h>

enum {
    MAX_SIDE = 65536
};

CohortRenderBuffer *cohort_render_buffer_create(CohortDelegate *delegate, uint32_t width,
                                                uint32_t height, CohortFormat format,
                                                CohortError *err)
{
    size_t pixel = cohort_format_size(format), bytes = 0;
    CO_CHECK_NULL(pixel, err, COHORT_ERROR_ARGUMENT, "a render buffer needs a format");
    CO_CHECK_NULL(width && height && width <= MAX_SIDE && height <= MAX_SIDE, err,
                  COHORT_ERROR_ARGUMENT,
                  "a render buffer is from 1 to %d pixels a side, not %u x %u", (int)MAX_SIDE,
                  (unsigned)width, (unsigned)height);
    CO_CHECK_NULL(co_size_mul((size_t)width * height, pixel, &bytes), err, COHORT_ERROR_LIMIT,
                  "the render buffer is too large");
    CohortRenderBuffer *buffer = co_alloc_zero(CO_MEMORY_DELEGATE, sizeof *buffer);
    CO_CHECK_NULL(buffer, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    *buffer = (CohortRenderBuffer){.delegate = delegate,
                                   .width = width,
                                   .height = height,
                                   .format = format,
                                   .bytes = bytes,
                                   .front = co_alloc_zero(CO_MEMORY_DELEGATE, bytes),
                                   .back = co_alloc_zero(CO_MEMORY_DELEGATE, bytes)};
    pthread_mutex_init(&buffer->lock, NULL);
    buffer->next = delegate->buffers;
    delegate->buffers = buffer;
    if (buffer->front && buffer->back)
        return buffer;
    cohort_render_buffer_destroy(buffer);
    CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for a %u x %u render buffer",
            (unsigned)width, (unsigned)height);
    return NULL;
}

void cohort_render_buffer_destroy(CohortRenderBuffer *buffer)
{
    if (!buffer)
        return;
    co_render_pass_unbind(buffer->delegate, buffer);
    CohortRenderBuffer **link = &buffer->delegate->buffers;
    while (*link != buffer)
        link = &(*link)->next;
    *link = buffer->next;
    pthread_mutex_destroy(&buffer->lock);
    co_free(CO_MEMORY_DELEGATE, buffer->front, buffer->bytes);
    co_free(CO_MEMORY_DELEGATE, buffer->back, buffer->bytes);
    co_free(CO_MEMORY_DELEGATE, buffer, sizeof *buffer);
}

uint32_t cohort_render_buffer_width(const CohortRenderBuffer *buffer)
{
    return buffer->width;
}

uint32_t cohort_render_buffer_height(const CohortRenderBuffer *buffer)
{
    return buffer->height;
}

CohortFormat cohort_render_buffer_format(const CohortRenderBuffer *buffer)
{
    return buffer->format;
}

// ---- Reading -----------------------------------------------------------------------------------

// With the lock held: the newest image comes to the front unless someone reads the one there.
static void swap_if_free(CohortRenderBuffer *buffer)
{
    if (buffer->maps || !buffer->is_fresh)
        return;
    void *newest = buffer->back;
    buffer->back = buffer->front;
    buffer->front = newest;
    buffer->is_fresh = false;
}

const void *cohort_render_buffer_map(CohortRenderBuffer *buffer)
{
    pthread_mutex_lock(&buffer->lock);
    swap_if_free(buffer);
    buffer->maps++;
    const void *pixels = buffer->front;
    pthread_mutex_unlock(&buffer->lock);
    return pixels;
}

void cohort_render_buffer_unmap(CohortRenderBuffer *buffer)
{
    pthread_mutex_lock(&buffer->lock);
    if (buffer->maps)
        buffer->maps--;
    pthread_mutex_unlock(&buffer->lock);
}

bool cohort_render_buffer_is_mapped(CohortRenderBuffer *buffer)
{
    pthread_mutex_lock(&buffer->lock);
    bool is_mapped = buffer->maps != 0;
    pthread_mutex_unlock(&buffer->lock);
    return is_mapped;
}

bool cohort_render_buffer_is_converged(CohortRenderBuffer *buffer)
{
    pthread_mutex_lock(&buffer->lock);
    bool is_converged = buffer->is_converged;
    pthread_mutex_unlock(&buffer->lock);
    return is_converged;
}

void cohort_render_buffer_resolve(CohortRenderBuffer *buffer)
{
    pthread_mutex_lock(&buffer->lock);
    swap_if_free(buffer);
    pthread_mutex_unlock(&buffer->lock);
}

// ---- Writing -----------------------------------------------------------------------------------

static CohortAovDescriptor descriptor_of(CohortAov aov)
{
    const CohortAovDescriptor *table;
    size_t count = cohort_aov_descriptors(&table);
    for (size_t i = 0; i < count; i++)
        if (table[i].aov == aov)
            return table[i];
    return (CohortAovDescriptor){.name = ""};
}

void co_render_buffer_clear(CohortRenderBuffer *buffer, CohortAov aov)
{
    CohortAovDescriptor d = descriptor_of(aov);
    size_t size = cohort_format_size(buffer->format),
           pixels = (size_t)buffer->width * buffer->height;
    bool is_id = buffer->format == COHORT_FORMAT_INT32;
    int32_t id = is_id ? (int32_t)d.clear[0] : 0;
    const void *value = is_id ? (const void *)&id : d.clear;
    pthread_mutex_lock(&buffer->lock);
    for (size_t i = 0; i < pixels; i++)
        memcpy((char *)buffer->back + i * size, value, size);
    buffer->is_fresh = true;
    buffer->is_converged = false;
    pthread_mutex_unlock(&buffer->lock);
}

// The renderer's rows run from top to bottom, Hydra's from bottom to top.
static void flip_rows(CohortRenderBuffer *buffer)
{
    size_t row = (size_t)buffer->width * cohort_format_size(buffer->format);
    char *pixels = buffer->back;
    for (uint32_t y = 0; y < buffer->height / 2; y++) {
        char *a = pixels + (size_t)y * row;
        char *b = pixels + (size_t)(buffer->height - 1 - y) * row;
        for (size_t i = 0; i < row; i += 4) {
            uint32_t word;
            memcpy(&word, a + i, 4);
            memcpy(a + i, b + i, 4);
            memcpy(b + i, &word, 4);
        }
    }
}

bool co_render_buffer_write(CohortRenderBuffer *buffer, const CohortRender *render, CohortAov aov,
                            bool is_converged)
{
    pthread_mutex_lock(&buffer->lock);
    bool ok = cohort_render_aov(render, aov, buffer->back);
    if (ok) {
        flip_rows(buffer);
        buffer->is_fresh = true;
        buffer->is_converged = is_converged;
    }
    pthread_mutex_unlock(&buffer->lock);
    return ok;
}
