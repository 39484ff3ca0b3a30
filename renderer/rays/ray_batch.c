#include "rays/ray_batch.h"

#include "base/error.h"
#include "base/memory.h"

#include <string.h>

#define GROUP 64

static size_t padded(size_t count)
{
    return (count + GROUP - 1) / GROUP * GROUP;
}

bool co_ray_batch_reserve(CoRayBatch *batch, size_t capacity, CohortError *err)
{
    batch->count = 0;
    capacity = padded(capacity);
    if (capacity <= batch->capacity)
        return true;
    CO_CHECK(capacity <= UINT32_MAX, err, COHORT_ERROR_LIMIT, "a batch of %zu rays is too large",
             capacity);
    co_ray_batch_clear(batch);
    batch->capacity = capacity;
    bool is_good = true;
#define ALLOCATE(type, name) \
    batch->name = co_alloc(CO_MEMORY_RAYS, capacity * sizeof(type)); \
    is_good = is_good && batch->name;
    CO_RAY_FIELDS(ALLOCATE)
    if (!is_good)
        co_ray_batch_clear(batch);
    CO_CHECK(is_good, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for a batch of %zu rays",
             capacity);
    return true;
}

void co_ray_batch_clear(CoRayBatch *batch)
{
#define FREE(type, name) co_free(CO_MEMORY_RAYS, batch->name, batch->capacity * sizeof(type));
    CO_RAY_FIELDS(FREE)
    memset(batch, 0, sizeof *batch);
}

bool co_hit_batch_reserve(CoHitBatch *batch, size_t capacity, CohortError *err)
{
    batch->count = 0;
    capacity = padded(capacity);
    if (capacity <= batch->capacity)
        return true;
    CO_CHECK(capacity <= UINT32_MAX, err, COHORT_ERROR_LIMIT, "a batch of %zu hits is too large",
             capacity);
    co_hit_batch_clear(batch);
    batch->capacity = capacity;
    bool is_good = true;
    CO_HIT_FIELDS(ALLOCATE)
    if (!is_good)
        co_hit_batch_clear(batch);
    CO_CHECK(is_good, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for a batch of %zu hits",
             capacity);
    return true;
}

void co_hit_batch_clear(CoHitBatch *batch)
{
    CO_HIT_FIELDS(FREE)
    memset(batch, 0, sizeof *batch);
}

void co_ray_batch_begin(CoRayBatch *batch, size_t count)
{
    CO_ASSERT(count <= batch->capacity);
    batch->count = count;
    for (size_t i = count; i < padded(count); i++) {
        batch->org_x[i] = batch->org_y[i] = batch->org_z[i] = 0.0f;
        batch->dir_x[i] = batch->dir_y[i] = 0.0f;
        batch->dir_z[i] = 1.0f;
        batch->tnear[i] = 1.0f;
        batch->tfar[i] = 0.0f;
        batch->record[i] = UINT32_MAX;
    }
}
