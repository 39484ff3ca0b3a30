// Files on disk are written with pwrite, not through a mapping: a disk that fails then gives an
// error where a store would give SIGBUS.
#include "rays/ray_bin_parts.h"

#include "base/error.h"
#include "base/mapped_file.h"
#include "base/memory.h"
#include "rays/ray_parts.h"
#include "simd/stream_copy.h"

#include <errno.h>
#include <math.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

// Files that the caches hold till they are read need not go around them.
#define STREAM_BYTES ((size_t)8 << 20)

#define AVAILABLE_PART 4

uint64_t co_ray_bins_budget(void)
{
    return co_memory_available() / AVAILABLE_PART;
}

// Floats in the order of their values as unsigned integers.
static uint32_t ordered(float x)
{
    uint32_t bits = co_float_bits(x);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

static float unordered(uint32_t bits)
{
    return co_float_from_bits(bits & 0x80000000u ? bits & 0x7fffffffu : ~bits);
}

static bool make_in_memory(CoRayBins *bins, CoBinFile *file)
{
    if (bins->file_bytes > bins->budget)
        return false;
    file->memory = co_alloc(CO_MEMORY_RAYS, bins->file_bytes);
    if (!file->memory)
        return false;
    file->map = file->memory;
    bins->budget -= bins->file_bytes;
    bins->stats.files_in_memory++;
    return true;
}

static bool make_on_disk(CoRayBins *bins, CoBinFile *file, CohortError *err)
{
    file->fd = co_scratch_file(bins->folder, bins->file_bytes, err);
    if (file->fd < 0)
        return false;
    void *map = mmap(NULL, bins->file_bytes, PROT_READ, MAP_SHARED, file->fd, 0);
    if (map == MAP_FAILED) {
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "cannot map a scratch file of %zu bytes: %s",
                bins->file_bytes, strerror(errno));
        close(file->fd);
        return false;
    }
    file->map = map;
    bins->stats.files_on_disk++;
    return true;
}

CoBinFile *co_bin_file_make(CoRayBins *bins, CohortError *err)
{
    CoBinFile *file = co_alloc_zero(CO_MEMORY_RAYS, sizeof *file);
    CO_CHECK_NULL(file, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    file->fd = -1;
    if (!make_in_memory(bins, file) && !make_on_disk(bins, file, err)) {
        co_free(CO_MEMORY_RAYS, file, sizeof *file);
        return NULL;
    }
    file->next_made = bins->made;
    bins->made = file;
    return file;
}

void co_bin_file_destroy(CoRayBins *bins, CoBinFile *file)
{
    if (file->memory) {
        co_free(CO_MEMORY_RAYS, file->memory, bins->file_bytes);
    } else {
        munmap((void *)(uintptr_t)file->map, bins->file_bytes);
        close(file->fd);
    }
    co_free(CO_MEMORY_RAYS, file, sizeof *file);
}

// --- records ------------------------------------------------------------------------------------

void co_bin_file_clear(CoBinFile *file)
{
    atomic_store(&file->reserved, 0);
    atomic_store(&file->committed, 0);
    atomic_store(&file->invalid, 0);
    for (int a = 0; a < 3; a++) {
        atomic_store(&file->low[a], ordered(INFINITY));
        atomic_store(&file->high[a], ordered(-INFINITY));
    }
}

void co_bin_file_widen(CoBinFile *file, const CoRayBounds *bounds)
{
    float low[3], high[3];
    co_vec3_store(low, bounds->low);
    co_vec3_store(high, bounds->high);
    for (int a = 0; a < 3; a++) {
        uint32_t l = ordered(low[a]), h = ordered(high[a]), held = atomic_load(&file->low[a]);
        while (l < held && !atomic_compare_exchange_weak(&file->low[a], &held, l))
            ;
        held = atomic_load(&file->high[a]);
        while (h > held && !atomic_compare_exchange_weak(&file->high[a], &held, h))
            ;
    }
    if (bounds->invalid)
        atomic_fetch_add(&file->invalid, bounds->invalid);
}

CoRayBounds co_bin_file_bounds(const CoBinFile *file)
{
    float low[3], high[3];
    for (int a = 0; a < 3; a++) {
        low[a] = unordered(atomic_load(&file->low[a]));
        high[a] = unordered(atomic_load(&file->high[a]));
    }
    return (CoRayBounds){co_vec3_load(low), co_vec3_load(high), atomic_load(&file->invalid)};
}

// cause: of errno, 0 for an unexpected end.
static bool fail_io(CoRayBins *bins, const char *what, int cause)
{
    CohortError err = {0};
    CO_FAIL(&err, COHORT_ERROR_FILE_WRITE, "cannot %s a scratch file of rays: %s", what,
            cause ? strerror(cause) : "unexpected end");
    return co_ray_bins_fail(bins, &err);
}

static bool write_to_disk(CoRayBins *bins, const CoBinFile *file, size_t at, const void *words,
                          size_t bytes)
{
    const char *data = words;
    while (bytes > 0) {
        ssize_t n = pwrite(file->fd, data, bytes, (off_t)at);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return fail_io(bins, "write", n < 0 ? errno : 0);
        data += n;
        at += (size_t)n;
        bytes -= (size_t)n;
    }
    return true;
}

bool co_bin_file_write(CoRayBins *bins, CoBinFile *file, uint64_t start, const uint32_t *words,
                       uint64_t count)
{
    size_t bytes = count * bins->record_bytes;
    if (!file->memory)
        return write_to_disk(bins, file, start * bins->record_bytes, words, bytes);
    uint32_t *to = file->memory + start * bins->stride;
    if (bins->file_bytes >= STREAM_BYTES)
        co_stream_copy(to, words, bytes);
    else
        memcpy(to, words, bytes);
    return true;
}

bool co_bin_file_read(CoRayBins *bins, const CoBinFile *file, size_t at, void *out, size_t bytes)
{
    char *data = out;
    if (file->memory) {
        memcpy(data, (const char *)file->memory + at, bytes);
        return true;
    }
    while (bytes > 0) {
        ssize_t n = pread(file->fd, data, bytes, (off_t)at);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return fail_io(bins, "read", n < 0 ? errno : 0);
        data += n;
        at += (size_t)n;
        bytes -= (size_t)n;
    }
    return true;
}
