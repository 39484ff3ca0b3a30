// Requests: the parts of lookups, one per texel block, with the slot that receives its sum.
//
// Source: Eisenacher et al. 2013, 3.2. A lookup's filter may touch several blocks; each touch is
// one request that carries its part of the kernel and its own slot, so that blocks can be read in
// any order and the slots still be added in one.

#ifndef CO_TEXTURE_REQUEST_H
#define CO_TEXTURE_REQUEST_H

#include "texture/image_file.h"
#include "texture/ptex_filter.h"
#include "texture/texture.h"

#define CO_TEXTURE_CHANNELS 4

// One open file. Textures that differ in filter or wrap share it.
typedef struct CoTextureFile {
    CoPtexFile *ptex; // one of the two
    CoImageFile *image;
    char *path; // for messages
    uint64_t device, inode;
    uint32_t block_count;
    uint64_t decoded_bytes; // of all its blocks
    _Atomic(void *)
        *blocks;            // [block_count] resident texels, NULL until first read; NULL: none kept
    size_t *sizes;          // [block_count] bytes of what is resident
    atomic_bool is_damaged; // a block could not be decoded
    bool is_damage_told;
} CoTextureFile;

typedef enum CoTextureKind {
    CO_TEXTURE_FALLBACK = 0, // a color: the file could not be used
    CO_TEXTURE_PTEX,
    CO_TEXTURE_IMAGE
} CoTextureKind;

#define CO_UDIM_TILES 100 // 1001 to 1100, ten per row

typedef struct CoTexture {
    CoTextureKind kind;
    float fallback[4];
    uint32_t file; // index into CoTextures.files
    CoPtexFilter filter;
    uint16_t channels[CO_TEXTURE_CHANNELS]; // of the file that are looked up: colors, then alpha
    uint32_t channel_count;
    bool has_alpha; // the last of them is alpha
    CohortWrap wrap_s, wrap_t;
    uint32_t *udim; // [CO_UDIM_TILES] files, COHORT_INVALID_ID where there is none; NULL: one image
} CoTexture;

// One part of one lookup. Its weights follow it: uw, then vw floats.
typedef struct CoRequest {
    struct CoRequest *next; // of the same lookup, in the order of addition
    uint32_t texture, file;
    uint32_t block; // CO_PTEX_NO_BLOCK: `sum` is there already
    uint32_t axes;  // CoPtexSource.axes
    int32_t u, v;   // first texel, in the block after its halvings
    uint8_t uw, vw;
    int8_t ulog2, vlog2; // Ptex: of the block
    uint8_t steps, rotation;
    bool is_served;
    float sum[CO_TEXTURE_CHANNELS];
    float weights[];
} CoRequest;

// A lookup between request and sum.
typedef struct CoPending {
    CoRequest *first;
    float scale;   // what the sum is divided by; 0: the result is black; -1: it is written already
    float missing; // part of the weight that fell on nothing: transparent
} CoPending;

// Memory for requests: in core up to a budget that the pools of a batch share, then in scratch
// files.
typedef struct CoRequestPool {
    struct CoRequestSegment *first, *current;
    const char *scratch_folder;
    atomic_size_t *budget; // bytes left in core
} CoRequestPool;

// Room for `size` bytes, 16-byte aligned, until the pool is rewound or cleared. NULL with *err set.
void *co_request_alloc(CoRequestPool *pool, size_t size, CohortError *err);

typedef struct CoRequestMark {
    struct CoRequestSegment *segment;
    size_t used;
} CoRequestMark;

CoRequestMark co_request_mark(const CoRequestPool *pool);
void co_request_rewind(CoRequestPool *pool, CoRequestMark mark);
void co_request_pool_clear(CoRequestPool *pool);

// Where the requests of one lookup go.
typedef struct CoRequestSink {
    CoRequestPool *pool;
    const CoTexture *texture;
    const CoTextureFile *file; // the file that is looked up
    uint32_t texture_id, file_id;
    CoRequest *first, **last;
    float missing; // CoPending.missing of the lookup
    uint64_t count;
    CohortError *err;
    bool ok;
} CoRequestSink;

// Room for a request with `uw` + `vw` weights at the end of the sink's list; NULL after a failure.
CoRequest *co_request_add(CoRequestSink *sink, uint32_t uw, uint32_t vw);

// Turns one lookup into requests; the result's scale. Lookups that are not finite are taken as 0.
float co_ptex_request(CoRequestSink *sink, const CoLookup *lookup);
float co_image_request(CoRequestSink *sink, const CoLookup *lookup);

// The file of a UDIM set that holds the lookup's tile, s and t moved into it; COHORT_INVALID_ID
// where there is none.
uint32_t co_image_udim(const CoTexture *texture, CoLookup *lookup);

// Position of a block among all blocks of all files: files in order of opening, blocks in file
// order.
uint64_t co_request_key(const CoRequest *request, const CoTextureFile *file);

#endif
