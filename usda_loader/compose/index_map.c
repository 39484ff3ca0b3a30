// How an arc carries paths and times, with what relocates move on the way.

#include "compose/indexer.h"

// The map of an arc from a site with moves at or below it: worked out once.
typedef struct CoArcMap {
    const CoPath *source;
    double offset, scale;
    bool has_root;
    const CoMap *map;
    struct CoArcMap *next;
} CoArcMap;

// What the stack moves at or below the site, and everything else as it is.
static const CoMap *moves_below(CoComposer *c, CoSite *site)
{
    if (site->moves)
        return site->moves;
    size_t count = 0;
    CoMapPair *pairs = co_composer_scratch(c, site->stack->relocate_count + 1, sizeof *pairs);
    for (size_t i = 0; i < site->stack->relocate_count; i++) {
        const CoMove *move = &site->stack->relocates[i];
        // A move of what was itself moved in counts from where it first stood.
        const CoPath *from = co_path_has_prefix(move->origin, site->path->prim)   ? move->origin
                             : co_path_has_prefix(move->source, site->path->prim) ? move->source
                                                                                  : NULL;
        if (move->target && from)
            pairs[count++] = (CoMapPair){from, move->target};
    }
    pairs[count++] = (CoMapPair){&c->paths.root, &c->paths.root};
    CoMap *moves = co_map_pairs(&c->paths, pairs, count);
    co_composer_need(c, moves);
    moves->is_in_steps = count > 1;
    return site->moves = moves;
}

static const CoMap *map_of_arc(CoComposer *c, CoSite *site, const CoArcMap *arc, bool has_moves)
{
    const CoMap *map =
        co_map_pair(&c->paths, arc->source, site->path->prim, false, arc->offset, arc->scale);
    co_composer_need(c, map);
    if (has_moves)
        map = co_composer_need(c, co_map_compose(&c->paths, moves_below(c, site), map));
    if (!arc->has_root)
        return map;
    // Of the pairs as they stand: a map with a root goes in one step.
    CoMap *rooted = co_map_pairs(&c->paths, map->pairs, map->count);
    co_composer_need(c, rooted);
    rooted->offset = map->offset;
    rooted->scale = map->scale;
    return co_composer_need(c, co_map_with_root(&c->paths, rooted));
}

const CoMap *co_indexer_arc_map(CoIndexer *indexer, uint32_t node, const CoPath *source,
                                bool has_root, double offset, double scale)
{
    CoComposer *c = indexer->c;
    CoSite *site = indexer->graph.nodes[node].site;
    CoArcMap arc = {source, offset, scale, has_root, NULL, site->maps};
    const CoMovesAt *moves = co_stack_moves_at(site->stack, site->path->prim);
    if (!moves || !moves->is_above)
        return map_of_arc(c, site, &arc, false);
    for (const CoArcMap *known = site->maps; known; known = known->next)
        if (known->source == source && known->has_root == has_root && known->offset == offset &&
            known->scale == scale)
            return known->map;
    arc.map = map_of_arc(c, site, &arc, true);
    site->maps = co_composer_alloc(c, sizeof *site->maps);
    *site->maps = arc;
    return arc.map;
}
