// What the two halves of the ray bins share: ray_bin.c fills files, ray_bin_take.c empties them.

#ifndef CO_RAYS_RAY_BIN_PARTS_H
#define CO_RAYS_RAY_BIN_PARTS_H

#include "rays/ray_bin.h"

#include <pthread.h>
#include <stdatomic.h>

#define CO_PAGE_IN_BYTES ((size_t)1 << 20)

struct CoBinFile {
    int fd;
    uint32_t bin;
    const uint32_t *map; // the whole file, read only
    // Reservations run past the capacity when several workers find the file full; those get
    // nothing.
    atomic_uint_fast64_t reserved, committed; // records
    uint64_t asked;  // bytes that were not in memory when they were asked for ahead
    CoBinFile *next; // on the ready stack or the free list
    CoBinFile *next_made;
};

// Records of a worker on their way to a file.
typedef struct CoBinLocal {
    uint32_t *words; // local_records records
    uint32_t count;
} CoBinLocal;

struct CoRayBins {
    size_t capacity, file_bytes, record_bytes;
    uint32_t stride, workers, local_records;
    char *folder;
    size_t folder_bytes;
    CoBinLocal (*local)[CO_RAY_BINS]; // per worker
    uint32_t *local_words;
    _Atomic(CoBinFile *) open[CO_RAY_BINS]; // NULL until someone needs one
    atomic_bool has_failed;
    atomic_uint_fast64_t committed[CO_RAY_BINS];

    pthread_mutex_t lock; // guards the rest while workers push
    CoBinFile *ready, *spare, *made;
    uint32_t ready_depth;
    CohortError error;
    CoRayBinStats stats;

    uint32_t *memory; // of the last drain
    size_t memory_bytes;
    unsigned char *page_buffer; // CO_PAGE_IN_BYTES
};

// Remembers a failed read or write, the first one of all; cause: of errno, 0 for an unexpected end.
// Returns false.
bool co_ray_bins_fail_io(CoRayBins *bins, const char *what, int cause);

#endif
