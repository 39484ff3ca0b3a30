#include "support/same_for_threads.h"

#include "support/same_layer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    HEARD_BYTES = 64 << 10 // of a hundred errors
};

typedef struct Parse {
    CoLayer *layer;
    CohortError err;
    size_t length;
    char heard[HEARD_BYTES];
} Parse;

static void hear(void *cookie, CohortSeverity severity, const char *file, uint32_t line,
                 uint32_t column, const char *prim_path, const char *text)
{
    Parse *parse = cookie;
    size_t room = sizeof parse->heard - parse->length;
    int length = snprintf(parse->heard + parse->length, room, "%d %s:%u:%u: <%s> %s\n",
                          (int)severity, file, line, column, prim_path, text);
    if (length < 0 || (size_t)length >= room)
        abort();
    parse->length += (size_t)length;
}

static Parse *parse_with(const char *text, size_t size, const CohortStageOptions *options,
                         uint32_t threads)
{
    static const CohortStageOptions none = {0};
    CohortStageOptions own = options ? *options : none;
    Parse *parse = calloc(1, sizeof *parse);
    if (!parse)
        abort();
    own.threads = threads;
    parse->layer = co_layer_parse("same.usda", text, size, &own, hear, parse, &parse->err);
    return parse;
}

static void end(Parse *parse)
{
    co_layer_destroy(parse->layer);
    free(parse);
}

static bool same_error(const CohortError *a, const CohortError *b)
{
    return a->code == b->code && a->line == b->line && a->column == b->column &&
           !strcmp(a->message, b->message) && !strcmp(a->file, b->file) &&
           !strcmp(a->prim_path, b->prim_path);
}

static bool same_lines(const CoSpec *a, const CoSpec *b);

static bool same_lists(CoSpec *const *a, CoSpec *const *b, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!same_lines(a[i], b[i]))
            return false;
    return true;
}

// Of two specs that are the same otherwise; their fields must also stand in the same order.
static bool same_lines(const CoSpec *a, const CoSpec *b)
{
    const CoContents *x = co_spec_contents(a), *y = co_spec_contents(b);
    for (uint32_t i = 0; i < a->field_count; i++)
        if (a->fields[i].name != b->fields[i].name || a->fields[i].line != b->fields[i].line)
            return false;
    return a->line == b->line && same_lists(x->children, y->children, x->child_count) &&
           same_lists(x->properties, y->properties, x->property_count) &&
           same_lists(x->variant_sets, y->variant_sets, x->variant_set_count);
}

// Every child must be found by its name, and be the one that stands there.
static bool finds_children(const CoSpec *spec)
{
    const CoContents *in = co_spec_contents(spec);
    for (uint32_t i = 0; i < in->child_count; i++)
        if (co_spec_child(spec, in->children[i]->name) != in->children[i] ||
            !finds_children(in->children[i]))
            return false;
    return true;
}

bool same_for_threads(const char *text, size_t size, const CohortStageOptions *options,
                      uint32_t threads)
{
    Parse *one = parse_with(text, size, options, 1);
    Parse *several = parse_with(text, size, options, threads);
    bool same = !one->layer == !several->layer && !strcmp(one->heard, several->heard) &&
                same_error(&one->err, &several->err);
    if (same && one->layer)
        same = same_layer(one->layer, several->layer) &&
               same_lines(one->layer->root, several->layer->root) &&
               finds_children(several->layer->root);
    end(one);
    end(several);
    return same;
}
