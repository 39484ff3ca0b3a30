// What the files of this room share about a set of textures; the other rooms see texture.h.

#ifndef CO_TEXTURE_TEXTURES_H
#define CO_TEXTURE_TEXTURES_H

#include "texture/block_cache.h"
#include "texture/reader.h"

struct CoTextures {
    CoTexturesOptions options; // its strings are owned
    uint64_t rendering_space;  // hash of what `to_rendering` does to some colors
    CoTexture *textures;
    CoTextureFile **files;
    uint32_t count, file_count;
    size_t capacity, file_capacity;
    uint64_t decoded_bytes;  // of all files
    uint64_t resident_limit; // of those that may stay
    uint64_t block_bytes;    // of the largest block
    bool is_resident;        // all of it may stay
    uint32_t batch;          // number of the last one
    uint32_t worker_count;   // of the arrays below
    CoReader *readers;
    CoRequestPool *pools;
    CoBlockCache *caches;
    atomic_size_t request_budget;
};

// Says that something about a texture is not as it should be. `asset` names it.
void co_textures_warn(CoTextures *textures, const char *asset, const char *text);

// Makes the workers' tools and decides what may stay resident. Before each batch.
bool co_textures_prepare(CoTextures *textures, CohortError *err);

// Opens a file once, however many textures name it. Returns its index; COHORT_INVALID_ID on
// failure.
uint32_t co_textures_open_ptex(CoTextures *textures, const char *path, CohortError *err);
uint32_t co_textures_open_image(CoTextures *textures, const char *path, CohortError *err);

#endif
