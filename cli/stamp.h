// What goes into the header of an EXR beside the pixels: where the image comes from, and the
// camera.

#ifndef COHORT_CLI_STAMP_H
#define COHORT_CLI_STAMP_H

#include "cohort/delegate.h"
#include "cohort/image.h"

typedef struct OutputStamp {
    const char *stage, *camera, *filter, *status; // status: "complete", "interrupted", "snapshot"
    double time, pixel_aspect, frames_per_second;
    uint32_t seed;
    uint64_t stage_hash;
    const char *ocio_config, *rendering_space;
    const CohortView *view; // NULL when no PNG is written
    bool has_lens;
    CohortCameraDesc lens; // as rendered
    CohortRenderStats stats;
} OutputStamp;

enum {
    STAMP_ATTRIBUTES_MAX = 40
};

typedef struct StampAttributes {
    CohortAttribute list[STAMP_ATTRIBUTES_MAX];
    char texts[4][64];
    char space[128];
    size_t count, text_count;
} StampAttributes;

// Fails when the rendering space cannot be described.
bool stamp_attributes(const OutputStamp *stamp, StampAttributes *out, CohortError *err);

#endif
