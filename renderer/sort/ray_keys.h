// Keys of records for the ray sort, many at once; one function per instruction set, the same keys
// from each.

#ifndef CO_SORT_RAY_KEYS_H
#define CO_SORT_RAY_KEYS_H

#include "rays/ray_bin.h"

enum {
    CO_KEY_FACE_BITS = 3,
    // Of a direction, for each of two axes on a face of the cube:
    CO_KEY_DIRECTION_BITS = 5, // in a batch of one bin, where faces are known
    CO_KEY_MIXED_BITS = 5,
    CO_KEY_PINHOLE_BITS = 12 // where place is direction
};

// What an item is made of: place above direction above the index of the record. A place is a cell
// of the origins along a Hilbert curve; where all origins are one point it is that of the
// direction.
typedef struct CoKeyGrid {
    CoVec3 low;         // of the origins
    float scale;        // origin to cells, 0: one point
    uint32_t levels;    // bits of a cell along an axis
    uint32_t axis_bits; // of a direction
    uint32_t place_bits, direction_bits, index_bits;
} CoKeyGrid;

// Items of records [begin, end) to items[begin, end). That of an invalid record, whose origin is
// not finite, has the bit above its place set.
typedef void CoRayKeysFn(const CoRayRecords *records, const CoKeyGrid *grid, size_t begin,
                         size_t end, uint64_t *items);

CoRayKeysFn co_ray_keys_scalar, co_ray_keys_sse42, co_ray_keys_avx2, co_ray_keys_avx512;

// isa as co_ray_kernels has it; NULL if this machine lacks it or it is masked off.
CoRayKeysFn *co_ray_keys(const char *isa);

#endif
