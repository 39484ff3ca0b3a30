// The files that a render is going to write: a slip in their names costs no frame.

#ifndef COHORT_CLI_NAMES_H
#define COHORT_CLI_NAMES_H

#include "render_command.h"

// The name of one frame of a pattern with or without ####.
bool names_frame(const RenderRun *run, const char *pattern, size_t frame, char *path, size_t size,
                 CohortError *err);

// Says before the first ray what would keep any file of any frame from being written after the last
// one: endings, folders, missing placeholders, one file named twice, or the stage itself.
bool names_check(const RenderRun *run, CohortError *err);

// The part of it that may change while other frames render.
bool names_check_writable(const char *path, CohortError *err);

#endif
