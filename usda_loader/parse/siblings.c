#include "parse/siblings.h"

#include "base/parallel.h"

#include <string.h>

enum {
    LEAST_BYTES = 8 * CO_CUT_BYTES,   // of text that is worth dividing
    FIRST_WINDOW = 32 * CO_CUT_BYTES, // text looked at first, for each thread
    WINDOW_GROWTH = 4,                // the next one, when that was divided:
    MOST_GROWTH = 16,                 // threads wait for each other at the end of each
    SHARES = 8,                       // a range longer than a thread's share of a window by this,
    LONG_RANGE = 16 * CO_CUT_BYTES,   // and than this, is gone into and divided below
    MOST_DEPTH = 16                   // of prims that are looked beside
};

// What one thread reads into.
typedef struct Reader {
    CoParser parser;
    CoLayer layer; // of which only the path and the arena are used
} Reader;

typedef struct Range {
    CoCut from, to;
    CoSpec **prims; // those that stand in it, if it is good
    uint32_t count;
    uint64_t prim_count; // with all below them
    bool is_good;
} Range;

struct CoSiblings {
    Reader *readers;
    uint32_t reader_count;
    CoCuts cuts;
    // Ranges read ahead, in the order of the text, those before `next` dealt with.
    Range *ranges;
    size_t next, count, capacity;
    const CoSpec *parent;
    const CoParser *parser; // that stands at the first of them
    size_t window;
    // Nothing is gained by another look before this place, except deeper down.
    const char *looked;
    uint64_t looked_depth;
};

CoSiblings *co_siblings_create(const CoParser *p)
{
    uint32_t workers = co_worker_count();
    if (workers < 2 || co_in_parallel() || p->scan.end - p->scan.at < LEAST_BYTES)
        return NULL;
    CoSiblings *s = co_alloc_zero(CO_MEMORY_USDA, sizeof *s);
    if (!s)
        return NULL;
    s->reader_count = workers;
    s->window = (size_t)FIRST_WINDOW * workers;
    s->looked = p->scan.begin;
    return s;
}

static void drop_range(Range *range)
{
    co_free(CO_MEMORY_USDA, range->prims, range->count * sizeof *range->prims);
    *range = (Range){0};
}

void co_siblings_destroy(CoSiblings *s, CoParser *p)
{
    if (!s)
        return;
    for (; s->next < s->count; s->next++)
        drop_range(&s->ranges[s->next]);
    for (uint32_t i = 0; s->readers && i < s->reader_count; i++) {
        co_arena_adopt(&p->layer->arena, &s->readers[i].layer.arena);
        co_parse_buffers_free(&s->readers[i].parser);
    }
    co_free(CO_MEMORY_USDA, s->readers, s->reader_count * sizeof *s->readers);
    co_free(CO_MEMORY_USDA, s->ranges, s->capacity * sizeof *s->ranges);
    co_free(CO_MEMORY_USDA, s->cuts.cuts, s->cuts.capacity * sizeof *s->cuts.cuts);
    co_free(CO_MEMORY_USDA, s, sizeof *s);
}

// ---- Reading -----------------------------------------------------------------------------------

// Stops at the first error and tells nobody.
static void begin_reader(Reader *reader, const CoParser *p)
{
    reader->layer.path = p->layer->path;
    reader->layer.arena.tag = CO_MEMORY_USDA;
    CoParser *own = &reader->parser;
    own->layer = &reader->layer;
    own->max_depth = p->max_depth;
    own->max_array_length = p->max_array_length;
    own->max_prims = p->max_prims;
    own->max_edit_size = p->max_edit_size;
    own->max_errors = 1;
    own->stop = p->stop;
    own->empty = p->empty;
}

// As the one loop would stand at the beginning of the range.
static bool go_to(CoParser *own, const Range *range, const CoParser *p)
{
    co_scan_init(&own->scan, range->from.at, (size_t)(range->to.at - range->from.at));
    own->scan.line = range->from.line;
    own->line_at = NULL;
    own->field_spec = NULL;
    own->depth = p->depth;
    own->prim_count = 0;
    own->error_count = 0;
    own->stopped = false;
    return co_parse_set_prim_path(own, p->prim_path, p->prim_path_length);
}

static void read_range(Reader *reader, Range *range, const CoSiblings *s)
{
    CoParser *own = &reader->parser;
    CoContents contents = {0};
    CoSpec parent = {.name = s->parent->name, .kind = s->parent->kind, .contents = &contents};
    bool good = go_to(own, range, s->parser) && co_parse_prims(own, &parent);
    if (good && contents.child_count) {
        size_t bytes = contents.child_count * sizeof *range->prims;
        range->prims = co_alloc(CO_MEMORY_USDA, bytes);
        if (range->prims)
            memcpy(range->prims, contents.children, bytes);
    }
    range->is_good = range->prims != NULL;
    range->count = range->is_good ? contents.child_count : 0;
    range->prim_count = own->prim_count;
    co_parse_children_free(own, &contents);
}

static void read_ranges(void *context, size_t begin, size_t end, uint32_t worker)
{
    const CoSiblings *s = context;
    Reader *reader = &s->readers[worker];
    if (!reader->parser.layer)
        begin_reader(reader, s->parser);
    for (size_t i = begin; i < end; i++)
        read_range(reader, &s->ranges[i], s);
}

// Ranges between cuts, up to the first that is too long for one thread.
static bool make_ranges(CoSiblings *s)
{
    size_t most = s->cuts.count, longest = s->window / s->reader_count / SHARES;
    longest = longest > LONG_RANGE ? longest : LONG_RANGE;
    if (most > s->capacity) {
        Range *grown = co_realloc(CO_MEMORY_USDA, s->ranges, s->capacity * sizeof *grown,
                                  most * sizeof *grown);
        if (!grown)
            return false;
        s->ranges = grown;
        s->capacity = most;
    }
    s->next = s->count = 0;
    const CoCut *cut = s->cuts.cuts;
    while (s->count + 1 < most && (size_t)(cut[1].at - cut[0].at) <= longest) {
        s->ranges[s->count++] = (Range){.from = cut[0], .to = cut[1]};
        cut++;
    }
    return true;
}

static bool is_worth_a_look(const CoSiblings *s, const CoParser *p)
{
    const char *at = p->scan.at;
    if (s->next < s->count || p->depth > MOST_DEPTH || p->scan.end - at < LEAST_BYTES)
        return false;
    return (at >= s->looked || p->depth > s->looked_depth) && co_prim_begins(&p->scan);
}

// Reads ahead from the prim at the cursor. Without memory nothing is read ahead.
static void read_ahead(CoSiblings *s, CoParser *p, const CoSpec *parent)
{
    size_t left = (size_t)(p->scan.end - p->scan.at);
    const char *stop = p->scan.at + (left < s->window ? left : s->window);
    CoCut here = {p->scan.at, co_parse_line(p, p->scan.at)};
    s->looked = stop;
    s->looked_depth = p->depth;
    if (!s->readers)
        s->readers = co_alloc_zero(CO_MEMORY_USDA, s->reader_count * sizeof *s->readers);
    if (!s->readers || !co_cuts_find(&s->cuts, here, stop) || !make_ranges(s))
        return;
    bool all = s->count + 1 == s->cuts.count;
    if (s->count < 2) {
        s->looked = all ? s->cuts.looked : s->cuts.cuts[s->count + 1].at;
        s->window = (size_t)FIRST_WINDOW * s->reader_count;
        s->count = 0;
        return;
    }
    s->looked = all && s->cuts.is_closed ? s->cuts.looked : s->ranges[s->count - 1].to.at;
    if (!s->cuts.is_closed && s->window < (size_t)FIRST_WINDOW * MOST_GROWTH * s->reader_count)
        s->window *= WINDOW_GROWTH;
    s->parent = parent;
    s->parser = p;
    co_parallel_for(s->count, 1, read_ranges, s);
}

// ---- Taking ------------------------------------------------------------------------------------

// What was read is what the one loop would read next: it stands at the same place, below the same
// parent, and no limit or name is in the way.
static bool take_range(const Range *range, const CoSiblings *s, CoParser *p, CoSpec *parent)
{
    if (!range->is_good || range->from.at != p->scan.at || parent != s->parent ||
        range->prim_count > p->max_prims - p->prim_count ||
        !co_parse_adopt(p, parent, range->prims, range->count))
        return false;
    p->prim_count += range->prim_count;
    p->scan.at = range->to.at;
    co_scan_count_lines(&p->scan, range->to.at, range->to.line - p->scan.line);
    return true;
}

bool co_parse_siblings(CoParser *p, CoSpec *parent)
{
    CoSiblings *s = p->siblings;
    bool any = false;
    if (!s)
        return false;
    if (is_worth_a_look(s, p))
        read_ahead(s, p, parent);
    while (s->next < s->count && s->ranges[s->next].from.at <= p->scan.at) {
        Range *range = &s->ranges[s->next++];
        any |= take_range(range, s, p, parent);
        drop_range(range);
    }
    return any;
}
