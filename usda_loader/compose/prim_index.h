// Prim indices: which sites have a say in a prim, as a tree (indexer.h says how they are built).

#ifndef CO_COMPOSE_PRIM_INDEX_H
#define CO_COMPOSE_PRIM_INDEX_H

#include "compose/graph.h"

// The index of the pseudo-root. Graphs live in the composer's scratch arena.
void co_prim_index_root(CoComposer *c, CoStack *stack, CoGraph *out);

// The index of a child of the prim that `parent` belongs to. Below an instance, what only the
// instance itself says about its descendants is left out.
void co_prim_index_child(CoComposer *c, const CoGraph *parent, bool parent_is_instance,
                         const char *name, CoGraph *out);

// True if the prim is an instance: said to be instanceable, and arcs of its own bring something in.
// Marks the nodes that these arcs bring in.
bool co_prim_index_mark_instance(CoComposer *c, CoGraph *graph);

// True if the prim may not exist: it was moved away by a relocate.
bool co_prim_index_is_prohibited(const CoGraph *graph);

#endif
