#include "texture/ptex_convert.h"

#include "base/error.h"
#include "base/memory.h"
#include "texture/ptex_write.h"

#include <string.h>
#include <unistd.h>

CoTextureColor co_ptex_color(const CoTexturesOptions *options, const CohortTextureDesc *desc,
                             const CoPtexFile *file)
{
    CoTextureColor ruled;
    if (desc->color_space == COHORT_COLOR_AUTO && co_texture_ruled(options, desc->path, &ruled))
        return ruled;
    bool is_color = file->type == CO_PTEX_U8 && file->channels >= 3 && file->channels <= 4;
    return co_texture_color(options, desc, !is_color);
}

#define NO_CHANNEL UINT32_MAX // is 0 everywhere

// Order of channels in the converted file: colors first, then alpha; at most the four that lookups
// use. Returns their number: 1 gray, 2 gray and alpha, 3 RGB, 4 RGB and alpha.
static uint32_t order_channels(const CoPtexFile *file, uint32_t order[4])
{
    uint32_t count = 0;
    for (uint32_t c = 0; c < file->channels && count < 3; c++)
        if ((int32_t)c != file->alpha || file->channels == 1)
            order[count++] = c;
    if (count == 2 && file->alpha >= 0)
        order[count++] = NO_CHANNEL; // two colors and alpha: no blue
    if (file->channels > 1 && file->alpha >= 0)
        order[count++] = (uint32_t)file->alpha;
    else if (file->alpha < 0 && file->channels == 4)
        order[count++] = 3;
    return count;
}

typedef struct Conversion {
    const CoTextureColor *color;
    const CoPtexFile *file;
    CoPtexWriter *writer;
    CoPtexDecoder decoder;
    uint32_t order[4], channels;
    unsigned char *texels;
    float *pixels; // levels one after the other
    size_t texels_size, pixels_size;
    CohortError *err;
} Conversion;

static bool reserve(void **bytes, size_t *have, size_t size, CohortError *err)
{
    if (size <= *have)
        return true;
    co_free(CO_MEMORY_TEXTURE, *bytes, *have);
    *bytes = co_alloc(CO_MEMORY_TEXTURE, size);
    *have = *bytes ? size : 0;
    CO_CHECK_MEMORY(*bytes, err);
    return true;
}

// One face at one resolution, linear, to `out`.
static bool read_linear(Conversion *c, uint32_t face, int ulog2, int vlog2, float *out)
{
    const CoPtexFile *file = c->file;
    if (!co_ptex_face_texels(file, face, ulog2, vlog2, &c->decoder, c->texels, c->err))
        return false;
    size_t count = (size_t)1 << (ulog2 + vlog2), pixel = co_ptex_pixel_size(file);
    float scale = 1.0f / co_ptex_one(file->type);
    bool is_integer = file->type == CO_PTEX_U8 || file->type == CO_PTEX_U16;
    for (size_t i = 0; i < count; i++)
        for (uint32_t k = 0; k < c->channels; k++) {
            float value = 0;
            if (c->order[k] != NO_CHANNEL)
                value = co_ptex_pixel_value(file->type, c->texels + i * pixel, c->order[k]);
            out[i * c->channels + k] = is_integer ? value * scale : value;
        }
    return co_texture_to_linear(c->color, out, count, c->channels, c->err);
}

static bool convert_face(Conversion *c, uint32_t face)
{
    CoPtexFace info = c->file->faces[face];
    const void *levels[CO_PTEX_LEVELS] = {0};
    // A constant face keeps its place among the resolutions, and needs one texel of it.
    bool is_constant = info.flags & CO_PTEX_CONSTANT;
    size_t count = (size_t)1 << (info.ulog2 + info.vlog2);
    bool is_authored = c->color->options->ptex_reductions_authored && !is_constant;
    if (!reserve((void **)&c->texels, &c->texels_size, count * co_ptex_pixel_size(c->file),
                 c->err) ||
        !reserve((void **)&c->pixels, &c->pixels_size, 2 * count * c->channels * sizeof(float),
                 c->err))
        return false;
    int least = info.ulog2 < info.vlog2 ? info.ulog2 : info.vlog2;
    int last = is_authored && least > 2 ? least - 2 : 0;
    if (last >= (int)c->file->levels)
        last = (int)c->file->levels - 1;
    float *out = c->pixels;
    for (int level = 0; level <= last; level++) {
        if (!read_linear(c, face, info.ulog2 - level, info.vlog2 - level, out))
            return false;
        levels[level] = out;
        out += ((size_t)1 << (info.ulog2 + info.vlog2 - 2 * level)) * c->channels;
    }
    return co_ptex_writer_face(c->writer, face, &info, levels, (uint32_t)last + 1, c->err);
}

static bool convert(const CoTextureColor *color, const CoPtexFile *file, const char *path,
                    CohortError *err)
{
    Conversion c = {.color = color, .file = file, .err = err};
    c.channels = order_channels(file, c.order);
    CoPtexWriteDesc desc = {.face_count = file->faces_count,
                            .type = CO_PTEX_F32,
                            .channels = c.channels,
                            .u_border = file->u_border,
                            .v_border = file->v_border,
                            .zlib_level = 2};
    c.writer = co_ptex_writer_create(path, &desc, err);
    bool ok = c.writer != NULL;
    for (uint32_t face = 0; ok && face < file->faces_count; face++)
        ok = convert_face(&c, face);
    if (c.writer && !co_ptex_writer_finish(c.writer, err))
        ok = false;
    co_ptex_decoder_clear(&c.decoder);
    co_free(CO_MEMORY_TEXTURE, c.texels, c.texels_size);
    co_free(CO_MEMORY_TEXTURE, c.pixels, c.pixels_size);
    return ok;
}

bool co_ptex_convert(const CoTextureColor *color, const char *path, const CoPtexFile *file,
                     char **out, CohortError *err)
{
    uint64_t settings = 1000 + (uint64_t)color->options->ptex_reductions_authored;
    if (!co_converted_path(color, path, settings, ".ptx", out, err))
        return false;
    CoPtexFile *there = access(*out, R_OK) == 0 ? co_ptex_open(*out, NULL) : NULL;
    bool ok = there && there->faces_count == file->faces_count;
    co_ptex_close(there);
    ok = ok || convert(color, file, *out, err);
    if (!ok) {
        co_path_free(*out);
        *out = NULL;
    }
    return ok;
}
