// Inherits and specializes, and the classes they imply: when a referenced asset inherits </Class>,
// the scenes that refer to it may say more about </Class> at their own level, and win.

#include "compose/indexer.h"

// The node that starts a chain of class arcs authored at one depth, and the chain's first class.
static void hierarchy_start(const CoGraph *graph, uint32_t node, uint32_t *instance,
                            uint32_t *class)
{
    uint32_t depth = co_node_depth_below_arc(graph, node);
    *instance = *class = node;
    while (co_arc_is_class(graph->nodes[*instance].link->kind) &&
           co_node_depth_below_arc(graph, *instance) == depth) {
        *class = *instance;
        *instance = graph->nodes[*instance].parent;
    }
}

// The node whose class tree, with `node` in it, is to be passed on to its parent.
uint32_t co_arc_class_start(const CoIndexer *indexer, uint32_t node)
{
    const CoGraph *graph = &indexer->graph;
    uint32_t start = node;
    while (co_arc_is_class(graph->nodes[start].link->kind)) {
        uint32_t instance, class;
        hierarchy_start(graph, start, &instance, &class);
        start = instance;
        if (co_arc_is_class(graph->nodes[instance].link->kind) &&
            co_path_has_prefix(graph->nodes[class].site->path,
                               co_node_path_at_arc(graph, instance)))
            break;
    }
    return start;
}

// The path that a node inherits under a class map. A class of a prim in a variant is looked for
// within that variant.
static const CoPath *class_path(CoIndexer *indexer, const CoPath *parent, const CoMap *map)
{
    CoPathTable *paths = &indexer->c->paths;
    const CoPath *path = co_map_to_source(paths, map, parent->prim);
    if (!path || parent->prim == parent)
        return path;
    const CoPath *variant = parent;
    while (!variant->selection)
        variant = variant->parent;
    if (!co_path_has_prefix(path, variant->prim))
        return path;
    return co_composer_need(indexer->c,
                            co_path_replace_prefix(paths, path, variant->prim, variant));
}

static uint32_t matching_child(const CoIndexer *indexer, const CoArcSpec *arc)
{
    const CoGraph *graph = &indexer->graph;
    bool under_relocate = co_indexer_node_kind(indexer, arc->parent) == CO_ARC_RELOCATE;
    for (uint32_t i = graph->nodes[arc->parent].first_child; i != CO_NO_NODE;
         i = graph->nodes[i].next_sibling) {
        const CoNode *child = &graph->nodes[i];
        if (!under_relocate) {
            if (child->site == arc->site)
                return i;
        } else if (child->link->kind == arc->kind &&
                   co_map_equal(child->link->to_parent, arc->to_parent) &&
                   co_node_depth_below_arc(graph, child->origin) ==
                       co_node_depth_below_arc(graph, arc->origin)) {
            return i;
        }
    }
    return CO_NO_NODE;
}

static uint32_t add_class(CoIndexer *indexer, CoArcSpec arc, const CoSite *same,
                          const CoSiteName *name)
{
    const CoSite *parent = indexer->graph.nodes[arc.parent].site;
    const CoPath *path = class_path(indexer, parent->path, arc.to_parent);
    if (!path)
        return CO_NO_NODE;
    arc.site = co_site(indexer->c, parent->stack, path);
    arc.namespace_depth = parent->path->depth;
    arc.root_depth = indexer->root_depth;
    arc.site->stack->arc_count++;
    uint32_t there = matching_child(indexer, &arc);
    if (there != CO_NO_NODE)
        return there;
    // A class that maps onto itself stays as a placeholder, so that it is still passed on upwards.
    CoArcOptions options = {.is_placeholder = path == parent->path || arc.site == same};
    options.skip_duplicates = !options.is_placeholder;
    options.has_ancestors = !options.is_placeholder && path->length > 1;
    // What is specialized elsewhere already is so from here as well, for those that refer to this.
    uint32_t echo = CO_NO_NODE;
    if (arc.kind == CO_ARC_SPECIALIZE && !options.is_placeholder)
        echo = co_indexer_add_echo(indexer, &arc);
    if (echo != CO_NO_NODE)
        return echo;
    return co_indexer_add_arc(indexer, &arc, options, name ? name->layer : NULL,
                              name ? name->line : 0);
}

void co_arc_inherits(CoIndexer *indexer, uint32_t node, CoArcKind kind)
{
    CoComposer *c = indexer->c;
    const CoNode *n = &indexer->graph.nodes[node];
    if (!co_node_contributes(n))
        return;
    const CoSite *site = n->site;
    const CoSiteArcs *arcs = co_site_arcs(c, n->site);
    bool inherits = kind == CO_ARC_INHERIT;
    size_t count = inherits ? arcs->inherit_count : arcs->specialize_count;
    for (size_t i = 0; i < count; i++) {
        const CoSiteName *name = inherits ? &arcs->inherits[i] : &arcs->specializes[i];
        bool malformed;
        size_t length = 0;
        while (name->text[length])
            length++;
        const CoPath *path =
            co_path_parse(&c->paths, name->text, length, site->path->prim, &malformed);
        if (malformed || !path || !path->parent) {
            co_composer_warn(c, COHORT_PROBLEM_INVALID_PRIM_PATH, name->layer->file, name->line,
                             co_indexer_stage_path(indexer), "<%s> is no prim to %s from",
                             name->text, inherits ? "inherit" : "specialize");
            continue;
        }
        CoArcSpec arc = {.kind = kind,
                         .parent = node,
                         .origin = node,
                         .to_parent = co_indexer_arc_map(indexer, node, path, true, 0, 1),
                         .sibling = (int)i};
        add_class(indexer, arc, NULL, name);
    }
}

// ---- Implied classes ----------------------------------------------------------------------------
static const CoMap *implied_map(CoIndexer *indexer, const CoMap *transfer, const CoMap *class)
{
    CoComposer *c = indexer->c;
    CoPathTable *paths = &c->paths;
    if (co_map_is_identity(transfer))
        return class;
    const CoMap *map = co_composer_need(c, co_map_inverse(paths, transfer));
    map = co_composer_need(c, co_map_compose(paths, class, map));
    map = co_composer_need(c, co_map_compose(paths, transfer, map));
    return co_composer_need(c, co_map_with_root(paths, map));
}

static uint32_t implied_already(const CoGraph *graph, uint32_t dest, uint32_t source,
                                const CoMap *map)
{
    for (uint32_t i = graph->nodes[dest].first_child; i != CO_NO_NODE;
         i = graph->nodes[i].next_sibling)
        if (graph->nodes[i].origin == source && co_map_equal(graph->nodes[i].link->to_parent, map))
            return i;
    return CO_NO_NODE;
}

static void imply_tree(CoIndexer *indexer, uint32_t dest, uint32_t source, const CoMap *transfer,
                       bool is_start);

static void imply_child(CoIndexer *indexer, uint32_t dest, uint32_t child, const CoMap *transfer)
{
    CoComposer *c = indexer->c;
    const CoLink *link = indexer->graph.nodes[child].link;
    // A class whose name means something else at the destination, or nothing, says nothing there.
    if (!co_map_to_target(&c->paths, transfer, indexer->graph.nodes[child].site->path->prim))
        return;
    const CoMap *map = implied_map(indexer, transfer, link->to_parent);
    uint32_t made = implied_already(&indexer->graph, dest, child, map);
    if (made == CO_NO_NODE) {
        CoArcSpec arc = {.kind = link->kind,
                         .parent = dest,
                         .origin = child,
                         .to_parent = map,
                         .sibling = link->sibling};
        made = add_class(indexer, arc, indexer->graph.nodes[child].site, NULL);
    }
    if (made == CO_NO_NODE || !co_node_has_class_child(&indexer->graph, child))
        return;
    const CoMap *inner = co_composer_need(c, co_map_compose(&c->paths, transfer, link->to_parent));
    const CoMap *down = co_composer_need(c, co_map_inverse(&c->paths, map));
    imply_tree(indexer, made, child, co_composer_need(c, co_map_compose(&c->paths, down, inner)),
               false);
}

static void imply_tree(CoIndexer *indexer, uint32_t dest, uint32_t source, const CoMap *transfer,
                       bool is_start)
{
    CoComposer *c = indexer->c;
    const CoNode *to = &indexer->graph.nodes[dest];
    if (to->link->kind == CO_ARC_RELOCATE && to->parent != CO_NO_NODE) {
        // A relocate only stands between: the classes go straight to its parent.
        const CoMap *up = co_composer_need(c, co_map_with_root(&c->paths, to->link->to_parent));
        up = co_composer_need(c, co_map_compose(&c->paths, up, transfer));
        imply_tree(indexer, to->parent, source, up, is_start);
        co_indexer_add_task(indexer, (CoTask){.kind = CO_TASK_IMPLIED_CLASSES, .node = dest});
        return;
    }
    uint32_t count = 0;
    uint32_t *children = co_composer_scratch(c, indexer->graph.count, sizeof *children);
    for (uint32_t i = indexer->graph.nodes[source].first_child; i != CO_NO_NODE;
         i = indexer->graph.nodes[i].next_sibling)
        children[count++] = i;
    bool source_is_class = co_arc_is_class(indexer->graph.nodes[source].link->kind);
    for (uint32_t i = 0; i < count; i++) {
        if (!co_arc_is_class(indexer->graph.nodes[children[i]].link->kind))
            continue;
        // dest inherits source, which inherits the child: a chain that is not dest's own to imply.
        if (is_start && source_is_class &&
            co_node_depth_below_arc(&indexer->graph, source) ==
                co_node_depth_below_arc(&indexer->graph, children[i]))
            continue;
        imply_child(indexer, dest, children[i], transfer);
    }
}

void co_arc_implied_classes(CoIndexer *indexer, uint32_t node)
{
    const CoNode *n = &indexer->graph.nodes[node];
    if (n->parent == CO_NO_NODE || !co_node_has_class_child(&indexer->graph, node))
        return;
    const CoMap *transfer = co_map_with_root(&indexer->c->paths, n->link->to_parent);
    imply_tree(indexer, n->parent, node, co_composer_need(indexer->c, transfer), true);
}
