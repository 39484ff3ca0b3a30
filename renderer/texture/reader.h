// Reading blocks and serving the requests that wait for them: one thread's side of it.

#ifndef CO_TEXTURE_READER_H
#define CO_TEXTURE_READER_H

#include "texture/request.h"

typedef struct CoReader {
    CoPtexDecoder decoder;
    CoImageReader images;
    void *texels, *halved; // scratch
    size_t texels_size, halved_size;
    CohortError err;
} CoReader;

void co_reader_clear(CoReader *reader);

// Bytes of the decoded block that a request names.
size_t co_reader_block_size(const CoTextureFile *file, const CoRequest *request);

// Decodes it into `out`; false when it is damaged or memory is short.
bool co_reader_decode(CoReader *reader, const CoTextureFile *file, const CoRequest *request,
                      void *out);

// True when the decoding that just failed did so for want of memory.
bool co_reader_is_short(const CoReader *reader, const CoTextureFile *file);

// Reader scratch of at least `size` bytes for a decoded block, or NULL.
void *co_reader_texels(CoReader *reader, size_t size);

// Sums one request over its block, which `texels` holds with all halvings made.
void co_reader_sum(const CoTextureFile *file, const CoTexture *texture, CoRequest *request,
                   const void *texels);

// Serves requests of one block, or of one tiled face and its tiles: `texels` is the whole of it,
// `whole` a request that names it. Halvings are made once per resolution. False without memory.
bool co_reader_serve(CoReader *reader, const CoTextureFile *file, const CoTexture *textures,
                     const CoRequest *whole, CoRequest *const *requests, size_t count,
                     const void *texels);

// A block that cannot be decoded: its requests get the texture's fallback color.
void co_reader_give_up(CoTextureFile *file, const CoTexture *textures, CoRequest *const *requests,
                       size_t count);

#endif
