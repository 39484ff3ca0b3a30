// What `cohort check` finds: collected, made unique, put in order, and printed for people or
// programs.

#ifndef COHORT_CLI_FINDINGS_H
#define COHORT_CLI_FINDINGS_H

#include "cohort/base.h"

#include <stdio.h>

// Codes are part of the JSON output and never change their meaning.
#define FINDING_CODES(X) \
    X(SYNTAX, "syntax", "correct the text there; Cohort reads what usd-core 26.11 reads") \
    X(LIMIT, "limit", "make it smaller, or raise the limit if it is meant to be so big") \
    X(MISSING_LAYER, "missing-layer", "put the file there, or correct the asset path") \
    X(COMPOSITION, "composition", "correct or remove the arc") \
    X(UNSUPPORTED_LAYER, "unsupported-layer", \
      "convert it to USDA with UsdPreviewSurface materials") \
    X(MISSING_ASSET, "missing-asset", "put the file there, or correct the asset path") \
    X(MISSING_TARGET, "missing-target", "correct the path, or remove the target") \
    X(ARRAY_LENGTH, "array-length", "export the mesh again, or correct the interpolation") \
    X(TOPOLOGY, "topology", "export the mesh again; faces that are not valid are not drawn") \
    X(VALUE, "value", "correct the value; what is not finite cannot be drawn") \
    X(TRANSFORM, "transform", "correct xformOpOrder and the ops it names") \
    X(UNITS, "units", "author it in the root layer's metadata") \
    X(EXTENT, "extent", "check metersPerUnit and the transforms; recompute the extent") \
    X(CAMERA, "camera", "correct the camera; lengths are in tenths of a stage unit") \
    X(DEFAULT_PRIM, "default-prim", "name a root prim in defaultPrim") \
    X(NO_LIGHT, "no-light", "add a light, or render with --env sky") \
    X(NOT_HONORED, "not-honored", \
      "other renderers may show it; the README of Cohort lists what is supported")

typedef enum FindingCode {
#define FINDING_ENUM(name, text, hint) FINDING_##name,
    FINDING_CODES(FINDING_ENUM)
#undef FINDING_ENUM
    FINDING_CODE_COUNT
} FindingCode;

typedef struct Finding {
    FindingCode code;
    CohortSeverity severity; // error or warning
    const char *layer;       // absolute path, "" if none
    uint32_t line, column;   // 1-based, 0 if unknown
    const char *prim;        // path, "" if none
    const char *property;    // "" if none
    const char *text;
    size_t prim_count; // prims it holds for; `prim` is the first
} Finding;

typedef struct Findings {
    Finding *items;
    size_t count, capacity;
    size_t errors, warnings; // after findings_finish
    bool is_out_of_memory;
} Findings;

// Copies what it is given.
void findings_add(Findings *findings, const Finding *finding);

// Sorts by layer and line, drops repeats, and merges what several prims have from one line.
void findings_finish(Findings *findings);

// For people: paths relative to the current folder, with source lines where the text is wrong.
void findings_print(const Findings *findings, FILE *out);

// One JSON object (docs/check.md).
void findings_print_json(const Findings *findings, const char *stage, FILE *out);

void findings_clear(Findings *findings);

#endif
