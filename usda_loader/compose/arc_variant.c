// Variants: what is selected anywhere in the index decides which variant's opinions join in.

#include "compose/indexer.h"

#include <string.h>

static bool may_speak_at(const CoNode *node, const CoPath *path)
{
    return node->restricted == 0 || node->restricted > path->length;
}

static void add_sets_at(CoIndexer *indexer, uint32_t node, const CoPath *path, bool ancestral)
{
    CoComposer *c = indexer->c;
    CoSite *site = co_site(c, indexer->graph.nodes[node].site->stack, path);
    if (!(site->flags & CO_SITE_VARIANT_SETS))
        return;
    const CoSiteArcs *arcs = co_site_arcs(c, site);
    for (size_t i = 0; i < arcs->variant_set_count; i++)
        co_indexer_add_task(indexer,
                            (CoTask){ancestral ? CO_TASK_ANCESTRAL_VARIANT : CO_TASK_VARIANT, node,
                                     path, arcs->variant_sets[i].text, (int)i});
}

void co_arc_variant_sets(CoIndexer *indexer, uint32_t node, bool ancestral)
{
    const CoNode *n = &indexer->graph.nodes[node];
    if (!ancestral) {
        if (co_node_contributes(n))
            add_sets_at(indexer, node, n->site->path, false);
        return;
    }
    for (const CoPath *path = n->site->path->parent; path && path->parent; path = path->parent) {
        if (may_speak_at(&indexer->graph.nodes[node], path))
            add_sets_at(indexer, node, path, true);
        if (path->selection)
            break;
    }
}

// ---- Which selection ----------------------------------------------------------------------------
typedef struct CoSelectionSearch {
    CoIndexer *indexer;
    const char *set;
    const CoPath *
        *paths;      // per node: the set's prim as the node calls it, NULL: it does not know it
    uint32_t *order; // the nodes searched, strongest first
    uint32_t count;
} CoSelectionSearch;

static void spread_paths(CoSelectionSearch *search, uint32_t node)
{
    const CoGraph *graph = &search->indexer->graph;
    for (uint32_t i = graph->nodes[node].first_child; i != CO_NO_NODE;
         i = graph->nodes[i].next_sibling) {
        const CoPath *path = search->paths[node];
        if (path)
            path =
                co_map_to_source(&search->indexer->c->paths, graph->nodes[i].link->to_parent, path);
        search->paths[i] = path;
        spread_paths(search, i);
    }
}

// Starts from the root, or from the node nearest to it that has a name for the prim.
static uint32_t begin_search(CoSelectionSearch *search, uint32_t node, const CoPath *path)
{
    CoIndexer *indexer = search->indexer;
    CoComposer *c = indexer->c;
    const CoGraph *graph = &indexer->graph;
    while (graph->nodes[node].parent != CO_NO_NODE) {
        const CoPath *up = co_map_to_target(&c->paths, graph->nodes[node].link->to_parent, path);
        if (!up)
            break;
        path = up;
        node = graph->nodes[node].parent;
    }
    search->paths = co_composer_scratch(c, graph->count, sizeof *search->paths);
    search->order = co_composer_scratch(c, graph->count, sizeof *search->order);
    search->paths[node] = path;
    spread_paths(search, node);
    co_graph_order(c, graph, node, search->order, &search->count);
    return node;
}

static const char *chosen_outside(const CoSelectionSearch *search, uint32_t start)
{
    const CohortStageOptions *options = &search->indexer->c->options;
    char text[1024];
    if (start != 0 || !options->variant_count)
        return NULL;
    co_path_text(search->paths[start], text, sizeof text);
    for (size_t i = options->variant_count; i-- > 0;) {
        const CohortVariantChoice *choice = &options->variants[i];
        if (!strcmp(choice->set, search->set) && !strcmp(choice->prim, text))
            return co_composer_need(search->indexer->c,
                                    co_token(choice->selection, strlen(choice->selection)));
    }
    return NULL;
}

// A variant of the same set of the same prim may be in already, through another node.
static const char *prior_selection(const CoSelectionSearch *search)
{
    const CoGraph *graph = &search->indexer->graph;
    for (uint32_t i = 0; i < search->count; i++) {
        uint32_t node = search->order[i];
        if (graph->nodes[node].link->kind != CO_ARC_VARIANT || !search->paths[node])
            continue;
        const CoPath *path = co_node_path_at_arc(graph, node);
        if (path->selection && path->name == search->set && path->prim == search->paths[node])
            return path->selection;
    }
    return NULL;
}

static const char *authored_selection(const CoSelectionSearch *search)
{
    CoComposer *c = search->indexer->c;
    const CoGraph *graph = &search->indexer->graph;
    for (uint32_t i = 0; i < search->count; i++) {
        uint32_t node = search->order[i];
        const CoNode *n = &graph->nodes[node];
        const CoPath *path = search->paths[node];
        if (!path || !may_speak_at(n, path))
            continue;
        if (n->link->kind == CO_ARC_VARIANT) {
            const CoPath *variant = co_node_path_at_arc(graph, node);
            if (co_path_has_prefix(path, variant->prim))
                path = co_composer_need(
                    c, co_path_replace_prefix(&c->paths, path, variant->prim, variant));
        }
        const char *selection = co_site_selection(c, co_site(c, n->site->stack, path), search->set);
        if (selection)
            return selection;
    }
    return NULL;
}

static const char *fallback_selection(CoIndexer *indexer, const CoTask *task)
{
    CoComposer *c = indexer->c;
    const CohortStageOptions *o = &c->options;
    CoStack *stack = indexer->graph.nodes[task->node].site->stack;
    for (size_t i = 0; i < o->fallback_count; i++) {
        if (strcmp(o->fallbacks[i].set, task->set) != 0)
            continue;
        const char *text = o->fallbacks[i].selection;
        const char *selection = co_composer_need(c, co_token(text, strlen(text)));
        const CoPath *variant = co_path_variant(&c->paths, task->set_path, task->set, selection);
        if (co_site(c, stack, co_composer_need(c, variant))->spec_count)
            return selection;
    }
    return NULL;
}

// Nothing is selected, or nothing yet: another variant may bring a selection in.
static void put_off(CoIndexer *indexer, const CoTask *task, bool ancestral, bool may_fall_back)
{
    CoTask later = *task;
    if (may_fall_back && indexer->c->options.fallback_count)
        later.kind = ancestral ? CO_TASK_ANCESTRAL_VARIANT_FALLBACK : CO_TASK_VARIANT_FALLBACK;
    else
        later.kind = ancestral ? CO_TASK_ANCESTRAL_VARIANT_WITHOUT_SELECTION
                               : CO_TASK_VARIANT_WITHOUT_SELECTION;
    co_indexer_add_task(indexer, later);
}

void co_arc_variant(CoIndexer *indexer, const CoTask *task)
{
    CoComposer *c = indexer->c;
    bool falls_back =
        task->kind == CO_TASK_VARIANT_FALLBACK || task->kind == CO_TASK_ANCESTRAL_VARIANT_FALLBACK;
    bool ancestral =
        task->kind == CO_TASK_ANCESTRAL_VARIANT || task->kind == CO_TASK_ANCESTRAL_VARIANT_FALLBACK;
    const CoNode *node = &indexer->graph.nodes[task->node];
    if (!may_speak_at(node, task->set_path))
        return;
    CoSelectionSearch search = {.indexer = indexer, .set = task->set};
    uint32_t start = begin_search(&search, task->node, task->set_path->prim);
    const char *selection = prior_selection(&search);
    if (!selection)
        selection = chosen_outside(&search, start);
    if (!selection)
        selection = authored_selection(&search);
    bool is_open = !selection || !*selection;
    if (is_open && falls_back)
        selection = fallback_selection(indexer, task);
    if (!selection || !*selection) {
        put_off(indexer, task, ancestral, is_open && !falls_back);
        return;
    }
    const CoPath *variant = co_path_variant(&c->paths, task->set_path, task->set, selection);
    co_composer_need(c, variant);
    const CoPath *path =
        co_path_replace_prefix(&c->paths, node->site->path, task->set_path, variant);
    CoArcSpec arc = {.kind = CO_ARC_VARIANT,
                     .parent = task->node,
                     .origin = task->node,
                     .site = co_site(c, node->site->stack, co_composer_need(c, path)),
                     .to_parent = co_composer_need(c, co_map_identity(&c->paths)),
                     .sibling = task->set_number,
                     .namespace_depth = task->set_path->depth,
                     .root_depth = indexer->root_depth};
    CoArcOptions options = {.has_ancestors = ancestral};
    for (uint32_t i = task->node; ancestral && i != 0; i = indexer->graph.nodes[i].parent)
        options.skip_duplicates |= co_arc_is_class(indexer->graph.nodes[i].link->kind) &&
                                   co_node_depth_below_arc(&indexer->graph, i) == 0 &&
                                   !indexer->graph.nodes[i].is_inert;
    if (co_indexer_add_arc(indexer, &arc, options, NULL, 0) != CO_NO_NODE)
        co_indexer_retry_variants(indexer);
}
