#include "texture/image_convert.h"

#include "base/error.h"
#include "base/mapped_file.h"
#include "base/memory.h"
#include "texture/image_file.h"

#include <math.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

// True when a PNG says itself that it is sRGB, by a chunk of that name or an ICC profile with a
// name that begins so. OpenImageIO calls every PNG so.
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

typedef enum FileSays {
    SAYS_NOTHING = 0,
    SAYS_SRGB,
    SAYS_LINEAR
} FileSays;

// What a file says of itself, not what its format makes OpenImageIO think.
static FileSays file_says(const char *path, const CoOiioInfo *info)
{
    if (strcmp(info->format, "png") == 0)
        return png_is_srgb(path) ? SAYS_SRGB : SAYS_NOTHING;
    if (strcmp(info->format, "jpeg") == 0)
        return SAYS_NOTHING;
    if (strcmp(info->color_space, "sRGB") == 0)
        return SAYS_SRGB;
    bool is_linear = strncasecmp(info->color_space, "lin", 3) == 0 ||
                     strncasecmp(info->color_space, "scene_lin", 9) == 0;
    // Float files without a word are called linear too.
    return is_linear && info->is_8bit ? SAYS_LINEAR : SAYS_NOTHING;
}

// Linear spaces by the primaries and white that files give (SMPTE, ITU-R and ACES documents).
static const struct {
    const char *space;
    float xy[8];
} linear_spaces[] = {
    {"lin_rec709_scene", {0.640f, 0.330f, 0.300f, 0.600f, 0.150f, 0.060f, 0.3127f, 0.3290f}},
    {"lin_p3d65_scene", {0.680f, 0.320f, 0.265f, 0.690f, 0.150f, 0.060f, 0.3127f, 0.3290f}},
    {"lin_rec2020_scene", {0.708f, 0.292f, 0.170f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.3290f}},
    {"lin_adobergb_scene", {0.640f, 0.330f, 0.210f, 0.710f, 0.150f, 0.060f, 0.3127f, 0.3290f}},
    {"lin_ap0_scene", {0.7347f, 0.2653f, 0.0f, 1.0f, 0.0001f, -0.0770f, 0.32168f, 0.33767f}},
    {"lin_ap1_scene", {0.713f, 0.293f, 0.165f, 0.830f, 0.128f, 0.044f, 0.32168f, 0.33767f}}};

// Writers round to three digits, or find them by way of a matrix.
#define SAME_XY 2e-3f

// NULL when they are those of none.
static const char *space_of_primaries(const float xy[8])
{
    for (size_t i = 0; i < sizeof linear_spaces / sizeof *linear_spaces; i++) {
        bool is_same = true;
        for (int k = 0; k < 8; k++)
            is_same = is_same && fabsf(xy[k] - linear_spaces[i].xy[k]) <= SAME_XY;
        if (is_same)
            return linear_spaces[i].space;
    }
    return NULL;
}

// Where the desc leaves it to others: false when none has a word for it, and it is raw.
static bool find_auto(const CoTexturesOptions *options, const CohortTextureDesc *desc,
                      const char *path, const CoOiioInfo *info, CoTextureColor *out)
{
    FileSays says = file_says(path, info);
    if (says == SAYS_NOTHING && co_texture_ruled(options, path, out))
        return true;
    bool is_encoded = says == SAYS_SRGB || (info->is_8bit && info->channels >= 3);
    *out = co_texture_color(options, desc, says == SAYS_LINEAR || !is_encoded);
    return !out->is_raw;
}

CoTextureColor co_image_color(const CoTexturesOptions *options, const CohortTextureDesc *desc,
                              const char *path, const CoOiioInfo *info)
{
    CoTextureColor color;
    if (desc->color_space != COHORT_COLOR_AUTO)
        return co_texture_color(options, desc, false);
    find_auto(options, desc, path, info, &color);
    return color;
}

CoTextureColor co_light_image_color(const CoTexturesOptions *options, const CohortTextureDesc *desc,
                                    const char *path, const CoOiioInfo *info, bool *unknown)
{
    CoTextureColor color;
    *unknown = false;
    // Without a way into the rendering space that is linear Rec.709, and the image with it.
    if (desc->color_space != COHORT_COLOR_AUTO || !options->to_rendering)
        return co_image_color(options, desc, path, info);
    const char *own = info->has_chromaticities ? space_of_primaries(info->chromaticities) : NULL;
    if (own)
        return co_texture_named(options, own);
    if (find_auto(options, desc, path, info, &color))
        return color;
    *unknown = info->has_chromaticities;
    return co_texture_named(options, linear_spaces[0].space);
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
