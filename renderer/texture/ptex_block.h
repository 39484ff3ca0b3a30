// Texels of Ptex blocks: decoding, halving, weighted sums.
//
// A decoded block is planar, as it is stored: all of channel 0 (rows from v = 0, u fastest), then
// channel 1 and so on, in the file's data type. Sums run over it as it is; nothing is converted but
// the texels a kernel touches.

#ifndef CO_TEXTURE_PTEX_BLOCK_H
#define CO_TEXTURE_PTEX_BLOCK_H

#include "texture/ptex_file.h"

// One thread's tools for decoding.
typedef struct CoPtexDecoder {
    CoInflate inflate;
    CoBlockCount *count; // may be NULL
    unsigned char *tile; // scratch for assembling tiled faces
    size_t tile_size;
    bool is_short; // memory for it was missing
} CoPtexDecoder;

void co_ptex_decoder_clear(CoPtexDecoder *decoder);

// Whether the decoding that just failed did so for want of memory.
bool co_ptex_decoder_is_short(const CoPtexDecoder *decoder);

// Bytes of one decoded block.
static inline size_t co_ptex_block_size(const CoPtexFile *file, int ulog2, int vlog2)
{
    return (size_t)co_ptex_pixel_size(file) << (ulog2 + vlog2);
}

// Decodes a block of 2^ulog2 x 2^vlog2 texels; of a tiled one all tiles, put together. False when
// the stream is broken or memory is short; `out` then holds anything.
bool co_ptex_block_decode(const CoPtexFile *file, uint32_t block, int ulog2, int vlog2,
                          CoPtexDecoder *decoder, void *out);

// Halves a block along one axis, in place: integers (a + b) >> 1, floats 0.5 * (a + b).
void co_ptex_halve(CoPtexType type, uint32_t channels, int ulog2, int vlog2, bool in_v,
                   void *texels);

// The steps of a source, all of them, in place.
void co_ptex_halve_all(const CoPtexFile *file, const CoPtexSource *source, void *texels);

// A kernel cut to one block: weights of texels [u, u + uw) x [v, v + vw), inside the block.
typedef struct CoPtexPart {
    int32_t u, v;
    uint32_t uw, vw;
    const float *ku, *kv;
} CoPtexPart;

// sum[i] = sum over rows of kv * (sum over columns of ku * texel), of channels[i]; integers
// unscaled.
void co_ptex_sum(CoPtexType type, const void *texels, int ulog2, int vlog2, const CoPtexPart *part,
                 const uint16_t *channels, uint32_t count, float *sum);

// One channel of a pixel as a float, integers unscaled.
float co_ptex_pixel_value(CoPtexType type, const void *pixel, uint32_t channel);

// What an integer's 1.0 is; 1 for half and float.
static inline float co_ptex_one(CoPtexType type)
{
    return type == CO_PTEX_U8 ? 255.0f : type == CO_PTEX_U16 ? 65535.0f : 1.0f;
}

// A whole face at a resolution, interleaved, v-major, in the file's data type. `out` holds
// co_ptex_block_size bytes. For conversions, not for lookups.
bool co_ptex_face_texels(const CoPtexFile *file, uint32_t face, int ulog2, int vlog2,
                         CoPtexDecoder *decoder, void *out, CohortError *err);

#endif
