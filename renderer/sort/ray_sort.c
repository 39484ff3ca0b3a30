#include "sort/ray_sort.h"

#include "base/parallel.h"
#include "sort/ray_entry.h"

#define GRAIN 16384

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

static void set_bounds(CoRaySort *sort)
{
    const CoRayBounds *bounds = &sort->records->bounds;
    sort->valid = sort->records->count - bounds->invalid;
    if (sort->valid == 0)
        return;
    CoVec3 extent = co_sub(bounds->high, bounds->low);
    sort->low = bounds->low;
    sort->extent = co_max3(extent);
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
    set_bounds(&sort);
    if (is_exact)
        sort_exact(&sort);
    else
        co_curve_sort_rays(&sort);
    return true;
}
