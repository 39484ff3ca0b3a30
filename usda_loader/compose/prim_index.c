#include "compose/prim_index.h"

#include "compose/fields.h"

#include <string.h>

void co_indexer_add_task(CoIndexer *indexer, CoTask task)
{
    for (size_t i = 0; i < indexer->task_count; i++) {
        const CoTask *t = &indexer->tasks[i];
        if (t->kind == task.kind && t->node == task.node && t->set == task.set &&
            t->set_path == task.set_path)
            return;
    }
    if (indexer->task_count == indexer->task_capacity) {
        size_t capacity = indexer->task_capacity ? indexer->task_capacity * 2 : 8;
        CoTask *tasks = co_composer_scratch(indexer->c, capacity, sizeof *tasks);
        if (indexer->task_count)
            memcpy(tasks, indexer->tasks, indexer->task_count * sizeof *tasks);
        indexer->tasks = tasks;
        indexer->task_capacity = capacity;
    }
    indexer->tasks[indexer->task_count++] = task;
}

void co_indexer_retry_variants(CoIndexer *indexer)
{
    for (size_t i = 0; i < indexer->task_count; i++) {
        CoTask *task = &indexer->tasks[i];
        if (task->kind == CO_TASK_VARIANT_WITHOUT_SELECTION ||
            task->kind == CO_TASK_VARIANT_FALLBACK)
            task->kind = CO_TASK_VARIANT;
        else if (task->kind == CO_TASK_ANCESTRAL_VARIANT_WITHOUT_SELECTION ||
                 task->kind == CO_TASK_ANCESTRAL_VARIANT_FALLBACK)
            task->kind = CO_TASK_ANCESTRAL_VARIANT;
    }
}

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

// ---- Which tasks a node brings ------------------------------------------------------------------
static void add_own_tasks(CoIndexer *indexer, uint32_t node, bool skip_expressed,
                          bool ancestral_variants)
{
    const CoNode *n = &indexer->graph.nodes[node];
    uint32_t flags = n->site->flags;
    // Only the index of a stage prim can see all selections.
    if (!indexer->frame && flags & CO_SITE_VARIANT_SETS)
        co_indexer_add_task(indexer, (CoTask){.kind = CO_TASK_VARIANT_SETS, .node = node});
    if (!indexer->frame && ancestral_variants)
        co_indexer_add_task(indexer,
                            (CoTask){.kind = CO_TASK_ANCESTRAL_VARIANT_SETS, .node = node});
    if (!skip_expressed) {
        static const struct {
            uint32_t flag;
            CoTaskKind kind;
        } tasks[] = {{CO_SITE_RELOCATED, CO_TASK_RELOCATES},
                     {CO_SITE_REFERENCES, CO_TASK_REFERENCES},
                     {CO_SITE_PAYLOADS, CO_TASK_PAYLOADS},
                     {CO_SITE_INHERITS, CO_TASK_INHERITS},
                     {CO_SITE_SPECIALIZES, CO_TASK_SPECIALIZES}};
        for (size_t i = 0; i < sizeof tasks / sizeof *tasks; i++)
            if (flags & tasks[i].flag)
                co_indexer_add_task(indexer, (CoTask){.kind = tasks[i].kind, .node = node});
    }
    if (n->link->kind == CO_ARC_RELOCATE)
        co_indexer_add_task(indexer, (CoTask){.kind = CO_TASK_IMPLIED_RELOCATES, .node = node});
}

static void add_tree_tasks(CoIndexer *indexer, uint32_t node, bool skip_expressed,
                           bool ancestral_variants)
{
    for (uint32_t i = indexer->graph.nodes[node].first_child; i != CO_NO_NODE;
         i = indexer->graph.nodes[i].next_sibling)
        add_tree_tasks(indexer, i, skip_expressed, ancestral_variants);
    add_own_tasks(indexer, node, skip_expressed, ancestral_variants);
}

static void add_arc_tasks(CoIndexer *indexer, uint32_t node, bool has_ancestors)
{
    if (co_arc_is_class(indexer->graph.nodes[node].link->kind)) {
        uint32_t start = co_arc_class_start(indexer, node);
        if (start != CO_NO_NODE)
            co_indexer_add_task(indexer, (CoTask){.kind = CO_TASK_IMPLIED_CLASSES, .node = start});
    } else if (co_node_has_class_child(&indexer->graph, node)) {
        co_indexer_add_task(indexer, (CoTask){.kind = CO_TASK_IMPLIED_CLASSES, .node = node});
    }
    add_tree_tasks(indexer, node, has_ancestors, has_ancestors);
}

// ---- Cycles and duplicates ----------------------------------------------------------------------
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

static void set_specializes_apart(CoGraph *graph)
{
    for (uint32_t i = 0; i < graph->count; i++)
        graph->nodes[i].is_apart = graph->nodes[i].link->kind == CO_ARC_SPECIALIZE;
}

static bool is_cycle(const CoIndexer *indexer, const CoArcSpec *arc)
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

// Implied classes under relocates pass the test above; that the index of a site would need itself
// is a cycle all the same.
static bool is_being_built(const CoIndexer *indexer, const CoSite *site)
{
    for (const CoFrame *frame = indexer->frame; frame; frame = frame->outer->frame)
        if (frame->requested == site)
            return true;
    return false;
}

static bool is_duplicate(const CoIndexer *indexer, const CoSite *site)
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

// ---- Arcs
// -----------------------------------------------------------------------------------------
static void build(CoIndexer *indexer, CoSite *site, bool is_placeholder);

static uint32_t depth_of_frames(const CoFrame *frame)
{
    uint32_t depth = 0;
    for (; frame; frame = frame->outer->frame)
        depth++;
    return depth;
}

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

static bool is_crowded(const CoIndexer *indexer, const CoArcSpec *arc)
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

static void warn_crowded(CoIndexer *indexer, const CoStackLayer *layer, uint32_t line)
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

uint32_t co_indexer_add_arc(CoIndexer *indexer, const CoArcSpec *arc, CoArcOptions options,
                            const CoStackLayer *layer, uint32_t line)
{
    CoComposer *c = indexer->c;
    static const char *const kinds[] = {"root",      "inherit", "variant",   "relocate",
                                        "reference", "payload", "specialize"};
    arc->site->stack->arc_count++;
    if (is_cycle(indexer, arc) || (options.has_ancestors && is_being_built(indexer, arc->site))) {
        char text[256];
        co_path_text(arc->site->path, text, sizeof text);
        co_composer_warn(c, COHORT_PROBLEM_ARC_CYCLE, layer ? layer->file : NULL, line,
                         co_indexer_stage_path(indexer),
                         "%s %s to <%s> leads back to itself and is left out",
                         arc->kind == CO_ARC_INHERIT ? "an" : "a", kinds[arc->kind], text);
        return CO_NO_NODE;
    }
    if (is_crowded(indexer, arc)) {
        warn_crowded(indexer, layer, line);
        return CO_NO_NODE;
    }
    options.skip_duplicates |= indexer->frame && indexer->frame->skip_duplicates;
    if (options.skip_duplicates && is_duplicate(indexer, arc->site))
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
    add_arc_tasks(indexer, made, options.has_ancestors);
    if (!arc->site->path->parent)
        co_graph_make_inert(&indexer->graph, made, false);
    return made;
}

uint32_t co_indexer_add_echo(CoIndexer *indexer, const CoArcSpec *arc)
{
    if (!is_duplicate(indexer, arc->site) || is_cycle(indexer, arc) || is_crowded(indexer, arc))
        return CO_NO_NODE;
    uint32_t made = co_graph_insert(indexer->c, &indexer->graph, arc);
    indexer->graph.nodes[made].is_inert = true;
    indexer->graph.nodes[made].restricted = 1;
    co_indexer_add_task(indexer, (CoTask){.kind = CO_TASK_IMPLIED_CLASSES,
                                          .node = co_arc_class_start(indexer, made)});
    return made;
}

// ---- Maps of arcs -------------------------------------------------------------------------------
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

// ---- The order of work --------------------------------------------------------------------------
// Payloads and variants go strongest first, by node, then by the order of their sets.
static size_t next_task(CoIndexer *indexer)
{
    size_t best = 0, ties = 0;
    for (size_t i = 0; i < indexer->task_count; i++) {
        if (indexer->tasks[i].kind < indexer->tasks[best].kind) {
            best = i;
            ties = 0;
        }
        ties += indexer->tasks[i].kind == indexer->tasks[best].kind;
    }
    CoTaskKind kind = indexer->tasks[best].kind;
    if (ties < 2 || (kind < CO_TASK_ANCESTRAL_VARIANT && kind != CO_TASK_PAYLOADS))
        return best;
    uint32_t count;
    CoArenaMark mark = co_arena_mark(&indexer->c->scratch);
    uint32_t *order = co_composer_scratch(indexer->c, indexer->graph.count, 2 * sizeof *order);
    co_graph_order(indexer->c, &indexer->graph, 0, order, &count);
    uint32_t *rank = order + indexer->graph.count;
    for (uint32_t i = 0; i < count; i++)
        rank[order[i]] = i;
    for (size_t i = 0; i < indexer->task_count; i++) {
        const CoTask *a = &indexer->tasks[i], *b = &indexer->tasks[best];
        if (a->kind != kind || i == best)
            continue;
        uint32_t depth_a = a->set_path ? a->set_path->depth : 0;
        uint32_t depth_b = b->set_path ? b->set_path->depth : 0;
        bool is_first = depth_a != depth_b               ? depth_a < depth_b
                        : rank[a->node] != rank[b->node] ? rank[a->node] < rank[b->node]
                                                         : a->set_number < b->set_number;
        if (is_first)
            best = i;
    }
    co_arena_rewind(&indexer->c->scratch, mark);
    return best;
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
        size_t at = next_task(indexer);
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
        add_tree_tasks(indexer, 0, false, false);
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
        add_tree_tasks(&indexer, 0, false, false);
        run_tasks(&indexer);
        co_graph_cull(c, &indexer.graph);
    }
    *out = indexer.graph;
}
