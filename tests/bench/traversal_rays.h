// Rays of the traversal benchmark: paths of diffuse bounces through a scene, as a path tracer
// without any sorting would make them.

#ifndef TRAVERSAL_RAYS_H
#define TRAVERSAL_RAYS_H

#include "rays/ray_batch.h"
#include "traversal_scene.h"

typedef struct BenchRays {
    CoRayBatch primary; // tiles of 8 x 8 pixels, row by row
    CoRayBatch diffuse; // bounces 1 to 5 of a path, then the next path's; paths by tile
    CoRayBatch light;   // from each of those vertices to a point of the light, as many as primary
} BenchRays;

// `diffuse` bounces, `others` of the rest. The scene's trees must be built.
bool bench_rays_make(const BenchScene *scene, size_t diffuse, size_t others, BenchRays *out);
void bench_rays_destroy(BenchRays *rays);

// The first `count` rays of a batch, as they are or in random order.
bool bench_rays_copy(const CoRayBatch *from, size_t count, bool shuffle, CoRayBatch *out);

#endif
