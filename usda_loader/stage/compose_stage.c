// From the root layer to the tree of prims, depth first: one prim index at a time is alive per
// level.

#include "compose/fields.h"
#include "compose/list_op.h"
#include "compose/population.h"
#include "stage/clips.h"
#include "stage/share.h"

#include "base/hash.h"
#include "base/stop.h"

#include <stdlib.h>
#include <string.h>

// ---- Opinions -----------------------------------------------------------------------------------
static const CoSource *link_sources(CoComposer *c, const CoNode *node)
{
    if (node->link->sources)
        return node->link->sources;
    const CoStack *stack = node->site->stack;
    const CoMap *map = node->link->to_root;
    CoSource *sources = co_composer_array(c, stack->layer_count, sizeof *sources);
    for (size_t i = 0; i < stack->layer_count; i++) {
        const CoStackLayer *layer = &stack->layers[i];
        sources[i] = (CoSource){layer->file,
                                stack,
                                map,
                                map->scale * layer->offset + map->offset,
                                map->scale * layer->scale,
                                node->link->kind};
    }
    node->link->sources = sources;
    return sources;
}

typedef struct CoOrdered {
    uint32_t *nodes; // strongest first
    uint32_t count;
} CoOrdered;

static CoOrdered order_nodes(CoComposer *c, const CoGraph *graph)
{
    CoOrdered out = {co_composer_scratch(c, graph->count, sizeof(uint32_t)), 0};
    co_graph_order(c, graph, 0, out.nodes, &out.count);
    return out;
}

static CoPrimData *gather_opinions(CohortStage *stage, CohortPrim *prim, const CoGraph *graph,
                                   const CoOrdered *ordered)
{
    CoComposer *c = &stage->composer;
    size_t count = 0;
    for (uint32_t i = 0; i < ordered->count; i++) {
        const CoNode *node = &graph->nodes[ordered->nodes[i]];
        count += node->is_inert ? 0 : node->site->spec_count;
    }
    CoPrimData *data = co_composer_alloc(c, sizeof *data + count * sizeof *data->opinions);
    data->stage = stage;
    data->path = graph->nodes[0].site->path;
    data->above = prim->parent ? prim->parent->data : NULL;
    data->type = "";
    prim->data = data;
    for (uint32_t i = 0; i < ordered->count; i++) {
        const CoNode *node = &graph->nodes[ordered->nodes[i]];
        if (node->is_inert || !node->site->spec_count)
            continue;
        const CoSource *sources = link_sources(c, node);
        for (uint32_t j = 0; j < node->site->spec_count; j++)
            data->opinions[data->opinion_count++] =
                (CoOpinion){node->site->specs[j].spec, &sources[node->site->specs[j].layer]};
    }
    return data;
}

// ---- What a prim is -----------------------------------------------------------------------------
static bool is_directly_inherited(const CoGraph *graph, uint32_t node)
{
    for (; node != 0; node = graph->nodes[node].parent)
        if (graph->nodes[node].link->kind == CO_ARC_INHERIT &&
            co_node_depth_below_arc(graph, node) == 0)
            return true;
    return false;
}

// The strongest that defines wins; that a class is inherited (not specialized) does not make a
// class of the heir as long as anything weaker defines it.
static CohortSpecifier compose_specifier(const CoGraph *graph, const CoOrdered *ordered)
{
    CohortSpecifier out = COHORT_SPECIFIER_OVER;
    bool is_inherited_class = false;
    for (uint32_t i = 0; i < ordered->count; i++) {
        const CoNode *node = &graph->nodes[ordered->nodes[i]];
        for (uint32_t j = 0; !node->is_inert && j < node->site->spec_count; j++) {
            const CoSpec *spec = node->site->specs[j].spec;
            if (spec->kind != CO_SPEC_PRIM || spec->specifier == COHORT_SPECIFIER_OVER)
                continue;
            if (spec->specifier == COHORT_SPECIFIER_CLASS &&
                is_directly_inherited(graph, ordered->nodes[i])) {
                if (!is_inherited_class)
                    out = COHORT_SPECIFIER_CLASS;
                is_inherited_class = true;
                continue;
            }
            return spec->specifier;
        }
    }
    return out;
}

static bool compose_bool(const CoPrimData *data, const char *name, bool fallback)
{
    for (uint32_t i = 0; i < data->opinion_count; i++) {
        const CoField *field = co_spec_field(data->opinions[i].spec, name);
        bool value;
        if (field && co_value_bool(&field->value, &value))
            return value;
    }
    return fallback;
}

static void compose_identity(CoPrimData *data, const CoGraph *graph, const CoOrdered *ordered)
{
    const CoFieldNames *names = &data->stage->composer.names;
    for (uint32_t i = 0; i < data->opinion_count && !*data->type; i++) {
        const char *type = data->opinions[i].spec->type_name;
        if (type && type != names->any_type)
            data->type = type;
    }
    data->specifier = (uint8_t)compose_specifier(graph, ordered);
    bool parent_defined = data->above->flags & CO_PRIM_DEFINED;
    bool parent_abstract = data->above->flags & CO_PRIM_ABSTRACT;
    if (compose_bool(data, names->active, true))
        data->flags |= CO_PRIM_ACTIVE;
    if (parent_defined && data->specifier != COHORT_SPECIFIER_OVER)
        data->flags |= CO_PRIM_DEFINED;
    if (parent_abstract || data->specifier == COHORT_SPECIFIER_CLASS)
        data->flags |= CO_PRIM_ABSTRACT;
}

// ---- Instances ----------------------------------------------------------------------------------
static CoInstanceSlot *find_instance(CohortStage *stage, const uint64_t *key, size_t length,
                                     uint64_t hash)
{
    size_t capacity = stage->instance_capacity;
    for (size_t at = hash & (capacity - 1);; at = (at + 1) & (capacity - 1)) {
        CoInstanceSlot *slot = &stage->instances[at];
        if (!slot->prim || (slot->hash == hash && slot->length == length &&
                            !memcmp(slot->key, key, length * sizeof *key)))
            return slot;
    }
}

static void grow_instances(CohortStage *stage)
{
    CoInstanceSlot *old = stage->instances;
    size_t count = stage->instance_capacity;
    stage->instance_capacity = count ? count * 2 : 64;
    stage->instances =
        co_composer_array(&stage->composer, stage->instance_capacity, sizeof *stage->instances);
    for (size_t i = 0; i < count; i++)
        if (old[i].prim)
            *find_instance(stage, old[i].key, old[i].length, old[i].hash) = old[i];
}

// Equal keys, equal children: the same sites by the same arcs at the same times, below ancestors
// that are defined and abstract alike, which their children inherit.
static CohortPrim *find_prototype(CohortStage *stage, CohortPrim *prim, const CoGraph *graph,
                                  const CoOrdered *ordered)
{
    CoComposer *c = &stage->composer;
    uint64_t *key = co_composer_array(c, (size_t)ordered->count * 4 + 2, sizeof *key);
    size_t length = 0;
    key[length++] = prim->data->flags & (CO_PRIM_DEFINED | CO_PRIM_ABSTRACT);
    key[length++] = co_population_key(c, prim->data->path);
    for (uint32_t i = 0; i < ordered->count; i++) {
        const CoNode *node = &graph->nodes[ordered->nodes[i]];
        if (!node->is_instanceable || !node->site->spec_count)
            continue;
        key[length++] = (uint64_t)(uintptr_t)node->site;
        key[length++] = (uint64_t)node->link->kind << 1 | node->is_inert;
        memcpy(&key[length++], &node->link->to_root->offset, sizeof *key);
        memcpy(&key[length++], &node->link->to_root->scale, sizeof *key);
    }
    if (2 * stage->instance_count >= stage->instance_capacity)
        grow_instances(stage);
    uint64_t hash = co_hash_bytes(key, length * sizeof *key, 0);
    CoInstanceSlot *slot = find_instance(stage, key, length, hash);
    if (!slot->prim) {
        *slot = (CoInstanceSlot){key, length, hash, prim};
        stage->instance_count++;
    }
    return slot->prim;
}

// ---- Children -----------------------------------------------------------------------------------
typedef struct CoNameSet {
    const char **slots;
    size_t capacity;
} CoNameSet;

// Stands where a name was removed, so that probing goes on past it.
static const char removed_name[] = "";

static void remove_name(CoNameSet *set, const char *name)
{
    size_t at = co_hash64((uint64_t)(uintptr_t)name) & (set->capacity - 1);
    for (; set->slots[at]; at = (at + 1) & (set->capacity - 1))
        if (set->slots[at] == name)
            set->slots[at] = removed_name;
}

static bool add_name(CoNameSet *set, const char *name)
{
    size_t at = co_hash64((uint64_t)(uintptr_t)name) & (set->capacity - 1);
    for (; set->slots[at]; at = (at + 1) & (set->capacity - 1))
        if (set->slots[at] == name)
            return false;
    set->slots[at] = name;
    return true;
}

static int compare_names(const void *a, const void *b)
{
    return strcmp(((const CoListItem *)a)->a, ((const CoListItem *)b)->a);
}

// Edits the names so far as one site's relocates say: children moved away go, renamed ones are
// renamed in place, and those moved here are added in the order of their names.
static void relocate_names(CoComposer *c, CoList *names, CoNameSet *set, const CoSite *site)
{
    const CoStack *stack = site->stack;
    const CoMovesAt *here = co_stack_moves_at(stack, site->path);
    if (!here)
        return;
    size_t kept = 0;
    for (size_t i = 0; i < names->count; i++) {
        CoListItem item = names->items[i];
        const CoPath *path = co_path_find_child(&c->paths, site->path, item.a);
        const CoMove *move = path ? co_stack_move_from(stack, path) : NULL;
        if (move) {
            remove_name(set, item.a);
            bool stays = move->target && move->target->parent == site->path;
            if (!stays || !add_name(set, move->target->name))
                continue;
            item.a = move->target->name;
        }
        names->items[kept++] = item;
    }
    names->count = kept;
    size_t added = 0, number = here->first[CO_MOVES_TO_CHILDREN];
    for (; number; number = stack->relocates[number - 1].next[CO_MOVES_TO_CHILDREN]) {
        const CoMove *move = &stack->relocates[number - 1];
        if (move->source->parent == site->path || !add_name(set, move->target->name))
            continue;
        co_list_push(c, names, (CoListItem){.a = move->target->name});
        added++;
    }
    if (added)
        qsort(names->items + kept, added, sizeof *names->items, compare_names);
}

static void reorder_names(CoComposer *c, CoList *names, const CoSpec *spec)
{
    const CoField *field = co_spec_field(spec, c->names.primOrder);
    if (!field || field->value.type != COHORT_TYPE_TOKEN || !field->value.count)
        return;
    const CohortString *text = field->value.data;
    CoListItem *order = co_composer_scratch(c, field->value.count, sizeof *order);
    for (size_t i = 0; i < field->value.count; i++)
        order[i].a = co_composer_need(c, co_token(text[i].text, text[i].length));
    co_list_reorder(c, names, order, field->value.count);
}

// Weakest first, so that the strongest layer's new names come last.
static CoList child_names(CoComposer *c, const CoGraph *graph, const CoOrdered *ordered)
{
    CoList names = {.is_scratch = true};
    size_t most = 1;
    for (uint32_t i = 0; i < ordered->count; i++) {
        const CoSite *site = graph->nodes[ordered->nodes[i]].site;
        const CoMovesAt *moves = co_stack_moves_at(site->stack, site->path);
        for (uint32_t j = moves ? moves->first[CO_MOVES_TO_CHILDREN] : 0; j;
             j = site->stack->relocates[j - 1].next[CO_MOVES_TO_CHILDREN])
            most++;
        for (uint32_t j = 0; j < site->spec_count; j++)
            most += co_spec_contents(site->specs[j].spec)->child_count;
    }
    CoNameSet set = {NULL, 4};
    while (set.capacity < 2 * most)
        set.capacity *= 2;
    set.slots = co_composer_scratch(c, set.capacity, sizeof *set.slots);
    for (uint32_t i = ordered->count; i-- > 0;) {
        const CoNode *node = &graph->nodes[ordered->nodes[i]];
        if (node->is_inert)
            continue;
        if (node->site->stack->relocate_count)
            relocate_names(c, &names, &set, node->site);
        for (uint32_t j = node->site->spec_count; j-- > 0;) {
            const CoSpec *spec = node->site->specs[j].spec;
            const CoContents *in = co_spec_contents(spec);
            for (size_t k = 0; k < in->child_count; k++)
                if (add_name(&set, in->children[k]->name))
                    co_list_push(c, &names, (CoListItem){.a = in->children[k]->name});
            reorder_names(c, &names, spec);
        }
    }
    return names;
}

static void compose_children(CohortStage *stage, CohortPrim *prim, const CoGraph *graph,
                             const CoOrdered *ordered, uint64_t depth);

// Arcs upon arcs take as much time and memory as prims do: they count as much.
static void count_arcs(CohortStage *stage, const CoGraph *graph)
{
    CoComposer *c = &stage->composer;
    stage->arc_count += graph->count - 1;
    if (stage->prim_count + stage->arc_count > c->options.max_prims)
        co_composer_limit(c, NULL, graph->nodes[0].site->path, "more prims and arcs to them",
                          c->options.max_prims, "max_prims");
}

static void compose_prim(CohortStage *stage, CohortPrim *prim, CoGraph *graph, uint64_t depth)
{
    CoComposer *c = &stage->composer;
    if (co_is_stopped(c->options.stop))
        co_composer_fail(c, COHORT_ERROR_CANCELLED, "stopped");
    count_arcs(stage, graph);
    CoOrdered ordered = order_nodes(c, graph);
    CoPrimData *data = gather_opinions(stage, prim, graph, &ordered);
    compose_identity(data, graph, &ordered);
    if (!(data->flags & CO_PRIM_ACTIVE))
        return;
    data->clips = co_clips_compose(stage, prim);
    if (co_prim_index_mark_instance(c, graph)) {
        data->flags |= CO_PRIM_INSTANCE;
        CohortPrim *prototype = find_prototype(stage, prim, graph, &ordered);
        data->prototype = prototype;
        if (prototype != prim) {
            prim->children = prototype->children;
            data->child_count = prototype->data->child_count;
            data->shown = prototype->data->shown;
            data->shown_count = prototype->data->shown_count;
            return;
        }
    }
    compose_children(stage, prim, graph, &ordered, depth);
}

static bool is_shown(const CohortPrim *prim)
{
    return (prim->data->flags & (CO_PRIM_ACTIVE | CO_PRIM_DEFINED | CO_PRIM_ABSTRACT)) ==
           (CO_PRIM_ACTIVE | CO_PRIM_DEFINED);
}

static void note_shown(CoComposer *c, CohortPrim *prim)
{
    CoPrimData *data = prim->data;
    for (uint32_t i = 0; i < data->child_count; i++)
        data->shown_count += is_shown(&prim->children[i]);
    if (data->shown_count == data->child_count)
        return;
    uint32_t *shown = co_composer_array(c, data->shown_count, sizeof *shown), count = 0;
    for (uint32_t i = 0; i < data->child_count; i++)
        if (is_shown(&prim->children[i]))
            shown[count++] = i;
    data->shown = shown;
}

static void compose_children(CohortStage *stage, CohortPrim *prim, const CoGraph *graph,
                             const CoOrdered *ordered, uint64_t depth)
{
    CoComposer *c = &stage->composer;
    if (depth >= c->options.max_depth)
        co_composer_limit(c, NULL, graph->nodes[0].site->path, "prims nested deeper",
                          c->options.max_depth, "max_depth");
    CoShareKey key = co_share_key(stage, prim, graph);
    if (co_share_take(stage, prim, &key))
        return;
    CoOrdered visible = *ordered;
    bool is_instance = prim->data->flags & CO_PRIM_INSTANCE;
    if (is_instance) {
        visible = (CoOrdered){co_composer_scratch(c, ordered->count, sizeof(uint32_t)), 0};
        for (uint32_t i = 0; i < ordered->count; i++)
            if (graph->nodes[ordered->nodes[i]].is_instanceable)
                visible.nodes[visible.count++] = ordered->nodes[i];
    }
    CoList names = child_names(c, graph, &visible);
    if (!names.count)
        return;
    if (names.count > c->options.max_prims ||
        stage->prim_count > c->options.max_prims - names.count)
        co_composer_limit(c, NULL, graph->nodes[0].site->path, "more prims", c->options.max_prims,
                          "max_prims");
    prim->children = co_composer_array(c, names.count, sizeof *prim->children);
    for (size_t i = 0; i < names.count; i++) {
        CoArenaMark mark = co_arena_mark(&c->scratch);
        CoGraph child_graph;
        const CoPath *path = co_path_child(&c->paths, graph->nodes[0].site->path, names.items[i].a);
        if (!co_population_includes(c, co_composer_need(c, path)))
            continue;
        co_prim_index_child(c, graph, is_instance, names.items[i].a, &child_graph);
        if (!co_prim_index_is_prohibited(&child_graph)) {
            CohortPrim *child = &prim->children[prim->data->child_count++];
            child->parent = prim;
            stage->prim_count++;
            compose_prim(stage, child, &child_graph, depth + 1);
        }
        co_arena_rewind(&c->scratch, mark);
    }
    note_shown(c, prim);
    co_share_offer(stage, prim, graph, &key);
}

void co_stage_compose(CohortStage *stage)
{
    CoComposer *c = &stage->composer;
    CoGraph graph;
    co_prim_index_root(c, stage->stack, &graph);
    CohortPrim *root = &stage->root;
    CoOrdered ordered = order_nodes(c, &graph);
    CoPrimData *data = gather_opinions(stage, root, &graph, &ordered);
    data->flags = CO_PRIM_ACTIVE | CO_PRIM_DEFINED;
    compose_children(stage, root, &graph, &ordered, 0);
}
