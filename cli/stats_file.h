// --stats: everything that a render counted, as one JSON object with stable keys.

#ifndef COHORT_CLI_STATS_H
#define COHORT_CLI_STATS_H

#include "cohort/delegate.h"
#include "cohort/stage_adapter.h"

typedef struct StatsContext {
    const char *stage, *status;
    CohortDelegate *delegate;
    CohortRenderIndex *index;
    CohortAdapter *adapter;
    CohortRenderStats render;
    double load_seconds, total_seconds;
} StatsContext;

bool stats_write(const char *path, const StatsContext *context, CohortError *err);

#endif
