// Where the prims beside one begin, as far as braces tell. Strings and comments are not looked at:
// what is wrong because of them is found out when the text is read.

#include "base/parallel.h"
#include "parse/siblings.h"

#include <string.h>

enum {
    GRAIN = 64 // blocks that are sooner looked at than given to another thread
};

// A piece of the text. Depths are those of braces, 0 where the search began.
typedef struct Block {
    size_t lines;        // line ends in it
    int64_t change, low; // of the depth, from before it to behind it, and to its lowest
    int64_t depth;       // before it
    uint32_t line;       // at its first character
    CoCut cut;           // the first prim at depth 0 that begins here, or NULL
    const char *closing; // the brace that leads below depth 0, or NULL
} Block;

typedef struct Search {
    const char *begin, *stop;
    Block *blocks;
} Search;

// ---- Counting ----------------------------------------------------------------------------------

typedef signed char Lanes __attribute__((vector_size(16)));
typedef uint64_t Words __attribute__((vector_size(16)));

static size_t add_lanes(Lanes lanes)
{
    size_t sum = 0;
    for (size_t i = 0; i < sizeof lanes; i++)
        sum += (size_t)lanes[i];
    return sum;
}

static void count_braces(Block *block, const char *at, size_t size)
{
    for (size_t i = 0; i < size; i++) {
        block->change += (at[i] == '{') - (at[i] == '}');
        block->low = block->change < block->low ? block->change : block->low;
    }
}

static const char *block_end(const Search *search, size_t i)
{
    const char *text = search->begin + i * CO_CUT_BYTES;
    return (size_t)(search->stop - text) > CO_CUT_BYTES ? text + CO_CUT_BYTES : search->stop;
}

static void count_block(Block *block, const char *at, const char *stop)
{
    const Lanes zero = {0}, line_ends = zero + '\n', opens = zero + '{', closes = zero + '}';
    while ((size_t)(stop - at) >= sizeof zero) {
        Lanes sums = zero;
        // What is equal is -1, so that 127 steps fit.
        for (int i = 0; i < 127 && (size_t)(stop - at) >= sizeof zero; i++, at += sizeof zero) {
            Lanes bytes;
            memcpy(&bytes, at, sizeof bytes);
            sums -= bytes == line_ends;
            Words braces = (Words)((bytes == opens) | (bytes == closes));
            if (braces[0] | braces[1])
                count_braces(block, at, sizeof bytes);
        }
        block->lines += add_lanes(sums);
    }
    count_braces(block, at, (size_t)(stop - at));
    for (; at < stop; at++)
        block->lines += *at == '\n';
}

static void count_blocks(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Search *search = context;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        search->blocks[i] = (Block){0};
        count_block(&search->blocks[i], search->begin + i * CO_CUT_BYTES, block_end(search, i));
    }
}

// ---- Finding -----------------------------------------------------------------------------------

// The prim that begins the line, or NULL.
static const char *prim_on_line(const char *at, const char *stop)
{
    static const char *const words[] = {"def", "over", "class"};
    while (at < stop && (*at == ' ' || *at == '\t'))
        at++;
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        size_t length = strlen(words[i]);
        if ((size_t)(stop - at) > length && memcmp(at, words[i], length) == 0 &&
            (at[length] == ' ' || at[length] == '\t'))
            return at;
    }
    return NULL;
}

// The line's end belongs to the block, what follows may stand behind it.
static void find_in_block(Block *block, const char *at, const char *stop, const char *end)
{
    int64_t depth = block->depth;
    uint32_t line = block->line;
    for (; at < stop; at++) {
        depth += (*at == '{') - (*at == '}');
        line += *at == '\n';
        if (depth < 0) {
            block->closing = at;
            return;
        }
        if (*at != '\n' || depth || block->cut.at)
            continue;
        block->cut = (CoCut){prim_on_line(at + 1, end), line};
        // Only the block in which the parent ends is looked at to its end.
        if (block->cut.at && block->depth + block->low >= 0)
            return;
    }
}

static void find_in_blocks(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Search *search = context;
    (void)worker;
    for (size_t i = begin; i < end; i++)
        if (search->blocks[i].depth + search->blocks[i].low <= 0)
            find_in_block(&search->blocks[i], search->begin + i * CO_CUT_BYTES,
                          block_end(search, i), search->stop);
}

// Says of each block at which depth and line it begins. Returns how many there are up to the
// parent's end.
static size_t place_blocks(Search *search, size_t count, uint32_t line)
{
    int64_t depth = 0;
    for (size_t i = 0; i < count; i++) {
        Block *block = &search->blocks[i];
        block->depth = depth;
        block->line = line;
        if (depth + block->low < 0)
            return i + 1;
        depth += block->change;
        line += (uint32_t)block->lines;
    }
    return count;
}

static bool collect(CoCuts *out, CoCut from, const Search *search, size_t count)
{
    if (out->capacity < count + 1) {
        CoCut *grown = co_realloc(CO_MEMORY_USDA, out->cuts, out->capacity * sizeof *grown,
                                  (count + 1) * sizeof *grown);
        if (!grown)
            return false;
        out->cuts = grown;
        out->capacity = count + 1;
    }
    out->cuts[out->count++] = from;
    for (size_t i = 0; i < count; i++)
        if (search->blocks[i].cut.at)
            out->cuts[out->count++] = search->blocks[i].cut;
    return true;
}

bool co_cuts_find(CoCuts *out, CoCut from, const char *stop)
{
    size_t count = ((size_t)(stop - from.at) + CO_CUT_BYTES - 1) / CO_CUT_BYTES;
    Search search = {from.at, stop, co_alloc(CO_MEMORY_USDA, count * sizeof(Block))};
    out->count = 0;
    out->looked = stop;
    out->is_closed = false;
    bool good = search.blocks != NULL;
    if (good) {
        co_parallel_for(count, GRAIN, count_blocks, &search);
        size_t used = place_blocks(&search, count, from.line);
        co_parallel_for(used, GRAIN, find_in_blocks, &search);
        good = collect(out, from, &search, used);
        if (search.blocks[used - 1].closing)
            out->looked = search.blocks[used - 1].closing;
        out->is_closed = search.blocks[used - 1].closing != NULL;
    }
    co_free(CO_MEMORY_USDA, search.blocks, count * sizeof(Block));
    return good;
}
