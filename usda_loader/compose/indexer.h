// How prim indices are built: in the reference implementation's order of work.
//
// Arcs are tasks. They are done in the order relocates, references, payloads, inherits, implied
// classes, specializes, variants, because each may bring in more of the others; variants are last,
// since any other arc may bring in a selection. An arc to a prim that is no root prim first builds
// the index of that prim by itself, so that what its ancestors refer to counts too.

#ifndef CO_COMPOSE_INDEXER_H
#define CO_COMPOSE_INDEXER_H

#include "compose/prim_index.h"

typedef enum CoTaskKind {
    CO_TASK_RELOCATES = 0,
    CO_TASK_IMPLIED_RELOCATES,
    CO_TASK_REFERENCES,
    CO_TASK_PAYLOADS,
    CO_TASK_INHERITS,
    CO_TASK_IMPLIED_CLASSES,
    CO_TASK_SPECIALIZES,
    CO_TASK_ANCESTRAL_VARIANT_SETS,
    CO_TASK_ANCESTRAL_VARIANT,
    CO_TASK_ANCESTRAL_VARIANT_FALLBACK, // where nothing is selected, what the options say
    CO_TASK_VARIANT_SETS,
    CO_TASK_VARIANT,
    CO_TASK_VARIANT_FALLBACK,
    CO_TASK_VARIANT_WITHOUT_SELECTION, // tried again whenever a variant brings in new opinions
    CO_TASK_ANCESTRAL_VARIANT_WITHOUT_SELECTION
} CoTaskKind;

typedef struct CoTask {
    CoTaskKind kind;
    uint32_t node;
    const CoPath *set_path; // variants: where the set is authored
    const char *set;
    int set_number;
} CoTask;

typedef struct CoIndexer CoIndexer;

// How the index of a non-root target hangs in the index it is built for.
typedef struct CoFrame {
    const CoIndexer *outer;
    uint32_t parent; // node of the outer graph
    CoArcKind kind;
    const CoSite *requested;
    bool skip_duplicates;
} CoFrame;

struct CoIndexer {
    CoComposer *c;
    CoGraph graph;
    CoTask *tasks;
    size_t task_count, task_capacity;
    const CoFrame *frame; // NULL for the index of a stage prim
    uint32_t root_depth;  // of the stage prim
    bool is_prohibited;   // a relocate has moved away what the index is of
};

typedef struct CoArcOptions {
    bool is_placeholder;  // the node itself has no say
    bool has_ancestors;   // build the target's own index first
    bool skip_duplicates; // nothing to do if the site is in the graph already
} CoArcOptions;

// ---- Arcs (prim_index.c)
// Adds an arc and the tasks that follow from it; CO_NO_NODE when it is skipped (a cycle is
// reported).
uint32_t co_indexer_add_arc(CoIndexer *indexer, const CoArcSpec *arc, CoArcOptions options,
                            const CoStackLayer *layer, uint32_t line);
// Where the site is in the graph already and an arc to it would be skipped: a node without a say,
// for what the arc implies elsewhere. CO_NO_NODE when the site is not there, or by a cycle.
uint32_t co_indexer_add_echo(CoIndexer *indexer, const CoArcSpec *arc);

// The kind of a node as it will be once its graph hangs in the outer one.
CoArcKind co_indexer_node_kind(const CoIndexer *indexer, uint32_t node);

// The stage path that a node speaks of, for messages.
const CoPath *co_indexer_stage_path(const CoIndexer *indexer);

// ---- Tasks (index_task.c)
void co_indexer_add_task(CoIndexer *indexer, CoTask task); // unless it is there
// What has no selection yet may have one now.
void co_indexer_retry_variants(CoIndexer *indexer);
// Of a node and those below it; `skip_expressed` leaves out arcs that the index of the site itself
// has followed, `ancestral_variants` asks for the sets of the site's ancestors too.
void co_indexer_add_tree_tasks(CoIndexer *indexer, uint32_t node, bool skip_expressed,
                               bool ancestral_variants);
void co_indexer_add_arc_tasks(CoIndexer *indexer, uint32_t node, bool has_ancestors); // a new one
size_t co_indexer_next_task(CoIndexer *indexer); // index of the one to do; there must be any

// ---- What is left out (index_check.c)
bool co_indexer_is_cycle(const CoIndexer *indexer, const CoArcSpec *arc);
// Implied classes under relocates pass as no cycle; that the index of a site would need itself is
// one all the same.
bool co_indexer_is_being_built(const CoIndexer *indexer, const CoSite *site);
bool co_indexer_is_duplicate(const CoIndexer *indexer, const CoSite *site);
bool co_indexer_is_crowded(const CoIndexer *indexer, const CoArcSpec *arc);
void co_indexer_warn_crowded(CoIndexer *indexer, const CoStackLayer *layer, uint32_t line);

// ---- Maps (index_map.c)
// The map of an arc authored at a node, with the relocates of the node's stack applied.
const CoMap *co_indexer_arc_map(CoIndexer *indexer, uint32_t node, const CoPath *source,
                                bool has_root, double offset, double scale);

// ---- One file per arc
void co_arc_references(CoIndexer *indexer, uint32_t node, bool payloads);
void co_arc_inherits(CoIndexer *indexer, uint32_t node, CoArcKind kind);
void co_arc_implied_classes(CoIndexer *indexer, uint32_t node);
uint32_t co_arc_class_start(const CoIndexer *indexer, uint32_t node);
void co_arc_variant_sets(CoIndexer *indexer, uint32_t node, bool ancestral);
void co_arc_variant(CoIndexer *indexer, const CoTask *task);
void co_arc_relocates(CoIndexer *indexer, uint32_t node);
void co_arc_implied_relocates(CoIndexer *indexer, uint32_t node);

#endif
