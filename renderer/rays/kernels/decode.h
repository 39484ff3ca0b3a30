// Records to the field arrays of a batch, a few at a time. To be included by code.c alone.
#include "rays/octahedral.h"
#include "rays/ray_parts.h"

// The words that traversal asks for, each by itself.
typedef struct Gathered {
    uint32_t org[3][DECODED], tnear[DECODED], record[DECODED];
    int32_t code[2][DECODED];
} Gathered;

typedef struct Directions {
    float x[DECODED], y[DECODED], z[DECODED];
} Directions;

static inline void gather(const CoRayRecords *records, const uint32_t *order, uint32_t options,
                          size_t begin, size_t count, Gathered *out)
{
    for (size_t i = 0; i < count; i++) {
        uint32_t record = order ? order[begin + i] : (uint32_t)(begin + i);
        const uint32_t *words = records->words + (size_t)record * records->stride;
        for (int k = 0; k < 3; k++)
            out->org[k][i] = words[k];
        for (int k = 0; k < 2; k++)
            out->code[k][i] = (int32_t)(words[3 + k] & CO_DIRECTION_MASK) - CO_DIRECTION_MAX;
        out->tnear[i] = options & CO_RAY_OPTION_TNEAR ? words[CO_RAY_WORDS] : 0;
        out->record[i] = record;
    }
}

// Records in the order of a sort lie all over the batch: each is a miss unless asked for in time.
static inline void prefetch(const CoRayRecords *records, const uint32_t *order, size_t begin,
                            size_t end)
{
    for (size_t i = begin; i < end; i++) {
        const uint32_t *words = records->words + (size_t)order[i] * records->stride;
        __builtin_prefetch(words);
        __builtin_prefetch(words + CO_RAY_WORDS - 1); // often on the next cache line
    }
}

static inline void decode_directions(const Gathered *in, Directions *out)
{
    for (uint32_t i = 0; i < DECODED; i++) {
        CoVec3 d = co_oct_decode((CoOct){in->code[0][i], in->code[1][i]}, CO_DIRECTION_MAX);
        out->x[i] = d.x;
        out->y[i] = d.y;
        out->z[i] = d.z;
    }
}

static inline void store(const Gathered *in, const Directions *directions, size_t begin,
                         size_t count, CoRayBatch *batch)
{
    size_t bytes = count * sizeof(uint32_t);
    memcpy(batch->org_x + begin, in->org[0], bytes);
    memcpy(batch->org_y + begin, in->org[1], bytes);
    memcpy(batch->org_z + begin, in->org[2], bytes);
    memcpy(batch->dir_x + begin, directions->x, bytes);
    memcpy(batch->dir_y + begin, directions->y, bytes);
    memcpy(batch->dir_z + begin, directions->z, bytes);
    memcpy(batch->tnear + begin, in->tnear, bytes);
    memcpy(batch->record + begin, in->record, bytes);
    for (size_t i = begin; i < begin + count; i++)
        batch->tfar[i] = INFINITY;
}

void CO_LANE_NAME(co_ray_decode_batch)(const CoRayRecords *records, const uint32_t *order,
                                       uint32_t options, size_t begin, size_t end,
                                       CoRayBatch *batch)
{
    Gathered gathered = {.record = {0}};
    Directions directions;
    size_t asked = begin;
    for (size_t i = begin; i < end; i += DECODED) {
        size_t count = end - i < DECODED ? end - i : DECODED;
        size_t ahead = end - i < AHEAD + DECODED ? end : i + AHEAD + DECODED;
        if (order)
            prefetch(records, order, asked, ahead);
        asked = ahead;
        gather(records, order, options, i, count, &gathered);
        decode_directions(&gathered, &directions);
        if (count == DECODED)
            store(&gathered, &directions, i, DECODED, batch); // of a known size: vectors
        else
            store(&gathered, &directions, i, count, batch);
    }
}
