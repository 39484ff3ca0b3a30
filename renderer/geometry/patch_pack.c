#include "geometry/patch_pack.h"

#include "base/parallel.h"

#define GRAIN 64u

typedef struct Packing {
    const uint32_t *words;
    size_t count;
    uint32_t stride;
    CoPatchPack *packs; // changed by measure alone
    unsigned char *bits;
} Packing;

// The patches of a pack.
static uint32_t patches_of(const Packing *p, size_t pack)
{
    size_t left = p->count - pack * CO_PATCH_PACKED;
    return left < CO_PATCH_PACKED ? (uint32_t)left : CO_PATCH_PACKED;
}

// What is packed of word k of a patch. Of words below 2^31 differences do not wrap as signed
// numbers, nor do they of CO_PATCH_NONE, which is -1 then.
static int32_t value_of(const Packing *p, size_t patch, uint32_t k)
{
    const uint32_t *words = p->words + patch * p->stride;
    return (int32_t)(words[k] - (k ? words[0] : 0));
}

static uint8_t width_of(uint32_t range)
{
    return range ? (uint8_t)(32 - __builtin_clz(range)) : 0;
}

static void measure(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const Packing *p = context;
    for (size_t i = begin; i < end; i++) {
        CoPatchPack *pack = &p->packs[i];
        const uint32_t count = patches_of(p, i);
        *pack = (CoPatchPack){0};
        for (uint32_t k = 0; k < p->stride; k++) {
            int32_t low = INT32_MAX, high = INT32_MIN;
            for (uint32_t j = 0; j < count; j++) {
                const int32_t value = value_of(p, i * CO_PATCH_PACKED + j, k);
                low = value < low ? value : low;
                high = value > high ? value : high;
            }
            pack->least[k] = (uint32_t)low;
            pack->width[k] = width_of((uint32_t)high - (uint32_t)low);
        }
    }
}

size_t co_patch_pack_measure(const uint32_t *words, size_t count, uint32_t stride,
                             CoPatchPack *packs)
{
    Packing p = {words, count, stride, packs, NULL};
    const size_t pack_count = (count + CO_PATCH_PACKED - 1) / CO_PATCH_PACKED;
    co_parallel_for(pack_count, GRAIN, measure, &p);
    uint64_t units = 0;
    for (size_t i = 0; i < pack_count; i++) {
        packs[i].first = (uint32_t)units;
        units += (patches_of(&p, i) * co_patch_pack_width(&packs[i]) + 31u) / 32u;
    }
    return units > UINT32_MAX ? SIZE_MAX : (size_t)(4 * units) + CO_PATCH_PACK_TAIL;
}

static void write_bits(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    const Packing *p = context;
    for (size_t i = begin; i < end; i++) {
        const CoPatchPack *pack = &p->packs[i];
        unsigned char *out = p->bits + 4 * (size_t)pack->first;
        uint64_t waiting = 0; // bits that do not fill 4 bytes yet
        uint32_t width = 0;
        for (uint32_t j = 0; j < patches_of(p, i) * p->stride; j++) {
            const uint32_t k = j % p->stride;
            const int32_t value = value_of(p, i * CO_PATCH_PACKED + j / p->stride, k);
            waiting |= (uint64_t)((uint32_t)value - pack->least[k]) << width;
            width += pack->width[k];
            if (width < 32)
                continue;
            memcpy(out, &waiting, 4);
            out += 4;
            waiting >>= 32;
            width -= 32;
        }
        if (width)
            memcpy(out, &waiting, 4);
    }
}

void co_patch_pack_write(const uint32_t *words, size_t count, uint32_t stride,
                         const CoPatchPack *packs, unsigned char *bits)
{
    Packing p = {words, count, stride, (CoPatchPack *)(uintptr_t)packs, bits};
    co_parallel_for((count + CO_PATCH_PACKED - 1) / CO_PATCH_PACKED, GRAIN, write_bits, &p);
}
