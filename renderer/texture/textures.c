#include "texture/textures.h"

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "texture/converted.h"

#include <string.h>
#include <sys/stat.h>

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
    void *files = textures->files;
    bool has_room = co_grow(CO_MEMORY_TEXTURE, &files, textures->file_count,
                            &textures->file_capacity, sizeof *textures->files);
    textures->files = files;
    char *copy = co_path_copy(path);
    if (!file || !copy || !has_room) {
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
