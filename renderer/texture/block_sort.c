#include "texture/block_sort.h"

#include "base/memory.h"
#include "base/parallel.h"

#include <string.h>

#define DIGIT_BITS 11
#define DIGITS (1u << DIGIT_BITS)
#define PART 65536 // entries per part: a part counts and scatters for itself

typedef struct Pass {
    const CoBlockEntry *from;
    CoBlockEntry *to;
    size_t count;
    uint32_t shift;
    size_t (*places)[DIGITS]; // [parts]: counts, then where the part's next entry of a digit goes
} Pass;

static uint32_t digit_of(const Pass *pass, size_t i)
{
    return (uint32_t)(pass->from[i].key >> pass->shift) & (DIGITS - 1);
}

static size_t part_end(const Pass *pass, size_t part)
{
    return pass->count - part * PART < PART ? pass->count : (part + 1) * PART;
}

static void count_parts(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    Pass *pass = context;
    for (size_t part = begin; part < end; part++) {
        memset(pass->places[part], 0, sizeof pass->places[part]);
        for (size_t i = part * PART; i < part_end(pass, part); i++)
            pass->places[part][digit_of(pass, i)]++;
    }
}

static void scatter_parts(void *context, size_t begin, size_t end, uint32_t worker)
{
    (void)worker;
    Pass *pass = context;
    for (size_t part = begin; part < end; part++)
        for (size_t i = part * PART; i < part_end(pass, part); i++)
            pass->to[pass->places[part][digit_of(pass, i)]++] = pass->from[i];
}

// Turns counts into places. False when all entries share one digit, and the pass changes nothing.
static bool place(Pass *pass, size_t parts)
{
    size_t at = 0;
    for (uint32_t digit = 0; digit < DIGITS; digit++) {
        size_t before = at;
        for (size_t part = 0; part < parts; part++) {
            size_t count = pass->places[part][digit];
            pass->places[part][digit] = at;
            at += count;
        }
        if (at - before == pass->count)
            return false;
    }
    return true;
}

CoBlockEntry *co_block_sort(CoBlockEntry *entries, CoBlockEntry *spare, size_t count)
{
    if (count < 2)
        return entries;
    size_t parts = (count - 1) / PART + 1, size = parts * sizeof(size_t[DIGITS]);
    uint64_t used = 0;
    for (size_t i = 0; i < count; i++)
        used |= entries[i].key;
    Pass pass = {.count = count, .places = co_alloc(CO_MEMORY_TEXTURE, size)};
    if (!pass.places)
        return NULL;
    for (; pass.shift < 64 && used >> pass.shift; pass.shift += DIGIT_BITS) {
        pass.from = entries;
        pass.to = spare;
        co_parallel_for(parts, 1, count_parts, &pass);
        if (!place(&pass, parts))
            continue;
        co_parallel_for(parts, 1, scatter_parts, &pass);
        spare = entries;
        entries = pass.to;
    }
    co_free(CO_MEMORY_TEXTURE, pass.places, size);
    return entries;
}
