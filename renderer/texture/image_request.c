// Image lookups as requests: bilinear in the two nearest mip levels, cut at tile borders.
//
// The level is chosen by the longer side of the footprint's bounding box, in texels: never sharper
// than the footprint, blurrier along its short side. Between two levels the weights are linear in
// that width, not in its logarithm, which needs no transcendental. A footprint of at most one texel
// takes level 0 alone.

#include "texture/request.h"

#include <math.h>
#include <string.h>

// One or two neighboring texels of one axis, in one tile.
typedef struct Run {
    uint32_t tile;
    int32_t first; // in the tile
    int count;
    float weights[2];
} Run;

static float wrap_coordinate(float s, CohortWrap wrap)
{
    if (wrap == COHORT_WRAP_REPEAT)
        return s - floorf(s);
    if (wrap == COHORT_WRAP_MIRROR)
        return s - 2 * floorf(0.5f * s);
    return s < -2 ? -2 : s > 3 ? 3 : s; // beyond the image nothing changes any more
}

// The texel that stands for texel i of [0, n); -1: none.
static int wrap_texel(int i, int n, CohortWrap wrap)
{
    if (i >= 0 && i < n)
        return i;
    switch (wrap) {
    case COHORT_WRAP_REPEAT:
        return i < 0 ? (i % n + n) % n : i % n;
    case COHORT_WRAP_MIRROR:
        i = i < 0 ? (i % (2 * n) + 2 * n) % (2 * n) : i % (2 * n);
        return i < n ? i : 2 * n - 1 - i;
    case COHORT_WRAP_CLAMP:
        return i < 0 ? 0 : n - 1;
    case COHORT_WRAP_USE_METADATA:
    case COHORT_WRAP_BLACK:
        break;
    }
    return -1;
}

// Texels and weights of a bilinear lookup at p (texel centers at integers), as runs within tiles;
// returns their number, 0 to 2. `kept` is the weight that fell on texels.
static int find_runs(float p, uint32_t size, CohortWrap wrap, Run runs[2], float *kept)
{
    float down = floorf(p), f = p - down;
    const float weights[2] = {1.0f - f, f};
    int count = 0;
    float lost = 0;
    for (int i = 0; i < 2; i++) {
        if (weights[i] == 0)
            continue;
        int texel = wrap_texel((int)down + i, (int)size, wrap);
        if (texel < 0) {
            lost += weights[i];
            continue;
        }
        uint32_t tile = (uint32_t)texel / CO_IMAGE_TILE;
        int32_t at = texel % CO_IMAGE_TILE;
        Run *last = count ? &runs[count - 1] : NULL;
        if (last && last->tile == tile && at == last->first) {
            last->weights[0] += weights[i];
        } else if (last && last->tile == tile && at == last->first + 1) {
            last->weights[1] = weights[i];
            last->count = 2;
        } else {
            runs[count++] = (Run){tile, at, 1, {weights[i], 0}};
        }
    }
    *kept = count ? 1.0f - lost : 0; // exactly 1 where nothing was lost
    return count;
}

static void request_level(CoRequestSink *sink, const CoLookup *lookup, uint32_t index, float weight)
{
    const CoTexture *texture = sink->texture;
    const CoImageLevel *level = &sink->file->image->levels[index];
    Run columns[2], rows[2];
    float kept_u, kept_v;
    float s = wrap_coordinate(lookup->s, texture->wrap_s);
    float t = wrap_coordinate(lookup->t, texture->wrap_t);
    int across =
        find_runs(s * (float)level->width - 0.5f, level->width, texture->wrap_s, columns, &kept_u);
    int down = find_runs((1.0f - t) * (float)level->height - 0.5f, level->height, texture->wrap_t,
                         rows, &kept_v);
    sink->missing += weight * (1.0f - kept_u * kept_v);
    for (int y = 0; y < down; y++) {
        for (int x = 0; x < across; x++) {
            const Run *column = &columns[x], *row = &rows[y];
            CoRequest *request =
                co_request_add(sink, (uint32_t)column->count, (uint32_t)row->count);
            if (!request)
                return;
            request->block = level->first + row->tile * level->across + column->tile;
            request->u = column->first;
            request->v = row->first;
            memcpy(request->weights, column->weights, (size_t)column->count * sizeof(float));
            for (int i = 0; i < row->count; i++)
                request->weights[column->count + i] = weight * row->weights[i];
        }
    }
}

static float finite_or_zero(float x)
{
    return fabsf(x) < 1e30f ? x : 0;
}

float co_image_request(CoRequestSink *sink, const CoLookup *lookup)
{
    const CoImageFile *image = sink->file->image;
    CoLookup clean = *lookup;
    clean.s = finite_or_zero(lookup->s);
    clean.t = finite_or_zero(lookup->t);
    float wide = (fabsf(lookup->ds0) + fabsf(lookup->ds1)) * (float)image->levels[0].width;
    float high = (fabsf(lookup->dt0) + fabsf(lookup->dt1)) * (float)image->levels[0].height;
    float width = wide > high ? wide : high;
    uint32_t last = image->level_count - 1, level = 0;
    if (!(width > 1.0f)) {
        request_level(sink, &clean, 0, 1.0f);
        return 1.0f;
    }
    while (level < last && width >= 2.0f) {
        width *= 0.5f;
        level++;
    }
    float coarser = level < last ? width - 1.0f : 0;
    request_level(sink, &clean, level, 1.0f - coarser);
    if (coarser > 0)
        request_level(sink, &clean, level + 1, coarser);
    return 1.0f;
}

uint32_t co_image_udim(const CoTexture *texture, CoLookup *lookup)
{
    float u = floorf(lookup->s), v = floorf(lookup->t);
    if (!(u >= 0 && u < 10 && v >= 0 && v < 10))
        return COHORT_INVALID_ID;
    lookup->s -= u;
    lookup->t -= v;
    return texture->udim[(int)u + 10 * (int)v];
}
