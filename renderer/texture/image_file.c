#include "texture/image_file.h"

#include "base/error.h"
#include "base/memory.h"
#include "shims/oiio.h"

#include <string.h>

static bool read_levels(CoImageFile *image, CoOiioFile *handle, CohortError *err)
{
    uint32_t width, height, channels, tile;
    while (image->level_count < CO_IMAGE_LEVELS &&
           co_oiio_level(handle, image->level_count, &width, &height, &channels, &tile)) {
        CO_CHECK(tile == CO_IMAGE_TILE && channels <= 4, err, COHORT_ERROR_TEXTURE,
                 "converted image has tiles of %u and %u channels", tile, channels);
        CoImageLevel *level = &image->levels[image->level_count++];
        *level = (CoImageLevel){.width = width,
                                .height = height,
                                .across = (width - 1) / CO_IMAGE_TILE + 1,
                                .down = (height - 1) / CO_IMAGE_TILE + 1,
                                .first = image->tile_count};
        image->channels = channels;
        image->tile_count += level->across * level->down; // at most 2^28 texels: no overflow
    }
    CO_CHECK(image->level_count > 0, err, COHORT_ERROR_TEXTURE, "converted image has no levels");
    return true;
}

CoImageFile *co_image_open(const char *path, CohortError *err)
{
    size_t length = strlen(path) + 1;
    CoOiioFile *handle = co_oiio_open(path, err);
    if (!handle)
        return NULL;
    CoImageFile *image = co_alloc_zero(CO_MEMORY_TEXTURE, sizeof *image);
    bool ok = image && read_levels(image, handle, err);
    co_oiio_close(handle);
    if (ok) {
        image->path = co_alloc(CO_MEMORY_TEXTURE, length);
        image->stamps = co_alloc_zero(CO_MEMORY_TEXTURE, image->tile_count * sizeof(CoBlockStamp));
        ok = image->path && image->stamps;
        if (image->path)
            memcpy(image->path, path, length);
    }
    if (!ok) {
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
        co_image_close(image);
        return NULL;
    }
    return image;
}

void co_image_close(CoImageFile *image)
{
    if (!image)
        return;
    co_free(CO_MEMORY_TEXTURE, image->stamps, image->tile_count * sizeof(CoBlockStamp));
    if (image->path)
        co_free(CO_MEMORY_TEXTURE, image->path, strlen(image->path) + 1);
    co_free(CO_MEMORY_TEXTURE, image, sizeof *image);
}

void co_image_reader_clear(CoImageReader *reader)
{
    for (int i = 0; i < CO_IMAGE_HANDLES; i++)
        if (reader->handles[i])
            co_oiio_close(reader->handles[i]);
    *reader = (CoImageReader){0};
}

static CoOiioFile *handle_of(CoImageReader *reader, const CoImageFile *image)
{
    for (int i = 0; i < CO_IMAGE_HANDLES; i++)
        if (reader->images[i] == image)
            return reader->handles[i];
    CoOiioFile *handle = co_oiio_open(image->path, NULL);
    if (!handle)
        return NULL;
    uint32_t at = reader->next++ % CO_IMAGE_HANDLES;
    if (reader->handles[at])
        co_oiio_close(reader->handles[at]);
    reader->handles[at] = handle;
    reader->images[at] = image;
    return handle;
}

bool co_image_tile_read(CoImageReader *reader, const CoImageFile *image, uint32_t tile,
                        CoBlockCount *count, float *out)
{
    CoOiioFile *handle = handle_of(reader, image);
    if (!handle)
        return false;
    uint32_t level = 0;
    while (level + 1 < image->level_count && image->levels[level + 1].first <= tile)
        level++;
    uint32_t at = tile - image->levels[level].first, across = image->levels[level].across;
    if (count)
        co_block_counted(count, &image->stamps[tile],
                         (size_t)CO_IMAGE_TILE * CO_IMAGE_TILE * image->channels * sizeof(float));
    return co_oiio_tile(handle, level, at % across, at / across, out, NULL);
}
