// Ray bins: rays collected by major direction, in memory while there is some for them, else in
// files that the system streams to disk.
//
// Source: Eisenacher et al. 2013, 3.1.
// Terms: bin = one of six directions; batch = the records of one file, `capacity` of them when
// full; ready = full and every record in place. A full file goes onto the ready stack and a fresh
// or reused one takes its place. Files are in memory until `budget` is spent or memory is refused;
// those after them are on disk, have no name and are preallocated: a full disk is an error when a
// file is made, never a signal. Where a file is changes no batch. Threads: push from any number of
// workers at once, each with its own index; everything else from one thread while nobody pushes.

#ifndef CO_RAYS_RAY_BIN_H
#define CO_RAYS_RAY_BIN_H

#include "cohort/base.h"
#include "rays/ray.h"
#include "rays/ray_bounds.h"

enum {
    CO_RAY_BINS = 6,
    CO_RAY_BIN_MIXED = 6
};

typedef struct CoRayBins CoRayBins;
typedef struct CoBinFile CoBinFile;

// A batch in work: valid until it is recycled (a gathered one: until the next drain).
typedef struct CoRayRecords {
    const uint32_t *words; // count records of `stride` words
    size_t count;
    uint32_t stride;
    uint32_t bin;    // 0-5, or CO_RAY_BIN_MIXED: gathered over all bins
    CoBinFile *file; // NULL: gathered apart from any file
    CoRayBounds bounds;
} CoRayRecords;

typedef struct CoRayBinStats {
    uint64_t committed[CO_RAY_BINS];    // records written: one side of "no ray is lost"
    uint64_t batches[CO_RAY_BINS];      // taken as files
    uint64_t drained;                   // batches gathered over all bins
    uint64_t bytes_written, bytes_read; // to disk and back; read = was not in memory any more
    double wait_seconds;                // until it was
    uint32_t files_in_memory, files_on_disk, ready_depth_peak;
} CoRayBinStats;

// capacity: records per file, 2^8 to 2^26. stride: words per record. budget: bytes that files may
// take in memory, 0 = all on disk. folder as co_scratch_file.
// Nothing is written before the first push. NULL with *err set on failure.
CoRayBins *co_ray_bins_create(size_t capacity, uint32_t stride, uint32_t workers, uint64_t budget,
                              const char *folder, CohortError *err);

// A budget where no one limits memory: a quarter of what is available now.
uint64_t co_ray_bins_budget(void);

void co_ray_bins_destroy(CoRayBins *bins);

// Adds one record of `stride` words. worker < workers; bin from co_ray_bin. False once a file could
// not be made or written: the round can't be completed then, co_ray_bins_flush says why.
bool co_ray_bins_push(CoRayBins *bins, uint32_t worker, const uint32_t *words, uint32_t bin);

// Moves all that is in the workers' local buffers to the files. False, with the cause, if this or
// any push before it failed. Call before pop, left or drain.
bool co_ray_bins_flush(CoRayBins *bins, CohortError *err);

// Takes the newest ready batch and starts reading the next ahead. out->count = 0 when none is
// ready.
bool co_ray_bins_pop(CoRayBins *bins, CoRayRecords *out, CohortError *err);

size_t co_ray_bins_left(const CoRayBins *bins); // records in files that are not full

// Takes what is left over all bins: everything at once, in memory, if it is at most one batch, else
// the fullest file as it is. out->count = 0 when nothing is left.
bool co_ray_bins_drain(CoRayBins *bins, CoRayRecords *out, CohortError *err);

// Gives a batch back; its file is used again. *records is cleared.
void co_ray_bins_recycle(CoRayBins *bins, CoRayRecords *records);

// Forgets every record and any failure: a cancelled round. Batches in work must be recycled before.
// The counts stay.
void co_ray_bins_reset(CoRayBins *bins);

void co_ray_bins_stats(const CoRayBins *bins, CoRayBinStats *out);

#endif
