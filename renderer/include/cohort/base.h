// What every public header of Cohort shares: errors, limits and severities.
//
// A host links libcohort.a as `pkg-config --cflags --libs cohort` says. Beside it lies a module,
// lib/cohort/cohort_oiio.so, which is opened when the first image file is read: the host's RPATH
// must lead to that folder (the flags above see to it; a program that moves with its prefix has
// $ORIGIN/../lib/cohort), or LD_LIBRARY_PATH. Where it does not, the first image is
// COHORT_ERROR_INSTALLATION; scenes without image files need no module.
//
// Threads: all types here are plain data. A CohortError belongs to the thread that passes it.

#ifndef COHORT_BASE_H
#define COHORT_BASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

// Says "no limit" in an option that limits something; zero means that option's finite default.
#define COHORT_NO_LIMIT UINT64_MAX

// The one index value that names nothing.
#define COHORT_INVALID_ID UINT32_MAX

// Stable causes. The numbers never change once released; new ones are added at the end.
typedef enum CohortErrorCode {
    COHORT_OK = 0,
    COHORT_ERROR_OUT_OF_MEMORY,  // an allocation failed or would have passed its limit
    COHORT_ERROR_LIMIT,          // input is larger, deeper or longer than an option allows
    COHORT_ERROR_ARGUMENT,       // a call's argument makes no sense
    COHORT_ERROR_FILE_NOT_FOUND, // nothing at that path
    COHORT_ERROR_FILE_READ,      // it is there, but could not be read
    COHORT_ERROR_FILE_WRITE,     // could not be created, written or closed; disk full
    COHORT_ERROR_USDA_SYNTAX,    // text that is no USDA
    COHORT_ERROR_USD_BINARY,     // a binary crate or package: Cohort reads text
    COHORT_ERROR_COMPOSITION,    // an arc that leads nowhere, a cycle
    COHORT_ERROR_SCENE,          // a scene description that cannot be rendered
    COHORT_ERROR_TEXTURE,        // an image or Ptex file that cannot be used
    COHORT_ERROR_COLOR,          // an OCIO config, display, view or color space
    COHORT_ERROR_IMAGE,          // an EXR or PNG that cannot be read or has the wrong shape
    COHORT_ERROR_CANCELLED,      // the caller asked to stop
    COHORT_ERROR_INTERNAL,       // a bug in Cohort: please report it
    COHORT_ERROR_INSTALLATION    // a part of Cohort, or a library that it needs, is not where it
                                 // belongs
} CohortErrorCode;

// One failure, for people and for programs. A zeroed error means none; the first failure wins.
typedef struct CohortError {
    CohortErrorCode code;
    char message[256];   // a sentence: what was found, what was expected, what to do
    char file[256];      // the input file it stands in, empty if none
    uint32_t line;       // 1-based, 0 if none
    uint32_t column;     // 1-based, 0 if none
    char prim_path[256]; // the prim it concerns, empty if none
    const char *where;   // "file.c:123" in Cohort's source, for reports
} CohortError;

// Of one thing told by a diagnostic callback, a list of warnings or a report; no message has
// another way, and nothing is ever printed.
typedef enum CohortSeverity {
    COHORT_SEVERITY_ERROR = 0,
    COHORT_SEVERITY_WARNING,
    COHORT_SEVERITY_INFO
} CohortSeverity;

// Cohort's version, "major.minor.patch". The string is static.
const char *cohort_version(void);

#ifdef __cplusplus
}
#endif

#endif
