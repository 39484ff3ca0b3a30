#include "rays/ray_batch.h"

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"

#include <string.h>

#define GRAIN 8192
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

typedef struct Decode {
    const CoRayRecords *records;
    uint32_t options;
    CoRayBatch *batch;
} Decode;

static void decode_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Decode *decode = context;
    CoRayBatch *batch = decode->batch;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        const uint32_t *words = decode->records->words + i * decode->records->stride;
        CoVec3 dir = co_ray_decode_direction(words);
        memcpy(&batch->org_x[i], &words[0], sizeof(float));
        memcpy(&batch->org_y[i], &words[1], sizeof(float));
        memcpy(&batch->org_z[i], &words[2], sizeof(float));
        batch->dir_x[i] = dir.x;
        batch->dir_y[i] = dir.y;
        batch->dir_z[i] = dir.z;
        batch->tnear[i] = 0.0f;
        if (decode->options & CO_RAY_OPTION_TNEAR)
            memcpy(&batch->tnear[i], &words[CO_RAY_WORDS], sizeof(float));
        batch->tfar[i] = INFINITY;
        batch->record[i] = (uint32_t)i;
    }
}

void co_ray_batch_decode(const CoRayRecords *records, uint32_t options, CoRayBatch *batch)
{
    CO_ASSERT(records->count <= batch->capacity);
    Decode decode = {records, options, batch};
    co_parallel_for(records->count, GRAIN, decode_range, &decode);
    batch->count = records->count;
    for (size_t i = batch->count; i < padded(batch->count); i++) {
        batch->org_x[i] = batch->org_y[i] = batch->org_z[i] = 0.0f;
        batch->dir_x[i] = batch->dir_y[i] = 0.0f;
        batch->dir_z[i] = 1.0f;
        batch->tnear[i] = 1.0f;
        batch->tfar[i] = 0.0f;
        batch->record[i] = UINT32_MAX;
    }
}
