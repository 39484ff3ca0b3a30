// Ptex lookups as requests: the filter's parts, cut at tile borders.

#include "texture/request.h"

#include <string.h>

// Halvings along u of a source; the others are along v.
static int halvings_u(const CoPtexSource *source)
{
    return source->steps - __builtin_popcount(source->axes);
}

static void add_constant(CoRequestSink *sink, const void *pixel, const CoPtexKernel *kernel)
{
    CoRequest *request = co_request_add(sink, 0, 0);
    if (!request)
        return;
    float weight = co_ptex_weight(kernel);
    for (uint32_t i = 0; i < sink->texture->channel_count; i++)
        request->sum[i] =
            weight * co_ptex_pixel_value(sink->file->ptex->type, pixel, sink->texture->channels[i]);
    request->is_served = true;
}

// Columns [u, u + uw) and rows [v, v + vw) of the kernel, texels counted from (u0, v0).
static CoRequest *add_block(CoRequestSink *sink, const CoPtexSource *source, const CoPtexKernel *k,
                            const int window[4], const int origin[2])
{
    int u = window[0], v = window[1], uw = window[2], vw = window[3];
    CoRequest *request = co_request_add(sink, (uint32_t)uw, (uint32_t)vw);
    if (!request)
        return NULL;
    request->block = source->block;
    request->axes = source->axes;
    request->steps = source->steps;
    request->ulog2 = source->ulog2;
    request->vlog2 = source->vlog2;
    request->rotation = (uint8_t)k->rotation;
    request->u = u - origin[0];
    request->v = v - origin[1];
    memcpy(request->weights, k->ku + (u - k->u), (size_t)uw * sizeof(float));
    memcpy(request->weights + uw, k->kv + (v - k->v), (size_t)vw * sizeof(float));
    return request;
}

static int span_end(int at, int log2, int end)
{
    int next = ((at >> log2) + 1) << log2;
    return next < end ? next : end;
}

// One request per tile that the kernel touches. Each tile is halved by itself.
static void add_tiles(CoRequestSink *sink, const CoPtexSource *source, const CoPtexKernel *k)
{
    const CoPtexFile *file = sink->file->ptex;
    const CoPtexTiling *tiling = &file->tilings[file->blocks[source->block].tiling];
    int ulog2 = tiling->ulog2 - halvings_u(source);
    int vlog2 = tiling->vlog2 - __builtin_popcount(source->axes);
    int across = 1 << (source->ulog2 - tiling->ulog2);
    for (int v = k->v, v_end; v < k->v + k->vw; v = v_end) {
        v_end = span_end(v, vlog2, k->v + k->vw);
        for (int u = k->u, u_end; u < k->u + k->uw; u = u_end) {
            u_end = span_end(u, ulog2, k->u + k->uw);
            int tile_u = u >> ulog2, tile_v = v >> vlog2;
            CoPtexSource tile = *source;
            tile.block = tiling->first + (uint32_t)(tile_v * across + tile_u);
            tile.ulog2 = tiling->ulog2;
            tile.vlog2 = tiling->vlog2;
            CoRequest *request =
                add_block(sink, &tile, k, (const int[4]){u, v, u_end - u, v_end - v},
                          (const int[2]){tile_u << ulog2, tile_v << vlog2});
            const CoPtexBlock *block = &file->blocks[tile.block];
            if (!request || co_ptex_encoding(block) != CO_PTEX_PLAIN)
                continue;
            // A constant tile needs no reading; it is a sum all the same, turned like any other.
            const unsigned char *pixel = (const unsigned char *)file->map.data + block->offset;
            float ku = 0, kv = 0;
            for (int i = 0; i < request->uw; i++)
                ku += request->weights[i];
            for (int i = 0; i < request->vw; i++)
                kv += request->weights[request->uw + i];
            for (uint32_t i = 0; i < sink->texture->channel_count; i++)
                request->sum[i] =
                    ku * kv * co_ptex_pixel_value(file->type, pixel, sink->texture->channels[i]);
            request->is_served = true;
        }
    }
}

static void add_part(void *context, uint32_t face, const CoPtexKernel *kernel)
{
    CoRequestSink *sink = context;
    const CoPtexFile *file = sink->file->ptex;
    CoPtexSource source;
    if (!co_ptex_locate(file, face, kernel->ulog2, kernel->vlog2, &source))
        return;
    if (source.block == CO_PTEX_NO_BLOCK) {
        add_constant(sink, source.pixel, kernel);
        return;
    }
    const CoPtexBlock *block = &file->blocks[source.block];
    if (co_ptex_encoding(block) == CO_PTEX_TILED) {
        const CoPtexTiling *tiling = &file->tilings[block->tiling];
        // Where a texel is the mean of several tiles, the whole face is the block.
        if (halvings_u(&source) <= tiling->ulog2 &&
            __builtin_popcount(source.axes) <= tiling->vlog2) {
            add_tiles(sink, &source, kernel);
            return;
        }
    }
    add_block(sink, &source, kernel, (const int[4]){kernel->u, kernel->v, kernel->uw, kernel->vw},
              (const int[2]){0, 0});
}

float co_ptex_request(CoRequestSink *sink, const CoLookup *lookup)
{
    const CoPtexFile *file = sink->file->ptex;
    CoPtexQuery query = {.face = lookup->face,
                         .u = lookup->s,
                         .v = lookup->t,
                         .uw1 = lookup->ds0,
                         .vw1 = lookup->dt0,
                         .uw2 = lookup->ds1,
                         .vw2 = lookup->dt1,
                         .width = 1};
    if (lookup->face >= file->faces_count)
        return 0;
    return co_ptex_filter(file, &sink->texture->filter, &query, add_part, sink) *
           co_ptex_one(file->type);
}
