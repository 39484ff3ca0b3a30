#include "compose/site.h"

#include "compose/fields.h"
#include "compose/list_op.h"

#include "base/hash.h"

#include <math.h>
#include <string.h>

// ---- The cache --------------------------------------------------------------------------------
static CoSite **find_slot(CoSite **slots, size_t capacity, const CoStack *stack, const CoPath *path)
{
    uint64_t h = co_hash64((uint64_t)(uintptr_t)stack * 5 ^ (uint64_t)(uintptr_t)path);
    for (size_t at = h & (capacity - 1);; at = (at + 1) & (capacity - 1))
        if (!slots[at] || (slots[at]->stack == stack && slots[at]->path == path))
            return &slots[at];
}

static void grow_cache(CoComposer *c)
{
    size_t capacity = c->site_capacity ? c->site_capacity * 2 : 1024;
    CoSite **slots = co_composer_array(c, capacity, sizeof *slots);
    for (size_t i = 0; i < c->site_capacity; i++)
        if (c->sites[i])
            *find_slot(slots, capacity, c->sites[i]->stack, c->sites[i]->path) = c->sites[i];
    c->sites = slots;
    c->site_capacity = capacity;
}

// Most paths mean something in one stack only. Paths that are made after each other are asked for
// after each other, so that a list by number keeps together what a table would scatter.
static CoSite **first_slot(CoComposer *c, const CoPath *path)
{
    if (path->number >= c->first_site_capacity) {
        size_t capacity = c->first_site_capacity ? c->first_site_capacity : 256;
        while (capacity <= path->number)
            capacity *= 2;
        CoSite **grown = co_composer_array(c, capacity, sizeof *grown);
        if (c->first_site_capacity)
            memcpy(grown, c->first_sites, c->first_site_capacity * sizeof *grown);
        c->first_sites = grown;
        c->first_site_capacity = capacity;
    }
    return &c->first_sites[path->number];
}

// Where the site stands or goes. What is made meanwhile may move it.
static CoSite **slot_of(CoComposer *c, const CoStack *stack, const CoPath *path)
{
    CoSite **first = first_slot(c, path);
    if (!*first || (*first)->stack == stack)
        return first;
    if (2 * c->site_count >= c->site_capacity)
        grow_cache(c);
    return find_slot(c->sites, c->site_capacity, stack, path);
}

static const CoSpec *spec_below(const CoSpec *parent, const CoPath *path)
{
    if (!path->selection)
        return co_spec_child(parent, path->name);
    const CoContents *in = co_spec_contents(parent);
    for (size_t i = 0; i < in->variant_set_count; i++)
        if (in->variant_sets[i]->name == path->name)
            return co_spec_child(in->variant_sets[i], path->selection);
    return NULL;
}

static uint32_t spec_flags(const CoComposer *c, const CoSpec *spec)
{
    const CoFieldNames *n = &c->names;
    uint32_t flags = co_spec_contents(spec)->variant_set_count ? CO_SITE_VARIANT_SETS : 0;
    for (size_t i = 0; i < spec->field_count; i++) {
        const char *name = spec->fields[i].name;
        flags |= name == n->references         ? CO_SITE_REFERENCES
                 : name == n->payload          ? CO_SITE_PAYLOADS
                 : name == n->inheritPaths     ? CO_SITE_INHERITS
                 : name == n->specializes      ? CO_SITE_SPECIALIZES
                 : name == n->variantSetNames  ? CO_SITE_VARIANT_SETS
                 : name == n->variantSelection ? CO_SITE_SELECTIONS
                 : name == n->instanceable     ? CO_SITE_INSTANCEABLE
                                               : 0u;
    }
    return flags;
}

static void find_specs(CoComposer *c, CoSite *site)
{
    CoSiteSpec stack_specs[64];
    CoSiteSpec *found = stack_specs;
    CoStack *stack = site->stack;
    if (stack->layer_count > 64)
        found = co_composer_array(c, stack->layer_count, sizeof *found);
    uint32_t count = 0;
    if (!site->path->parent) {
        for (size_t i = 0; i < stack->layer_count; i++)
            found[count++] = (CoSiteSpec){stack->layers[i].file->layer->root, (uint32_t)i};
    } else {
        const CoSite *parent = co_site(c, stack, site->path->parent);
        for (uint32_t i = 0; i < parent->spec_count; i++) {
            const CoSpec *spec = spec_below(parent->specs[i].spec, site->path);
            if (!spec)
                continue;
            found[count++] = (CoSiteSpec){spec, parent->specs[i].layer};
            site->flags |= spec_flags(c, spec);
        }
    }
    if (!count)
        return;
    CoSiteSpec *specs = co_composer_array(c, count, sizeof *specs);
    memcpy(specs, found, count * sizeof *specs);
    site->specs = specs;
    site->spec_count = count;
}

CoSite *co_site(CoComposer *c, CoStack *stack, const CoPath *path)
{
    CoSite *known = *slot_of(c, stack, path);
    if (known)
        return known;
    CoSite *site = co_composer_alloc(c, sizeof *site);
    site->stack = stack;
    site->path = path;
    find_specs(c, site);
    if (co_stack_move_to(stack, path))
        site->flags |= CO_SITE_RELOCATED;
    if (co_stack_move_from(stack, path))
        site->flags |= CO_SITE_MOVED_AWAY;
    CoSite **slot = slot_of(c, stack, path);
    c->site_count += slot != first_slot(c, path);
    *slot = site;
    return site;
}

// ---- Arcs -------------------------------------------------------------------------------------
typedef struct CoArcReader {
    CoComposer *c;
    const CoSite *site;
    const CoStackLayer *layer;
    uint32_t line;
} CoArcReader;

static bool read_arc(void *context, const CoListOp *op, CoListOpKind kind, size_t i,
                     CoListItem *out)
{
    CoArcReader *reader = context;
    CoComposer *c = reader->c;
    const CoArc *arc = (const CoArc *)op->list[kind].items + i;
    const char *why = NULL;
    const char *asset = co_expression_evaluate(c, reader->site->stack->variables, arc->asset, &why);
    uint32_t line = arc->line ? arc->line : reader->line;
    if (!asset) {
        co_composer_warn(c, COHORT_PROBLEM_VARIABLE_EXPRESSION, reader->layer->file, line,
                         reader->site->path, "asset path @%s@: %s", arc->asset, why);
        return false;
    }
    // An expression may come to nothing on purpose: the arc is then not there.
    if (!*asset && *arc->asset)
        return false;
    CoSiteArc *made = co_composer_alloc(c, sizeof *made);
    *made = (CoSiteArc){asset,      co_asset_anchor(c, reader->layer->file, asset),
                        arc->prim,  arc->offset,
                        arc->scale, reader->layer,
                        line};
    *out = (CoListItem){.a = made->asset,
                        .b = co_composer_need(c, co_token(arc->prim, strlen(arc->prim))),
                        .offset = arc->offset,
                        .scale = arc->scale,
                        .source = made};
    made->prim = out->b;
    return true;
}

static bool read_name(void *context, const CoListOp *op, CoListOpKind kind, size_t i,
                      CoListItem *out)
{
    CoArcReader *reader = context;
    const CohortString *text = (const CohortString *)op->list[kind].items + i;
    *out = (CoListItem){.a = co_composer_need(reader->c, co_token(text->text, text->length)),
                        .source = reader->layer,
                        .line = reader->line};
    return true;
}

static CoList compose_list(CoComposer *c, const CoSite *site, const char *name, CoListItemFn *fn)
{
    CoList list = {.is_scratch = true};
    for (uint32_t i = site->spec_count; i-- > 0;) {
        const CoField *field = co_spec_field(site->specs[i].spec, name);
        const CoListOp *op = field ? co_value_list_op(&field->value) : NULL;
        CoArcReader reader = {c, site, &site->stack->layers[site->specs[i].layer],
                              field ? field->line : 0};
        if (op)
            co_list_apply(c, &list, op, fn, &reader);
    }
    return list;
}

static size_t compose_arcs(CoComposer *c, const CoSite *site, const char *name, CoSiteArc **out)
{
    CoList list = compose_list(c, site, name, read_arc);
    *out = co_composer_array(c, list.count, sizeof **out);
    for (size_t i = 0; i < list.count; i++)
        (*out)[i] = *(const CoSiteArc *)list.items[i].source;
    return list.count;
}

static size_t copy_names(CoComposer *c, const CoList *list, CoSiteName **out)
{
    *out = co_composer_array(c, list->count, sizeof **out);
    for (size_t i = 0; i < list->count; i++)
        (*out)[i] = (CoSiteName){list->items[i].a, list->items[i].source, list->items[i].line};
    return list->count;
}

const CoSiteArcs *co_site_arcs(CoComposer *c, CoSite *site)
{
    if (site->arcs)
        return site->arcs;
    CoSiteArcs *arcs = co_composer_alloc(c, sizeof *arcs);
    const CoFieldNames *n = &c->names;
    if (site->flags & CO_SITE_REFERENCES)
        arcs->reference_count = compose_arcs(c, site, n->references, &arcs->references);
    if (site->flags & CO_SITE_PAYLOADS)
        arcs->payload_count = compose_arcs(c, site, n->payload, &arcs->payloads);
    if (site->flags & CO_SITE_INHERITS) {
        CoList list = compose_list(c, site, n->inheritPaths, read_name);
        arcs->inherit_count = copy_names(c, &list, &arcs->inherits);
    }
    if (site->flags & CO_SITE_SPECIALIZES) {
        CoList list = compose_list(c, site, n->specializes, read_name);
        arcs->specialize_count = copy_names(c, &list, &arcs->specializes);
    }
    if (site->flags & CO_SITE_VARIANT_SETS) {
        CoList list = compose_list(c, site, n->variantSetNames, read_name);
        arcs->variant_set_count = copy_names(c, &list, &arcs->variant_sets);
    }
    site->arcs = arcs;
    return arcs;
}

const char *co_site_selection(CoComposer *c, const CoSite *site, const char *set)
{
    if (!(site->flags & CO_SITE_SELECTIONS))
        return NULL;
    for (uint32_t i = 0; i < site->spec_count; i++) {
        const CoField *field = co_spec_field(site->specs[i].spec, c->names.variantSelection);
        const CoDict *dict = field ? co_value_dict(&field->value) : NULL;
        for (size_t j = 0; dict && j < dict->count; j++) {
            const CohortString *text = co_value_text(dict->entries[j].value);
            if (dict->entries[j].key != set || !text)
                continue;
            const char *why = NULL;
            const char *selection =
                co_expression_evaluate(c, site->stack->variables, text->text, &why);
            if (selection)
                return co_composer_need(c, co_token(selection, strlen(selection)));
            co_composer_warn(c, COHORT_PROBLEM_VARIABLE_EXPRESSION,
                             site->stack->layers[site->specs[i].layer].file, field->line,
                             site->path, "variant selection of \"%s\": %s", set, why);
        }
    }
    return NULL;
}
