// What is left of a triangle in a box, and its halves. Private to the builder of shards.

#ifndef CO_ACCEL_CUT_H
#define CO_ACCEL_CUT_H

#include "accel/build.h"
#include "simd/four.h"

enum {
    CO_CUT_CORNERS = 32 // mostly 9 at most
};

typedef struct CoShard {
    CoFour lo, hi;
    int count;
    CoFour corners[CO_CUT_CORNERS];
} CoShard;

// The area of its box is their sum, three times.
static inline CoFour co_shard_sides(const CoShard *shard)
{
    CoFour size = shard->hi - shard->lo;
    return size * __builtin_shufflevector(size, size, 1, 2, 0, 3);
}

// A whole triangle, whose box is known.
void co_cut_start(const CoMesh *mesh, const CoBuildPrim *prim, CoShard *out);

// Cuts through the middle of the longest side of the box. False when floats have none, or rounding
// has bent the outline so often that a corner more on each edge is too many.
//   rounding  what corners are off by, by axis: boxes are wider by as much, but within what it was
bool co_cut_halve(const CoShard *shard, CoFour rounding, CoShard halves[2]);

// What that would save of the area of each of four whole triangles, three times, but for rounding;
// not a number where floats do not say.
CoFour co_cut_saving(const CoMesh *mesh, const uint32_t ids[4]);

#endif
