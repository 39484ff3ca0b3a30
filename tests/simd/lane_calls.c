#include "lane_calls.h"

#include "simd/lane.h"

// One bit of a mask, as a float per lane.
static void store_mask(float *out, CoLaneMask mask)
{
    uint32_t bits = co_lane_bits(mask);
    for (int i = 0; i < CO_LANE_WIDTH; i++)
        out[i] = (float)(bits >> i & 1u);
}

void CO_LANE_NAME(lane_calls)(const float *a, const float *b, const uint8_t *index, uint32_t count,
                              float *out)
{
    for (uint32_t i = 0; i < count; i += CO_LANE_WIDTH) {
        CoLane x = co_lane_load(a + i), y = co_lane_load(b + i);
        CoLaneMask less = co_lane_lt(x, y), same = co_lane_le(x, y);
        float *at = out + i;
        co_lane_store(at, co_lane_add(x, y));
        co_lane_store(at += count, co_lane_sub(x, y));
        co_lane_store(at += count, co_lane_mul(x, y));
        co_lane_store(at += count, co_lane_div(x, y));
        co_lane_store(at += count, co_lane_min(x, y));
        co_lane_store(at += count, co_lane_max(x, y));
        co_lane_store(at += count, co_lane_abs(x));
        co_lane_store(at += count, co_lane_copysign(x, y));
        store_mask(at += count, less);
        store_mask(at += count, same);
        store_mask(at += count, co_lane_ne(x, y));
        store_mask(at += count, co_lane_and(less, same));
        co_lane_store(at += count, co_lane_select(less, x, y));
        CoLaneMask again = co_lane_mask(co_lane_bits(less) | 0x10000u); // bits beyond do not matter
        co_lane_store(at += count, co_lane_select(again, y, x));
        co_lane_store(at += count, co_lane_load_bytes(index + i));
        uint32_t place[CO_LANE_WIDTH];
        CoLane point[3];
        for (uint32_t k = 0; k < CO_LANE_WIDTH; k++)
            place[k] = index[i + k] % 85u;
        co_lane_load_points(a, place, point); // of 256 floats
        for (int c = 0; c < 3; c++)
            co_lane_store(at += count, point[c]);
        uint8_t which[8];
        uint32_t words[9], found[8];
        __builtin_memcpy(words, b, sizeof words);
        for (uint32_t k = 0; k < CO_LANE_WIDTH; k++)
            which[k] = index[i + k] % 9u;
        co_lane_along(words, which, index + i, found);
        at += count;
        for (uint32_t k = 0; k < CO_LANE_WIDTH; k++)
            at[k] = (float)(found[k] >> 16) + (float)(found[k] & 0xffu);
    }
    float *at = out + (LANE_CALL_COUNT - 2) * count;
    for (uint32_t i = 0; i < count; i += CO_LANE_WIDTH) {
        uint64_t sets[CO_LANE_WIDTH];
        CoLane x = co_lane_load(a + i), y = co_lane_load(b + i);
        CoLaneSets all = co_lane_sets_put(co_lane_sets_empty(), co_lane_lt(x, y), 1ull << 3);
        all = co_lane_sets_put(all, co_lane_le(y, x), 1ull << 40);
        co_lane_sets_store(sets, co_lane_sets_put(all, co_lane_ne(x, y), 1ull << 63));
        for (uint32_t k = 0; k < CO_LANE_WIDTH; k++)
            at[i + k] = (float)(sets[k] >> 63) + 2.0f * (float)(sets[k] >> 40 & 1u) +
                        4.0f * (float)(sets[k] & 0xffu);
    }
    at += count;
    for (uint32_t i = 0; i < count; i += 8) {
        uint16_t v[8];
        for (uint32_t k = 0; k < 8; k++) // some are equal, some 0xffff
            v[k] = (uint16_t)(index[i + k] < 200 ? index[i + (k & 5u)] * 511u : 0xffffu);
        uint32_t taken = co_take_least(v);
        for (uint32_t k = 0; k < 8; k++)
            at[i + k] = (float)(k < 6 ? v[k] : k == 6 ? taken & 0xffffu : taken >> 16);
    }
}

static void store_wide_mask(float *out, CoWideMask mask)
{
    uint32_t bits = co_wide_bits(mask);
    for (int i = 0; i < CO_WIDE_WIDTH; i++)
        out[i] = (float)(bits >> i & 1u);
}

// Among the 16 numbers of `table` that i is in, by the bits of `places`.
static CoWide look_up(const float *table, const float *places, uint32_t i)
{
    CoWide held[16 / CO_WIDE_WIDTH];
    uint32_t first = i & ~15u;
    const uint8_t *bytes = (const uint8_t *)(places + first);
    for (uint32_t k = 0; k < 16; k += CO_WIDE_WIDTH)
        held[k / CO_WIDE_WIDTH] = co_wide_load(table + first + k);
    return co_wide_lookup16(held, bytes, i - first);
}

// The same among the first 8 of them.
static void look_up_few(const float *table, const float *places, uint32_t i, float *out)
{
    CoLane held[8 / CO_LANE_WIDTH];
    uint32_t first = i & ~15u;
    uint8_t low[16] = {0}; // kernels read places of 16
    for (uint32_t k = 0; k < 8; k++)
        low[k] = ((const uint8_t *)(places + first))[k] & 0x77u;
    for (uint32_t k = 0; k < 8; k += CO_LANE_WIDTH)
        held[k / CO_LANE_WIDTH] = co_lane_load(table + first + k);
    for (uint32_t k = 0; k < CO_WIDE_WIDTH; k += CO_LANE_WIDTH)
        co_lane_store(out + k, co_lane_lookup8(held, low, (i + k) % 8));
}

void CO_LANE_NAME(wide_calls)(const float *a, const float *b, const float *c, uint32_t count,
                              float *out)
{
    for (uint32_t i = 0; i < count; i += CO_WIDE_WIDTH) {
        CoWide x = co_wide_load(a + i), y = co_wide_load(b + i), z = co_wide_load(c + i);
        CoWideMask less = co_wide_lt(x, y), same = co_wide_le(x, y);
        float *at = out + i;
        co_wide_store(at, co_wide_add(x, y));
        co_wide_store(at += count, co_wide_sub(x, y));
        co_wide_store(at += count, co_wide_mul(x, y));
        co_wide_store(at += count, co_wide_div(x, y));
        co_wide_store(at += count, co_wide_min(x, y));
        co_wide_store(at += count, co_wide_max(x, y));
        co_wide_store(at += count, co_wide_abs(x));
        co_wide_store(at += count, co_wide_copysign(x, y));
        store_wide_mask(at += count, less);
        store_wide_mask(at += count, same);
        store_wide_mask(at += count, co_wide_ne(x, y));
        store_wide_mask(at += count, co_wide_and(same, co_wide_ne(x, z)));
        co_wide_store(at += count, co_wide_select(less, x, y));
        co_wide_store(at += count, look_up(b, c, i));
        look_up_few(b, c, i, at += count);
        co_wide_store(at += count, co_wide_residue(x, y, co_wide_mul(x, y)));
        co_wide_store(at += count, co_wide_muladd(x, y, z));
    }
}
