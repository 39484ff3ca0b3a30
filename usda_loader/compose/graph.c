#include "compose/graph.h"

#include <string.h>

static void reserve(CoComposer *c, CoGraph *graph)
{
    if (graph->count < graph->capacity)
        return;
    size_t capacity = graph->capacity ? graph->capacity * 2 : 4;
    CoNode *nodes = co_composer_scratch(c, capacity, sizeof *nodes);
    if (graph->count)
        memcpy(nodes, graph->nodes, graph->count * sizeof *nodes);
    graph->nodes = nodes;
    graph->capacity = capacity;
}

void co_graph_init(CoComposer *c, CoGraph *graph, CoSite *site)
{
    *graph = (CoGraph){0};
    reserve(c, graph);
    CoLink *link = co_composer_alloc(c, sizeof *link);
    link->to_parent = link->to_root = co_composer_need(c, co_map_identity(&c->paths));
    graph->nodes[0] = (CoNode){.site = site,
                               .link = link,
                               .parent = CO_NO_NODE,
                               .first_child = CO_NO_NODE,
                               .next_sibling = CO_NO_NODE,
                               .origin = CO_NO_NODE};
    graph->count = 1;
}

void co_graph_copy(CoComposer *c, CoGraph *out, const CoGraph *graph)
{
    size_t capacity = (size_t)graph->count + 2;
    CoNode *nodes = co_composer_scratch(c, capacity, sizeof *nodes);
    memcpy(nodes, graph->nodes, graph->count * sizeof *nodes);
    *out = (CoGraph){nodes, graph->count, capacity};
}

uint32_t co_node_depth_below_arc(const CoGraph *graph, uint32_t node)
{
    const CoNode *n = &graph->nodes[node];
    if (n->parent == CO_NO_NODE)
        return 0;
    return graph->nodes[n->parent].site->path->depth - n->link->namespace_depth;
}

const CoPath *co_node_path_at_arc(const CoGraph *graph, uint32_t node)
{
    const CoPath *path = graph->nodes[node].site->path;
    for (uint32_t i = co_node_depth_below_arc(graph, node); i > 0 && path->parent; i--)
        path = path->parent;
    return path;
}

bool co_node_has_class_child(const CoGraph *graph, uint32_t node)
{
    for (uint32_t i = graph->nodes[node].first_child; i != CO_NO_NODE;
         i = graph->nodes[i].next_sibling)
        if (co_arc_is_class(graph->nodes[i].link->kind))
            return true;
    return false;
}

void co_graph_make_inert(CoGraph *graph, uint32_t node, bool with_restriction)
{
    CoNode *n = &graph->nodes[node];
    n->is_inert = true;
    if (with_restriction)
        n->restricted = 1;
    for (uint32_t i = n->first_child; i != CO_NO_NODE; i = graph->nodes[i].next_sibling)
        co_graph_make_inert(graph, i, with_restriction);
}

// ---- Order ------------------------------------------------------------------------------------
// -1 if `a` comes before `b` in a walk of the tree below `from`, 1 if after, 0 if neither is met.
static int first_met(const CoGraph *graph, uint32_t from, uint32_t a, uint32_t b)
{
    if (from == a)
        return -1;
    if (from == b)
        return 1;
    for (uint32_t i = graph->nodes[from].first_child; i != CO_NO_NODE;
         i = graph->nodes[i].next_sibling) {
        int met = first_met(graph, i, a, b);
        if (met)
            return met;
    }
    return 0;
}

static bool is_stronger(const CoGraph *graph, const CoArcSpec *a, uint32_t sibling)
{
    const CoNode *b = &graph->nodes[sibling];
    if (a->kind != b->link->kind)
        return a->kind < b->link->kind;
    if (a->namespace_depth != b->link->namespace_depth)
        return a->namespace_depth > b->link->namespace_depth;
    if (a->origin != b->origin)
        return first_met(graph, 0, a->origin, b->origin) < 0;
    return a->sibling < b->link->sibling;
}

static uint32_t add_node(CoComposer *c, CoGraph *graph, const CoArcSpec *arc)
{
    reserve(c, graph);
    uint32_t made = graph->count++;
    CoLink *link = co_composer_alloc(c, sizeof *link);
    const CoMap *parent_to_root = graph->nodes[arc->parent].link->to_root;
    *link = (CoLink){.kind = arc->kind,
                     .sibling = arc->sibling,
                     .namespace_depth = arc->namespace_depth,
                     .root_depth = arc->root_depth,
                     .to_parent = arc->to_parent};
    link->to_root = co_map_is_identity(arc->to_parent)
                        ? parent_to_root
                        : co_map_compose_exactly(&c->paths, parent_to_root, arc->to_parent);
    co_composer_need(c, link->to_root);
    graph->nodes[made] = (CoNode){.site = arc->site,
                                  .link = link,
                                  .parent = arc->parent,
                                  .first_child = CO_NO_NODE,
                                  .next_sibling = CO_NO_NODE,
                                  .origin = arc->origin};
    return made;
}

uint32_t co_graph_insert(CoComposer *c, CoGraph *graph, const CoArcSpec *arc)
{
    uint32_t made = add_node(c, graph, arc);
    uint32_t *at = &graph->nodes[arc->parent].first_child;
    while (*at != CO_NO_NODE && !is_stronger(graph, arc, *at))
        at = &graph->nodes[*at].next_sibling;
    graph->nodes[made].next_sibling = *at;
    *at = made;
    return made;
}

uint32_t co_graph_graft(CoComposer *c, CoGraph *graph, const CoArcSpec *arc, const CoGraph *branch)
{
    uint32_t top = co_graph_insert(c, graph, arc), base = graph->count - 1;
    graph->nodes[top].is_inert = branch->nodes[0].is_inert;
    graph->nodes[top].restricted = branch->nodes[0].restricted;
    // Node i of the branch becomes base + i; its root is `top` = base already.
    for (uint32_t i = 1; i < branch->count; i++) {
        const CoNode *from = &branch->nodes[i];
        reserve(c, graph);
        CoLink *link = co_composer_alloc(c, sizeof *link);
        *link = *from->link;
        link->root_depth = arc->root_depth;
        link->sources = NULL;
        CoNode *node = &graph->nodes[graph->count++];
        *node = *from;
        node->link = link;
        node->parent = base + from->parent;
        node->origin = base + from->origin;
        node->first_child = from->first_child == CO_NO_NODE ? CO_NO_NODE : base + from->first_child;
        node->next_sibling =
            from->next_sibling == CO_NO_NODE ? CO_NO_NODE : base + from->next_sibling;
    }
    if (branch->nodes[0].first_child != CO_NO_NODE)
        graph->nodes[top].first_child = base + branch->nodes[0].first_child;
    for (uint32_t i = base + 1; i < graph->count; i++) {
        const CoMap *to_root = graph->nodes[graph->nodes[i].parent].link->to_root;
        CoLink *link = graph->nodes[i].link;
        link->to_root = co_map_is_identity(link->to_parent)
                            ? to_root
                            : co_map_compose_exactly(&c->paths, to_root, link->to_parent);
        co_composer_need(c, link->to_root);
    }
    return top;
}

// What the order of a graph is worked out with.
typedef struct CoOrdering {
    const CoGraph *graph;
    uint32_t *out, count;
    uint32_t *ranks; // of all nodes in a plain walk, where there are specializes
    uint32_t ranked;
} CoOrdering;

static void rank_nodes(CoOrdering *o, uint32_t node)
{
    o->ranks[node] = o->ranked++;
    for (uint32_t i = o->graph->nodes[node].first_child; i != CO_NO_NODE;
         i = o->graph->nodes[i].next_sibling)
        rank_nodes(o, i);
}

// The node where the arc was authored that this one stands for elsewhere, and how far that is.
static uint32_t authored_node(const CoGraph *graph, uint32_t node, uint32_t *steps)
{
    for (*steps = 0; graph->nodes[node].origin != graph->nodes[node].parent; ++*steps)
        node = graph->nodes[node].origin;
    return node;
}

// Deeper in the stage's namespace is stronger, then what is authored under the stronger arc, then
// what is implied furthest from there; equals stay as they were met.
static bool is_stronger_late(const CoOrdering *o, uint32_t a, uint32_t b)
{
    const CoNode *nodes = o->graph->nodes;
    if (nodes[a].link->root_depth != nodes[b].link->root_depth)
        return nodes[a].link->root_depth > nodes[b].link->root_depth;
    uint32_t steps_a, steps_b;
    uint32_t from_a = authored_node(o->graph, a, &steps_a);
    uint32_t from_b = authored_node(o->graph, b, &steps_b);
    return from_a != from_b ? o->ranks[from_a] < o->ranks[from_b] : steps_a > steps_b;
}

static void put_main(CoOrdering *o, uint32_t node, uint32_t *late, uint32_t *late_count)
{
    o->out[o->count++] = node;
    const CoNode *nodes = o->graph->nodes;
    for (uint32_t i = nodes[node].first_child; i != CO_NO_NODE; i = nodes[i].next_sibling)
        if (nodes[i].link->kind == CO_ARC_SPECIALIZE)
            late[(*late_count)++] = i;
    for (uint32_t i = nodes[node].first_child; i != CO_NO_NODE; i = nodes[i].next_sibling)
        if (nodes[i].link->kind != CO_ARC_SPECIALIZE)
            put_main(o, i, late, late_count);
}

static void put_late(CoOrdering *o, uint32_t *late, uint32_t late_count)
{
    for (uint32_t i = 1; i < late_count; i++) {
        uint32_t node = late[i], j = i;
        for (; j > 0 && is_stronger_late(o, node, late[j - 1]); j--)
            late[j] = late[j - 1];
        late[j] = node;
    }
    for (uint32_t i = 0; i < late_count; i++) {
        uint32_t *more = late + late_count, more_count = 0;
        put_main(o, late[i], more, &more_count);
        put_late(o, more, more_count);
    }
}

void co_graph_order(CoComposer *c, const CoGraph *graph, uint32_t from, uint32_t *out,
                    uint32_t *count)
{
    uint32_t small[96], late_count = 0;
    uint32_t *late =
        graph->count <= 32 ? small : co_composer_scratch(c, (size_t)graph->count * 3, sizeof *late);
    CoOrdering o = {.graph = graph, .out = out, .ranks = late + (size_t)graph->count * 2};
    put_main(&o, from, late, &late_count);
    if (late_count)
        rank_nodes(&o, 0);
    put_late(&o, late, late_count);
    *count = o.count;
}

// ---- From a prim to its child -----------------------------------------------------------------
// Marks the subtrees to keep: those where an arc was just authored or some site has a spec. Even
// relocates count no further down than that.
static bool mark_kept(const CoGraph *graph, uint32_t node, bool *keep)
{
    bool kept = graph->nodes[node].site->spec_count || !co_node_depth_below_arc(graph, node);
    for (uint32_t i = graph->nodes[node].first_child; i != CO_NO_NODE;
         i = graph->nodes[i].next_sibling)
        kept |= mark_kept(graph, i, keep);
    keep[node] |= kept;
    return kept;
}

static void keep_origins(const CoGraph *graph, bool *keep)
{
    for (bool again = true; again;) {
        again = false;
        for (uint32_t i = 0; i < graph->count; i++) {
            if (!keep[i])
                continue;
            uint32_t needed[2] = {graph->nodes[i].origin, graph->nodes[i].parent};
            for (int k = 0; k < 2; k++)
                if (needed[k] != CO_NO_NODE && !keep[needed[k]])
                    keep[needed[k]] = again = true;
        }
    }
}

static uint32_t next_kept(const CoGraph *graph, uint32_t node, const bool *keep)
{
    while (node != CO_NO_NODE && !keep[node])
        node = graph->nodes[node].next_sibling;
    return node;
}

static void compact(CoComposer *c, CoGraph *graph, const bool *keep)
{
    uint32_t small[64], count = 0;
    uint32_t *moved =
        graph->count <= 64 ? small : co_composer_scratch(c, graph->count, sizeof *moved);
    for (uint32_t i = 0; i < graph->count; i++)
        moved[i] = keep[i] ? count++ : CO_NO_NODE;
    // Links first leave out what goes: a child may stand before its sibling in the array, so none
    // may move before.
    for (uint32_t i = 0; i < graph->count; i++) {
        CoNode *node = &graph->nodes[i];
        node->first_child = next_kept(graph, node->first_child, keep);
        node->next_sibling = next_kept(graph, node->next_sibling, keep);
    }
    for (uint32_t i = 0; i < graph->count; i++) {
        if (!keep[i])
            continue;
        CoNode node = graph->nodes[i];
        uint32_t *links[] = {&node.first_child, &node.next_sibling, &node.parent, &node.origin};
        for (int k = 0; k < 4; k++)
            if (*links[k] != CO_NO_NODE)
                *links[k] = moved[*links[k]];
        graph->nodes[moved[i]] = node;
    }
    graph->count = count;
}

void co_graph_cull(CoComposer *c, CoGraph *graph)
{
    bool small[64] = {false};
    bool *keep = graph->count <= 64 ? small : co_composer_scratch(c, graph->count, sizeof *keep);
    mark_kept(graph, 0, keep);
    keep_origins(graph, keep);
    compact(c, graph, keep);
}

void co_graph_descend(CoComposer *c, CoGraph *graph, const char *name)
{
    for (uint32_t i = 0; i < graph->count; i++) {
        CoSite *site = graph->nodes[i].site;
        const CoPath *path = co_path_child(&c->paths, site->path, name);
        graph->nodes[i].site = co_site(c, site->stack, co_composer_need(c, path));
    }
}
