// Shared by the files that read a Ptex file's tables; nobody else includes it.

#ifndef CO_TEXTURE_PTEX_OPEN_H
#define CO_TEXTURE_PTEX_OPEN_H

#include "base/error.h"
#include "base/memory.h"
#include "texture/ptex_file.h"

#include <string.h>

// An allocation that lives as long as the file.
typedef struct CoPtexBytes {
    struct CoPtexBytes *next;
    size_t size; // of the whole allocation
    unsigned char bytes[];
} CoPtexBytes;

// Everything the parts share while a file is opened.
typedef struct CoPtexOpening {
    CoPtexFile *file;
    const unsigned char *data; // of the mapped file
    uint64_t size;
    CoInflate inflate;
    CohortError *err;
} CoPtexOpening;

static inline uint16_t co_load_u16(const unsigned char *p)
{
    return (uint16_t)(p[0] | p[1] << 8);
}

static inline uint32_t co_load_u32(const unsigned char *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static inline uint64_t co_load_u64(const unsigned char *p)
{
    return co_load_u32(p) | (uint64_t)co_load_u32(p + 4) << 32;
}

// Fails with "<what> of the Ptex file ...".
#define CO_PTEX_CHECK(opening, cond, ...) \
    CO_CHECK(cond, (opening)->err, COHORT_ERROR_TEXTURE, "broken Ptex file: " __VA_ARGS__)

// Room for `size` bytes owned by the file, or NULL.
void *co_ptex_keep(CoPtexFile *file, size_t size);

// Checks that a stream lies in the file and may hold `size` bytes, before they are allocated.
bool co_ptex_claim(CoPtexOpening *opening, uint64_t offset, uint64_t packed, uint64_t size,
                   const char *what);

// Inflates a header-like stream at [offset, offset + packed) into `out`; both ranges are checked.
bool co_ptex_inflate_at(CoPtexOpening *opening, uint64_t offset, uint64_t packed, void *out,
                        size_t size, const char *what);

// Reads and checks 20 bytes of face info.
bool co_ptex_face_read(CoPtexOpening *opening, const unsigned char *bytes, CoPtexFace *out);

enum {
    CO_PTEX_LEVEL_INFO = 16 // bytes for each level
};

// Reads the level info at *offset and the levels behind it, `data_size` bytes, which *offset is
// then moved past. The faces must have been read.
bool co_ptex_levels_read(CoPtexOpening *opening, uint64_t data_size, uint64_t *offset);

// Adds a face's block and its tiles; `index` is where it goes, CO_PTEX_NO_BLOCK appends (and `*out`
// receives the place).
bool co_ptex_block_add(CoPtexOpening *opening, const CoPtexBlock *block, int ulog2, int vlog2,
                       uint32_t index, uint32_t *out);

// Checks the metadata entries that a stream at `offset` inflates to. With `items_size` their values
// are streams of their own, of so many bytes in all.
bool co_ptex_meta_check(CoPtexOpening *opening, uint64_t offset, uint32_t packed, uint32_t size,
                        const uint64_t *items_size);

// Edit blocks in [begin, end) of the file. Old files have no size: `to_end` lets a cut block end
// it.
bool co_ptex_edits_read(CoPtexOpening *opening, uint64_t begin, uint64_t end, bool to_end);

#endif
