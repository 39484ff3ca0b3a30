// One Ptex lookup at once, without requests and readers: the parts of its kernel, added up.

#ifndef TEST_TEXTURE_PTEX_EVALUATE_H
#define TEST_TEXTURE_PTEX_EVALUATE_H

#include "texture/ptex_filter.h"

#include <stdlib.h>

enum {
    EVALUATE_CHANNELS = 16 // that one lookup may ask for
};

typedef struct Evaluation {
    const CoPtexFile *file;
    CoPtexDecoder *decoder;
    uint16_t channels[EVALUATE_CHANNELS];
    uint32_t count;
    float *sum;
    bool ok;
} Evaluation;

static inline void evaluate_part(void *context, uint32_t face, const CoPtexKernel *kernel)
{
    Evaluation *e = context;
    float sum[EVALUATE_CHANNELS];
    CoPtexSource source;
    CoPtexPart part = {kernel->u,  kernel->v, (uint32_t)kernel->uw, (uint32_t)kernel->vw,
                       kernel->ku, kernel->kv};
    if (!e->ok || !co_ptex_locate(e->file, face, kernel->ulog2, kernel->vlog2, &source))
        return;
    if (source.block == CO_PTEX_NO_BLOCK) {
        float weight = co_ptex_weight(kernel);
        for (uint32_t i = 0; i < e->count; i++)
            e->sum[i] += weight * co_ptex_pixel_value(e->file->type, source.pixel, e->channels[i]);
        return;
    }
    void *texels = malloc(co_ptex_block_size(e->file, source.ulog2, source.vlog2));
    e->ok =
        co_ptex_block_decode(e->file, source.block, source.ulog2, source.vlog2, e->decoder, texels);
    if (e->ok) {
        co_ptex_halve_all(e->file, &source, texels);
        co_ptex_sum(e->file->type, texels, kernel->ulog2, kernel->vlog2, &part, e->channels,
                    e->count, sum);
        co_ptex_turn(e->file, kernel->rotation, e->count, sum);
        for (uint32_t i = 0; i < e->count; i++)
            e->sum[i] += sum[i];
    }
    free(texels);
}

// Channels [first, first + count) of a file of quads to `out`, integers scaled to [0, 1]. False
// when a block is damaged.
static inline bool evaluate_ptex(const CoPtexFile *file, const CoPtexFilter *filter,
                                 const CoPtexQuery *query, uint32_t first, uint32_t count,
                                 CoPtexDecoder *decoder, float *out)
{
    Evaluation e = {.file = file, .decoder = decoder, .count = count, .sum = out, .ok = true};
    for (uint32_t i = 0; i < count; i++) {
        e.channels[i] = (uint16_t)(first + i);
        out[i] = 0;
    }
    float weight = co_ptex_filter(file, filter, query, evaluate_part, &e);
    float scale = weight * co_ptex_one(file->type);
    for (uint32_t i = 0; i < count; i++)
        out[i] = weight == 0 ? 0 : out[i] / scale;
    return e.ok;
}

#endif
