// --stats: everything that a render counted, as one JSON object with stable keys.

#ifndef COHORT_CLI_STATS_FILE_H
#define COHORT_CLI_STATS_FILE_H

#include "cohort/delegate.h"

typedef struct StatsContext {
    const char *stage, *status;
    CohortDelegate *delegate;
    CohortRenderIndex *index;
    CohortRenderStats render;
    double load_seconds, total_seconds;
} StatsContext;

bool stats_write(const char *path, const StatsContext *context, CohortError *err);

#endif
