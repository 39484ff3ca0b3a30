// The reference of the traversal benchmark, held to one instruction set.

#ifndef TRAVERSAL_EMBREE_H
#define TRAVERSAL_EMBREE_H

#include "rays/ray_batch.h"
#include "traversal_scene.h"

typedef struct BenchEmbree BenchEmbree;

// The same triangles in one tree of default quality. isa: "avx2" or "avx512". NULL when it cannot
// be had. The meshes must outlive it. *seconds: of the build, buffers made.
BenchEmbree *bench_embree_create(const BenchScene *scene, const char *isa, bool robust,
                                 uint32_t threads, double *seconds);
void bench_embree_destroy(BenchEmbree *embree);

// All memory that it asked for, without the points and indices which it was lent.
size_t bench_embree_bytes(const BenchEmbree *embree);

// Rays [begin, end) in packets of 1, 8 or 16; t = INFINITY without a hit, and 0 for whatever blocks
// an occlusion ray. coherent: the flag of the context, which lets packets stay together.
void bench_embree_trace(const BenchEmbree *embree, uint32_t width, bool coherent, bool occlusion,
                        const CoRayBatch *rays, CoHitBatch *hits, size_t begin, size_t end);

// Whether packets of that width are native.
bool bench_embree_has(const BenchEmbree *embree, uint32_t width);

#endif
