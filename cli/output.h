// Writes the buffers of a frame: EXR with every AOV and its metadata, PNG through a view.

#ifndef COHORT_CLI_OUTPUT_H
#define COHORT_CLI_OUTPUT_H

#include "stamp.h"

enum {
    OUTPUT_AOVS_MAX = 16
};

// The buffers of a render, in the order of their names.
typedef struct OutputBuffers {
    CohortAovDescriptor aovs[OUTPUT_AOVS_MAX];
    CohortRenderBuffer *buffers[OUTPUT_AOVS_MAX];
    CohortAovBinding bindings[OUTPUT_AOVS_MAX];
    size_t count;
} OutputBuffers;

// Creates one buffer per AOV name; color first. False with the unknown one named.
bool output_buffers_create(CohortDelegate *delegate, uint32_t width, uint32_t height,
                           const char *const *names, size_t count, OutputBuffers *out,
                           CohortError *err);
void output_buffers_destroy(OutputBuffers *buffers);

// True for names that end in .exr or .png.
bool output_is_supported(const char *path);
bool output_is_png(const char *path);

bool output_write(const char *path, const OutputBuffers *buffers, const OutputStamp *stamp,
                  CohortError *err);

#endif
