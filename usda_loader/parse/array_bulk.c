// Long lists of plain numbers, by several threads. The text up to the closing bracket is cut into
// blocks that begin at an element; elements are counted by what each has one of (its parenthesis, or
// the comma behind it), which gives the size of the array and where each block's elements go. A block
// is good when its elements end exactly where the next begins, so good blocks in a row are what one
// loop over the text would have read; the first that is not good says where that loop had stopped.

#include "base/parallel.h"
#include "parse/array.h"

#include <string.h>

enum {
    BLOCK_BYTES = 1 << 16
};

typedef struct Block {
    const char *from, *stop;
    size_t first, expected; // elements before it; in it
    size_t count;           // read
    const char *at;         // where reading ended
} Block;

typedef struct Bulk {
    const CoArray *array;
    const char *safe;
    char mark; // that each element has one of
    Block *blocks;
    size_t block_count;
} Bulk;

typedef signed char Lanes __attribute__((vector_size(16)));

// Bytes equal to `wanted`. Lanes of what is equal are -1, so 127 steps fit before they are added up.
static size_t count_bytes(const char *at, const char *stop, char wanted)
{
    const Lanes pattern = (Lanes){0} + (signed char)wanted;
    size_t count = 0;
    while ((size_t)(stop - at) >= sizeof pattern) {
        Lanes sums = {0};
        for (int i = 0; i < 127 && (size_t)(stop - at) >= sizeof sums; i++, at += sizeof sums) {
            Lanes bytes;
            memcpy(&bytes, at, sizeof bytes);
            sums -= bytes == pattern;
        }
        for (size_t i = 0; i < sizeof sums; i++)
            count += (size_t)sums[i];
    }
    for (; at < stop; at++)
        count += *at == wanted;
    return count;
}

static void count_blocks(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Bulk *bulk = context;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        Block *block = &bulk->blocks[i];
        block->expected = count_bytes(block->from, block->stop, bulk->mark);
    }
}

static void read_blocks(void *context, size_t begin, size_t end, uint32_t worker)
{
    const Bulk *bulk = context;
    const CoArray *array = bulk->array;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        Block *block = &bulk->blocks[i];
        CoPlainRun run = {block->from, block->stop, array->data + block->first * array->element,
                          block->expected, 0};
        co_plain_read(array->info, bulk->safe, &run);
        block->at = run.at;
        block->count = run.count;
    }
}

// The first element at or after a place.
static const char *next_element(const char *at, const char *stop, char mark)
{
    at = memchr(at, mark, (size_t)(stop - at));
    if (!at)
        return stop;
    if (mark == '(')
        return at;
    at++;
    while (at < stop && (*at == ' ' || *at == '\n' || *at == '\t' || *at == '\r'))
        at++;
    return at;
}

// Cuts [from, stop), whose length is above BLOCK_BYTES.
static void cut(Bulk *bulk, const char *from, const char *stop)
{
    bulk->block_count = 0;
    while (from < stop) {
        const char *next = (size_t)(stop - from) <= BLOCK_BYTES
                               ? stop
                               : next_element(from + BLOCK_BYTES, stop, bulk->mark);
        bulk->blocks[bulk->block_count++] = (Block){.from = from, .stop = next};
        from = next;
    }
}

// Elements of all blocks; SIZE_MAX when so many cannot stand in so little text.
static size_t add_up(Bulk *bulk, size_t bytes)
{
    size_t total = 0;
    for (size_t i = 0; i < bulk->block_count; i++) {
        bulk->blocks[i].first = total;
        total += bulk->blocks[i].expected;
    }
    size_t least = 2 * (size_t)co_type_width(bulk->array->info) + (bulk->mark == '(' ? 1 : 0);
    return total > bytes / least + 1 ? SIZE_MAX : total;
}

// How far one loop over the text would have come.
static void take(CoParser *p, CoArray *array, const Bulk *bulk)
{
    for (size_t i = 0; i < bulk->block_count; i++) {
        const Block *block = &bulk->blocks[i];
        array->count = block->first + block->count;
        p->scan.at = block->at;
        if (block->at != block->stop)
            return;
    }
}

static bool read_all(CoParser *p, CoArray *array, Bulk *bulk, size_t bytes)
{
    co_parallel_for(bulk->block_count, 4, count_blocks, bulk);
    size_t total = add_up(bulk, bytes);
    // A list too long, or no list: the general reader says so, in its place.
    if (total >= p->max_array_length)
        return true;
    // The last element has no comma.
    size_t capacity = total + 1;
    array->data = co_arena_bytes(&p->layer->arena, capacity * array->element, 64);
    if (!array->data)
        return co_parse_stop(p, p->scan.at, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    array->capacity = capacity;
    array->is_final = true;
    co_parallel_for(bulk->block_count, 1, read_blocks, bulk);
    take(p, array, bulk);
    return true;
}

bool co_parse_bulk(CoParser *p, CoArray *array)
{
    if (array->count || array->is_final || p->scan.at < array->bulk_end ||
        p->scan.at + BLOCK_BYTES > p->scan.safe)
        return true;
    size_t left = (size_t)(p->scan.safe - p->scan.at);
    const char *stop = memchr(p->scan.at, ']', left);
    stop = stop ? stop : p->scan.safe;
    array->bulk_end = stop;
    size_t bytes = (size_t)(stop - p->scan.at);
    if (bytes <= BLOCK_BYTES)
        return true;
    Bulk bulk = {.array = array, .safe = p->scan.safe, .mark = array->info->columns ? '(' : ','};
    size_t most = bytes / BLOCK_BYTES + 1;
    bulk.blocks = co_alloc(CO_MEMORY_USDA, most * sizeof *bulk.blocks);
    if (!bulk.blocks)
        return co_parse_stop(p, p->scan.at, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    cut(&bulk, p->scan.at, stop);
    bool good = read_all(p, array, &bulk, bytes);
    co_free(CO_MEMORY_USDA, bulk.blocks, most * sizeof *bulk.blocks);
    return good;
}
