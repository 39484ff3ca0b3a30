// A prim index: the tree of sites that have a say in one prim.
//
// Each node is a site, reached by an arc from its parent node. Siblings are kept strongest first:
// inherits, variants, relocates, references, payloads, specializes (LIVERPS below the node's own
// local opinions), then arcs authored deeper in namespace, then the order of their origins, then
// the order of authoring. The index of a child prim starts as a copy of its parent's with the
// child's name added to every site.

#ifndef CO_COMPOSE_GRAPH_H
#define CO_COMPOSE_GRAPH_H

#include "compose/site.h"

typedef enum CoArcKind {
    CO_ARC_ROOT = 0,
    CO_ARC_INHERIT,
    CO_ARC_VARIANT,
    CO_ARC_RELOCATE,
    CO_ARC_REFERENCE,
    CO_ARC_PAYLOAD,
    CO_ARC_SPECIALIZE
} CoArcKind;

#define CO_NO_NODE UINT32_MAX

// One layer as a node's opinions in it reach the stage. Shared by a node and its copies in the
// indices of descendants.
typedef struct CoSource {
    const CoLayerFile *file;
    const CoStack *stack;
    const CoMap *to_root; // paths of the node to paths of the stage
    double offset, scale; // times of the layer to times of the stage
    CoArcKind arc;        // by which the node hangs at its parent
} CoSource;

// What a node keeps in the indices of descendants.
typedef struct CoLink {
    CoArcKind kind;
    int sibling;              // number among the arcs authored with it
    uint32_t namespace_depth; // prim elements of the parent node's path where the arc is authored
    uint32_t root_depth;      // depth of the stage prim at which it was found
    const CoMap *to_parent, *to_root;
    const CoSource *sources; // one per layer of the stack; made when first needed
} CoLink;

typedef struct CoNode {
    CoSite *site;
    CoLink *link;
    uint32_t parent, first_child, next_sibling, origin;
    uint32_t restricted;  // elements of the path from which on it has no say; 0 = everywhere
    bool is_inert;        // a placeholder without opinions
    bool is_apart;        // a specialize that now stands by itself, right below the root
    bool is_instanceable; // brought in by an arc of an instance (see prim_index.h)
} CoNode;

typedef struct CoGraph {
    CoNode *nodes; // [0] is the root
    uint32_t count;
    size_t capacity;
} CoGraph;

void co_graph_init(CoComposer *c, CoGraph *graph, CoSite *site);

// A copy with room to grow.
void co_graph_copy(CoComposer *c, CoGraph *out, const CoGraph *graph);

// Drops the subtrees that have nothing to say of the prim, nor of any below it.
void co_graph_cull(CoComposer *c, CoGraph *graph);

// Turns the index of a prim into the start of its child's: adds the name to every site.
void co_graph_descend(CoComposer *c, CoGraph *graph, const char *name);

typedef struct CoArcSpec {
    CoArcKind kind;
    uint32_t parent, origin;
    CoSite *site;
    const CoMap *to_parent;
    int sibling;
    uint32_t namespace_depth, root_depth;
} CoArcSpec;

// Adds a node at its place among its siblings.
uint32_t co_graph_insert(CoComposer *c, CoGraph *graph, const CoArcSpec *arc);

// Adds a whole index as a child.
uint32_t co_graph_graft(CoComposer *c, CoGraph *graph, const CoArcSpec *arc, const CoGraph *branch);

// How many prim names ago the node's arc was authored; 0 = at this prim.
uint32_t co_node_depth_below_arc(const CoGraph *graph, uint32_t node);
const CoPath *co_node_path_at_arc(const CoGraph *graph, uint32_t node);

static inline bool co_node_contributes(const CoNode *node)
{
    return !node->is_inert;
}

static inline bool co_arc_is_class(CoArcKind kind)
{
    return kind == CO_ARC_INHERIT || kind == CO_ARC_SPECIALIZE;
}

// Whether an inherit or specialize arc leads from the node.
bool co_node_has_class_child(const CoGraph *graph, uint32_t node);

// All nodes, strongest first; specializes come after everything else. `out` has graph->count
// elements.
void co_graph_order(CoComposer *c, const CoGraph *graph, uint32_t from, uint32_t *out,
                    uint32_t *count);

void co_graph_make_inert(CoGraph *graph, uint32_t node, bool with_restriction);

#endif
