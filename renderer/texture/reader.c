#include "texture/reader.h"

#include "base/memory.h"

#include <string.h>

void co_reader_clear(CoReader *reader)
{
    co_ptex_decoder_clear(&reader->decoder);
    co_image_reader_clear(&reader->images);
    co_free(CO_MEMORY_TEXTURE, reader->texels, reader->texels_size);
    co_free(CO_MEMORY_TEXTURE, reader->halved, reader->halved_size);
    *reader = (CoReader){0};
}

static void *reserve(void **bytes, size_t *have, size_t size)
{
    if (size > *have) {
        co_free(CO_MEMORY_TEXTURE, *bytes, *have);
        *bytes = co_alloc(CO_MEMORY_TEXTURE, size);
        *have = *bytes ? size : 0;
    }
    return *bytes;
}

void *co_reader_texels(CoReader *reader, size_t size)
{
    return reserve(&reader->texels, &reader->texels_size, size);
}

size_t co_reader_block_size(const CoTextureFile *file, const CoRequest *request)
{
    if (file->ptex)
        return co_ptex_block_size(file->ptex, request->ulog2, request->vlog2);
    return (size_t)CO_IMAGE_TILE * CO_IMAGE_TILE * file->image->channels * sizeof(float);
}

bool co_reader_decode(CoReader *reader, const CoTextureFile *file, const CoRequest *request,
                      void *out)
{
    const void *resident = file->blocks ? atomic_load(&file->blocks[request->block]) : NULL;
    if (resident) {
        memcpy(out, resident, co_reader_block_size(file, request));
        return true;
    }
    if (file->ptex)
        return co_ptex_block_decode(file->ptex, request->block, request->ulog2, request->vlog2,
                                    &reader->decoder, out);
    return co_image_tile_read(&reader->images, file->image, request->block, reader->decoder.count,
                              out);
}

bool co_reader_is_short(const CoReader *reader, const CoTextureFile *file)
{
    return file->ptex && co_ptex_decoder_is_short(&reader->decoder);
}

static void sum_image(const CoTextureFile *file, CoRequest *request, const float *texels)
{
    uint32_t channels = file->image->channels;
    float sum[CO_TEXTURE_CHANNELS] = {0};
    for (uint32_t y = 0; y < request->vw; y++) {
        const float *row =
            texels +
            ((size_t)(request->v + (int)y) * CO_IMAGE_TILE + (size_t)request->u) * channels;
        float row_sum[CO_TEXTURE_CHANNELS] = {0};
        for (uint32_t x = 0; x < request->uw; x++)
            for (uint32_t c = 0; c < channels; c++)
                row_sum[c] += request->weights[x] * row[x * channels + c];
        for (uint32_t c = 0; c < channels; c++)
            sum[c] += request->weights[request->uw + y] * row_sum[c];
    }
    memcpy(request->sum, sum, channels * sizeof(float));
}

// The request's kernel moved by (u, v) texels, over a block of 2^ulog2 x 2^vlog2.
static void sum_ptex(const CoTextureFile *file, const CoTexture *texture, CoRequest *request,
                     const int place[4], const void *texels)
{
    CoPtexPart part = {request->u + place[0], request->v + place[1],
                       request->uw,           request->vw,
                       request->weights,      request->weights + request->uw};
    co_ptex_sum(file->ptex->type, texels, place[2], place[3], &part, texture->channels,
                texture->channel_count, request->sum);
    co_ptex_turn(file->ptex, request->rotation, texture->channel_count, request->sum);
}

void co_reader_sum(const CoTextureFile *file, const CoTexture *texture, CoRequest *request,
                   const void *texels)
{
    int in_v = __builtin_popcount(request->axes);
    if (file->ptex)
        sum_ptex(
            file, texture, request,
            (const int[4]){0, 0, request->ulog2 - (request->steps - in_v), request->vlog2 - in_v},
            texels);
    else
        sum_image(file, request, texels);
    request->is_served = true;
}

// Same sum where the request names a tile of the face that `texels` holds.
static void sum_in_face(const CoTextureFile *file, const CoTexture *texture, const CoRequest *whole,
                        CoRequest *request, const void *texels)
{
    int in_v = __builtin_popcount(request->axes), in_u = request->steps - in_v;
    int place[4] = {0, 0, whole->ulog2 - in_u, whole->vlog2 - in_v};
    if (request->block != whole->block) {
        const CoPtexFile *ptex = file->ptex;
        uint32_t first = ptex->tilings[ptex->blocks[whole->block].tiling].first;
        uint32_t tile = request->block - first, across = 1u << (whole->ulog2 - request->ulog2);
        place[0] = (int)(tile % across) << (request->ulog2 - in_u);
        place[1] = (int)(tile / across) << (request->vlog2 - in_v);
    }
    sum_ptex(file, texture, request, place, texels);
    request->is_served = true;
}

bool co_reader_serve(CoReader *reader, const CoTextureFile *file, const CoTexture *textures,
                     const CoRequest *whole, CoRequest *const *requests, size_t count,
                     const void *texels)
{
    for (size_t i = 0; i < count; i++) {
        CoRequest *request = requests[i];
        if (request->is_served)
            continue;
        if (!file->ptex) {
            co_reader_sum(file, &textures[request->texture], request, texels);
            continue;
        }
        if (request->steps == 0) {
            sum_in_face(file, &textures[request->texture], whole, request, texels);
            continue;
        }
        size_t size = co_ptex_block_size(file->ptex, whole->ulog2, whole->vlog2);
        if (!reserve(&reader->halved, &reader->halved_size, size))
            return false;
        memcpy(reader->halved, texels, size);
        CoPtexSource source = {.ulog2 = whole->ulog2,
                               .vlog2 = whole->vlog2,
                               .steps = request->steps,
                               .axes = request->axes};
        co_ptex_halve_all(file->ptex, &source, reader->halved);
        for (size_t j = i; j < count; j++)
            if (!requests[j]->is_served && requests[j]->steps == request->steps &&
                requests[j]->axes == source.axes)
                sum_in_face(file, &textures[requests[j]->texture], whole, requests[j],
                            reader->halved);
    }
    return true;
}

void co_reader_give_up(CoTextureFile *file, const CoTexture *textures, CoRequest *const *requests,
                       size_t count)
{
    atomic_store(&file->is_damaged, true);
    float one = file->ptex ? co_ptex_one(file->ptex->type) : 1.0f;
    for (size_t i = 0; i < count; i++) {
        CoRequest *request = requests[i];
        const CoTexture *texture = &textures[request->texture];
        float ku = 0, kv = 0;
        for (int x = 0; x < request->uw; x++)
            ku += request->weights[x];
        for (int y = 0; y < request->vw; y++)
            kv += request->weights[request->uw + y];
        for (uint32_t c = 0; c < texture->channel_count; c++) {
            bool is_alpha = texture->has_alpha && c + 1 == texture->channel_count;
            request->sum[c] = ku * kv * one * texture->fallback[is_alpha ? 3 : c];
        }
        request->is_served = true;
    }
}
