// What the parts of the ray bins share: ray_bin.c fills files, ray_bin_take.c empties them,
// ray_bin_file.c knows where their records are.

#ifndef CO_RAYS_RAY_BIN_PARTS_H
#define CO_RAYS_RAY_BIN_PARTS_H

#include "rays/ray_bin.h"

#include <pthread.h>
#include <stdatomic.h>

#define CO_PAGE_IN_BYTES ((size_t)1 << 20)
#define CO_CACHE_LINE 64

struct CoBinFile {
    const uint32_t *map; // all of it; on disk read only
    uint32_t *memory;    // the same to write to; NULL: on disk
    int fd;              // -1: in memory
    uint32_t bin;
    uint64_t asked;  // bytes that were not in memory when they were asked for ahead
    CoBinFile *next; // on the ready stack or the free list
    CoBinFile *next_made;
    // Reservations run past the capacity when several workers find the file full; those get
    // nothing.
    _Alignas(CO_CACHE_LINE) atomic_uint_fast64_t reserved; // records
    atomic_uint_fast64_t committed;
    // CoRayBounds of what is committed, floats as integers of the same order.
    _Atomic uint32_t low[3], high[3];
    atomic_size_t invalid;
};

// Records of a worker on their way to a file.
typedef struct CoBinLocal {
    uint32_t *words; // room for local_records records
    uint32_t count;
    uint64_t committed, written; // records: all of them; to disk
} CoBinLocal;

// Written at every ray: no two workers may share a cache line.
typedef struct CoBinWorker {
    _Alignas(CO_CACHE_LINE) CoBinLocal local[CO_RAY_BINS];
} CoBinWorker;

struct CoRayBins {
    size_t capacity, file_bytes, record_bytes;
    uint32_t stride, workers, local_records;
    char *folder;
    size_t folder_bytes;
    CoBinWorker *worker;
    uint32_t *local_words;
    _Atomic(CoBinFile *) open[CO_RAY_BINS]; // NULL until someone needs one
    atomic_bool has_failed;

    pthread_mutex_t lock; // guards the rest while workers push
    uint64_t budget;      // bytes of memory that may still become files
    CoBinFile *ready, *spare, *made;
    uint32_t ready_depth;
    CohortError error;
    CoRayBinStats stats;

    uint32_t *memory; // of the last drain
    size_t memory_bytes;
    unsigned char *page_buffer; // CO_PAGE_IN_BYTES
};

// An empty file, in memory while the budget lasts and there is memory, else on disk. NULL with *err
// set. The lock is held.
CoBinFile *co_bin_file_make(CoRayBins *bins, CohortError *err);
void co_bin_file_destroy(CoRayBins *bins, CoBinFile *file);

// Empties a file that is nobody else's, so that it can be filled.
void co_bin_file_clear(CoBinFile *file);

// Bounds of the records of a file: add those of some more, from any thread; and all of them.
void co_bin_file_widen(CoBinFile *file, const CoRayBounds *bounds);
CoRayBounds co_bin_file_bounds(const CoBinFile *file);

// Copy records to and bytes from a file. False when the disk fails, which the bins then remember.
bool co_bin_file_write(CoRayBins *bins, CoBinFile *file, uint64_t start, const uint32_t *words,
                       uint64_t count);
bool co_bin_file_read(CoRayBins *bins, const CoBinFile *file, size_t at, void *out, size_t bytes);

// Remembers a failure, the first one of all. Returns false.
bool co_ray_bins_fail(CoRayBins *bins, const CohortError *err);

#endif
