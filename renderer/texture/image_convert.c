#include "texture/image_convert.h"

#include "base/error.h"
#include "base/mapped_file.h"
#include "base/memory.h"
#include "texture/image_file.h"

#include <string.h>
#include <strings.h>
#include <unistd.h>

// True when a PNG says itself that it is sRGB, by a chunk of that name or an ICC profile with a name
// that begins so. OpenImageIO calls every PNG so.
static bool png_is_srgb(const char *path)
{
    CoMappedFile file;
    if (!co_mapped_file_open(path, &file, NULL))
        return false;
    const unsigned char *data = file.data;
    bool found = false;
    for (size_t at = 8; !found && at + 12 <= file.size;) {
        uint32_t length = (uint32_t)data[at] << 24 | (uint32_t)data[at + 1] << 16 |
                          (uint32_t)data[at + 2] << 8 | data[at + 3];
        found = memcmp(data + at + 4, "sRGB", 4) == 0 || memcmp(data + at + 4, "iCCPsRGB", 8) == 0;
        if (memcmp(data + at + 4, "IDAT", 4) == 0)
            break;
        at += 12 + (size_t)length;
    }
    co_mapped_file_close(&file);
    return found;
}

// What a file says of itself when nobody else does.
static bool holds_data(const char *path, const CoOiioInfo *info)
{
    bool is_byte_color = info->is_8bit && info->channels >= 3;
    // What OpenImageIO says of these two is a guess from the format.
    if (strcmp(info->format, "png") == 0)
        return !is_byte_color && !png_is_srgb(path);
    if (strcmp(info->format, "jpeg") == 0 || info->color_space[0] == 0)
        return !is_byte_color;
    if (strcmp(info->color_space, "sRGB") == 0)
        return false;
    return !is_byte_color || strncasecmp(info->color_space, "lin", 3) == 0 ||
           strncasecmp(info->color_space, "scene_lin", 9) == 0;
}

CoTextureColor co_image_color(const CoTexturesOptions *options, const CohortTextureDesc *desc,
                              const char *path, const CoOiioInfo *info)
{
    bool is_auto = desc->color_space == COHORT_COLOR_AUTO;
    return co_texture_color(options, desc, is_auto && holds_data(path, info));
}

CohortWrap co_image_wrap(CohortWrap wanted, const char *metadata)
{
    if (wanted != COHORT_WRAP_USE_METADATA)
        return wanted;
    if (strcmp(metadata, "clamp") == 0)
        return COHORT_WRAP_CLAMP;
    if (strcmp(metadata, "periodic") == 0 || strcmp(metadata, "repeat") == 0)
        return COHORT_WRAP_REPEAT;
    if (strcmp(metadata, "mirror") == 0)
        return COHORT_WRAP_MIRROR;
    return COHORT_WRAP_BLACK;
}

float *co_image_decode(const CoTextureColor *color, const char *path, const CoOiioInfo *info,
                       size_t *size, CohortError *err)
{
    size_t count = (size_t)info->width * info->height; // at most 2^28
    *size = count * info->channels * sizeof(float);
    float *texels = co_alloc(CO_MEMORY_TEXTURE, *size);
    CO_CHECK_NULL(texels, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory for an image");
    if (co_oiio_read(path, info, texels, err) &&
        co_texture_to_linear(color, texels, count, info->channels, err))
        return texels;
    co_free(CO_MEMORY_TEXTURE, texels, *size);
    return NULL;
}

static bool make(const CoTextureColor *color, const char *path, const CoOiioInfo *info,
                 const char *converted, CohortError *err)
{
    size_t size;
    float *texels = co_image_decode(color, path, info, &size, err);
    char *temporary = NULL;
    // Levels are a third more, tables and headers little. See co_oiio_write_mips.
    bool ok = texels && co_converted_room(converted, size + size / 2 + 65536, err) &&
              co_converted_temporary(converted, &temporary, err);
    if (ok) {
        ok = co_oiio_write_mips(temporary, info, texels, CO_IMAGE_TILE, err);
        if (ok)
            ok = co_converted_publish(temporary, converted, err);
        else
            unlink(temporary);
    }
    co_path_free(temporary);
    if (texels)
        co_free(CO_MEMORY_TEXTURE, texels, size);
    return ok;
}

bool co_image_convert(const CoTextureColor *color, const char *path, const CoOiioInfo *info,
                      char **out, CohortError *err)
{
    if (!co_converted_path(color, path, info->channels, ".exr", out, err))
        return false;
    // A file there that cannot be opened is what a crash left: it is made anew.
    CoImageFile *there = access(*out, R_OK) == 0 ? co_image_open(*out, NULL) : NULL;
    bool ok = there && there->channels == info->channels && there->levels[0].width == info->width &&
              there->levels[0].height == info->height;
    co_image_close(there);
    ok = ok || make(color, path, info, *out, err);
    if (!ok) {
        co_path_free(*out);
        *out = NULL;
    }
    return ok;
}
