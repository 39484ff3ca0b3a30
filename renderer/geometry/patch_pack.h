// Words of patches of level 0, which no kernel reads, in few bits: of 64 patches at a time, the
// first word less the least of them, the others less the first and less the least of that.
// Neighbors in the order of faces mostly have points near each other, so that a quad takes 2 to 6
// bytes in place of 16.
//
// Source: frame of reference (Goldstein, Ramakrishnan, Shaft 1998), by column.

#ifndef CO_GEOMETRY_PATCH_PACK_H
#define CO_GEOMETRY_PATCH_PACK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum {
    CO_PATCH_PACKED = 64, // patches that are packed together
    CO_PATCH_PACK_WORDS = 4,
    CO_PATCH_PACK_TAIL = 8 // bytes behind the last: words are read 8 bytes at a time
};

typedef struct CoPatchPack {
    uint32_t first;                      // where their bits begin, in units of 4 bytes
    uint32_t least[CO_PATCH_PACK_WORDS]; // modulo 2^32
    uint8_t width[CO_PATCH_PACK_WORDS];  // bits
} CoPatchPack;
_Static_assert(sizeof(CoPatchPack) == 24, "24 bytes for 64 patches");

// Bits of one patch, at most 128.
static inline uint32_t co_patch_pack_width(const CoPatchPack *pack)
{
    uint32_t widths;
    memcpy(&widths, pack->width, sizeof widths);
    return widths * 0x01010101u >> 24; // the sum of its bytes
}

// Where a patch's bits begin.
static inline uint64_t co_patch_pack_place(const CoPatchPack *packs, uint32_t patch)
{
    const CoPatchPack *pack = &packs[patch / CO_PATCH_PACKED];
    return 32ull * pack->first + (uint64_t)(patch % CO_PATCH_PACKED) * co_patch_pack_width(pack);
}

// At least 57 bits from that place on.
static inline uint64_t co_patch_pack_bits(const unsigned char *bits, uint64_t at)
{
    uint64_t found;
    memcpy(&found, bits + at / 8, sizeof found);
    return found >> at % 8;
}

// The words of a patch; what it has not are something.
static inline void co_patch_unpack(const CoPatchPack *packs, const unsigned char *bits,
                                   uint32_t patch, uint32_t words[CO_PATCH_PACK_WORDS])
{
    const CoPatchPack *pack = &packs[patch / CO_PATCH_PACKED];
    uint64_t at = co_patch_pack_place(packs, patch), found = co_patch_pack_bits(bits, at);
    const bool is_all = co_patch_pack_width(pack) <= 57; // that there is to be read
    uint32_t before = 0;
    for (uint32_t k = 0; k < CO_PATCH_PACK_WORDS; k++) {
        const uint32_t width = pack->width[k], value = (uint32_t)(found & ((1ull << width) - 1));
        words[k] = pack->least[k] + value + before;
        before = words[0];
        at += width;
        found = is_all ? found >> width : co_patch_pack_bits(bits, at);
    }
}

// patch_pack.c: widths and places for words [count * stride], in parallel.
//   stride  at most CO_PATCH_PACK_WORDS
//   packs   [ceil(count / CO_PATCH_PACKED)] out
// Returns the bytes that the bits take, CO_PATCH_PACK_TAIL included; SIZE_MAX: too many for places.
size_t co_patch_pack_measure(const uint32_t *words, size_t count, uint32_t stride,
                             CoPatchPack *packs);

// Writes the bits, which are all zero yet, of words that have been measured.
void co_patch_pack_write(const uint32_t *words, size_t count, uint32_t stride,
                         const CoPatchPack *packs, unsigned char *bits);

#endif
