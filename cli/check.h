// What `cohort check` finds, and what looks for it.

#ifndef COHORT_CLI_CHECK_H
#define COHORT_CLI_CHECK_H

#include "cohort/usda.h"

typedef struct Check {
    const CohortStage *stage;
    bool is_json;
    size_t errors, warnings; // found up to now
} Check;

// Prints one finding. `property` may be NULL.
void check_found(Check *check, CohortSeverity severity, const CohortPrim *prim,
                 const char *property, const char *format, ...)
    __attribute__((format(printf, 5, 6)));

// Looks at one prim: assets, targets, array lengths and topology.
void check_prim(Check *check, const CohortPrim *prim);

#endif
