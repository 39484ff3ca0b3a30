// Progress: a bar for people on a terminal, ALF_PROGRESS lines for farms.

#ifndef COHORT_CLI_PROGRESS_H
#define COHORT_CLI_PROGRESS_H

#include "cohort/render.h"

typedef struct Progress {
    bool has_bar, has_alf;
    int last_percent; // of the ALF lines, which only rise
    size_t frame, frame_count;
} Progress;

// is_alf: lines "ALF_PROGRESS nn%" on standard output. A bar is drawn on standard error when that
// is a terminal and not is_quiet.
void progress_begin(Progress *progress, bool is_alf, bool is_quiet, size_t frame_count);

// fraction of the current frame, 0 to 1.
void progress_update(Progress *progress, double fraction, double seconds,
                     const CohortRenderStats *stats);
void progress_end(Progress *progress);

#endif
