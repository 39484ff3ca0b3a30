// Active batches: from records to field arrays (Eisenacher et al. 2013, 3.1).

#ifndef CO_RAYS_RAY_BATCH_H
#define CO_RAYS_RAY_BATCH_H

#include "cohort/base.h"
#include "rays/ray_bin.h"

// Makes room for `capacity` rays, rounded up to 64, in 64-byte aligned arrays; count is 0.
// *batch is zeroed or holds an earlier batch, which is kept if it is large enough.
bool co_ray_batch_reserve(CoRayBatch *batch, size_t capacity, CohortError *err);
void co_ray_batch_clear(CoRayBatch *batch);

bool co_hit_batch_reserve(CoHitBatch *batch, size_t capacity, CohortError *err);
void co_hit_batch_clear(CoHitBatch *batch);

// Makes *batch one of `count` rays, which are still to be decoded (rays/ray_kernels.h). The padding
// up to a multiple of 64 gets rays that are over before they begin (tnear > tfar). count <=
// capacity.
void co_ray_batch_begin(CoRayBatch *batch, size_t count);

#endif
