// Filling in a CohortError, and assertions.

#ifndef CO_BASE_ERROR_H
#define CO_BASE_ERROR_H

#include "cohort/base.h"

#include <stdio.h>
#include <stdlib.h>

#define CO_STRINGIFY_(x) #x
#define CO_STRINGIFY(x) CO_STRINGIFY_(x)
#define CO_HERE __FILE__ ":" CO_STRINGIFY(__LINE__)

#ifdef __cplusplus
extern "C" {
#endif

// Records a failure in *err unless it already holds one; err may be NULL. Always returns false, so
// that `return co_error_set(...)` reads as what it does.
bool co_error_set(CohortError *err, const char *where, CohortErrorCode code, const char *format,
                  ...) __attribute__((format(printf, 4, 5)));

// Adds the place in the input to a failure just recorded; NULL or 0 leaves a part as it is.
void co_error_place(CohortError *err, const char *file, uint32_t line, uint32_t column,
                    const char *prim_path);

#ifdef __cplusplus
}
#endif

#define CO_FAIL(err, code, ...) co_error_set((err), CO_HERE, (code), __VA_ARGS__)

// Leaves the function with `false` (or NULL: CO_CHECK_NULL) when a condition on input does not
// hold.
#define CO_CHECK(cond, err, code, ...) \
    do { \
        if (!(cond)) \
            return co_error_set((err), CO_HERE, (code), __VA_ARGS__); \
    } while (0)
#define CO_CHECK_NULL(cond, err, code, ...) \
    do { \
        if (!(cond)) { \
            co_error_set((err), CO_HERE, (code), __VA_ARGS__); \
            return NULL; \
        } \
    } while (0)
#define CO_CHECK_MEMORY(ptr, err) \
    CO_CHECK((ptr) != NULL, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory")

// Programmer mistakes only, never input. Kept out of Release builds.
#ifdef NDEBUG
#define CO_ASSERT(cond) ((void)sizeof(cond))
#else
#define CO_ASSERT(cond) \
    do { \
        if (!(cond)) { \
            fprintf(stderr, "%s: assertion failed: %s\n", CO_HERE, #cond); \
            abort(); \
        } \
    } while (0)
#endif

#endif
