// Relocates: a layer stack moves a prim that its arcs bring in. The new place shows what the old
// one would have shown; opinions that the stack itself has at the old place no longer count.

#include "compose/indexer.h"

static void silence_moved_away(CoGraph *graph, uint32_t node)
{
    for (uint32_t i = graph->nodes[node].first_child; i != CO_NO_NODE;
         i = graph->nodes[i].next_sibling) {
        if (graph->nodes[i].link->kind == CO_ARC_RELOCATE)
            continue;
        if (!graph->nodes[i].is_inert && (graph->nodes[i].site->flags & CO_SITE_MOVED_AWAY))
            co_graph_make_inert(graph, i, true);
        else
            silence_moved_away(graph, i);
    }
}

static void warn_opinions_at_source(CoIndexer *indexer, const CoSite *site)
{
    for (uint32_t i = 0; i < site->spec_count; i++)
        co_composer_warn(indexer->c, COHORT_PROBLEM_OPINION_AT_RELOCATION_SOURCE,
                         site->stack->layers[site->specs[i].layer].file, site->specs[i].spec->line,
                         co_indexer_stage_path(indexer),
                         "opinions at the source of a relocate are ignored");
}

void co_arc_relocates(CoIndexer *indexer, uint32_t node)
{
    CoComposer *c = indexer->c;
    CoGraph *graph = &indexer->graph;
    const CoNode *n = &graph->nodes[node];
    if (n->is_inert && co_node_depth_below_arc(graph, node) == 0)
        return;
    const CoMove *move = co_stack_move_to(n->site->stack, n->site->path);
    if (!move)
        return;
    // What other arcs brought to the new place is superseded.
    for (uint32_t i = n->first_child; i != CO_NO_NODE; i = graph->nodes[i].next_sibling)
        if (graph->nodes[i].link->kind != CO_ARC_VARIANT)
            co_graph_make_inert(graph, i, true);
    CoArcSpec arc = {.kind = CO_ARC_RELOCATE,
                     .parent = node,
                     .origin = node,
                     .site = co_site(c, n->site->stack, move->source),
                     .to_parent = co_composer_need(c, co_map_identity(&c->paths)),
                     .namespace_depth = n->site->path->depth,
                     .root_depth = indexer->root_depth};
    CoArcOptions options = {.is_placeholder = true, .has_ancestors = true};
    uint32_t made = co_indexer_add_arc(indexer, &arc, options, NULL, 0);
    if (made == CO_NO_NODE)
        return;
    warn_opinions_at_source(indexer, arc.site);
    silence_moved_away(graph, made);
}

void co_arc_implied_relocates(CoIndexer *indexer, uint32_t node)
{
    CoComposer *c = indexer->c;
    CoGraph *graph = &indexer->graph;
    const CoNode *n = &graph->nodes[node];
    if (n->link->kind != CO_ARC_RELOCATE || co_node_depth_below_arc(graph, node) > 0 ||
        n->parent == CO_NO_NODE)
        return;
    const CoNode *parent = &graph->nodes[n->parent];
    uint32_t above = parent->parent;
    if (above == CO_NO_NODE)
        return;
    const CoPath *source =
        co_map_to_target(&c->paths, parent->link->to_parent, n->site->path->prim);
    if (!source)
        return;
    CoSite *site = co_site(c, graph->nodes[above].site->stack, source);
    for (uint32_t i = graph->nodes[above].first_child; i != CO_NO_NODE;
         i = graph->nodes[i].next_sibling)
        if (graph->nodes[i].site == site && graph->nodes[i].link->kind == CO_ARC_RELOCATE)
            return;
    CoArcSpec arc = {.kind = CO_ARC_RELOCATE,
                     .parent = above,
                     .origin = node,
                     .site = site,
                     .to_parent = co_composer_need(c, co_map_identity(&c->paths)),
                     .namespace_depth = graph->nodes[above].site->path->depth,
                     .root_depth = indexer->root_depth};
    co_indexer_add_arc(indexer, &arc, (CoArcOptions){.is_placeholder = true}, NULL, 0);
}
