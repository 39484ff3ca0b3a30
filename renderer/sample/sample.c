#include "sample/sample.h"

#include "base/hash.h"
#include "math/warp.h"
#include "sample/sobol_table.h"

static uint32_t reverse_bits(uint32_t x)
{
    x = __builtin_bswap32(x);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x >> 4) & 0x0f0f0f0fu);
    x = ((x & 0x33333333u) << 2) | ((x >> 2) & 0x33333333u);
    return ((x & 0x55555555u) << 1) | ((x >> 1) & 0x55555555u);
}

// A hash in which each bit is flipped by the bits below it only: on a bit-reversed fraction that is
// an Owen scramble. The form is Laine and Karras' (2011), the constants Vegdahl's (2021), which
// pass where the originals correlate.
static uint32_t owen_hash(uint32_t x, uint32_t seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

static float unit_float(uint32_t x)
{
    return (float)(x >> 8) * 0x1p-24f;
}

void co_sample(CoSampleKey key, uint32_t vertex, uint32_t path_branch, CoDecision decision,
               uint32_t branch, uint32_t split, uint32_t count, float *out)
{
    // Even and odd samples are two sequences of their own: two half films that share nothing.
    uint64_t index = (uint64_t)(key.sample >> 1) * (split > 1u ? split : 1u) + branch;
    uint64_t who = co_hash64(((uint64_t)key.seed << 32) ^ key.pixel);
    uint64_t what = ((uint64_t)vertex << 32) ^ ((uint64_t)path_branch << 4) ^
                    ((uint64_t)decision << 1) ^ (key.sample & 1u);
    uint64_t seed = co_hash64(who ^ what);
    // Past 2^32 points a fresh scramble takes over.
    if (index >> 32)
        seed = co_hash_combine(seed, index >> 32);

    uint32_t shuffled = owen_hash(reverse_bits((uint32_t)index), (uint32_t)(seed >> 32));
    uint32_t point[4] = {0u, 0u, 0u, 0u};
    for (int i = 0; i < 8; i++) {
        const uint32_t *entry = sobol_table[i][(shuffled >> (4 * i)) & 15u];
        for (int d = 0; d < 4; d++)
            point[d] ^= entry[d];
    }
    for (uint32_t d = 0; d < count && d < 4u; d++) {
        uint32_t scramble = co_hash32((uint32_t)seed + d * 0x9e3779b9u);
        out[d] = unit_float(reverse_bits(owen_hash(point[d], scramble)));
    }
}

float co_sample_hash(CoSampleKey key, uint32_t a, uint32_t b)
{
    uint64_t who = co_hash64(((uint64_t)key.seed << 32) ^ key.pixel);
    // Not the constant of co_sample: the two must never draw the same stream.
    uint64_t path = co_hash64(who ^ key.sample ^ 0xa24baed4963ee407u);
    return unit_float((uint32_t)(co_hash64(path ^ (((uint64_t)a << 32) | b)) >> 32));
}

void co_disk_sample(float u0, float u1, float *x, float *y)
{
    co_warp_disk(u0, u1, x, y);
}
