// Long lists of plain numbers, by several threads. The text up to the closing bracket is taken in
// blocks of a fixed size. Elements are counted by what each has one of, the parenthesis before it
// or the comma behind it, and belong to the block in which that stands; this gives the size of the
// array and where the elements of each block begin and go. As long as each block ends where the
// next begins, one loop over the text would have read the same; the first that does not says where
// that loop had stopped.

#include "base/parallel.h"
#include "base/stop.h"
#include "parse/array.h"

#include <stdatomic.h>
#include <string.h>

enum {
    BLOCK_BYTES = 1 << 16,
    FIRST_WAVE = 32, // blocks looked at before it is known where the list ends
    WAVE_GROWTH = 4, // the next wave, in all blocks so far
    GRAINS = 32,     // pieces of the work, at least, for even shares
    MOST_GRAIN = 8   // blocks in one
};

typedef struct Block {
    const char *text;       // where the block begins
    const char *closing;    // its first ']', or NULL
    const char *mark_at;    // its first parenthesis or last comma
    size_t lines, expected; // line ends and elements in it
    const char *from;       // its first element
    size_t first;           // elements before it
    const char *at;         // where reading ended
    size_t count;           // elements read
} Block;

typedef struct Bulk {
    const CoParser *parser;
    const CoArray *array;
    const char *begin, *stop; // all of the list, or as much as is known
    char mark;                // that each element has one of
    Block *blocks;
    size_t block_count, capacity;
    _Atomic size_t closing_block; // the first known to hold the end; those behind it are left alone
    atomic_bool is_cut;           // the host wants no more: blocks may be left undone
} Bulk;

static bool is_cut(Bulk *bulk)
{
    if (co_is_stopped(bulk->parser->stop))
        atomic_store(&bulk->is_cut, true);
    return atomic_load_explicit(&bulk->is_cut, memory_order_relaxed);
}

// ---- Counting ----------------------------------------------------------------------------------

typedef signed char Lanes __attribute__((vector_size(16)));

typedef struct Counts {
    size_t marks, lines;
    bool closes; // there may be a ']'
} Counts;

static size_t add_lanes(Lanes lanes)
{
    size_t sum = 0;
    for (size_t i = 0; i < sizeof lanes; i++)
        sum += (size_t)lanes[i];
    return sum;
}

static Counts count_bytes(const char *at, const char *stop, char mark)
{
    const Lanes zero = {0}, marks = zero + (signed char)mark;
    const Lanes lines = zero + '\n', closings = zero + ']';
    Counts out = {0};
    Lanes closed = zero;
    while ((size_t)(stop - at) >= sizeof zero) {
        Lanes mark_sums = zero, line_sums = zero;
        // What is equal is -1, so that 127 steps fit.
        for (int i = 0; i < 127 && (size_t)(stop - at) >= sizeof zero; i++, at += sizeof zero) {
            Lanes bytes;
            memcpy(&bytes, at, sizeof bytes);
            mark_sums -= bytes == marks;
            line_sums -= bytes == lines;
            closed |= bytes == closings;
        }
        out.marks += add_lanes(mark_sums);
        out.lines += add_lanes(line_sums);
    }
    out.closes = add_lanes(closed) != 0;
    for (; at < stop; at++) {
        out.marks += *at == mark;
        out.lines += *at == '\n';
        out.closes |= *at == ']';
    }
    return out;
}

static const char *last_of(const char *at, const char *stop, char c)
{
    while (stop > at && stop[-1] != c)
        stop--;
    return stop - 1;
}

static void closes_at(Bulk *bulk, size_t block)
{
    size_t known = atomic_load(&bulk->closing_block);
    while (block < known && !atomic_compare_exchange_weak(&bulk->closing_block, &known, block))
        ;
}

// Of those behind the `block_count` that are done already.
static void count_blocks(void *context, size_t begin, size_t end, uint32_t worker)
{
    Bulk *bulk = context;
    (void)worker;
    for (size_t i = bulk->block_count + begin; i < bulk->block_count + end; i++) {
        if (i > atomic_load_explicit(&bulk->closing_block, memory_order_relaxed) || is_cut(bulk))
            return;
        Block *block = &bulk->blocks[i];
        const char *text = bulk->begin + i * BLOCK_BYTES;
        const char *stop =
            (size_t)(bulk->stop - text) > BLOCK_BYTES ? text + BLOCK_BYTES : bulk->stop;
        Counts counts = count_bytes(text, stop, bulk->mark);
        *block = (Block){.text = text};
        if (counts.closes) {
            stop = block->closing = memchr(text, ']', (size_t)(stop - text));
            counts = count_bytes(text, stop, bulk->mark);
            closes_at(bulk, i);
        }
        block->lines = counts.lines;
        block->expected = counts.marks;
        if (counts.marks)
            block->mark_at = bulk->mark == '(' ? memchr(text, '(', (size_t)(stop - text))
                                               : last_of(text, stop, ',');
    }
}

// Counts block after block up to the one that ends the list.
static bool find_end(CoParser *p, Bulk *bulk)
{
    size_t all = (size_t)(bulk->stop - bulk->begin + BLOCK_BYTES - 1) / BLOCK_BYTES;
    while (bulk->block_count < all) {
        size_t count = bulk->block_count ? WAVE_GROWTH * bulk->block_count : FIRST_WAVE;
        count = count < all - bulk->block_count ? count : all - bulk->block_count;
        size_t capacity = bulk->block_count + count;
        Block *blocks =
            co_realloc(CO_MEMORY_USDA, bulk->blocks, bulk->capacity * sizeof *bulk->blocks,
                       capacity * sizeof *bulk->blocks);
        if (!blocks)
            return co_parse_stop(p, p->scan.at, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
        bulk->blocks = blocks;
        bulk->capacity = capacity;
        co_parallel_for(count, 2, count_blocks, bulk);
        if (atomic_load(&bulk->is_cut))
            return co_parse_give_up(p);
        size_t closing = atomic_load(&bulk->closing_block);
        if (closing < capacity) {
            bulk->block_count = closing + 1;
            bulk->stop = bulk->blocks[closing].closing;
            return true;
        }
        bulk->block_count = capacity;
    }
    return true;
}

// ---- Reading -----------------------------------------------------------------------------------

// Says of each block where its elements begin and go. Returns how many there are, SIZE_MAX when so
// many cannot stand in so little text.
static size_t place_elements(Bulk *bulk)
{
    size_t total = 0;
    const char *from = bulk->begin;
    for (size_t i = 0; i < bulk->block_count; i++) {
        Block *block = &bulk->blocks[i];
        block->first = total;
        total += block->expected;
        if (!block->expected)
            continue;
        block->from = bulk->mark == '(' ? block->mark_at : from;
        if (bulk->mark == ',')
            for (from = block->mark_at + 1;
                 *from == ' ' || *from == '\n' || *from == '\t' || *from == '\r';)
                from++;
    }
    size_t least = 2 * (size_t)co_type_width(bulk->array->info) + (bulk->mark == '(');
    return total > (size_t)(bulk->stop - bulk->begin) / least + 1 ? SIZE_MAX : total;
}

static void read_blocks(void *context, size_t begin, size_t end, uint32_t worker)
{
    Bulk *bulk = context;
    const CoArray *array = bulk->array;
    const CoParser *p = bulk->parser;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        Block *block = &bulk->blocks[i];
        if (is_cut(bulk))
            return;
        if (!block->expected)
            continue;
        CoPlainRun run = {block->from, p->scan.safe, array->data + block->first * array->element,
                          block->expected, 0};
        co_plain_read(array->info, p->scan.safe, &run);
        block->at = run.at;
        block->count = run.count;
    }
}

// How far one loop over the text would have come.
static void take(CoParser *p, CoArray *array, const Bulk *bulk)
{
    size_t lines = 0;
    const char *counted = bulk->begin;
    uint32_t line, column;
    co_scan_place(&p->scan, counted, &line, &column);
    for (size_t i = 0; i < bulk->block_count; i++) {
        const Block *block = &bulk->blocks[i];
        if (block->expected && block->from != p->scan.at)
            break;
        counted = block->text;
        if (block->expected) {
            array->count = block->first + block->count;
            p->scan.at = block->at;
            if (block->count != block->expected)
                break;
        }
        lines += block->lines;
        counted = i + 1 < bulk->block_count ? bulk->blocks[i + 1].text : bulk->stop;
    }
    co_scan_count_lines(&p->scan, counted, (uint32_t)lines);
}

static bool read_all(CoParser *p, CoArray *array, Bulk *bulk)
{
    size_t total = place_elements(bulk);
    // A list too long, or no list: the general reader says so, in its place.
    if (total >= p->max_array_length)
        return true;
    // The last element of scalars has no comma; what the end of the text leaves to others follows.
    size_t capacity = total + 1;
    if (bulk->stop == p->scan.safe)
        capacity += (size_t)(p->scan.end - p->scan.safe);
    array->data = co_arena_bytes(&p->layer->arena, capacity * array->element, 64);
    if (!array->data)
        return co_parse_stop(p, p->scan.at, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    array->capacity = capacity;
    array->is_final = true;
    size_t grain = bulk->block_count / GRAINS;
    grain = grain < 1 ? 1 : grain > MOST_GRAIN ? MOST_GRAIN : grain;
    co_parallel_for(bulk->block_count, grain, read_blocks, bulk);
    if (atomic_load(&bulk->is_cut))
        return co_parse_give_up(p);
    take(p, array, bulk);
    return true;
}

bool co_parse_bulk(CoParser *p, CoArray *array)
{
    const char *at = p->scan.at;
    if (array->count || array->is_final || at < array->bulk_end || at + BLOCK_BYTES > p->scan.safe)
        return true;
    const char *closing = memchr(at, ']', BLOCK_BYTES);
    array->bulk_end = closing;
    if (closing)
        return true;
    Bulk bulk = {.parser = p,
                 .array = array,
                 .begin = at,
                 .stop = p->scan.safe,
                 .mark = array->info->columns ? '(' : ',',
                 .closing_block = SIZE_MAX};
    bool good = find_end(p, &bulk);
    array->bulk_end = bulk.stop;
    good = good && read_all(p, array, &bulk);
    co_free(CO_MEMORY_USDA, bulk.blocks, bulk.capacity * sizeof *bulk.blocks);
    return good;
}
