// Frame specs and file name placeholders, as usdrecord has them.

#ifndef COHORT_CLI_FRAMES_H
#define COHORT_CLI_FRAMES_H

#include <stdbool.h>
#include <stddef.h>

enum {
    FRAMES_MAX = 1000000
};

typedef struct FrameList {
    double *times; // malloc'ed
    size_t count;
    int precision; // digits after the point that tell the frames apart
} FrameList;

// "7", "1:5", "5:1", "1:9x2", "1:2x0.5", joined by commas. False with a sentence in why.
bool frames_parse(const char *spec, FrameList *out, char *why, size_t why_size);
void frames_clear(FrameList *list);

// Writes `pattern` with its one placeholder (### or ###.###: hashes are the width, those after the
// point the precision) replaced by the frame. Without a placeholder: a copy, an error when several
// frames would share the file.
bool frames_path(const char *pattern, const FrameList *list, size_t frame, char *out, size_t size,
                 char *why, size_t why_size);

#endif
