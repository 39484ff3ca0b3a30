// Coding of rays, compiled once per instruction set. Written lane by lane in loops of a known
// length that the compiler makes vectors of: every step is an operation that rounds once, so all
// instruction sets give the same bits.
#include "rays/ray_kernels.h"

#include "simd/lane.h"

enum {
    RAYS = CO_RAY_QUEUE_RAYS,
    DECODED = 32, // at once
    AHEAD = 64    // how many rays ahead records are asked for
};

#include "rays/kernels/decode.h"
#include "rays/kernels/encode.h"
