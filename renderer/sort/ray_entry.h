// What the ray sorters share.

#ifndef CO_SORT_RAY_ENTRY_H
#define CO_SORT_RAY_ENTRY_H

#include "sort/ray_keys.h"

#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum {
    CO_SORT_GROUP = 64
};

// One sort.
typedef struct CoRaySort {
    const CoRayRecords *records;
    CoRayKeysFn *keys; // FAST
    uint32_t *order;   // the result
    size_t valid;      // rays with finite origins
    CoVec3 low;        // of the origins that are
    float extent;      // of their bounds, on the longest axis
    char *memory;      // 64-byte aligned, as large as the sorter wants
} CoRaySort;

// A ray as one struct, so that moving it costs one cache line and not several.
typedef struct CoRayEntry {
    float v[6]; // origin, direction
    uint32_t record;
} CoRayEntry;

_Static_assert(sizeof(CoRayEntry) == 28, "no padding");

static inline CoVec3 co_sort_origin(const CoRayRecords *records, size_t i)
{
    float v[3];
    memcpy(v, records->words + i * records->stride, sizeof v);
    return co_vec3(v[0], v[1], v[2]);
}

// Recursive median partition of entries with finite origins; see ray_sort.h, EXACT.
void co_split_rays(CoRayEntry *entries, size_t count);

// Sorting along curves; see ray_sort.h, FAST.
size_t co_curve_sort_bytes(size_t count);
void co_curve_sort_rays(const CoRaySort *sort);

#endif
