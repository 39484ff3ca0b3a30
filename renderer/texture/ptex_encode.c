#include "texture/ptex_encode.h"

#include "base/error.h"
#include "base/memory.h"
#include "texture/half.h"
#include "texture/ptex_block.h"

#include <libdeflate.h>
#include <string.h>

bool co_ptex_encoder_init(CoPtexEncoder *encoder, const CoPtexWriteDesc *desc, CohortError *err)
{
    encoder->desc = desc;
    encoder->compressor = libdeflate_alloc_compressor(desc->zlib_level > 0 ? desc->zlib_level : 6);
    CO_CHECK_MEMORY(encoder->compressor, err);
    return true;
}

static void clear_buffer(CoByteBuffer *buffer)
{
    co_free(CO_MEMORY_TEXTURE, buffer->bytes, buffer->capacity);
    *buffer = (CoByteBuffer){0};
}

void co_ptex_encoder_clear(CoPtexEncoder *encoder)
{
    libdeflate_free_compressor(encoder->compressor);
    clear_buffer(&encoder->out);
    clear_buffer(&encoder->plain);
    clear_buffer(&encoder->tiles);
}

// Room for `more` bytes behind those there are.
static bool reserve(CoByteBuffer *buffer, size_t more, CohortError *err)
{
    if (buffer->size + more <= buffer->capacity)
        return true;
    size_t capacity = (buffer->size + more) * 3 / 2;
    void *grown = co_realloc(CO_MEMORY_TEXTURE, buffer->bytes, buffer->capacity, capacity);
    CO_CHECK_MEMORY(grown, err);
    buffer->bytes = grown;
    buffer->capacity = capacity;
    return true;
}

static bool zip_to(CoPtexEncoder *encoder, CoByteBuffer *out, const void *bytes, size_t size,
                   CohortError *err)
{
    size_t bound = libdeflate_zlib_compress_bound(encoder->compressor, size);
    if (!reserve(out, bound, err))
        return false;
    size_t packed =
        libdeflate_zlib_compress(encoder->compressor, bytes, size, out->bytes + out->size, bound);
    CO_CHECK(packed > 0 && packed < 1u << 30, err, COHORT_ERROR_LIMIT,
             "a block of %zu bytes is too large for a Ptex file", size);
    out->size += packed;
    return true;
}

bool co_ptex_zip(CoPtexEncoder *encoder, const void *bytes, size_t size, CohortError *err)
{
    return zip_to(encoder, &encoder->out, bytes, size, err);
}

static void make_differences(CoPtexType type, void *texels, size_t count)
{
    if (type == CO_PTEX_U8) {
        uint8_t *p = texels;
        for (size_t i = count - 1; i > 0; i--)
            p[i] = (uint8_t)(p[i] - p[i - 1]);
    } else {
        uint16_t *p = texels;
        for (size_t i = count - 1; i > 0; i--)
            p[i] = (uint16_t)(p[i] - p[i - 1]);
    }
}

static bool is_integer(CoPtexType type)
{
    return type == CO_PTEX_U8 || type == CO_PTEX_U16;
}

static bool encode_simple(CoPtexEncoder *encoder, CoByteBuffer *out, const void *planes,
                          size_t size, uint32_t *header, CohortError *err)
{
    CoPtexType type = encoder->desc->type;
    size_t before = out->size;
    if (is_integer(type)) {
        encoder->plain.size = 0;
        if (!reserve(&encoder->plain, size, err))
            return false;
        memcpy(encoder->plain.bytes, planes, size);
        make_differences(type, encoder->plain.bytes, size / co_ptex_type_size(type));
        planes = encoder->plain.bytes;
    }
    if (!zip_to(encoder, out, planes, size, err))
        return false;
    CoPtexEncoding encoding = is_integer(type) ? CO_PTEX_DIFFZIPPED : CO_PTEX_ZIPPED;
    *header = (uint32_t)(out->size - before) | (uint32_t)encoding << 30;
    return true;
}

// Cuts one tile out of the planes; true when all its texels are equal.
static bool cut_tile(const CoPtexWriteDesc *desc, const unsigned char *planes, const int log2s[4],
                     uint32_t index, unsigned char *tile)
{
    size_t texel = co_ptex_type_size(desc->type);
    size_t row = texel << log2s[2], rows = (size_t)1 << log2s[3];
    size_t stride = texel << log2s[0], plane = stride << log2s[1];
    uint32_t across = 1u << (log2s[0] - log2s[2]);
    const unsigned char *corner =
        planes + (index / across) * rows * stride + (index % across) * row;
    bool is_constant = true;
    for (uint32_t c = 0; c < desc->channels; c++) {
        unsigned char *to = tile + c * rows * row;
        for (size_t v = 0; v < rows; v++)
            memcpy(to + v * row, corner + c * plane + v * stride, row);
        is_constant = is_constant && memcmp(to, to + texel, rows * row - texel) == 0;
    }
    return is_constant;
}

static bool encode_tiled(CoPtexEncoder *encoder, const void *planes, const int log2s[4],
                         uint32_t *header, CohortError *err)
{
    const CoPtexWriteDesc *desc = encoder->desc;
    size_t texel = co_ptex_type_size(desc->type);
    size_t count = (size_t)1 << (log2s[0] + log2s[1] - log2s[2] - log2s[3]);
    size_t size = texel * desc->channels << (log2s[2] + log2s[3]), words = 4 * count;
    unsigned char *scratch = co_alloc(CO_MEMORY_TEXTURE, words + size);
    CO_CHECK_MEMORY(scratch, err);
    unsigned char *tile = scratch + words;
    encoder->tiles.size = 0;
    bool ok = true;
    for (uint32_t i = 0; ok && i < count; i++) {
        uint32_t word = (uint32_t)(texel * desc->channels); // a constant: one pixel, as it is
        if (!cut_tile(desc, planes, log2s, i, tile)) {
            ok = encode_simple(encoder, &encoder->tiles, tile, size, &word, err);
        } else if ((ok = reserve(&encoder->tiles, word, err))) {
            for (uint32_t c = 0; c < desc->channels; c++, encoder->tiles.size += texel)
                memcpy(encoder->tiles.bytes + encoder->tiles.size,
                       tile + c * (size / desc->channels), texel);
        }
        for (int byte = 0; byte < 4; byte++)
            scratch[4 * (size_t)i + (size_t)byte] = (unsigned char)(word >> 8 * byte);
    }
    ok = ok && reserve(&encoder->out, 6, err);
    if (ok) {
        encoder->out.size = 6;
        ok = zip_to(encoder, &encoder->out, scratch, words, err) &&
             reserve(&encoder->out, encoder->tiles.size, err);
    }
    co_free(CO_MEMORY_TEXTURE, scratch, words + size);
    if (!ok)
        return false;
    CoByteBuffer *out = &encoder->out;
    uint32_t packed = (uint32_t)out->size - 6;
    out->bytes[0] = (unsigned char)log2s[2];
    out->bytes[1] = (unsigned char)log2s[3];
    for (int byte = 0; byte < 4; byte++)
        out->bytes[2 + byte] = (unsigned char)(packed >> 8 * byte);
    memcpy(out->bytes + out->size, encoder->tiles.bytes, encoder->tiles.size);
    out->size += encoder->tiles.size;
    CO_CHECK(out->size < 1u << 30, err, COHORT_ERROR_LIMIT, "a face of %zu bytes", out->size);
    *header = (uint32_t)out->size | (uint32_t)CO_PTEX_TILED << 30;
    return true;
}

bool co_ptex_encode(CoPtexEncoder *encoder, const void *planes, int ulog2, int vlog2,
                    uint32_t *header, CohortError *err)
{
    const CoPtexWriteDesc *desc = encoder->desc;
    size_t size = (size_t)co_ptex_type_size(desc->type) * desc->channels << (ulog2 + vlog2);
    encoder->out.size = 0;
    int times = 0; // tiles hold about 64 KB
    while (size / 65536 >> (times + 1))
        times++;
    if (times > 0) {
        int left = ulog2 + vlog2 - times;
        int tile_u = (left + 1) / 2 < ulog2 ? (left + 1) / 2 : ulog2;
        int tile_v = left - tile_u < vlog2 ? left - tile_u : vlog2;
        if (tile_u < ulog2 || tile_v < vlog2)
            return encode_tiled(encoder, planes, (const int[4]){ulog2, vlog2, tile_u, tile_v},
                                header, err);
    }
    return encode_simple(encoder, &encoder->out, planes, size, header, err);
}

void co_ptex_to_planes(const CoPtexWriteDesc *desc, const void *pixels, int ulog2, int vlog2,
                       void *planes)
{
    size_t texel = co_ptex_type_size(desc->type), count = (size_t)1 << (ulog2 + vlog2);
    const unsigned char *from = pixels;
    for (size_t i = 0; i < count; i++)
        for (uint32_t c = 0; c < desc->channels; c++, from += texel)
            memcpy((unsigned char *)planes + (c * count + i) * texel, from, texel);
}

static void store_value(CoPtexType type, void *at, float value)
{
    uint16_t word = type == CO_PTEX_F16 ? co_half_from_float(value) : 0;
    uint8_t byte = 0;
    if (type == CO_PTEX_U8)
        byte = (uint8_t)value;
    else if (type == CO_PTEX_U16)
        word = (uint16_t)value;
    if (type == CO_PTEX_U8)
        memcpy(at, &byte, 1);
    else if (type == CO_PTEX_F32)
        memcpy(at, &value, 4);
    else
        memcpy(at, &word, 2);
}

// Channels that alpha applies to.
static void alpha_range(const CoPtexWriteDesc *desc, uint32_t *first, uint32_t *end)
{
    *first = desc->alpha == 0 ? 1 : 0;
    *end = desc->alpha == 0 ? desc->channels : desc->alpha;
}

void co_ptex_premultiply(const CoPtexWriteDesc *desc, void *planes, int ulog2, int vlog2)
{
    size_t texel = co_ptex_type_size(desc->type), count = (size_t)1 << (ulog2 + vlog2);
    unsigned char *bytes = planes;
    float scale = 1.0f / co_ptex_one(desc->type);
    uint32_t first, end;
    alpha_range(desc, &first, &end);
    for (size_t i = 0; i < count; i++) {
        float alpha = co_ptex_pixel_value(desc->type, bytes + (desc->alpha * count + i) * texel, 0);
        for (uint32_t c = first; c < end; c++) {
            void *at = bytes + (c * count + i) * texel;
            store_value(desc->type, at, co_ptex_pixel_value(desc->type, at, 0) * (alpha * scale));
        }
    }
}

void co_ptex_quarter(const CoPtexWriteDesc *desc, void *planes, int ulog2, int vlog2)
{
    size_t texel = co_ptex_type_size(desc->type), width = (size_t)1 << ulog2;
    size_t half = width / 2, rows = (size_t)desc->channels << (vlog2 - 1);
    unsigned char *bytes = planes;
    for (size_t row = 0; row < rows; row++) {
        for (size_t x = 0; x < half; x++) {
            const unsigned char *low = bytes + (2 * row * width + 2 * x) * texel;
            const unsigned char *high = low + width * texel;
            float sum = co_ptex_pixel_value(desc->type, low, 0) +
                        co_ptex_pixel_value(desc->type, low + texel, 0) +
                        co_ptex_pixel_value(desc->type, high, 0) +
                        co_ptex_pixel_value(desc->type, high + texel, 0);
            // A quarter of a small integer is exact, so cutting it is a shift by two.
            store_value(desc->type, bytes + (row * half + x) * texel, 0.25f * sum);
        }
    }
}

void co_ptex_average(const CoPtexWriteDesc *desc, const void *planes, int ulog2, int vlog2,
                     void *pixel)
{
    size_t texel = co_ptex_type_size(desc->type), count = (size_t)1 << (ulog2 + vlog2);
    const unsigned char *bytes = planes;
    unsigned char *out = pixel;
    float scale = 1.0f / (float)count;
    for (uint32_t c = 0; c < desc->channels; c++) {
        float sum = 0;
        for (size_t i = 0; i < count; i++)
            sum += co_ptex_pixel_value(desc->type, bytes + (c * count + i) * texel, 0);
        store_value(desc->type, out + c * texel, sum * scale);
    }
    float alpha = desc->has_alpha ? co_ptex_pixel_value(desc->type, out, desc->alpha) : 0;
    if (alpha == 0)
        return;
    uint32_t first, end;
    alpha_range(desc, &first, &end);
    float most = co_ptex_one(desc->type);
    for (uint32_t c = first; c < end; c++) {
        float value = co_ptex_pixel_value(desc->type, out, c) * (most / alpha);
        if (is_integer(desc->type) && value > most)
            value = most;
        store_value(desc->type, out + c * texel, value);
    }
}
