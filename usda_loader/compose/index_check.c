// Which arcs are left out: cycles, duplicates, and more than a prim can have.

#include "compose/indexer.h"

// ---- Cycles and duplicates ---------------------------------------------------------------------
static bool is_implied_class(const CoArcSpec *arc)
{
    return co_arc_is_class(arc->kind) && arc->parent != arc->origin;
}

// Under a relocate an implied class is a placeholder that may well be the relocate's own source.
static bool is_implied_under_relocate(const CoIndexer *indexer, const CoArcSpec *arc)
{
    if (!is_implied_class(arc))
        return false;
    uint32_t node = arc->parent;
    while (co_arc_is_class(co_indexer_node_kind(indexer, node))) {
        if (node == 0) {
            node = indexer->frame->parent;
            indexer = indexer->frame->outer;
        } else {
            node = indexer->graph.nodes[node].parent;
        }
    }
    return co_indexer_node_kind(indexer, node) == CO_ARC_RELOCATE;
}

// What the outer graph will call the site once the rest of the requested path is added to it.
static const CoPath *path_in_outer(const CoIndexer *indexer, const CoPath *path)
{
    const CoPath *here = indexer->graph.nodes[0].site->path;
    const CoPath *requested = indexer->frame->requested->path;
    if (!co_path_has_prefix(requested, here))
        return path;
    return co_composer_need(indexer->c,
                            co_path_replace_prefix(&indexer->c->paths, requested, here, path));
}

// Specializes hang below the root once their own arcs are done: what comes later below them does
// not meet what led to them.
static uint32_t next_above(const CoGraph *graph, uint32_t node)
{
    return graph->nodes[node].is_apart ? 0 : graph->nodes[node].parent;
}

bool co_indexer_is_cycle(const CoIndexer *indexer, const CoArcSpec *arc)
{
    if (arc->kind == CO_ARC_VARIANT || is_implied_under_relocate(indexer, arc))
        return false;
    const CoStack *stack = arc->site->stack;
    const CoPath *path = arc->site->path;
    uint32_t node = arc->parent;
    while (true) {
        for (; node != CO_NO_NODE; node = next_above(&indexer->graph, node)) {
            const CoSite *site = indexer->graph.nodes[node].site;
            if (site->stack == stack &&
                (co_path_has_prefix(site->path, path) || co_path_has_prefix(path, site->path)))
                return true;
        }
        if (!indexer->frame)
            return false;
        path = path_in_outer(indexer, path);
        node = indexer->frame->parent;
        indexer = indexer->frame->outer;
    }
}

bool co_indexer_is_being_built(const CoIndexer *indexer, const CoSite *site)
{
    for (const CoFrame *frame = indexer->frame; frame; frame = frame->outer->frame)
        if (frame->requested == site)
            return true;
    return false;
}

bool co_indexer_is_duplicate(const CoIndexer *indexer, const CoSite *site)
{
    const CoPath *path = site->path;
    while (true) {
        for (uint32_t i = 0; i < indexer->graph.count; i++) {
            const CoNode *node = &indexer->graph.nodes[i];
            if (!node->is_inert && node->site->stack == site->stack && node->site->path == path)
                return true;
        }
        if (!indexer->frame)
            return false;
        path = path_in_outer(indexer, path);
        indexer = indexer->frame->outer;
    }
}

// ---- Explosions --------------------------------------------------------------------------------
// Arcs of one prim, as many as the reference takes; more are an explosion, each doubling the
// others. Where that happens again and again it is stopped earlier, since every prim takes its
// time.
enum {
    NODES_MAX = 32767,
    NODES_MAX_AGAIN = 1000,
    CROWDED_MAX = 2
};

static uint32_t nodes_max(const CoComposer *c)
{
    return c->crowded_count < CROWDED_MAX ? NODES_MAX : NODES_MAX_AGAIN;
}

bool co_indexer_is_crowded(const CoIndexer *indexer, const CoArcSpec *arc)
{
    uint64_t nodes = 0, depth = 0;
    uint32_t node = arc->parent;
    for (;; indexer = indexer->frame->outer) {
        nodes += indexer->graph.count;
        for (; node != CO_NO_NODE; node = indexer->graph.nodes[node].parent)
            depth++;
        if (!indexer->frame)
            return nodes >= nodes_max(indexer->c) || depth >= indexer->c->options.max_depth;
        node = indexer->frame->parent;
    }
}

void co_indexer_warn_crowded(CoIndexer *indexer, const CoStackLayer *layer, uint32_t line)
{
    CoComposer *c = indexer->c;
    const CoPath *path = co_indexer_stage_path(indexer);
    if (c->crowded == path)
        return;
    co_composer_warn(c, COHORT_PROBLEM_ARC_CAPACITY, layer ? layer->file : NULL, line, path,
                     "arcs are left out: more than %u of one prim, or %llu of each other",
                     nodes_max(c), (unsigned long long)c->options.max_depth);
    c->crowded = path;
    c->crowded_count++;
}
