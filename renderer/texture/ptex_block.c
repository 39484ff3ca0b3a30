#include "texture/ptex_block.h"

#include "base/error.h"
#include "base/memory.h"

#include "texture/half.h"

#include <string.h>

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "texels are used as they are stored: little-endian"
#endif

void co_ptex_decoder_clear(CoPtexDecoder *decoder)
{
    co_inflate_clear(&decoder->inflate);
    co_free(CO_MEMORY_TEXTURE, decoder->tile, decoder->tile_size);
    decoder->tile = NULL;
    decoder->tile_size = 0;
}

bool co_ptex_decoder_is_short(const CoPtexDecoder *decoder)
{
    return decoder->is_short || !decoder->inflate.state;
}

static void undo_differences(CoPtexType type, void *texels, size_t count)
{
    if (type == CO_PTEX_U8) {
        uint8_t *p = texels, value = 0;
        for (size_t i = 0; i < count; i++)
            p[i] = value = (uint8_t)(value + p[i]);
    } else if (type == CO_PTEX_U16) {
        uint16_t *p = texels, value = 0;
        for (size_t i = 0; i < count; i++)
            p[i] = value = (uint16_t)(value + p[i]);
    }
}

static void fill_constant(const CoPtexFile *file, const void *pixel, size_t count, void *out)
{
    size_t size = co_ptex_type_size(file->type);
    for (uint32_t channel = 0; channel < file->channels; channel++) {
        unsigned char *plane = (unsigned char *)out + channel * count * size;
        for (size_t i = 0; i < count; i++)
            memcpy(plane + i * size, (const unsigned char *)pixel + channel * size, size);
    }
}

static bool decode_simple(const CoPtexFile *file, uint32_t index, int ulog2, int vlog2,
                          CoPtexDecoder *decoder, void *out)
{
    const CoPtexBlock *block = &file->blocks[index];
    const unsigned char *data = (const unsigned char *)file->map.data + block->offset;
    size_t count = (size_t)1 << (ulog2 + vlog2);
    if (co_ptex_encoding(block) == CO_PTEX_PLAIN) {
        fill_constant(file, data, count, out);
        return true;
    }
    if (!co_inflate(&decoder->inflate, data, co_ptex_stored_size(block), out,
                    co_ptex_block_size(file, ulog2, vlog2), decoder->count, &file->stamps[index]))
        return false;
    if (co_ptex_encoding(block) == CO_PTEX_DIFFZIPPED)
        undo_differences(file->type, out, count * file->channels);
    return true;
}

static bool reserve_tile(CoPtexDecoder *decoder, size_t size)
{
    if (size <= decoder->tile_size)
        return true;
    co_free(CO_MEMORY_TEXTURE, decoder->tile, decoder->tile_size);
    decoder->tile = co_alloc(CO_MEMORY_TEXTURE, size);
    decoder->tile_size = decoder->tile ? size : 0;
    decoder->is_short = !decoder->tile;
    return !decoder->is_short;
}

static bool decode_tiled(const CoPtexFile *file, uint32_t index, int ulog2, int vlog2,
                         CoPtexDecoder *decoder, unsigned char *out)
{
    const CoPtexTiling *tiling = &file->tilings[file->blocks[index].tiling];
    if (!reserve_tile(decoder, co_ptex_block_size(file, tiling->ulog2, tiling->vlog2)))
        return false;
    size_t texel = co_ptex_type_size(file->type);
    size_t row = texel << tiling->ulog2, rows = (size_t)1 << tiling->vlog2;
    size_t stride = texel << ulog2, plane = stride << vlog2;
    uint32_t across = 1u << (ulog2 - tiling->ulog2), down = 1u << (vlog2 - tiling->vlog2);
    for (uint32_t i = 0; i < across * down; i++) {
        if (!decode_simple(file, tiling->first + i, tiling->ulog2, tiling->vlog2, decoder,
                           decoder->tile))
            return false;
        unsigned char *corner = out + (i / across) * rows * stride + (i % across) * row;
        for (uint32_t channel = 0; channel < file->channels; channel++)
            for (size_t v = 0; v < rows; v++)
                memcpy(corner + channel * plane + v * stride,
                       decoder->tile + (channel * rows + v) * row, row);
    }
    return true;
}

bool co_ptex_block_decode(const CoPtexFile *file, uint32_t block, int ulog2, int vlog2,
                          CoPtexDecoder *decoder, void *out)
{
    decoder->is_short = false;
    if (co_ptex_encoding(&file->blocks[block]) == CO_PTEX_TILED)
        return decode_tiled(file, block, ulog2, vlog2, decoder, out);
    return decode_simple(file, block, ulog2, vlog2, decoder, out);
}

static uint8_t mean_u8(uint8_t a, uint8_t b)
{
    return (uint8_t)((a + b) >> 1);
}

static uint16_t mean_u16(uint16_t a, uint16_t b)
{
    return (uint16_t)(((uint32_t)a + b) >> 1);
}

static uint16_t mean_f16(uint16_t a, uint16_t b)
{
    return co_half_from_float(0.5f * (co_half_to_float(a) + co_half_to_float(b)));
}

static float mean_f32(float a, float b)
{
    return 0.5f * (a + b);
}

// Writing trails reading, so the result may take the place of the texels.
#define DEFINE_HALVE(name, type, mean) \
    static void name(type *p, size_t rows, size_t width, bool in_v) \
    { \
        if (in_v) { \
            for (size_t row = 0; row < rows / 2; row++) \
                for (size_t x = 0; x < width; x++) \
                    p[row * width + x] = \
                        mean(p[2 * row * width + x], p[(2 * row + 1) * width + x]); \
        } else { \
            for (size_t i = 0; i < rows * width / 2; i++) \
                p[i] = mean(p[2 * i], p[2 * i + 1]); \
        } \
    }

DEFINE_HALVE(halve_u8, uint8_t, mean_u8)
DEFINE_HALVE(halve_u16, uint16_t, mean_u16)
DEFINE_HALVE(halve_f16, uint16_t, mean_f16)
DEFINE_HALVE(halve_f32, float, mean_f32)

void co_ptex_halve(CoPtexType type, uint32_t channels, int ulog2, int vlog2, bool in_v,
                   void *texels)
{
    // Sides are powers of two, so rows pair up within their channel.
    size_t rows = (size_t)channels << vlog2, width = (size_t)1 << ulog2;
    switch (type) {
    case CO_PTEX_U8:
        halve_u8(texels, rows, width, in_v);
        break;
    case CO_PTEX_U16:
        halve_u16(texels, rows, width, in_v);
        break;
    case CO_PTEX_F16:
        halve_f16(texels, rows, width, in_v);
        break;
    case CO_PTEX_F32:
        halve_f32(texels, rows, width, in_v);
        break;
    }
}

void co_ptex_halve_all(const CoPtexFile *file, const CoPtexSource *source, void *texels)
{
    int ulog2 = source->ulog2, vlog2 = source->vlog2;
    for (int step = 0; step < source->steps; step++) {
        bool in_v = source->axes >> step & 1;
        co_ptex_halve(file->type, file->channels, ulog2, vlog2, in_v, texels);
        in_v ? vlog2-- : ulog2--;
    }
}

#define DEFINE_SUM(name, type, to_float) \
    static float name(const type *plane, size_t width, const CoPtexPart *part) \
    { \
        float sum = 0; \
        for (uint32_t y = 0; y < part->vw; y++) { \
            const type *row = plane + ((size_t)part->v + y) * width + (size_t)part->u; \
            float row_sum = 0; \
            for (uint32_t x = 0; x < part->uw; x++) \
                row_sum += part->ku[x] * to_float(row[x]); \
            sum += part->kv[y] * row_sum; \
        } \
        return sum; \
    }

DEFINE_SUM(sum_u8, uint8_t, (float))
DEFINE_SUM(sum_u16, uint16_t, (float))
DEFINE_SUM(sum_f16, uint16_t, co_half_to_float)
DEFINE_SUM(sum_f32, float, (float))

void co_ptex_sum(CoPtexType type, const void *texels, int ulog2, int vlog2, const CoPtexPart *part,
                 const uint16_t *channels, uint32_t count, float *sum)
{
    size_t width = (size_t)1 << ulog2, plane = width << vlog2;
    for (uint32_t i = 0; i < count; i++) {
        size_t offset = plane * channels[i];
        switch (type) {
        case CO_PTEX_U8:
            sum[i] = sum_u8((const uint8_t *)texels + offset, width, part);
            break;
        case CO_PTEX_U16:
            sum[i] = sum_u16((const uint16_t *)texels + offset, width, part);
            break;
        case CO_PTEX_F16:
            sum[i] = sum_f16((const uint16_t *)texels + offset, width, part);
            break;
        case CO_PTEX_F32:
            sum[i] = sum_f32((const float *)texels + offset, width, part);
            break;
        }
    }
}

float co_ptex_pixel_value(CoPtexType type, const void *pixel, uint32_t channel)
{
    const unsigned char *p = (const unsigned char *)pixel + channel * co_ptex_type_size(type);
    uint16_t word;
    float value = 0;
    switch (type) {
    case CO_PTEX_U8:
        return (float)p[0];
    case CO_PTEX_U16:
        memcpy(&word, p, 2);
        return (float)word;
    case CO_PTEX_F16:
        memcpy(&word, p, 2);
        return co_half_to_float(word);
    case CO_PTEX_F32:
        memcpy(&value, p, 4);
        break;
    }
    return value;
}
