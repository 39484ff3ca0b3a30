#include "output.h"

#include "cli.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static bool ends_in(const char *path, const char *ending)
{
    size_t n = strlen(path), k = strlen(ending);
    return n > k && !strcasecmp(path + n - k, ending);
}

bool output_is_supported(const char *path)
{
    return ends_in(path, ".exr") || ends_in(path, ".png");
}

bool output_is_png(const char *path)
{
    return ends_in(path, ".png");
}

bool output_buffers_create(CohortDelegate *delegate, uint32_t width, uint32_t height,
                           const char *const *names, size_t count, OutputBuffers *out,
                           CohortError *err)
{
    memset(out, 0, sizeof *out);
    for (size_t i = 0; i < count + 1; i++) {
        const char *name = i == 0 ? "color" : names[i - 1];
        bool is_known = false;
        for (size_t k = 0; k < out->count; k++)
            is_known = is_known || !strcmp(out->aovs[k].name, name);
        if (is_known)
            continue;
        CohortAovDescriptor aov = cohort_aov_descriptor(name);
        if (aov.format == COHORT_FORMAT_NONE)
            return fail(err, COHORT_ERROR_ARGUMENT,
                        "there is no AOV \"%s\"; there are color, depth, cameraDepth, normal, "
                        "albedo, primId, elementId, sampleCount, error",
                        name);
        CohortRenderBuffer *buffer =
            cohort_render_buffer_create(delegate, width, height, aov.format, err);
        if (!buffer)
            return false;
        CohortAovBinding binding = {aov.name, buffer};
        out->aovs[out->count] = aov;
        out->buffers[out->count] = buffer;
        out->bindings[out->count++] = binding;
    }
    return true;
}

void output_buffers_destroy(OutputBuffers *b)
{
    for (size_t i = 0; i < b->count; i++)
        cohort_render_buffer_destroy(b->buffers[i]);
    memset(b, 0, sizeof *b);
}

// Rows of a buffer from top to bottom; it keeps them as Hydra does, from the bottom.
static void *top_down(CohortRenderBuffer *buffer)
{
    size_t line = cohort_format_size(cohort_render_buffer_format(buffer)) *
                  cohort_render_buffer_width(buffer);
    size_t rows = cohort_render_buffer_height(buffer);
    char *out = malloc(line * rows);
    const char *in = cohort_render_buffer_map(buffer);
    for (size_t y = 0; out && in && y < rows; y++)
        memcpy(out + y * line, in + (rows - 1 - y) * line, line);
    cohort_render_buffer_unmap(buffer);
    return out;
}

typedef struct Channels {
    CohortChannel list[4 * OUTPUT_AOVS_MAX];
    char names[4 * OUTPUT_AOVS_MAX][64];
    size_t count;
    void *planes[OUTPUT_AOVS_MAX];
} Channels;

static void add_channel(Channels *c, const char *name, CohortChannelType type, const void *pixels,
                        size_t stride)
{
    snprintf(c->names[c->count], sizeof c->names[0], "%s", name);
    CohortChannel channel = {c->names[c->count], type, pixels, stride};
    c->list[c->count++] = channel;
}

// Names as compositors know them: R, G, B, A bare; Z is the camera's depth; vectors by axis.
static void add_aov(Channels *c, const CohortAovDescriptor *aov, const float *pixels)
{
    size_t stride = cohort_format_size(aov->format);
    bool is_id = aov->format == COHORT_FORMAT_INT32;
    if (aov->aov == COHORT_AOV_COLOR) {
        for (size_t i = 0; i < 4; i++) {
            const char name[2] = {"RGBA"[i], 0};
            add_channel(c, name, COHORT_CHANNEL_FLOAT, pixels + i, stride);
        }
        return;
    }
    if (aov->format == COHORT_FORMAT_FLOAT32_VEC3) {
        for (size_t i = 0; i < 3; i++) {
            char name[64];
            const char *axes = aov->aov == COHORT_AOV_NORMAL ? "XYZ" : "RGB";
            snprintf(name, sizeof name, "%s.%c", aov->name, axes[i]);
            add_channel(c, name, COHORT_CHANNEL_FLOAT, pixels + i, stride);
        }
        return;
    }
    const char *name = aov->aov == COHORT_AOV_CAMERA_DEPTH ? "Z" : aov->name;
    add_channel(c, name, is_id ? COHORT_CHANNEL_UINT : COHORT_CHANNEL_FLOAT, pixels, stride);
}

static bool write_exr(const char *path, const OutputBuffers *b, const OutputStamp *stamp,
                      CohortError *err)
{
    Channels channels = {.count = 0};
    StampAttributes attributes;
    bool ok = stamp_attributes(stamp, &attributes, err);
    for (size_t i = 0; i < b->count && ok; i++) {
        channels.planes[i] = top_down(b->buffers[i]);
        ok = channels.planes[i] || fail(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
        if (ok)
            add_aov(&channels, &b->aovs[i], channels.planes[i]);
    }
    CohortExrDesc desc = {.width = cohort_render_buffer_width(b->buffers[0]),
                          .height = cohort_render_buffer_height(b->buffers[0]),
                          .pixel_aspect = (float)stamp->pixel_aspect,
                          .channels = channels.list,
                          .channel_count = channels.count,
                          .attributes = attributes.list,
                          .attribute_count = attributes.count};
    ok = ok && cohort_exr_write(path, &desc, err);
    for (size_t i = 0; i < b->count; i++)
        free(channels.planes[i]);
    return ok;
}

static bool write_png(const char *path, const OutputBuffers *b, const OutputStamp *stamp,
                      CohortError *err)
{
    float *pixels = top_down(b->buffers[0]);
    if (!pixels)
        return fail(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    bool ok =
        cohort_png_write(path, cohort_render_buffer_width(b->buffers[0]),
                         cohort_render_buffer_height(b->buffers[0]), pixels, stamp->view, err);
    free(pixels);
    return ok;
}

bool output_write(const char *path, const OutputBuffers *buffers, const OutputStamp *stamp,
                  CohortError *err)
{
    return output_is_png(path) ? write_png(path, buffers, stamp, err)
                               : write_exr(path, buffers, stamp, err);
}
