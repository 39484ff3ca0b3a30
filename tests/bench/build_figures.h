// What bench_build measures of a tree, ours or Embree's.

#ifndef BENCH_BUILD_FIGURES_H
#define BENCH_BUILD_FIGURES_H

#include "rays/ray_batch.h"

// What a ray that meets the root is expected to touch.
typedef struct Cost {
    double nodes, leaves, blocks; // blocks of as many triangles as are tested at once: ours 8, 4
} Cost;

typedef struct Figures {
    double seconds, cpu; // the least of all rounds
    double bytes, peak;  // of the tree and of its making
    Cost cost;
} Figures;

#ifdef BENCH_EMBREE
// Builds a tree of medium quality once; the cost is left as it is.
void build_embree(const CoMesh *mesh, uint32_t threads, Figures *out);

// Of Embree's builder over boxes, with nodes as wide as ours.
Cost build_embree_cost(const CoMesh *mesh);

// Nanoseconds of a ray, the least of five passes, one thread.
double build_embree_trace(const CoMesh *mesh, const CoRayBatch *rays);
#endif

#endif
