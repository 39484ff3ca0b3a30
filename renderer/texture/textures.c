#include "texture/textures.h"

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "texture/image_convert.h"
#include "texture/ptex_convert.h"

#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define RESIDENT_DEFAULT ((uint64_t)1 << 30)
#define REQUESTS_IN_CORE ((size_t)512 << 20)

CoTextures *co_textures_create(const CoTexturesOptions *options, CohortError *err)
{
    CoTextures *textures = co_alloc_zero(CO_MEMORY_TEXTURE, sizeof *textures);
    CO_CHECK_NULL(textures, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    textures->options = *options;
    textures->options.converted_folder = NULL;
    if (textures->options.resident_bytes == 0)
        textures->options.resident_bytes = RESIDENT_DEFAULT;
    textures->resident_limit = textures->options.resident_bytes;
    atomic_init(&textures->request_budget, REQUESTS_IN_CORE);
    if (options->converted_folder) {
        textures->options.converted_folder = co_path_copy(options->converted_folder);
        if (!textures->options.converted_folder) {
            co_textures_destroy(textures);
            CO_CHECK_NULL(false, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
        }
    }
    return textures;
}

void co_textures_limit(CoTextures *textures, uint64_t resident_bytes, uint64_t request_bytes)
{
    textures->resident_limit = textures->options.resident_bytes;
    if (resident_bytes && resident_bytes < textures->resident_limit)
        textures->resident_limit = resident_bytes;
    // The pools of the last batch hold what they took: they give it back first.
    for (uint32_t i = 0; i < textures->worker_count; i++)
        co_request_pool_clear(&textures->pools[i]);
    size_t budget = REQUESTS_IN_CORE;
    if (request_bytes && request_bytes < budget)
        budget = (size_t)request_bytes;
    atomic_store(&textures->request_budget, budget);
}

uint64_t co_textures_block_bytes(const CoTextures *textures)
{
    return textures->block_bytes;
}

// Decoded bytes of a Ptex file's blocks: level 0 and its reductions, a third more at most.
static uint64_t ptex_bytes(const CoPtexFile *file)
{
    uint64_t bytes = 0;
    for (uint32_t face = 0; face < file->faces_count; face++)
        if (!(file->faces[face].flags & CO_PTEX_CONSTANT))
            bytes += co_ptex_block_size(file, file->faces[face].ulog2, file->faces[face].vlog2);
    return file->levels > 1 ? bytes + bytes / 3 : bytes;
}

static uint64_t largest_block(const CoTextureFile *file)
{
    const uint64_t tile = (uint64_t)CO_IMAGE_TILE * CO_IMAGE_TILE * sizeof(float);
    if (!file->ptex)
        return tile * file->image->channels;
    uint64_t most = 0;
    for (uint32_t f = 0; f < file->ptex->faces_count; f++) {
        const CoPtexFace *face = &file->ptex->faces[f];
        uint64_t bytes = co_ptex_block_size(file->ptex, face->ulog2, face->vlog2);
        most = bytes > most ? bytes : most;
    }
    return most;
}

static uint64_t image_bytes(const CoImageFile *image)
{
    return (uint64_t)image->tile_count * CO_IMAGE_TILE * CO_IMAGE_TILE * image->channels *
           sizeof(float);
}

static void drop_resident(CoTextureFile *file)
{
    if (!file->blocks)
        return;
    for (uint32_t i = 0; i < file->block_count; i++) {
        void *texels = atomic_load(&file->blocks[i]);
        if (texels)
            co_free(CO_MEMORY_TEXTURE, texels, file->sizes[i]);
    }
    co_free(CO_MEMORY_TEXTURE, file->blocks, file->block_count * sizeof *file->blocks);
    co_free(CO_MEMORY_TEXTURE, file->sizes, file->block_count * sizeof *file->sizes);
    file->blocks = NULL;
    file->sizes = NULL;
}

static void close_file(CoTextureFile *file)
{
    drop_resident(file);
    co_ptex_close(file->ptex);
    co_image_close(file->image);
    co_path_free(file->path);
    co_free(CO_MEMORY_TEXTURE, file, sizeof *file);
}

static void clear_workers(CoTextures *textures)
{
    for (uint32_t i = 0; i < textures->worker_count; i++) {
        co_reader_clear(&textures->readers[i]);
        co_request_pool_clear(&textures->pools[i]);
        co_block_cache_clear(&textures->caches[i]);
    }
    size_t count = textures->worker_count;
    co_free(CO_MEMORY_TEXTURE, textures->readers, count * sizeof *textures->readers);
    co_free(CO_MEMORY_TEXTURE, textures->pools, count * sizeof *textures->pools);
    co_free(CO_MEMORY_TEXTURE, textures->caches, count * sizeof *textures->caches);
    textures->worker_count = 0;
    textures->readers = NULL;
    textures->pools = NULL;
    textures->caches = NULL;
}

void co_textures_destroy(CoTextures *textures)
{
    if (!textures)
        return;
    clear_workers(textures);
    for (uint32_t i = 0; i < textures->count; i++)
        co_free(CO_MEMORY_TEXTURE, textures->textures[i].udim, CO_UDIM_TILES * sizeof(uint32_t));
    for (uint32_t i = 0; i < textures->file_count; i++)
        close_file(textures->files[i]);
    co_free(CO_MEMORY_TEXTURE, textures->textures, textures->capacity * sizeof(CoTexture));
    co_free(CO_MEMORY_TEXTURE, textures->files, textures->file_capacity * sizeof(void *));
    if (textures->options.converted_folder)
        co_path_free((char *)(uintptr_t)textures->options.converted_folder);
    co_free(CO_MEMORY_TEXTURE, textures, sizeof *textures);
}

void co_textures_warn(CoTextures *textures, const char *asset, const char *text)
{
    if (textures->options.warn)
        textures->options.warn(textures->options.warn_cookie, asset, text);
}

static bool prepare_workers(CoTextures *textures, CohortError *err)
{
    uint32_t count = co_worker_count();
    if (count > textures->worker_count) {
        clear_workers(textures);
        textures->readers = co_alloc_zero(CO_MEMORY_TEXTURE, count * sizeof *textures->readers);
        textures->pools = co_alloc_zero(CO_MEMORY_TEXTURE, count * sizeof *textures->pools);
        textures->caches = co_alloc_zero(CO_MEMORY_TEXTURE, count * sizeof *textures->caches);
        textures->worker_count = count;
        bool ok = textures->readers && textures->pools && textures->caches;
        if (!ok) { // whichever there are have nothing in them yet
            co_free(CO_MEMORY_TEXTURE, textures->readers, count * sizeof *textures->readers);
            co_free(CO_MEMORY_TEXTURE, textures->pools, count * sizeof *textures->pools);
            co_free(CO_MEMORY_TEXTURE, textures->caches, count * sizeof *textures->caches);
            textures->readers = NULL;
            textures->pools = NULL;
            textures->caches = NULL;
            textures->worker_count = 0;
        }
        CO_CHECK(ok, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    }
    for (uint32_t i = 0; i < textures->worker_count; i++)
        textures->caches[i].limit = (size_t)(textures->resident_limit / count);
    return true;
}

static bool prepare_resident(CoTextureFile *file, CohortError *err)
{
    if (file->blocks)
        return true;
    file->blocks = co_alloc_zero(CO_MEMORY_TEXTURE, file->block_count * sizeof *file->blocks);
    file->sizes = co_alloc_zero(CO_MEMORY_TEXTURE, file->block_count * sizeof *file->sizes);
    if (file->blocks && file->sizes)
        return true;
    co_free(CO_MEMORY_TEXTURE, file->blocks, file->block_count * sizeof *file->blocks);
    co_free(CO_MEMORY_TEXTURE, file->sizes, file->block_count * sizeof *file->sizes);
    file->blocks = NULL;
    file->sizes = NULL;
    CO_CHECK(false, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
}

bool co_textures_prepare(CoTextures *textures, CohortError *err)
{
    if (!prepare_workers(textures, err))
        return false;
    textures->is_resident = textures->decoded_bytes <= textures->resident_limit;
    for (uint32_t i = 0; i < textures->file_count; i++) {
        if (!textures->is_resident)
            drop_resident(textures->files[i]);
        else if (!prepare_resident(textures->files[i], err))
            return false;
    }
    return true;
}

// ---- Files -----------------------------------------------------------------------------------

static uint32_t find_file(const CoTextures *textures, const struct stat *info)
{
    for (uint32_t i = 0; i < textures->file_count; i++)
        if (textures->files[i]->device == (uint64_t)info->st_dev &&
            textures->files[i]->inode == (uint64_t)info->st_ino)
            return i;
    return COHORT_INVALID_ID;
}

// Adds an opened file, which is closed on failure.
static uint32_t add_file(CoTextures *textures, const char *path, const CoTextureFile *opened,
                         CohortError *err)
{
    CoTextureFile *file = co_alloc_zero(CO_MEMORY_TEXTURE, sizeof *file);
    if (textures->file_count == textures->file_capacity) {
        uint32_t capacity = 2 * textures->file_capacity + 16;
        void *grown =
            co_realloc(CO_MEMORY_TEXTURE, textures->files, textures->file_capacity * sizeof(void *),
                       capacity * sizeof(void *));
        if (grown) {
            textures->files = grown;
            textures->file_capacity = capacity;
        }
    }
    char *copy = co_path_copy(path);
    if (!file || !copy || textures->file_count == textures->file_capacity) {
        co_ptex_close(opened->ptex);
        co_image_close(opened->image);
        co_path_free(copy);
        co_free(CO_MEMORY_TEXTURE, file, sizeof *file);
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
        return COHORT_INVALID_ID;
    }
    file->ptex = opened->ptex;
    file->image = opened->image;
    file->device = opened->device;
    file->inode = opened->inode;
    file->path = copy;
    file->block_count = file->ptex ? file->ptex->block_count : file->image->tile_count;
    file->decoded_bytes = file->ptex ? ptex_bytes(file->ptex) : image_bytes(file->image);
    textures->decoded_bytes += file->decoded_bytes;
    uint64_t block = largest_block(file);
    textures->block_bytes = block > textures->block_bytes ? block : textures->block_bytes;
    textures->files[textures->file_count] = file;
    return textures->file_count++;
}

uint32_t co_textures_open_ptex(CoTextures *textures, const char *path, CohortError *err)
{
    struct stat info = {0};
    uint32_t found = stat(path, &info) == 0 ? find_file(textures, &info) : COHORT_INVALID_ID;
    if (found != COHORT_INVALID_ID && textures->files[found]->ptex)
        return found;
    CoTextureFile file = {.ptex = co_ptex_open(path, err),
                          .device = (uint64_t)info.st_dev,
                          .inode = (uint64_t)info.st_ino};
    return file.ptex ? add_file(textures, path, &file, err) : COHORT_INVALID_ID;
}

uint32_t co_textures_open_image(CoTextures *textures, const char *path, CohortError *err)
{
    struct stat info = {0};
    uint32_t found = stat(path, &info) == 0 ? find_file(textures, &info) : COHORT_INVALID_ID;
    if (found != COHORT_INVALID_ID && textures->files[found]->image)
        return found;
    CoTextureFile file = {.image = co_image_open(path, err),
                          .device = (uint64_t)info.st_dev,
                          .inode = (uint64_t)info.st_ino};
    return file.image ? add_file(textures, path, &file, err) : COHORT_INVALID_ID;
}

// ---- Textures --------------------------------------------------------------------------------

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
    for (uint16_t c = 0; converted && c < texture->channel_count; c++)
        texture->channels[c] = c; // a converted file has what is looked up, in that order
    co_path_free(converted);
    texture->kind = CO_TEXTURE_PTEX;
    return ok && texture->file != COHORT_INVALID_ID;
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
    if (textures->count == textures->capacity) {
        uint32_t capacity = 2 * textures->capacity + 16;
        void *grown =
            co_realloc(CO_MEMORY_TEXTURE, textures->textures,
                       textures->capacity * sizeof(CoTexture), capacity * sizeof(CoTexture));
        if (!grown) {
            CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
            return COHORT_INVALID_ID;
        }
        textures->textures = grown;
        textures->capacity = capacity;
    }
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
