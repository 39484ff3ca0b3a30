// Places on Hilbert curves (Skilling 2004, "Programming the Hilbert curve"), of many cells at once:
// bit operations without branches, in loops that compilers make vectors of. Neighbors on the curve
// are neighbors in space, so that a piece of it is compact; a Morton curve jumps.

#ifndef CO_SORT_HILBERT_H
#define CO_SORT_HILBERT_H

#include <stdint.h>

enum {
    CO_HILBERT_CELLS = 64
};

// Skilling's step for one bit of one coordinate: where it is set the lower bits of the first
// coordinate are turned around, else they change places with those of this one.
static inline void co_hilbert_turn(uint32_t *first, uint32_t *x, uint32_t bit)
{
    uint32_t lower = (1u << bit) - 1, set = 0u - (*x >> bit & 1u);
    uint32_t differ = (*first ^ *x) & lower & ~set;
    *first ^= differ | (lower & set);
    *x ^= differ;
}

// Each bit becomes the parity of the bits above it, for numbers below 2^16.
static inline uint32_t co_hilbert_parity(uint32_t x)
{
    x ^= x >> 1;
    x ^= x >> 2;
    x ^= x >> 4;
    x ^= x >> 8;
    return x >> 1;
}

// Bit i goes to 2 i, for numbers below 2^16.
static inline uint32_t co_hilbert_spread2(uint32_t x)
{
    x = (x | x << 8) & 0x00ff00ffu;
    x = (x | x << 4) & 0x0f0f0f0fu;
    x = (x | x << 2) & 0x33333333u;
    return (x | x << 1) & 0x55555555u;
}

// Bit i goes to 3 i, for numbers below 2^10.
static inline uint32_t co_hilbert_spread3(uint32_t x)
{
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

// x, y: cells, below 2^bits; bits at most 16. They are overwritten.
static inline void co_hilbert2(uint32_t x[CO_HILBERT_CELLS], uint32_t y[CO_HILBERT_CELLS],
                               uint32_t bits, uint32_t keys[CO_HILBERT_CELLS])
{
    for (uint32_t bit = bits; bit-- > 1;)
        for (uint32_t i = 0; i < CO_HILBERT_CELLS; i++) {
            uint32_t lower = (1u << bit) - 1, first = x[i] ^ (lower & (0u - (x[i] >> bit & 1u)));
            co_hilbert_turn(&first, &y[i], bit);
            x[i] = first;
        }
    for (uint32_t i = 0; i < CO_HILBERT_CELLS; i++) {
        uint32_t second = y[i] ^ x[i], parity = co_hilbert_parity(second);
        keys[i] = co_hilbert_spread2(x[i] ^ parity) << 1 | co_hilbert_spread2(second ^ parity);
    }
}

// x, y, z: cells, below 2^bits; bits at most 10. They are overwritten.
static inline void co_hilbert3(uint32_t x[CO_HILBERT_CELLS], uint32_t y[CO_HILBERT_CELLS],
                               uint32_t z[CO_HILBERT_CELLS], uint32_t bits,
                               uint32_t keys[CO_HILBERT_CELLS])
{
    for (uint32_t bit = bits; bit-- > 1;)
        for (uint32_t i = 0; i < CO_HILBERT_CELLS; i++) {
            uint32_t lower = (1u << bit) - 1, first = x[i] ^ (lower & (0u - (x[i] >> bit & 1u)));
            co_hilbert_turn(&first, &y[i], bit);
            co_hilbert_turn(&first, &z[i], bit);
            x[i] = first;
        }
    for (uint32_t i = 0; i < CO_HILBERT_CELLS; i++) {
        uint32_t second = y[i] ^ x[i], third = z[i] ^ second, parity = co_hilbert_parity(third);
        keys[i] = co_hilbert_spread3(x[i] ^ parity) << 2 |
                  co_hilbert_spread3(second ^ parity) << 1 | co_hilbert_spread3(third ^ parity);
    }
}

#endif
