// Whether one thread and several make the same of a layer: specs, fields, lines, and every error.

#ifndef TEST_SAME_FOR_THREADS_H
#define TEST_SAME_FOR_THREADS_H

#include "parse/layer.h"

// `options` (may be NULL) but for threads and report. True also when both refuse the text alike.
bool same_for_threads(const char *text, size_t size, const CohortStageOptions *options,
                      uint32_t threads);

#endif
