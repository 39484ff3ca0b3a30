#include "compose/indexer.h"

#include "compose/fields.h"

#include <string.h>

const CoPath *co_indexer_stage_path(const CoIndexer *indexer)
{
    while (indexer->frame)
        indexer = indexer->frame->outer;
    return indexer->graph.nodes[0].site->path;
}

CoArcKind co_indexer_node_kind(const CoIndexer *indexer, uint32_t node)
{
    return node == 0 && indexer->frame ? indexer->frame->kind
                                       : indexer->graph.nodes[node].link->kind;
}

// ---- Arcs --------------------------------------------------------------------------------------
static void build(CoIndexer *indexer, CoSite *site, bool is_placeholder);

static uint32_t depth_of_frames(const CoFrame *frame)
{
    uint32_t depth = 0;
    for (; frame; frame = frame->outer->frame)
        depth++;
    return depth;
}

uint32_t co_indexer_add_arc(CoIndexer *indexer, const CoArcSpec *arc, CoArcOptions options,
                            const CoStackLayer *layer, uint32_t line)
{
    CoComposer *c = indexer->c;
    static const char *const kinds[] = {"root",      "inherit", "variant",   "relocate",
                                        "reference", "payload", "specialize"};
    arc->site->stack->arc_count++;
    if (co_indexer_is_cycle(indexer, arc) ||
        (options.has_ancestors && co_indexer_is_being_built(indexer, arc->site))) {
        char text[256];
        co_path_text(arc->site->path, text, sizeof text);
        co_composer_warn(c, COHORT_PROBLEM_ARC_CYCLE, layer ? layer->file : NULL, line,
                         co_indexer_stage_path(indexer),
                         "%s %s to <%s> leads back to itself and is left out",
                         arc->kind == CO_ARC_INHERIT ? "an" : "a", kinds[arc->kind], text);
        return CO_NO_NODE;
    }
    if (co_indexer_is_crowded(indexer, arc)) {
        co_indexer_warn_crowded(indexer, layer, line);
        return CO_NO_NODE;
    }
    options.skip_duplicates |= indexer->frame && indexer->frame->skip_duplicates;
    if (options.skip_duplicates && co_indexer_is_duplicate(indexer, arc->site))
        return CO_NO_NODE;
    uint32_t made;
    if (options.has_ancestors && depth_of_frames(indexer->frame) < 64) {
        CoFrame frame = {indexer, arc->parent, arc->kind, arc->site, options.skip_duplicates};
        CoIndexer inner = {.c = c, .frame = &frame, .root_depth = indexer->root_depth};
        build(&inner, arc->site, options.is_placeholder);
        if (layer && inner.is_prohibited)
            co_composer_warn(c, COHORT_PROBLEM_ARC_TO_MOVED_PRIM, layer->file, line,
                             co_indexer_stage_path(indexer),
                             "the %s leads to what a relocate has moved away and is left out",
                             kinds[arc->kind]);
        made = co_graph_graft(c, &indexer->graph, arc, &inner.graph);
    } else {
        made = co_graph_insert(c, &indexer->graph, arc);
        if (options.is_placeholder) {
            indexer->graph.nodes[made].is_inert = true;
            indexer->graph.nodes[made].restricted = 1;
        }
    }
    co_indexer_add_arc_tasks(indexer, made, options.has_ancestors);
    if (!arc->site->path->parent)
        co_graph_make_inert(&indexer->graph, made, false);
    return made;
}

uint32_t co_indexer_add_echo(CoIndexer *indexer, const CoArcSpec *arc)
{
    if (!co_indexer_is_duplicate(indexer, arc->site) || co_indexer_is_cycle(indexer, arc) ||
        co_indexer_is_crowded(indexer, arc))
        return CO_NO_NODE;
    uint32_t made = co_graph_insert(indexer->c, &indexer->graph, arc);
    indexer->graph.nodes[made].is_inert = true;
    indexer->graph.nodes[made].restricted = 1;
    co_indexer_add_task(indexer, (CoTask){.kind = CO_TASK_IMPLIED_CLASSES,
                                          .node = co_arc_class_start(indexer, made)});
    return made;
}

// ---- Work --------------------------------------------------------------------------------------
static void set_specializes_apart(CoGraph *graph)
{
    for (uint32_t i = 0; i < graph->count; i++)
        graph->nodes[i].is_apart = graph->nodes[i].link->kind == CO_ARC_SPECIALIZE;
}

static void run_task(CoIndexer *indexer, const CoTask *task)
{
    switch (task->kind) {
    case CO_TASK_RELOCATES:
        co_arc_relocates(indexer, task->node);
        break;
    case CO_TASK_IMPLIED_RELOCATES:
        co_arc_implied_relocates(indexer, task->node);
        break;
    case CO_TASK_REFERENCES:
        co_arc_references(indexer, task->node, false);
        break;
    case CO_TASK_PAYLOADS:
        co_arc_references(indexer, task->node, true);
        break;
    case CO_TASK_INHERITS:
        co_arc_inherits(indexer, task->node, CO_ARC_INHERIT);
        break;
    case CO_TASK_IMPLIED_CLASSES:
        co_arc_implied_classes(indexer, task->node);
        break;
    case CO_TASK_SPECIALIZES:
        co_arc_inherits(indexer, task->node, CO_ARC_SPECIALIZE);
        break;
    case CO_TASK_ANCESTRAL_VARIANT_SETS:
        co_arc_variant_sets(indexer, task->node, true);
        break;
    case CO_TASK_VARIANT_SETS:
        co_arc_variant_sets(indexer, task->node, false);
        break;
    case CO_TASK_ANCESTRAL_VARIANT:
    case CO_TASK_ANCESTRAL_VARIANT_FALLBACK:
    case CO_TASK_VARIANT:
    case CO_TASK_VARIANT_FALLBACK:
        co_arc_variant(indexer, task);
        break;
    case CO_TASK_VARIANT_WITHOUT_SELECTION:
    case CO_TASK_ANCESTRAL_VARIANT_WITHOUT_SELECTION:
        break;
    }
}

static void run_tasks(CoIndexer *indexer)
{
    while (indexer->task_count) {
        size_t at = co_indexer_next_task(indexer);
        CoTask task = indexer->tasks[at];
        if (task.kind >= CO_TASK_VARIANT_WITHOUT_SELECTION)
            return;
        indexer->task_count--;
        memmove(indexer->tasks + at, indexer->tasks + at + 1,
                (indexer->task_count - at) * sizeof *indexer->tasks);
        if (!indexer->frame && task.kind >= CO_TASK_ANCESTRAL_VARIANT_SETS)
            set_specializes_apart(&indexer->graph);
        run_task(indexer, &task);
    }
}

bool co_prim_index_is_prohibited(const CoGraph *graph)
{
    for (uint32_t i = 0; i < graph->count; i++) {
        const CoNode *node = &graph->nodes[i];
        if (!node->is_inert && node->site->flags & CO_SITE_MOVED_AWAY)
            return true;
    }
    return false;
}

// ---- Instances ----------------------------------------------------------------------------------
static bool is_said_instanceable(CoComposer *c, const CoGraph *graph)
{
    bool any = false;
    for (uint32_t i = 0; i < graph->count && !any; i++)
        any = graph->nodes[i].site->flags & CO_SITE_INSTANCEABLE;
    if (!any)
        return false;
    uint32_t count, *order = co_composer_scratch(c, graph->count, sizeof *order);
    co_graph_order(c, graph, 0, order, &count);
    for (uint32_t i = 0; i < count; i++) {
        const CoNode *node = &graph->nodes[order[i]];
        for (uint32_t j = 0; !node->is_inert && j < node->site->spec_count; j++) {
            const CoField *field = co_spec_field(node->site->specs[j].spec, c->names.instanceable);
            bool value;
            if (field && co_value_bool(&field->value, &value))
                return value;
        }
    }
    return false;
}

// Marks what has specs and comes in by arcs authored at this very prim; true if there is any.
static bool mark_shared(CoGraph *graph, uint32_t node, bool is_below_arc)
{
    bool any = is_below_arc && graph->nodes[node].site->spec_count;
    graph->nodes[node].is_instanceable = any;
    any = any && !graph->nodes[node].is_inert;
    for (uint32_t i = graph->nodes[node].first_child; i != CO_NO_NODE;
         i = graph->nodes[i].next_sibling)
        any |= mark_shared(graph, i, is_below_arc || co_node_depth_below_arc(graph, i) == 0);
    return any;
}

bool co_prim_index_mark_instance(CoComposer *c, CoGraph *graph)
{
    return is_said_instanceable(c, graph) && mark_shared(graph, 0, false);
}

// As the reference has it, a prim that arcs lead below is an instance to them only if one of its
// own arcs leads to specs right where it says, not by an arc of an ancestor there.
static bool is_instance_on_the_way(CoComposer *c, CoGraph *graph)
{
    bool any = false;
    for (uint32_t i = 1; i < graph->count; i++)
        any |= graph->nodes[i].site->spec_count && co_node_depth_below_arc(graph, i) == 0;
    return any && co_prim_index_mark_instance(c, graph);
}

static void drop_local_opinions(CoGraph *graph)
{
    for (uint32_t i = 0; i < graph->count; i++)
        if (!graph->nodes[i].is_instanceable)
            graph->nodes[i].is_inert = true;
}

// ---- Indices ------------------------------------------------------------------------------------
// The index of a site that is not a stage prim: its ancestors' first.
static void build(CoIndexer *indexer, CoSite *site, bool is_placeholder)
{
    CoComposer *c = indexer->c;
    if (!site->path->parent || site->path->selection) {
        co_graph_init(c, &indexer->graph, site);
    } else {
        CoSite *parent = co_site(c, site->stack, site->path->parent);
        build(indexer, parent, false);
        if (is_instance_on_the_way(c, &indexer->graph))
            drop_local_opinions(&indexer->graph);
        co_graph_descend(c, &indexer->graph, site->path->name);
        indexer->task_count = 0;
    }
    if (is_placeholder)
        indexer->graph.nodes[0].is_inert = true;
    if (co_prim_index_is_prohibited(&indexer->graph)) {
        co_graph_make_inert(&indexer->graph, 0, true);
        indexer->is_prohibited = true;
        return;
    }
    if (site->path->parent) {
        co_indexer_add_tree_tasks(indexer, 0, false, false);
        run_tasks(indexer);
    }
}

void co_prim_index_root(CoComposer *c, CoStack *stack, CoGraph *out)
{
    co_graph_init(c, out, co_site(c, stack, &c->paths.root));
}

void co_prim_index_child(CoComposer *c, const CoGraph *parent, bool parent_is_instance,
                         const char *name, CoGraph *out)
{
    CoIndexer indexer = {.c = c};
    co_graph_copy(c, &indexer.graph, parent);
    if (parent_is_instance)
        drop_local_opinions(&indexer.graph);
    co_graph_descend(c, &indexer.graph, name);
    set_specializes_apart(&indexer.graph);
    indexer.root_depth = indexer.graph.nodes[0].site->path->depth;
    if (!co_prim_index_is_prohibited(&indexer.graph)) {
        co_indexer_add_tree_tasks(&indexer, 0, false, false);
        run_tasks(&indexer);
        co_graph_cull(c, &indexer.graph);
    }
    *out = indexer.graph;
}
