// Coding of many rays at once, one table per instruction set (Eisenacher et al. 2013, figure 3).

#ifndef CO_RAYS_RAY_KERNELS_H
#define CO_RAYS_RAY_KERNELS_H

#include "rays/ray_bin.h"
#include "rays/ray_queue.h"

// Encodes what is in the queue: E[decoded weight] = weight.
// The largest channel keeps nine bits: in light rays whatever its size, so that they end by
// roulette only when black; in camera and BSDF rays from 2^-16 on. Weights above RGB9e5's own 65408
// use more exponent bits. A ray that can't be traced (NaN, infinite or negative parts, no
// direction, a weight above 2.8e14, or 3.4e38 for light rays) gets a record with a NaN origin, so
// that traversal rejects and counts it. A direction, pdf or normal that has been through
// co_ray_snap_* or co_ray_quantize_pdf is stored exactly. normal and pdf are kept for camera and
// BSDF rays, emitter (24 bits) for light rays. options: which optional words there are; the others
// are undefined. Every ray is encoded by itself: which others share the queue changes nothing.
typedef void CoRayEncodeFn(const CoRayQueue *queue, uint32_t options, CoRayEncoded *out);

// Decodes origin, direction and tnear of places [begin, end) of a batch; tfar is infinity. Place i
// gets record order[i], or i where order is NULL. options: as the records were encoded with. A
// thousand places or so at a time: records are asked for ahead within a call.
typedef void CoRayDecodeFn(const CoRayRecords *records, const uint32_t *order, uint32_t options,
                           size_t begin, size_t end, CoRayBatch *batch);

typedef struct CoRayKernels {
    const char *isa; // "scalar", "sse42", "avx2", "avx512"
    CoRayEncodeFn *encode;
    CoRayDecodeFn *decode;
} CoRayKernels;

// isa NULL or "" = the best that co_isa_flags() allows (simd/isa.h); NULL if this machine lacks it
// or it is masked off. The same bits whichever.
const CoRayKernels *co_ray_kernels(const char *isa);

CoRayEncodeFn co_ray_encode_scalar, co_ray_encode_sse42, co_ray_encode_avx2, co_ray_encode_avx512;
CoRayDecodeFn co_ray_decode_batch_scalar, co_ray_decode_batch_sse42, co_ray_decode_batch_avx2,
    co_ray_decode_batch_avx512;

#endif
