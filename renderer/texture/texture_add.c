// From descriptions to what lookups find: files, channels, sets of tiles; whole images of lights.

#include "texture/textures.h"

#include "base/error.h"
#include "base/memory.h"
#include "texture/image_convert.h"
#include "texture/ptex_convert.h"

#include <string.h>
#include <unistd.h>

bool co_texture_may_lack(const CohortError *why)
{
    return why->code != COHORT_ERROR_OUT_OF_MEMORY && why->code != COHORT_ERROR_INSTALLATION;
}

// Which channels are looked up: up to three colors, then alpha where there is one.
static void choose_channels(CoTexture *texture, uint32_t channels, int32_t alpha)
{
    if (alpha < 0)
        alpha = channels == 2 ? 1 : channels == 4 ? 3 : -1;
    if (channels == 1)
        alpha = -1;
    texture->channel_count = 0;
    for (uint32_t c = 0; c < channels && texture->channel_count < 3; c++)
        if ((int32_t)c != alpha)
            texture->channels[texture->channel_count++] = (uint16_t)c;
    texture->has_alpha = alpha >= 0;
    if (texture->has_alpha)
        texture->channels[texture->channel_count++] = (uint16_t)alpha;
}

static bool add_ptex(CoTextures *textures, const CohortTextureDesc *desc, CoTexture *texture,
                     CohortError *err)
{
    CoPtexFile *file = co_ptex_open(desc->path, err);
    if (!file)
        return false;
    choose_channels(texture, file->channels, file->alpha);
    texture->filter.kind =
        desc->ptex_filter == COHORT_PTEX_BOX ? CO_PTEX_FILTER_BOX : CO_PTEX_FILTER_BILINEAR;
    CoTextureColor color = co_ptex_color(&textures->options, desc, file);
    char *converted = NULL;
    bool ok = !file->is_triangle;
    if (!ok)
        CO_FAIL(err, COHORT_ERROR_TEXTURE,
                "triangle Ptex files are not supported; only those of quads are");
    ok = ok && (color.is_raw || co_ptex_convert(&color, desc->path, file, &converted, err));
    co_ptex_close(file);
    if (ok)
        texture->file = co_textures_open_ptex(textures, converted ? converted : desc->path, err);
    ok = ok && texture->file != COHORT_INVALID_ID;
    if (ok && converted) // has what is looked up, in that order
        choose_channels(texture, textures->files[texture->file]->ptex->channels, -1);
    co_path_free(converted);
    texture->kind = CO_TEXTURE_PTEX;
    return ok;
}

// One image file; `texture` receives what all tiles of a set share.
static uint32_t add_image_file(CoTextures *textures, const CohortTextureDesc *desc,
                               const char *path, CoTexture *texture, CohortError *err)
{
    CoOiioInfo info;
    char *converted;
    if (!co_oiio_info(path, &info, err))
        return COHORT_INVALID_ID;
    CoTextureColor color = co_image_color(&textures->options, desc, path, &info);
    if (!co_image_convert(&color, path, &info, &converted, err))
        return COHORT_INVALID_ID;
    uint32_t file = co_textures_open_image(textures, converted, err);
    co_path_free(converted);
    choose_channels(texture, info.channels, -1);
    texture->wrap_s = co_image_wrap(desc->wrap_s, info.wrap_s);
    texture->wrap_t = co_image_wrap(desc->wrap_t, info.wrap_t);
    return file;
}

static const char udim_token[] = "<UDIM>";

// Every tile of a set that is there. A set without any is an error; tiles that cannot be used are
// warnings and show the fallback.
static bool add_udim(CoTextures *textures, const CohortTextureDesc *desc, CoTexture *texture,
                     CohortError *err)
{
    const char *token = strstr(desc->path, udim_token);
    uint32_t channels = 0, found = 0;
    texture->udim = co_alloc(CO_MEMORY_TEXTURE, CO_UDIM_TILES * sizeof(uint32_t));
    CO_CHECK_MEMORY(texture->udim, err);
    for (uint32_t i = 0; i < CO_UDIM_TILES; i++) {
        char path[4096];
        int length = snprintf(path, sizeof path, "%.*s%u%s", (int)(token - desc->path), desc->path,
                              1001 + i, token + sizeof udim_token - 1);
        texture->udim[i] = COHORT_INVALID_ID;
        if (length < 0 || (size_t)length >= sizeof path || access(path, F_OK) != 0)
            continue;
        CohortError tile_err = {0};
        CoTexture tile = *texture;
        texture->udim[i] = add_image_file(textures, desc, path, &tile, &tile_err);
        if (texture->udim[i] != COHORT_INVALID_ID && found && tile.channel_count != channels) {
            texture->udim[i] = COHORT_INVALID_ID;
            CO_FAIL(&tile_err, COHORT_ERROR_TEXTURE, "%s has other channels than the first tile",
                    path);
        }
        if (!co_texture_may_lack(&tile_err)) {
            if (err)
                *err = tile_err;
            return false;
        }
        if (texture->udim[i] == COHORT_INVALID_ID) {
            co_textures_warn(textures, path, tile_err.message);
            continue;
        }
        *texture = tile;
        channels = tile.channel_count;
        found++;
    }
    CO_CHECK(found, err, COHORT_ERROR_FILE_NOT_FOUND, "no tile of %s can be used", desc->path);
    // A tile is looked up inside itself only.
    texture->wrap_s = texture->wrap_t = COHORT_WRAP_CLAMP;
    return true;
}

static bool add_image(CoTextures *textures, const CohortTextureDesc *desc, CoTexture *texture,
                      CohortError *err)
{
    texture->kind = CO_TEXTURE_IMAGE;
    if (strstr(desc->path, udim_token))
        return add_udim(textures, desc, texture, err);
    texture->file = add_image_file(textures, desc, desc->path, texture, err);
    return texture->file != COHORT_INVALID_ID;
}

static bool is_ptex(const CohortTextureDesc *desc)
{
    size_t length = desc->path ? strlen(desc->path) : 0;
    return desc->is_ptex || (length > 4 && strcmp(desc->path + length - 4, ".ptx") == 0);
}

uint32_t co_textures_add(CoTextures *textures, const CohortTextureDesc *desc, CohortError *err)
{
    static const float magenta[4] = {1, 0, 1, 1};
    void *grown = textures->textures;
    if (!co_grow(CO_MEMORY_TEXTURE, &grown, textures->count, &textures->capacity,
                 sizeof(CoTexture))) {
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
        return COHORT_INVALID_ID;
    }
    textures->textures = grown;
    CoTexture texture = {.file = COHORT_INVALID_ID};
    memcpy(texture.fallback, is_ptex(desc) ? magenta : desc->fallback, sizeof magenta);
    CohortError why = {0};
    bool ok = desc->path && desc->path[0];
    if (!ok)
        CO_FAIL(&why, COHORT_ERROR_FILE_NOT_FOUND, "no file is named");
    ok = ok && (is_ptex(desc) ? add_ptex(textures, desc, &texture, &why)
                              : add_image(textures, desc, &texture, &why));
    if (!ok && !co_texture_may_lack(&why)) {
        co_free(CO_MEMORY_TEXTURE, texture.udim, CO_UDIM_TILES * sizeof(uint32_t));
        if (err && err->code == COHORT_OK)
            *err = why;
        return COHORT_INVALID_ID;
    }
    if (!ok) {
        co_textures_warn(textures,
                         desc->asset  ? desc->asset
                         : desc->path ? desc->path
                                      : "",
                         why.message);
        texture.kind = CO_TEXTURE_FALLBACK;
    }
    textures->textures[textures->count] = texture;
    return textures->count++;
}

uint32_t co_texture_ptex_faces(const CoTextures *textures, uint32_t texture, bool *is_triangle)
{
    *is_triangle = false;
    if (texture >= textures->count || textures->textures[texture].kind != CO_TEXTURE_PTEX)
        return 0;
    const CoPtexFile *file = textures->files[textures->textures[texture].file]->ptex;
    *is_triangle = file->is_triangle;
    return file->faces_count;
}

bool co_image_read(CoTextures *textures, const CohortTextureDesc *desc, float **pixels,
                   uint32_t *width, uint32_t *height, CohortError *err)
{
    CoOiioInfo info;
    size_t size;
    if (!co_oiio_info(desc->path, &info, err))
        return false;
    bool unknown;
    CoTextureColor color =
        co_light_image_color(&textures->options, desc, desc->path, &info, &unknown);
    if (unknown)
        co_textures_warn(textures, desc->asset ? desc->asset : desc->path,
                         "its chromaticities are those of no color space known: taken as linear "
                         "Rec.709; colorSpace metadata of the file's attribute names another");
    float *texels = co_image_decode(&color, desc->path, &info, &size, err);
    if (!texels)
        return false;
    size_t count = (size_t)info.width * info.height;
    float *rgba = co_alloc(CO_MEMORY_TEXTURE, count * 4 * sizeof(float));
    uint32_t colors = info.channels < 3 ? 1 : 3;
    for (size_t i = 0; rgba && i < count; i++) {
        const float *texel = texels + i * info.channels;
        for (uint32_t c = 0; c < 3; c++)
            rgba[4 * i + c] = texel[c < colors ? c : 0];
        rgba[4 * i + 3] = info.channels > colors ? texel[colors] : 1;
    }
    co_free(CO_MEMORY_TEXTURE, texels, size);
    CO_CHECK_MEMORY(rgba, err);
    *pixels = rgba;
    *width = info.width;
    *height = info.height;
    return true;
}

void co_image_free(float *pixels, uint32_t width, uint32_t height)
{
    co_free(CO_MEMORY_TEXTURE, pixels, (size_t)width * height * 4 * sizeof(float));
}
