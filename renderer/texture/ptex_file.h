// An open Ptex file: its tables, checked; no texels. Mapped, so opening costs its headers only.
//
// Source: the Ptex format, version 1 (Burley and Lacewell 2008, "Ptex: Per-Face Texture Mapping for
// Production Rendering"), as implemented by the reference library 2.4. Nothing a file says is
// believed: every position, count and size is checked before it is used, every inflated size is
// known before it is allocated.
// Terms: level k = resolution halved k times in both axes; rank = place of a face in the order in
// which coarser levels store their first faces; block = what one zlib stream holds: a face of a
// level, or a tile of it.

#ifndef CO_TEXTURE_PTEX_FILE_H
#define CO_TEXTURE_PTEX_FILE_H

#include "base/mapped_file.h"
#include "texture/inflate.h"

#define CO_PTEX_LEVELS 16 // most stored levels
#define CO_PTEX_LOG2 15   // most log2 of a face's side
#define CO_PTEX_NO_BLOCK UINT32_MAX

typedef enum CoPtexType {
    CO_PTEX_U8 = 0,
    CO_PTEX_U16,
    CO_PTEX_F16,
    CO_PTEX_F32
} CoPtexType;

typedef enum CoPtexBorder {
    CO_PTEX_CLAMP = 0,
    CO_PTEX_BLACK,
    CO_PTEX_PERIODIC
} CoPtexBorder;

enum { // CoPtexFace.flags
    CO_PTEX_CONSTANT = 1,
    CO_PTEX_EDITED = 2,
    CO_PTEX_NEIGHBORS_CONSTANT = 4,
    CO_PTEX_SUBFACE = 8
};

typedef struct CoPtexFace {
    int8_t ulog2, vlog2;
    uint8_t adjedges; // two bits per edge
    uint8_t flags;
    int32_t adjfaces[4]; // below 0: border
} CoPtexFace;

static inline int co_ptex_adjedge(const CoPtexFace *face, int edge)
{
    return face->adjedges >> (2 * edge) & 3;
}

typedef enum CoPtexEncoding {
    CO_PTEX_PLAIN = 0, // one pixel, not compressed: the block is constant
    CO_PTEX_ZIPPED,
    CO_PTEX_DIFFZIPPED,
    CO_PTEX_TILED
} CoPtexEncoding;

typedef struct CoPtexBlock {
    uint64_t offset; // in the file
    uint32_t header; // as stored: size in bits 0 to 29, encoding above
    uint32_t tiling; // index into tilings where the encoding is tiled
} CoPtexBlock;

static inline uint32_t co_ptex_stored_size(const CoPtexBlock *block)
{
    return block->header & 0x3fffffff;
}

static inline CoPtexEncoding co_ptex_encoding(const CoPtexBlock *block)
{
    return (CoPtexEncoding)(block->header >> 30);
}

// Tiles of one block: blocks[first ...], u fastest.
typedef struct CoPtexTiling {
    int8_t ulog2, vlog2; // of one tile
    uint32_t first;
} CoPtexTiling;

typedef struct CoPtexFile {
    CoMappedFile map;
    bool is_triangle;
    CoPtexType type;
    int32_t alpha; // channel, -1 = none
    uint32_t channels, levels, faces_count;
    CoPtexBorder u_border, v_border;
    bool is_tangent; // edge filter mode tanvec
    uint32_t level_faces[CO_PTEX_LEVELS];
    uint64_t level_bytes[CO_PTEX_LEVELS];
    uint32_t level_header_bytes[CO_PTEX_LEVELS];
    uint32_t level_block[CO_PTEX_LEVELS]; // block of the first face
    CoPtexFace *faces;                    // [faces_count], edits applied
    unsigned char *constants;             // [faces_count * pixel]
    uint32_t *ranks;                      // [faces_count]
    uint32_t *edit_blocks; // [faces_count] block of an edited face; NULL without edits
    CoPtexBlock *blocks;
    CoBlockStamp *stamps; // [block_count]
    uint32_t block_count, block_capacity;
    CoPtexTiling *tilings;
    uint32_t tiling_count;
    size_t tiling_capacity;
    struct CoPtexBytes *owned; // the arrays that have no capacity
} CoPtexFile;

// Bytes of one channel, and of one pixel.
static inline uint32_t co_ptex_type_size(CoPtexType type)
{
    return type == CO_PTEX_U8 ? 1 : type == CO_PTEX_F32 ? 4 : 2;
}

static inline uint32_t co_ptex_pixel_size(const CoPtexFile *file)
{
    return co_ptex_type_size(file->type) * file->channels;
}

// Opens and checks a file. Errors name it. On failure nothing is held. Threads: an open file is
// read-only but for its stamps; any number may read it.
CoPtexFile *co_ptex_open(const char *path, CohortError *err);
void co_ptex_close(CoPtexFile *file);

// Where the texels of a face at some resolution come from.
typedef struct CoPtexSource {
    uint32_t block;      // CO_PTEX_NO_BLOCK: constant, `pixel`
    const void *pixel;   // one pixel in the file's data type
    int8_t ulog2, vlog2; // of the block
    uint8_t steps;       // halvings that lead from the block to the resolution asked for
    uint32_t axes;       // bit i: step i halves v (else u); triangles halve both at once
} CoPtexSource;

// Finds it; false when the face has no such resolution. A stored level is taken where there is one,
// else the nearest finer one is halved, in the order in which the reference library does it.
bool co_ptex_locate(const CoPtexFile *file, uint32_t face, int ulog2, int vlog2, CoPtexSource *out);

#endif
