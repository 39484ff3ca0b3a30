// Integer mixing. One function per width, used wherever a value must be spread or keyed.

#ifndef CO_BASE_HASH_H
#define CO_BASE_HASH_H

#include <stddef.h>
#include <stdint.h>

// A bijection on 32 bits with good avalanche (constants found by search, after Wellons 2018).
static inline uint32_t co_hash32(uint32_t x)
{
    x ^= x >> 16;
    x *= 0x21f0aaadu;
    x ^= x >> 15;
    x *= 0xd35a2d97u;
    x ^= x >> 15;
    return x;
}

// A bijection on 64 bits (the finaliser of SplitMix64, Steele, Lea, Flood 2014).
static inline uint64_t co_hash64(uint64_t x)
{
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

static inline uint64_t co_hash_combine(uint64_t seed, uint64_t value)
{
    return co_hash64(seed ^ co_hash64(value));
}

// Hash of `size` bytes, for tables and content keys; no protection against malice.
static inline uint64_t co_hash_bytes(const void *data, size_t size, uint64_t seed)
{
    const unsigned char *p = (const unsigned char *)data;
    uint64_t h = co_hash64(seed ^ size);
    for (; size >= 8; size -= 8, p += 8) {
        uint64_t word = 0;
        for (int i = 0; i < 8; i++)
            word |= (uint64_t)p[i] << (8 * i);
        h = co_hash64(h ^ word);
    }
    uint64_t tail = 0;
    for (size_t i = 0; i < size; i++)
        tail |= (uint64_t)p[i] << (8 * i);
    return co_hash64(h ^ tail);
}

#endif
