// Places on Hilbert curves, as state machines over the bits of a cell (Hamilton, Rau-Chaplin 2008).
// Neighbors on the curve are neighbors in space, so that a piece of it is compact; a Morton curve
// jumps.

#ifndef CO_SORT_HILBERT_H
#define CO_SORT_HILBERT_H

#include <stdint.h>

// An entry is the place of the quadrant (low bits) and the state within it; one bit of x and y at a
// time, then two, of which the table has what two single steps come to.
static inline uint32_t co_hilbert2(uint32_t x, uint32_t y, uint32_t bits)
{
    static const uint8_t steps[4][4] = {
        {4, 15, 1, 2}, {0, 5, 11, 6}, {10, 9, 7, 12}, {14, 3, 13, 8}};
    static const uint8_t pairs[4][16] = {
        {0, 17, 62, 15, 35, 18, 61, 44, 20, 55, 24, 59, 5, 6, 9, 10},
        {16, 51, 4, 21, 1, 2, 39, 22, 46, 45, 8, 25, 31, 60, 43, 26},
        {42, 41, 38, 37, 27, 56, 23, 52, 12, 29, 50, 3, 47, 30, 49, 32},
        {58, 11, 28, 63, 57, 40, 13, 14, 54, 7, 34, 33, 53, 36, 19, 48}};
    uint32_t key = 0, state = 0;
    if (bits % 2) {
        uint32_t step = steps[0][(x >> (bits - 1) & 1) | (y >> (bits - 1) & 1) << 1];
        key = step & 3;
        state = step >> 2;
        bits--;
    }
    while (bits > 0) {
        bits -= 2;
        uint32_t step = pairs[state][(x >> bits & 3) | (y >> bits & 3) << 2];
        key = key << 4 | (step & 15);
        state = step >> 4;
    }
    return key;
}

// An entry is the place of the octant (low 3 bits) and the state within it; bits at most 10.
static inline uint32_t co_hilbert3(uint32_t x, uint32_t y, uint32_t z, uint32_t bits)
{
    static const uint8_t steps[12][8] = {
        {8, 23, 25, 38, 43, 44, 26, 37},  {24, 51, 63, 52, 1, 2, 70, 69},
        {76, 39, 75, 80, 5, 6, 66, 65},   {0, 9, 83, 10, 95, 78, 84, 77},
        {22, 7, 21, 60, 49, 88, 50, 59},  {58, 85, 3, 4, 57, 86, 72, 55},
        {90, 89, 45, 46, 11, 32, 12, 87}, {36, 13, 71, 14, 35, 74, 40, 73},
        {62, 81, 15, 16, 61, 82, 92, 91}, {94, 93, 41, 42, 31, 20, 56, 19},
        {18, 27, 17, 64, 53, 28, 54, 47}, {68, 67, 29, 34, 79, 48, 30, 33}};
    uint32_t key = 0, state = 0;
    while (bits-- > 0) {
        uint32_t octant = (x >> bits & 1) | (y >> bits & 1) << 1 | (z >> bits & 1) << 2;
        uint32_t step = steps[state][octant];
        key = key << 3 | (step & 7);
        state = step >> 3;
    }
    return key;
}

#endif
