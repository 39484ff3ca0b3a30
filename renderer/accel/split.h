// Splits ranges of boxes in two by the binned surface-area heuristic.
//
// Private to the builder. What comes out does not depend on the number of threads.

#ifndef CO_ACCEL_SPLIT_H
#define CO_ACCEL_SPLIT_H

#include "accel/build.h"
#include "simd/lanes4.h"

enum {
    CO_SPLIT_DEPTH = 60, // from here on ranges are halved, so that no tree is deeper than 93
    CO_BIN_COUNT = 32
};
_Static_assert(CO_SPLIT_DEPTH + 33 <= CO_TREE_DEPTH_MAX, "the walk's stack follows from the depth");

// A range of prims on its way down.
typedef struct CoRange {
    uint32_t first, count, depth;
    CoBox box;
} CoRange;

// Splits a range of at least 2 prims into two that are not empty, in place.
void co_split_range(CoBuildPrim *prims, const CoRange *range, CoRange halves[2]);

enum {
    CO_SPLIT_LARGE = 8192 // ranges of at most so many are split at once, without a CoWideSplit
};

// The same for large ranges, of at most `most` prims, by all threads or, with one
// worker, by the caller. NULL when memory ends.
typedef struct CoWideSplit CoWideSplit;
CoWideSplit *co_wide_split_create(size_t most, uint32_t workers);
void co_wide_split_destroy(CoWideSplit *split);
CoBox co_wide_split_box(CoWideSplit *split, CoBuildPrim *prims, size_t count);
void co_wide_split_range(CoWideSplit *split, CoBuildPrim *prims, const CoRange *range,
                         CoRange halves[2]);

// The steps of a split.

typedef struct CoBox4 {
    Co4 lo, hi;
} CoBox4;

// What lies in a bin. A cache line, so that one shift finds all of it.
typedef struct CoBin {
    CoBox4 box;
    uint32_t count[8]; // the first
} CoBin;
_Static_assert(sizeof(CoBin) == 64, "a cache line");

typedef struct CoBins {
    CoBin of[3][CO_BIN_COUNT];
    uint32_t used; // bins of an axis, a multiple of 4
} CoBins;

// How centroids map to bins; scale 0: no extent on that axis.
typedef struct CoBinning {
    float origin[4], scale[4];
    uint32_t used;
} CoBinning;

// Right of it is what has (centroid - origin) * scale >= edge on the axis; axis -1: none found.
typedef struct CoSplit {
    int axis;
    float origin, scale, edge;
    uint32_t left; // prims
    float cost;
    CoBox4 boxes[2];
} CoSplit;

CoBox4 co_box4_empty(void);
void co_box4_store(CoBox *out, const CoBox4 *from);
void co_box4_extend(CoBox4 *box, const CoBox4 *by);
CoBox4 co_centroid_box(const CoBuildPrim *prims, size_t count);
CoBox4 co_prim_box(const CoBuildPrim *prims, size_t count);
CoBinning co_binning_over(const CoBox4 *centroids, size_t count);
void co_bins_clear(CoBins *bins, uint32_t used);
void co_bins_fill(CoBins *bins, const CoBinning *binning, const CoBuildPrim *prims, size_t count);
void co_bins_merge(CoBins *into, const CoBins *from);
CoSplit co_split_choose(const CoBins *bins, const CoBinning *binning, const CoBox *box);

// How many are left of a split, and those of them to the front.
size_t co_split_count(const CoSplit *split, const CoBuildPrim *prims, size_t count);
void co_split_move(const CoSplit *split, CoBuildPrim *prims, size_t count, size_t left);

// The halves of a range that was split like this; axis -1: in the middle.
void co_split_give(const CoSplit *split, const CoBuildPrim *prims, const CoRange *range,
                   CoRange halves[2]);

#endif
