// Blocks of the Ptex writer: planes, averages, compression, tiling.

#ifndef CO_TEXTURE_PTEX_ENCODE_H
#define CO_TEXTURE_PTEX_ENCODE_H

#include "texture/ptex_write.h"

typedef struct CoByteBuffer {
    unsigned char *bytes;
    size_t size, capacity;
} CoByteBuffer;

typedef struct CoPtexEncoder {
    const CoPtexWriteDesc *desc;
    void *compressor;
    CoByteBuffer out;   // the block just encoded
    CoByteBuffer plain; // scratch
    CoByteBuffer tiles; // scratch
} CoPtexEncoder;

// `desc` must outlive the encoder.
bool co_ptex_encoder_init(CoPtexEncoder *encoder, const CoPtexWriteDesc *desc, CohortError *err);
void co_ptex_encoder_clear(CoPtexEncoder *encoder);

// Encodes planes of 2^ulog2 x 2^vlog2 texels into encoder->out; *header is the block's header word.
bool co_ptex_encode(CoPtexEncoder *encoder, const void *planes, int ulog2, int vlog2,
                    uint32_t *header, CohortError *err);

// Appends a zlib stream of `size` bytes to encoder->out.
bool co_ptex_zip(CoPtexEncoder *encoder, const void *bytes, size_t size, CohortError *err);

// Interleaved pixels to planes.
void co_ptex_to_planes(const CoPtexWriteDesc *desc, const void *pixels, int ulog2, int vlog2,
                       void *planes);

// Multiplies the colors by alpha, in place: channels before alpha, or after it where it is the
// first.
void co_ptex_premultiply(const CoPtexWriteDesc *desc, void *planes, int ulog2, int vlog2);

// Halves both sides, in place: integers (a + b + c + d) >> 2, floats 0.25 * their sum.
void co_ptex_quarter(const CoPtexWriteDesc *desc, void *planes, int ulog2, int vlog2);

// Mean of all texels as one pixel, integers cut; premultiplied texels (where there is alpha) are
// divided by it again.
void co_ptex_average(const CoPtexWriteDesc *desc, const void *planes, int ulog2, int vlog2,
                     void *pixel);

#endif
