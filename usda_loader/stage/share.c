#include "stage/share.h"

#include "compose/fields.h"

#include "base/hash.h"

#include <string.h>

// ---- Who is silent ------------------------------------------------------------------------------
// A site with nothing to say about descendants of its prim.
static bool is_silent_site(const CoComposer *c, const CoSite *site)
{
    if (site->stack->relocate_count)
        return false;
    for (uint32_t i = 0; i < site->spec_count; i++) {
        const CoSpec *spec = site->specs[i].spec;
        const CoContents *in = co_spec_contents(spec);
        if (in->child_count || in->variant_set_count || co_spec_field(spec, c->names.primOrder))
            return false;
    }
    return true;
}

// Which prim a silent node stands for does not matter to what is below. Classes are always looked
// at as they are, since others are implied by them.
static bool is_silent(const CoComposer *c, const CoGraph *graph, uint32_t node)
{
    CoArcKind kind = graph->nodes[node].link->kind;
    return (kind == CO_ARC_ROOT || kind == CO_ARC_REFERENCE || kind == CO_ARC_PAYLOAD) &&
           is_silent_site(c, graph->nodes[node].site);
}

static uint64_t count_remarks(const CoComposer *c, const CoGraph *graph)
{
    uint64_t remarks = c->warning_count;
    for (uint32_t i = 0; i < graph->count; i++)
        if (is_silent(c, graph, i))
            remarks += graph->nodes[i].site->stack->arc_count;
    return remarks;
}

// ---- Keys ---------------------------------------------------------------------------------------
typedef struct CoKeyWriter {
    CoComposer *c;
    const CoGraph *graph;
    uint64_t *words; // NULL: only counts
    size_t length;
    bool is_own; // the prim shares with no other
} CoKeyWriter;

static void put(CoKeyWriter *w, uint64_t word)
{
    if (w->words)
        w->words[w->length] = word;
    w->length++;
}

static void put_pointer(CoKeyWriter *w, const void *pointer)
{
    put(w, (uint64_t)(uintptr_t)pointer);
}

static void put_double(CoKeyWriter *w, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    put(w, bits);
}

static void put_selections(CoKeyWriter *w, const CoSite *site)
{
    if (!(site->flags & CO_SITE_SELECTIONS))
        return;
    for (uint32_t i = 0; i < site->spec_count; i++) {
        const CoField *field = co_spec_field(site->specs[i].spec, w->c->names.variantSelection);
        const CoDict *dict = field ? co_value_dict(&field->value) : NULL;
        put(w, dict ? dict->count : 0);
        for (size_t j = 0; dict && j < dict->count; j++) {
            const CohortString *text = co_value_text(dict->entries[j].value);
            put_pointer(w, dict->entries[j].key);
            put_pointer(w,
                        text ? co_composer_need(w->c, co_token(text->text, text->length)) : NULL);
        }
    }
}

// How the node hangs at its parent. Of a silent parent only "here" is said.
static void put_map(CoKeyWriter *w, const CoNode *node)
{
    const CoMap *map = node->link->to_parent;
    const CoPath *here = NULL;
    if (node->parent != CO_NO_NODE && is_silent(w->c, w->graph, node->parent))
        here = w->graph->nodes[node->parent].site->path->prim;
    put_double(w, map->offset);
    put_double(w, map->scale);
    put(w, map->count);
    for (uint32_t i = 0; i < map->count; i++) {
        const CoPath *target = map->pairs[i].target;
        put_pointer(w, map->pairs[i].source);
        put_pointer(w, target && target == here ? NULL : target);
        put(w, !target);
        w->is_own |= target && here && target != here && co_path_has_prefix(target, here);
    }
}

// Renaming by prefix reaches only what the node's paths are mapped to below the prim.
static bool leads_elsewhere(const CoNode *node, const CoPath *prim)
{
    const CoMap *map = node->link->to_root;
    for (uint32_t i = 0; i < map->count; i++)
        if (map->pairs[i].target && !co_path_has_prefix(map->pairs[i].target, prim))
            return true;
    return false;
}

static void put_node(CoKeyWriter *w, uint32_t i)
{
    const CoNode *node = &w->graph->nodes[i];
    const CoLink *link = node->link;
    bool silent = is_silent(w->c, w->graph, i);
    if (silent) {
        put_pointer(w, node->site->stack);
        put(w, node->site->path->depth);
        put_selections(w, node->site);
    } else {
        put_pointer(w, node->site);
        w->is_own |= !node->is_inert && node->site->spec_count &&
                     leads_elsewhere(node, w->graph->nodes[0].site->path);
    }
    put(w, (uint64_t)link->kind << 2 | (uint64_t)node->is_inert << 1 | silent);
    put(w, (uint64_t)node->parent << 32 | node->origin);
    put(w, (uint64_t)node->first_child << 32 | node->next_sibling);
    put(w, (uint64_t)link->namespace_depth << 32 | link->root_depth);
    put(w, (uint64_t)node->restricted << 32 | (uint32_t)link->sibling);
    put_map(w, node);
}

static void put_key(CoKeyWriter *w, const CohortPrim *prim)
{
    w->length = 0;
    put(w, prim->data->flags & (CO_PRIM_DEFINED | CO_PRIM_ABSTRACT));
    for (uint32_t i = 0; i < w->graph->count && !w->is_own; i++)
        put_node(w, i);
}

CoShareKey co_share_key(CohortStage *stage, const CohortPrim *prim, const CoGraph *graph)
{
    CoComposer *c = &stage->composer;
    // Choices from outside speak of single prims; clips find samples by the prim's path.
    const CohortStageOptions *o = &c->options;
    bool speaks_of_prims = o->variant_count || o->mask.count || o->loads.count || o->unloads.count;
    if (graph->count < 2 || speaks_of_prims || prim->data->clips ||
        prim->data->flags & CO_PRIM_INSTANCE || !is_silent(c, graph, 0))
        return (CoShareKey){0};
    CoKeyWriter writer = {.c = c, .graph = graph};
    put_key(&writer, prim);
    if (writer.is_own)
        return (CoShareKey){0};
    uint64_t *words = co_composer_scratch(c, writer.length, sizeof *words);
    writer.words = words;
    put_key(&writer, prim);
    return (CoShareKey){words, writer.length,
                        co_hash_bytes(words, writer.length * sizeof *words, 0),
                        count_remarks(c, graph)};
}

// ---- Taking and offering ------------------------------------------------------------------------
static CoInstanceSlot *find_slot(CoInstanceSlot *slots, size_t capacity, const CoShareKey *key)
{
    for (size_t at = key->hash & (capacity - 1);; at = (at + 1) & (capacity - 1)) {
        CoInstanceSlot *slot = &slots[at];
        if (!slot->prim || (slot->hash == key->hash && slot->length == key->length &&
                            !memcmp(slot->key, key->words, key->length * sizeof *key->words)))
            return slot;
    }
}

static void copy_children(CohortStage *stage, CohortPrim *prim, const CohortPrim *from)
{
    CoComposer *c = &stage->composer;
    size_t count = from->data->child_count;
    if (from->data->flags & CO_PRIM_INSTANCE) {
        prim->children = from->children;
        return;
    }
    if (count > c->options.max_prims || stage->prim_count > c->options.max_prims - count)
        co_composer_limit(c, NULL, NULL, "more prims", c->options.max_prims, "max_prims");
    stage->prim_count += count;
    prim->children = count ? co_composer_array(c, count, sizeof *prim->children) : NULL;
    for (size_t i = 0; i < count; i++) {
        prim->children[i] = (CohortPrim){.parent = prim, .data = from->children[i].data};
        copy_children(stage, &prim->children[i], &from->children[i]);
    }
}

bool co_share_take(CohortStage *stage, CohortPrim *prim, const CoShareKey *key)
{
    if (!key->length || !stage->share_capacity)
        return false;
    const CohortPrim *from = find_slot(stage->shares, stage->share_capacity, key)->prim;
    if (!from)
        return false;
    copy_children(stage, prim, from);
    prim->data->child_count = from->data->child_count;
    prim->data->shown = from->data->shown;
    prim->data->shown_count = from->data->shown_count;
    return true;
}

void co_share_offer(CohortStage *stage, CohortPrim *prim, const CoGraph *graph,
                    const CoShareKey *key)
{
    CoComposer *c = &stage->composer;
    if (!key->length || !prim->data->child_count || count_remarks(c, graph) != key->remarks)
        return;
    if (2 * stage->share_count >= stage->share_capacity) {
        size_t capacity = stage->share_capacity ? 2 * stage->share_capacity : 64;
        CoInstanceSlot *slots = co_composer_array(c, capacity, sizeof *slots);
        for (size_t i = 0; i < stage->share_capacity; i++) {
            const CoInstanceSlot *old = &stage->shares[i];
            CoShareKey known = {old->key, old->length, old->hash, 0};
            if (old->prim)
                *find_slot(slots, capacity, &known) = *old;
        }
        stage->shares = slots;
        stage->share_capacity = capacity;
    }
    uint64_t *words = co_composer_array(c, key->length, sizeof *words);
    memcpy(words, key->words, key->length * sizeof *words);
    *find_slot(stage->shares, stage->share_capacity, key) =
        (CoInstanceSlot){words, key->length, key->hash, prim};
    stage->share_count++;
}
