// What is on disk is read through a shared mapping, so that a batch in work needs no second copy in
// memory.
#include "rays/ray_bin_parts.h"

#include "base/clock.h"
#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#define PAGE_BYTES_MIN 4096
#define GATHER_GRAIN 16384 // records

// Bytes of [at, at + part) of a file that are not in memory; part is at most CO_PAGE_IN_BYTES.
static size_t absent_bytes(const CoBinFile *file, size_t at, size_t part)
{
    unsigned char residency[CO_PAGE_IN_BYTES / PAGE_BYTES_MIN];
    size_t page = (size_t)sysconf(_SC_PAGESIZE), absent = 0;
    void *address = (void *)((uintptr_t)file->map + at);
    bool is_known = mincore(address, part, residency) == 0;
    for (size_t i = 0; i < (part + page - 1) / page; i++)
        absent += !is_known || !(residency[i] & 1);
    return absent * page;
}

static size_t page_in_part(size_t bytes, size_t at)
{
    return bytes - at < CO_PAGE_IN_BYTES ? bytes - at : CO_PAGE_IN_BYTES;
}

// Has the system read the next batch while this one is worked on. What it reads counts here: by
// the time the batch is taken it is in memory.
static void ask_ahead(CoRayBins *bins, CoBinFile *file)
{
    uint64_t absent = 0;
    if (file->memory)
        return;
    for (size_t at = 0; at < bins->file_bytes; at += CO_PAGE_IN_BYTES)
        absent += absent_bytes(file, at, page_in_part(bins->file_bytes, at));
    if (absent > file->asked) {
        bins->stats.bytes_read += absent - file->asked;
        file->asked = absent;
    }
    if (absent)
        posix_fadvise(file->fd, 0, 0, POSIX_FADV_WILLNEED);
}

// Brings the pages of a batch into memory with reads, which can fail, before the mapping is
// touched.
static bool page_in(CoRayBins *bins, CoBinFile *file, size_t bytes)
{
    if (file->memory)
        return true;
    double begin = co_clock_seconds();
    uint64_t absent_sum = 0;
    for (size_t at = 0; at < bytes; at += CO_PAGE_IN_BYTES) {
        size_t part = page_in_part(bytes, at), absent = absent_bytes(file, at, part);
        if (absent && !co_bin_file_read(bins, file, at, bins->page_buffer, part))
            return false;
        absent_sum += absent;
    }
    if (absent_sum > file->asked)
        bins->stats.bytes_read += absent_sum - file->asked;
    file->asked = 0;
    bins->stats.wait_seconds += co_clock_seconds() - begin;
    return true;
}

static bool take_file(CoRayBins *bins, CoBinFile *file, size_t count, CoRayRecords *out,
                      CohortError *err)
{
    bool is_good = page_in(bins, file, count * bins->record_bytes);
    if (is_good && bins->ready)
        ask_ahead(bins, bins->ready);
    if (!is_good) {
        file->next = bins->spare;
        bins->spare = file;
        if (err && err->code == COHORT_OK)
            *err = bins->error;
        return false;
    }
    bins->stats.batches[file->bin]++;
    *out =
        (CoRayRecords){file->map, count, bins->stride, file->bin, file, co_bin_file_bounds(file)};
    return true;
}

bool co_ray_bins_pop(CoRayBins *bins, CoRayRecords *out, CohortError *err)
{
    CoBinFile *file = bins->ready;
    *out = (CoRayRecords){.stride = bins->stride, .bin = CO_RAY_BIN_MIXED};
    if (!file)
        return true;
    bins->ready = file->next;
    bins->ready_depth--;
    return take_file(bins, file, bins->capacity, out, err);
}

static size_t open_count(const CoRayBins *bins, uint32_t bin)
{
    CoBinFile *file = atomic_load(&bins->open[bin]);
    return file ? (size_t)atomic_load(&file->committed) : 0;
}

size_t co_ray_bins_left(const CoRayBins *bins)
{
    size_t left = 0;
    for (uint32_t b = 0; b < CO_RAY_BINS; b++)
        left += open_count(bins, b);
    return left;
}

static uint32_t fullest_bin(const CoRayBins *bins)
{
    uint32_t fullest = 0;
    for (uint32_t b = 1; b < CO_RAY_BINS; b++)
        if (open_count(bins, b) > open_count(bins, fullest))
            fullest = b;
    return fullest;
}

static bool take_fullest(CoRayBins *bins, CoRayRecords *out, CohortError *err)
{
    uint32_t fullest = fullest_bin(bins);
    CoBinFile *file = atomic_load(&bins->open[fullest]);
    atomic_store(&bins->open[fullest], NULL);
    return take_file(bins, file, (size_t)atomic_load(&file->committed), out, err);
}

static bool reserve_memory(CoRayBins *bins, size_t bytes, CohortError *err)
{
    if (bytes <= bins->memory_bytes)
        return true;
    co_free(CO_MEMORY_RAYS, bins->memory, bins->memory_bytes);
    bins->memory_bytes = 0;
    bins->memory = co_alloc(CO_MEMORY_RAYS, bytes);
    CO_CHECK_MEMORY(bins->memory, err);
    bins->memory_bytes = bytes;
    return true;
}

// Where the records of each bin go; those of `kept` are there already.
typedef struct Gather {
    CoRayBins *bins;
    uint32_t *to;
    size_t first[CO_RAY_BINS], count[CO_RAY_BINS];
    uint32_t kept;
    atomic_bool has_failed;
} Gather;

static void gather_range(void *context, size_t begin, size_t end, uint32_t worker)
{
    Gather *gather = context;
    CoRayBins *bins = gather->bins;
    (void)worker;
    for (uint32_t b = 0; b < CO_RAY_BINS; b++) {
        size_t first = gather->first[b], last = first + gather->count[b];
        size_t from = begin > first ? begin : first, stop = end < last ? end : last;
        if (b != gather->kept && from < stop &&
            !co_bin_file_read(bins, atomic_load(&bins->open[b]),
                              (from - first) * bins->record_bytes, gather->to + from * bins->stride,
                              (stop - from) * bins->record_bytes))
            atomic_store(&gather->has_failed, true);
    }
}

// The other bins' records behind those of the fullest, when that is in memory; else all of them in
// memory that is kept for this.
static bool gather_all(CoRayBins *bins, size_t left, CoRayRecords *out, CohortError *err)
{
    uint32_t fullest = fullest_bin(bins);
    CoBinFile *target = atomic_load(&bins->open[fullest]);
    Gather gather = {.bins = bins, .kept = CO_RAY_BINS};
    if (target->memory) {
        gather.to = target->memory;
        gather.kept = fullest;
    } else {
        if (!reserve_memory(bins, left * bins->record_bytes, err))
            return false;
        gather.to = bins->memory;
        target = NULL;
    }
    size_t at = target ? open_count(bins, fullest) : 0;
    for (uint32_t b = 0; b < CO_RAY_BINS; b++) {
        gather.count[b] = open_count(bins, b);
        gather.first[b] = b == gather.kept ? 0 : at;
        at += b == gather.kept ? 0 : gather.count[b];
    }
    co_parallel_for(left, GATHER_GRAIN, gather_range, &gather);
    if (atomic_load(&gather.has_failed)) {
        if (err && err->code == COHORT_OK)
            *err = bins->error;
        return false;
    }
    CoRayBounds all = co_ray_bounds_none();
    for (uint32_t b = 0; b < CO_RAY_BINS; b++)
        if (gather.count[b] > 0) {
            CoBinFile *file = atomic_load(&bins->open[b]);
            CoRayBounds bounds = co_bin_file_bounds(file);
            co_ray_bounds_join(&all, &bounds);
            co_bin_file_clear(file);
        }
    if (target)
        atomic_store(&bins->open[fullest], NULL);
    *out = (CoRayRecords){gather.to, left, bins->stride, CO_RAY_BIN_MIXED, target, all};
    return true;
}

bool co_ray_bins_drain(CoRayBins *bins, CoRayRecords *out, CohortError *err)
{
    size_t left = co_ray_bins_left(bins);
    *out = (CoRayRecords){.stride = bins->stride, .bin = CO_RAY_BIN_MIXED};
    if (left == 0)
        return true;
    if (left > bins->capacity)
        return take_fullest(bins, out, err);
    if (!gather_all(bins, left, out, err))
        return false;
    bins->stats.drained++;
    return true;
}

void co_ray_bins_recycle(CoRayBins *bins, CoRayRecords *records)
{
    if (records->file) {
        // What was read leaves the process; the file keeps its pages while there is room for them.
        if (!records->file->memory)
            madvise((void *)(uintptr_t)records->file->map, bins->file_bytes, MADV_DONTNEED);
        records->file->next = bins->spare;
        bins->spare = records->file;
    }
    *records = (CoRayRecords){.stride = bins->stride, .bin = CO_RAY_BIN_MIXED};
}
