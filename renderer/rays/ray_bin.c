// A worker gathers records and gives them to a bin's file many at a time: a disk wants whole pages,
// and copies to memory that go around the caches are waited for at each end.
#include "rays/ray_bin_parts.h"

#include "base/error.h"
#include "base/memory.h"

#include <string.h>

enum {
    LOCAL_RECORDS_MAX = 1024, // of 36 bytes: nine whole pages per write
    LOCAL_RECORDS_MIN = 16
};

// --- life ---------------------------------------------------------------------------------------

static size_t local_bytes(const CoRayBins *bins)
{
    return (size_t)bins->workers * CO_RAY_BINS * bins->local_records * bins->record_bytes;
}

static bool allocate_buffers(CoRayBins *bins, const char *folder)
{
    bins->folder_bytes = folder ? strlen(folder) + 1 : 1;
    bins->folder = co_alloc_zero(CO_MEMORY_RAYS, bins->folder_bytes);
    bins->worker = co_alloc_zero(CO_MEMORY_RAYS, bins->workers * sizeof *bins->worker);
    bins->local_words = co_alloc(CO_MEMORY_RAYS, local_bytes(bins));
    bins->page_buffer = co_alloc(CO_MEMORY_RAYS, CO_PAGE_IN_BYTES);
    if (!bins->folder || !bins->worker || !bins->local_words || !bins->page_buffer)
        return false;
    if (folder)
        memcpy(bins->folder, folder, bins->folder_bytes);
    size_t words = (size_t)bins->local_records * bins->stride;
    for (uint32_t worker = 0; worker < bins->workers; worker++)
        for (uint32_t b = 0; b < CO_RAY_BINS; b++)
            bins->worker[worker].local[b].words =
                bins->local_words + ((size_t)worker * CO_RAY_BINS + b) * words;
    return true;
}

CoRayBins *co_ray_bins_create(size_t capacity, uint32_t stride, uint32_t workers, uint64_t budget,
                              const char *folder, CohortError *err)
{
    CO_CHECK_NULL(capacity >= 1u << 8 && capacity <= 1u << 26 && stride >= CO_RAY_WORDS &&
                      stride <= CO_RAY_WORDS_MAX && workers > 0,
                  err, COHORT_ERROR_ARGUMENT,
                  "a batch holds 2^8 to 2^26 rays of 9 to 11 words; asked for %zu of %u", capacity,
                  stride);
    CoRayBins *bins = co_alloc_zero(CO_MEMORY_RAYS, sizeof *bins);
    CO_CHECK_NULL(bins, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    pthread_mutex_init(&bins->lock, NULL);
    bins->capacity = capacity;
    bins->stride = stride;
    bins->workers = workers;
    bins->budget = budget;
    bins->record_bytes = stride * sizeof(uint32_t);
    bins->file_bytes = capacity * bins->record_bytes;
    // Small batches get small buffers: else all of a batch would sit in them.
    size_t local = capacity / 16;
    bins->local_records = local < LOCAL_RECORDS_MIN   ? LOCAL_RECORDS_MIN
                          : local > LOCAL_RECORDS_MAX ? LOCAL_RECORDS_MAX
                                                      : (uint32_t)local;
    if (allocate_buffers(bins, folder))
        return bins;
    co_ray_bins_destroy(bins);
    CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    return NULL;
}

void co_ray_bins_destroy(CoRayBins *bins)
{
    if (!bins)
        return;
    while (bins->made) {
        CoBinFile *file = bins->made;
        bins->made = file->next_made;
        co_bin_file_destroy(bins, file);
    }
    pthread_mutex_destroy(&bins->lock);
    co_free(CO_MEMORY_RAYS, bins->folder, bins->folder_bytes);
    co_free(CO_MEMORY_RAYS, bins->worker, bins->workers * sizeof *bins->worker);
    co_free(CO_MEMORY_RAYS, bins->local_words, local_bytes(bins));
    co_free(CO_MEMORY_RAYS, bins->page_buffer, CO_PAGE_IN_BYTES);
    co_free(CO_MEMORY_RAYS, bins->memory, bins->memory_bytes);
    co_free(CO_MEMORY_RAYS, bins, sizeof *bins);
}

// --- files --------------------------------------------------------------------------------------

// The first failure stays; workers see the flag and stop pushing. The lock is held.
static bool fail_locked(CoRayBins *bins, const CohortError *err)
{
    if (!atomic_load(&bins->has_failed))
        bins->error = *err;
    atomic_store(&bins->has_failed, true);
    return false;
}

bool co_ray_bins_fail(CoRayBins *bins, const CohortError *err)
{
    pthread_mutex_lock(&bins->lock);
    fail_locked(bins, err);
    pthread_mutex_unlock(&bins->lock);
    return false;
}

// Files in memory before those on disk, whichever came back last.
static CoBinFile *take_spare(CoRayBins *bins)
{
    CoBinFile **at = &bins->spare;
    while (*at && !(*at)->memory)
        at = &(*at)->next;
    if (!*at)
        at = &bins->spare;
    CoBinFile *file = *at;
    if (file)
        *at = file->next;
    return file;
}

// Puts an empty file where `full` (or nothing) was, unless another worker already has.
static bool replace_file(CoRayBins *bins, uint32_t bin, CoBinFile *full)
{
    bool is_good = true;
    CohortError err = {0};
    pthread_mutex_lock(&bins->lock);
    if (atomic_load(&bins->open[bin]) == full) {
        CoBinFile *file = take_spare(bins);
        if (!file)
            file = co_bin_file_make(bins, &err);
        if (file) {
            file->bin = bin;
            co_bin_file_clear(file);
            atomic_store(&bins->open[bin], file);
        } else {
            is_good = fail_locked(bins, &err);
        }
    }
    pthread_mutex_unlock(&bins->lock);
    return is_good;
}

static void make_ready(CoRayBins *bins, CoBinFile *file)
{
    pthread_mutex_lock(&bins->lock);
    if (atomic_load(&bins->open[file->bin]) == file)
        atomic_store(&bins->open[file->bin], NULL);
    file->next = bins->ready;
    bins->ready = file;
    bins->ready_depth++;
    if (bins->ready_depth > bins->stats.ready_depth_peak)
        bins->stats.ready_depth_peak = bins->ready_depth;
    pthread_mutex_unlock(&bins->lock);
}

// --- pushing ------------------------------------------------------------------------------------

// A worker may hold a file that others have filled and replaced meanwhile: its reservation then
// finds no room and it looks again. Files come back for reuse only while nobody pushes, so it can't
// be writing into a second life of the file. The worker that completes the last record publishes
// the file; the mutex orders all writes before whoever pops it.
static bool commit(CoRayBins *bins, uint32_t bin, CoBinLocal *local)
{
    const uint32_t *words = local->words;
    uint64_t count = local->count;
    local->count = 0;
    local->committed += count;
    while (count > 0) {
        CoBinFile *file = atomic_load(&bins->open[bin]);
        uint64_t start = file ? atomic_fetch_add(&file->reserved, count) : bins->capacity;
        uint64_t room = start < bins->capacity ? bins->capacity - start : 0;
        if (room == 0) {
            if (!replace_file(bins, bin, file))
                return false;
            continue;
        }
        uint64_t take = count < room ? count : room;
        if (!co_bin_file_write(bins, file, start, words, take))
            return false;
        CoRayBounds bounds = co_ray_bounds_none();
        co_ray_bounds_add(&bounds, words, take, bins->stride);
        co_bin_file_widen(file, &bounds);
        local->written += file->memory ? 0 : take;
        if (atomic_fetch_add(&file->committed, take) + take == bins->capacity)
            make_ready(bins, file);
        words += take * bins->stride;
        count -= take;
    }
    return true;
}

// Of a length that the compiler knows but for the optional words.
static void copy_record(uint32_t *to, const uint32_t *from, uint32_t stride)
{
    memcpy(to, from, CO_RAY_WORDS * sizeof *to);
    for (uint32_t i = CO_RAY_WORDS; i < stride; i++)
        to[i] = from[i];
}

bool co_ray_bins_push(CoRayBins *bins, uint32_t worker, const uint32_t *words, uint32_t bin)
{
    CO_ASSERT(worker < bins->workers && bin < CO_RAY_BINS);
    CoBinLocal *local = &bins->worker[worker].local[bin];
    copy_record(local->words + (size_t)local->count * bins->stride, words, bins->stride);
    if (++local->count < bins->local_records)
        return true;
    if (!atomic_load_explicit(&bins->has_failed, memory_order_relaxed))
        return commit(bins, bin, local);
    local->count = 0;
    return false;
}

bool co_ray_bins_flush(CoRayBins *bins, CohortError *err)
{
    for (uint32_t worker = 0; worker < bins->workers; worker++)
        for (uint32_t b = 0; b < CO_RAY_BINS; b++) {
            CoBinLocal *local = &bins->worker[worker].local[b];
            if (local->count && !atomic_load(&bins->has_failed))
                commit(bins, b, local);
            local->count = 0;
        }
    if (!atomic_load(&bins->has_failed))
        return true;
    if (err && err->code == COHORT_OK)
        *err = bins->error;
    return false;
}

void co_ray_bins_reset(CoRayBins *bins)
{
    for (uint32_t b = 0; b < CO_RAY_BINS; b++)
        atomic_store(&bins->open[b], NULL);
    for (uint32_t worker = 0; worker < bins->workers; worker++)
        for (uint32_t b = 0; b < CO_RAY_BINS; b++)
            bins->worker[worker].local[b].count = 0;
    bins->ready = bins->spare = NULL;
    bins->ready_depth = 0;
    for (CoBinFile *file = bins->made; file; file = file->next_made) {
        file->next = bins->spare;
        bins->spare = file;
    }
    atomic_store(&bins->has_failed, false);
    bins->error = (CohortError){0};
}

void co_ray_bins_stats(const CoRayBins *bins, CoRayBinStats *out)
{
    *out = bins->stats;
    for (uint32_t worker = 0; worker < bins->workers; worker++)
        for (uint32_t b = 0; b < CO_RAY_BINS; b++) {
            const CoBinLocal *local = &bins->worker[worker].local[b];
            out->committed[b] += local->committed;
            out->bytes_written += local->written * bins->record_bytes;
        }
}
