#include "texture/request.h"

#include "base/error.h"
#include "base/mapped_file.h"
#include "base/memory.h"

#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#define SEGMENT_BYTES ((size_t)4 << 20)

typedef struct CoRequestSegment {
    struct CoRequestSegment *next;
    size_t used; // bytes, this header included
    bool is_scratch;
} CoRequestSegment;

#define HEADER_BYTES 32
_Static_assert(sizeof(CoRequestSegment) <= HEADER_BYTES, "segments start with their header");

static CoRequestSegment *map_segment(const char *folder, CohortError *err)
{
    int fd = co_scratch_file(folder, SEGMENT_BYTES, err);
    if (fd < 0)
        return NULL;
    void *bytes = mmap(NULL, SEGMENT_BYTES, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    close(fd);
    if (bytes == MAP_FAILED) {
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "cannot map %zu bytes of scratch space",
                SEGMENT_BYTES);
        return NULL;
    }
    return bytes;
}

static bool take_from_budget(CoRequestPool *pool)
{
    size_t left = atomic_load(pool->budget);
    while (left >= SEGMENT_BYTES)
        if (atomic_compare_exchange_weak(pool->budget, &left, left - SEGMENT_BYTES))
            return true;
    return false;
}

static CoRequestSegment *new_segment(CoRequestPool *pool, CohortError *err)
{
    bool in_core = take_from_budget(pool);
    CoRequestSegment *segment = in_core ? co_alloc(CO_MEMORY_TEXTURE, SEGMENT_BYTES)
                                        : map_segment(pool->scratch_folder, err);
    if (!segment) {
        if (in_core)
            CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for texture requests");
        return NULL;
    }
    *segment = (CoRequestSegment){NULL, HEADER_BYTES, !in_core};
    return segment;
}

void *co_request_alloc(CoRequestPool *pool, size_t size, CohortError *err)
{
    size = (size + 15) & ~(size_t)15;
    CO_CHECK_NULL(size <= SEGMENT_BYTES - HEADER_BYTES, err, COHORT_ERROR_INTERNAL,
                  "a request of %zu bytes", size);
    if (!pool->current || pool->current->used + size > SEGMENT_BYTES) {
        CoRequestSegment *next = pool->current ? pool->current->next : pool->first;
        if (!next) {
            next = new_segment(pool, err);
            if (!next)
                return NULL;
            *(pool->current ? &pool->current->next : &pool->first) = next;
        }
        next->used = HEADER_BYTES;
        pool->current = next;
    }
    void *out = (char *)pool->current + pool->current->used;
    pool->current->used += size;
    return out;
}

CoRequestMark co_request_mark(const CoRequestPool *pool)
{
    return (CoRequestMark){pool->current, pool->current ? pool->current->used : 0};
}

void co_request_rewind(CoRequestPool *pool, CoRequestMark mark)
{
    pool->current = mark.segment;
    if (mark.segment)
        mark.segment->used = mark.used;
}

void co_request_pool_clear(CoRequestPool *pool)
{
    while (pool->first) {
        CoRequestSegment *next = pool->first->next;
        if (pool->first->is_scratch) {
            munmap(pool->first, SEGMENT_BYTES);
        } else {
            co_free(CO_MEMORY_TEXTURE, pool->first, SEGMENT_BYTES);
            atomic_fetch_add(pool->budget, SEGMENT_BYTES);
        }
        pool->first = next;
    }
    pool->current = NULL;
}

CoRequest *co_request_add(CoRequestSink *sink, uint32_t uw, uint32_t vw)
{
    if (!sink->ok)
        return NULL;
    CoRequest *request =
        co_request_alloc(sink->pool, sizeof *request + (uw + vw) * sizeof(float), sink->err);
    sink->ok = request != NULL;
    if (!request)
        return NULL;
    memset(request, 0, sizeof *request);
    request->texture = sink->texture_id;
    request->file = sink->file_id;
    request->block = CO_PTEX_NO_BLOCK;
    request->uw = (uint8_t)uw;
    request->vw = (uint8_t)vw;
    *sink->last = request;
    sink->last = &request->next;
    sink->count++;
    return request;
}

uint64_t co_request_key(const CoRequest *request, const CoTextureFile *file)
{
    // Files of more than 2^40 bytes only lose their order beyond that, never their grouping by
    // file.
    uint64_t at = file->ptex ? file->ptex->blocks[request->block].offset : request->block;
    return (uint64_t)request->file << 40 | (at & (((uint64_t)1 << 40) - 1));
}
