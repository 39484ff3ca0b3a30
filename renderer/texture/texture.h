// Textures of a scene: Ptex and image files looked up for a whole batch at once.
//
// Source: Eisenacher et al. 2013, 3.2: each (file, face or tile, level) block is decompressed at
// most once per batch, in file order, over all meshes and layers, and no texture cache exists. A
// lookup becomes requests, one per block its filter touches, each with its part of the kernel;
// requests are sorted by (file, block); every request writes its partial sum to its own slot; slots
// are added in fixed order. The cached mode uses the same partial sums through an ordinary cache:
// same bits.

#ifndef CO_TEXTURE_TEXTURE_H
#define CO_TEXTURE_TEXTURE_H

#include "cohort/scene.h"

typedef struct CoTextures CoTextures;

typedef struct CoTexturesOptions {
    const char *converted_folder; // NULL: $XDG_CACHE_HOME/cohort or ~/.cache/cohort
    bool ptex_reductions_authored;
    uint64_t resident_bytes; // decoded texels that may stay resident where all fit; 0 = 1 GiB
    // Turns RGB(A) texels of a named color space (or "sRGB") into the rendering space, in place;
    // `pixels` holds count * 4 floats. NULL: sRGB is decoded by formula, nothing else is known.
    // Threads: may be called by several at once.
    bool (*to_rendering)(void *cookie, const char *space, float *pixels, size_t count,
                         CohortError *err);
    // What the color config says of a file by its name alone; NULL: nothing, or there is no config.
    const char *(*space_of_file)(void *cookie, const char *path);
    void *cookie; // of both
    void (*warn)(void *cookie, const char *place, const char *text);
    void *warn_cookie;
} CoTexturesOptions;

CoTextures *co_textures_create(const CoTexturesOptions *options, CohortError *err);
void co_textures_destroy(CoTextures *textures);

// Whether a picture may be made without a texture that failed for this reason: not when every other
// one would fail too, for lack of memory or of the means to read images.
bool co_texture_may_lack(const CohortError *why);

// Opens one texture (converting it first where it must be) and returns its id. A file that cannot
// be used gives a texture of its fallback color (Ptex: magenta) and a warning, not a failure.
uint32_t co_textures_add(CoTextures *textures, const CohortTextureDesc *desc, CohortError *err);

// For checks at commit: number of faces of a Ptex file, 0 for images; triangle or quad mesh type.
uint32_t co_texture_ptex_faces(const CoTextures *textures, uint32_t texture, bool *is_triangle);

// Bounds, from the next batch on, the decoded texels that may stay resident and the bytes of
// requests that are kept in core; 0 means what the options say, and 512 MiB. Pixels do not change.
void co_textures_limit(CoTextures *textures, uint64_t resident_bytes, uint64_t request_bytes);

// Bytes of the largest block, decoded: what a worker holds while it reads.
uint64_t co_textures_block_bytes(const CoTextures *textures);

// One lookup. The footprint is the parallelogram spanned by (ds0, dt0) and (ds1, dt1) in texture or
// Ptex face coordinates; all zero = full resolution.
typedef struct CoLookup {
    uint32_t texture;
    uint32_t face; // Ptex face id; 0 for images
    float s, t;    // image: (0, 0) is the lower left; Ptex: u, v of the face
    float ds0, dt0, ds1, dt1;
} CoLookup;

typedef enum CoLookupMode {
    CO_LOOKUP_SORTED = 0, // read in file order, each block once, nothing kept
    CO_LOOKUP_CACHED      // in the order given, through a cache
} CoLookupMode;

typedef struct CoLookupStats {
    uint64_t lookups, requests, blocks_read, blocks_twice, bytes_read;
    double seconds;
} CoLookupStats;

// Evaluates all lookups of a batch: out[i] = rgba of lookups[i], in the rendering space. Parallel
// inside. `cancel` is polled between blocks (may be NULL). Same bits for both modes, any thread
// count.
bool co_textures_evaluate(CoTextures *textures, const CoLookup *lookups, size_t count,
                          float (*out)[4], CoLookupMode mode, const volatile int *cancel,
                          const char *scratch_folder, CoLookupStats *stats, CohortError *err);

// A whole image as float RGBA, rows from the top, in the rendering space: for domes and rect
// lights, read once at commit. *pixels is freed with co_image_free.
bool co_image_read(CoTextures *textures, const CohortTextureDesc *desc, float **pixels,
                   uint32_t *width, uint32_t *height, CohortError *err);
void co_image_free(float *pixels, uint32_t width, uint32_t height);

#endif
