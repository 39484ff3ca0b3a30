// A ray of a batch as one struct, so that moving it costs one cache line and not nine.

#ifndef CO_SORT_RAY_ENTRY_H
#define CO_SORT_RAY_ENTRY_H

#include <stddef.h>
#include <stdint.h>

enum {
    CO_SORT_RUN = 4096,
    CO_SORT_GROUP = 64
};

typedef struct CoRayEntry {
    float v[6]; // origin, direction
    float tnear, tfar;
    uint32_t record;
} CoRayEntry;

_Static_assert(sizeof(CoRayEntry) == 36, "as large as the record it comes from");

// Recursive median partition of entries with finite origins; see ray_sort.h, EXACT.
void co_split_rays(CoRayEntry *entries, size_t count);

#endif
