// The tasks of an index: which arcs bring which, and what is done first.

#include "compose/indexer.h"

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

void co_indexer_add_tree_tasks(CoIndexer *indexer, uint32_t node, bool skip_expressed,
                               bool ancestral_variants)
{
    for (uint32_t i = indexer->graph.nodes[node].first_child; i != CO_NO_NODE;
         i = indexer->graph.nodes[i].next_sibling)
        co_indexer_add_tree_tasks(indexer, i, skip_expressed, ancestral_variants);
    add_own_tasks(indexer, node, skip_expressed, ancestral_variants);
}

void co_indexer_add_arc_tasks(CoIndexer *indexer, uint32_t node, bool has_ancestors)
{
    if (co_arc_is_class(indexer->graph.nodes[node].link->kind)) {
        uint32_t start = co_arc_class_start(indexer, node);
        if (start != CO_NO_NODE)
            co_indexer_add_task(indexer, (CoTask){.kind = CO_TASK_IMPLIED_CLASSES, .node = start});
    } else if (co_node_has_class_child(&indexer->graph, node)) {
        co_indexer_add_task(indexer, (CoTask){.kind = CO_TASK_IMPLIED_CLASSES, .node = node});
    }
    co_indexer_add_tree_tasks(indexer, node, has_ancestors, has_ancestors);
}

// ---- The order of work -------------------------------------------------------------------------
// Payloads and variants go strongest first, by node, then by the order of their sets.
size_t co_indexer_next_task(CoIndexer *indexer)
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
