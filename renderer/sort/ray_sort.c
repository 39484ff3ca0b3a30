#include "sort/ray_sort.h"

#include "base/parallel.h"
#include "sort/ray_entry.h"

#include <stdatomic.h>

#define GRAIN 16384

// --- bounds -------------------------------------------------------------------------------------

typedef struct Scan {
    const CoRayRecords *records;
    atomic_size_t invalid;
    _Atomic uint32_t low[3], high[3]; // ordered bits of floats
} Scan;

// Floats in the order of their values as unsigned integers.
static uint32_t ordered(float x)
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

static float unordered(uint32_t bits)
{
    float x;
    bits = bits & 0x80000000u ? bits & 0x7fffffffu : ~bits;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static void widen(Scan *scan, int axis, float low, float high)
{
    uint32_t l = ordered(low), h = ordered(high), held = atomic_load(&scan->low[axis]);
    while (l < held && !atomic_compare_exchange_weak(&scan->low[axis], &held, l))
        ;
    held = atomic_load(&scan->high[axis]);
    while (h > held && !atomic_compare_exchange_weak(&scan->high[axis], &held, h))
        ;
}

static void scan_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    Scan *scan = context;
    CoVec3 low = co_vec3_splat(INFINITY), high = co_vec3_splat(-INFINITY);
    size_t invalid = 0;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        CoVec3 o = co_sort_origin(scan->records, i);
        if (!co_is_finite3(o)) {
            invalid++;
            continue;
        }
        low = co_vec3(co_min(o.x, low.x), co_min(o.y, low.y), co_min(o.z, low.z));
        high = co_vec3(co_max(o.x, high.x), co_max(o.y, high.y), co_max(o.z, high.z));
    }
    if (invalid < end - begin) {
        widen(scan, 0, low.x, high.x);
        widen(scan, 1, low.y, high.y);
        widen(scan, 2, low.z, high.z);
    }
    atomic_fetch_add(&scan->invalid, invalid);
}

// Bounds of the origins, and how many are finite.
static void find_bounds(CoRaySort *sort)
{
    Scan scan = {.records = sort->records};
    for (int a = 0; a < 3; a++)
        atomic_store(&scan.low[a], UINT32_MAX);
    co_parallel_for(sort->records->count, GRAIN, scan_range, &scan);
    sort->valid = sort->records->count - atomic_load(&scan.invalid);
    float low[3] = {0};
    for (int a = 0; a < 3 && sort->valid > 0; a++) {
        low[a] = unordered(atomic_load(&scan.low[a]));
        sort->extent = fmaxf(sort->extent, unordered(atomic_load(&scan.high[a])) - low[a]);
    }
    sort->low = co_vec3_load(low);
}

// --- exact --------------------------------------------------------------------------------------

static void store_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    const CoRaySort *sort = context;
    const CoRayRecords *records = sort->records;
    CoRayEntry *entries = (CoRayEntry *)(void *)sort->memory;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        CoVec3 org = co_sort_origin(records, i);
        CoVec3 dir = co_ray_decode_direction(records->words + i * records->stride);
        co_vec3_store(entries[i].v, org);
        co_vec3_store(entries[i].v + 3, dir);
        entries[i].record = (uint32_t)i;
    }
}

static void order_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    const CoRaySort *sort = context;
    const CoRayEntry *entries = (const CoRayEntry *)(const void *)sort->memory;
    (void)worker;
    for (size_t i = begin; i < end; i++)
        sort->order[i] = entries[i].record;
}

static void move_invalid_last(CoRayEntry *entries, size_t count)
{
    size_t end = count;
    for (size_t i = 0; i < end;) {
        if (co_is_finite3(co_vec3_load(entries[i].v))) {
            i++;
            continue;
        }
        CoRayEntry t = entries[i];
        entries[i] = entries[--end];
        entries[end] = t;
    }
}

static void sort_exact(CoRaySort *sort)
{
    CoRayEntry *entries = (CoRayEntry *)(void *)sort->memory;
    size_t count = sort->records->count;
    co_parallel_for(count, GRAIN, store_range, sort);
    if (sort->valid < count)
        move_invalid_last(entries, count);
    co_split_rays(entries, sort->valid);
    co_parallel_for(count, GRAIN, order_range, sort);
}

bool co_sort_rays(const CoRayRecords *records, CoRaySorter sorter, CoSortScratch *scratch,
                  uint32_t *order, CohortError *err)
{
    if (records->count == 0)
        return true;
    bool is_exact = sorter.which == COHORT_SORTER_EXACT;
    size_t bytes =
        is_exact ? records->count * sizeof(CoRayEntry) : co_curve_sort_bytes(records->count);
    CoRaySort sort = {.records = records, .keys = sorter.keys, .order = order};
    sort.memory = co_sort_scratch_reserve(scratch, bytes, err);
    if (!sort.memory)
        return false;
    find_bounds(&sort);
    if (is_exact)
        sort_exact(&sort);
    else
        co_curve_sort_rays(&sort);
    return true;
}
