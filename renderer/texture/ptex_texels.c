// All texels of a face at one resolution, whichever the file stores.

#include "texture/half.h"
#include "texture/ptex_block.h"

#include "base/error.h"
#include "base/memory.h"

#include <string.h>

// Two triangles share a square of texels: the odd one is stored rotated by half a turn. One coarser
// texel is the mean of its three corner cells and of the cell in its middle, which is an odd one.
static void halve_triangle(const CoPtexFile *file, int log2, const unsigned char *in,
                           unsigned char *out)
{
    size_t side = (size_t)1 << log2, half = side / 2, size = co_ptex_type_size(file->type);
    for (uint32_t channel = 0; channel < file->channels; channel++) {
        const unsigned char *plane = in + channel * side * side * size;
        for (size_t i = 0; i < half * half; i++) {
            size_t x = 2 * (i % half), y = 2 * (i / half);
            const unsigned char *cells[4] = {plane + (y * side + x) * size,
                                             plane + (y * side + x + 1) * size,
                                             plane + ((y + 1) * side + x) * size,
                                             plane + ((side - 1 - x) * side + side - 1 - y) * size};
            float value[4];
            for (int cell = 0; cell < 4; cell++)
                value[cell] = co_ptex_pixel_value(file->type, cells[cell], 0);
            unsigned char *at = out + (channel * half * half + i) * size;
            float mean = 0.25f * (value[0] + value[1] + value[2] + value[3]);
            uint32_t whole = (uint32_t)(value[0] + value[1] + value[2] + value[3]) >> 2;
            uint16_t word = file->type == CO_PTEX_F16 ? co_half_from_float(mean) : (uint16_t)whole;
            if (file->type == CO_PTEX_U8)
                *at = (uint8_t)whole;
            else if (file->type == CO_PTEX_F32)
                memcpy(at, &mean, 4);
            else
                memcpy(at, &word, 2);
        }
    }
}

static void interleave(const CoPtexFile *file, const unsigned char *planes, size_t count,
                       unsigned char *out)
{
    size_t size = co_ptex_type_size(file->type);
    for (size_t i = 0; i < count; i++)
        for (uint32_t channel = 0; channel < file->channels; channel++, out += size)
            memcpy(out, planes + (channel * count + i) * size, size);
}

static bool read_planes(const CoPtexFile *file, const CoPtexSource *source, CoPtexDecoder *decoder,
                        unsigned char *planes, unsigned char *spare)
{
    if (!co_ptex_block_decode(file, source->block, source->ulog2, source->vlog2, decoder, planes))
        return false;
    if (!file->is_triangle) {
        co_ptex_halve_all(file, source, planes);
        return true;
    }
    for (int step = 0; step < source->steps; step++) {
        int log2 = source->ulog2 - step;
        halve_triangle(file, log2, planes, spare);
        memcpy(planes, spare, co_ptex_block_size(file, log2 - 1, log2 - 1));
    }
    return true;
}

bool co_ptex_face_texels(const CoPtexFile *file, uint32_t face, int ulog2, int vlog2,
                         CoPtexDecoder *decoder, void *out, CohortError *err)
{
    CoPtexSource source;
    CO_CHECK(face < file->faces_count, err, COHORT_ERROR_ARGUMENT, "no face %u of %u", face,
             file->faces_count);
    CO_CHECK(co_ptex_locate(file, face, ulog2, vlog2, &source), err, COHORT_ERROR_ARGUMENT,
             "face %u has 2^%d x 2^%d texels, not 2^%d x 2^%d", face, file->faces[face].ulog2,
             file->faces[face].vlog2, ulog2, vlog2);
    size_t count = (size_t)1 << (ulog2 + vlog2), pixel = co_ptex_pixel_size(file);
    if (source.block == CO_PTEX_NO_BLOCK) {
        for (size_t i = 0; i < count; i++)
            memcpy((unsigned char *)out + i * pixel, source.pixel, pixel);
        return true;
    }
    size_t size = co_ptex_block_size(file, source.ulog2, source.vlog2);
    unsigned char *planes = co_alloc(CO_MEMORY_TEXTURE, 2 * size);
    CO_CHECK_MEMORY(planes, err);
    bool ok = read_planes(file, &source, decoder, planes, planes + size);
    if (ok)
        interleave(file, planes, count, out);
    else if (co_ptex_decoder_is_short(decoder))
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    else
        CO_FAIL(err, COHORT_ERROR_TEXTURE, "broken Ptex file: face %u does not decompress", face);
    co_free(CO_MEMORY_TEXTURE, planes, 2 * size);
    return ok;
}
