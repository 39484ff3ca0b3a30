// What `cohort check` finds, and what looks for it.

#ifndef COHORT_CLI_CHECK_H
#define COHORT_CLI_CHECK_H

#include "cohort/usda.h"
#include "findings.h"

typedef struct Check {
    const CohortStage *stage;
    Findings findings;
    double box[6]; // of the points looked at, in the world: least x y z, greatest x y z
    size_t cameras, lights;
} Check;

// Adds a finding about a prim, or a property of it (NULL: none), where that is authored.
void check_found(Check *check, FindingCode code, CohortSeverity severity, const CohortPrim *prim,
                 const char *property, const char *format, ...)
    __attribute__((format(printf, 6, 7)));

// Looks at one prim (check_prim.c): targets, assets, transform, camera.
void check_prim(Check *check, const CohortPrim *prim);

// Topology, array lengths, points and extent of a mesh (check_mesh.c).
void check_mesh(Check *check, const CohortPrim *prim);

// The value of an attribute by default, else at its first time. False when there is none.
bool check_value(const CohortPrim *prim, const char *name, CohortValue *out);

#endif
