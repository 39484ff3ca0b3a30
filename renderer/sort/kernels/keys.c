// Keys of records, compiled once per instruction set; written as rays/kernels/code.c is. Directions
// stand in the records as points of a grid: no root is taken.
#include "sort/ray_keys.h"

#include "rays/octahedral.h"
#include "rays/ray_parts.h"
#include "simd/lane.h"
#include "sort/hilbert.h"

enum {
    RAYS = CO_HILBERT_CELLS
};

typedef struct Gathered {
    float org[3][RAYS];
    int32_t code[2][RAYS];
} Gathered;

typedef struct Cells {
    uint32_t at[3][RAYS], keys[RAYS];
} Cells;

static inline void gather(const CoRayRecords *records, size_t begin, size_t count, Gathered *out)
{
    for (size_t i = 0; i < count; i++) {
        const uint32_t *words = records->words + (begin + i) * records->stride;
        for (int k = 0; k < 3; k++)
            out->org[k][i] = co_float_from_bits(words[k]);
        for (int k = 0; k < 2; k++)
            out->code[k][i] = (int32_t)(words[3 + k] & CO_DIRECTION_MASK) - CO_DIRECTION_MAX;
    }
}

static inline uint32_t to_cell(float x, float most)
{
    return (uint32_t)(int32_t)co_min(co_max(x, 0.0f), most); // NaN: 0
}

static inline void find_places(const Gathered *in, const CoKeyGrid *grid, Cells *out)
{
    float most = (float)((1u << grid->levels) - 1), scale = grid->scale;
    CoVec3 low = grid->low;
    for (uint32_t i = 0; i < RAYS; i++) {
        out->at[0][i] = to_cell((in->org[0][i] - low.x) * scale, most);
        out->at[1][i] = to_cell((in->org[1][i] - low.y) * scale, most);
        out->at[2][i] = to_cell((in->org[2][i] - low.z) * scale, most);
    }
    co_hilbert3(out->at[0], out->at[1], out->at[2], grid->levels, out->keys);
}

// Face of the cube around the origin that the direction meets, then the place on it.
static inline void find_directions(const Gathered *in, uint32_t bits, Cells *out)
{
    float half = (float)(1u << (bits - 1)), most = (float)((1u << bits) - 1);
    for (uint32_t i = 0; i < RAYS; i++) {
        int32_t v[3];
        co_oct_unfold((CoOct){in->code[0][i], in->code[1][i]}, CO_DIRECTION_MAX, v);
        float x = (float)v[0], y = (float)v[1], z = (float)v[2];
        bool is_x = (fabsf(x) >= fabsf(y)) & (fabsf(x) >= fabsf(z));
        bool is_z = !is_x & (fabsf(z) > fabsf(y));
        float major = is_x ? x : is_z ? z : y, minor = is_x ? y : x, other = is_z ? y : z;
        float scale = half / fabsf(major);
        out->at[0][i] = to_cell(minor * scale + half, most);
        out->at[1][i] = to_cell(other * scale + half, most);
        out->at[2][i] = 2 * (is_x ? 0u : is_z ? 2u : 1u) + (major < 0.0f);
    }
    co_hilbert2(out->at[0], out->at[1], bits, out->keys);
    for (uint32_t i = 0; i < RAYS; i++)
        out->keys[i] |= out->at[2][i] << (2 * bits);
}

static inline void make_items(const Gathered *in, const CoKeyGrid *grid, const Cells *places,
                              const Cells *directions, size_t begin, uint64_t items[RAYS])
{
    uint32_t mask = (1u << grid->direction_bits) - 1, invalid = 1u << grid->place_bits;
    for (uint32_t i = 0; i < RAYS; i++) {
        // Only what is not finite leaves something when taken from itself.
        float x = in->org[0][i], y = in->org[1][i], z = in->org[2][i];
        bool is_valid = (x - x) + (y - y) + (z - z) == 0.0f;
        uint64_t place = is_valid ? places->keys[i] : invalid;
        uint64_t key = place << grid->direction_bits | (directions->keys[i] & mask);
        items[i] = key << grid->index_bits | (begin + i);
    }
}

void CO_LANE_NAME(co_ray_keys)(const CoRayRecords *records, const CoKeyGrid *grid, size_t begin,
                               size_t end, uint64_t *items)
{
    Gathered gathered = {.code = {{0}}};
    Cells places, directions;
    uint64_t some[RAYS];
    bool is_point = !(grid->scale > 0.0f);
    for (size_t i = begin; i < end; i += RAYS) {
        size_t count = end - i < RAYS ? end - i : RAYS;
        gather(records, i, count, &gathered);
        find_directions(&gathered, grid->axis_bits, &directions);
        if (is_point)
            make_items(&gathered, grid, &directions, &directions, i, some);
        else {
            find_places(&gathered, grid, &places);
            make_items(&gathered, grid, &places, &directions, i, some);
        }
        memcpy(items + i, some, count * sizeof *items);
    }
}
