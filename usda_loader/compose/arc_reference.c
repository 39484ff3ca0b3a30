// References and payloads: another prim, of this stack or of another layer, joins in.

#include "compose/fields.h"
#include "compose/indexer.h"
#include "compose/population.h"

#include <math.h>
#include <string.h>

// Where an arc leads once its layer is open.
typedef struct CoArcTarget {
    CoStack *stack;
    const CoPath *path;
    bool is_nothing; // no prim is named and the layer has no default prim
    double offset, scale;
} CoArcTarget;

static void warn(CoIndexer *indexer, CohortProblemKind kind, const CoSiteArc *arc, bool is_payload,
                 const char *what, const char *detail)
{
    co_composer_warn(indexer->c, kind, arc->layer->file, arc->line, co_indexer_stage_path(indexer),
                     "the %s to @%s@%s%s%s %s%s", is_payload ? "payload" : "reference",
                     arc->authored, *arc->prim ? "<" : "", arc->prim, *arc->prim ? ">" : "", what,
                     detail);
}

static const CoPath *default_prim(CoIndexer *indexer, const CoLayerFile *file)
{
    CoComposer *c = indexer->c;
    const CoField *field = co_layer_field(file, c->names.defaultPrim);
    const CohortString *text = field ? co_value_text(&field->value) : NULL;
    bool malformed;
    return text && text->length
               ? co_path_parse(&c->paths, text->text, text->length, &c->paths.root, &malformed)
               : NULL;
}

static bool open_target(CoIndexer *indexer, const CoSite *site, const CoSiteArc *arc,
                        bool is_payload, CoArcTarget *target)
{
    CoComposer *c = indexer->c;
    double offset = arc->offset, scale = arc->scale;
    if (!isfinite(offset) || !isfinite(scale) || !(scale > 0)) {
        warn(indexer, COHORT_PROBLEM_INVALID_REFERENCE_OFFSET, arc, is_payload,
             "has an unusable offset, which is ignored", "");
        offset = 0;
        scale = 1;
    }
    const CoLayerFile *file = site->stack->root;
    target->stack = site->stack;
    double rate = 1;
    if (*arc->asset && co_composer_is_muted(c, arc->asset)) {
        warn(indexer, COHORT_PROBLEM_MUTED_ASSET_PATH, arc, is_payload,
             "is left out: its layer is muted", "");
        return false;
    }
    if (*arc->asset) {
        CohortError err = {0};
        file = co_composer_layer(c, arc->asset, &err);
        if (!file) {
            warn(indexer, COHORT_PROBLEM_INVALID_ASSET_PATH, arc, is_payload,
                 "is left out: ", err.message);
            return false;
        }
        target->stack = co_composer_stack(c, file, site->stack->variables);
        rate = arc->layer->file->time_codes_per_second / file->time_codes_per_second;
    }
    // Within a stack, times are the stack's already, whichever of its layers says so.
    target->offset = offset;
    target->scale = scale * rate;
    if (*arc->asset) {
        target->offset = arc->layer->scale * offset + arc->layer->offset;
        target->scale *= arc->layer->scale;
    }
    if (!*arc->prim) {
        target->path = default_prim(indexer, file);
        target->is_nothing = !target->path;
        if (target->is_nothing) {
            warn(indexer, COHORT_PROBLEM_UNRESOLVED_PRIM_PATH, arc, is_payload,
                 "leads to a layer without a default prim", "");
            target->path = &c->paths.root;
        }
        return true;
    }
    bool malformed = true;
    if (arc->prim[0] == '/')
        target->path =
            co_path_parse(&c->paths, arc->prim, strlen(arc->prim), &c->paths.root, &malformed);
    if (malformed) {
        warn(indexer, COHORT_PROBLEM_INVALID_PRIM_PATH, arc, is_payload,
             "names no prim and is left out", "");
        return false;
    }
    co_composer_need(c, target->path);
    return true;
}

static void add(CoIndexer *indexer, uint32_t node, const CoSiteArc *arc, int number,
                bool is_payload)
{
    CoComposer *c = indexer->c;
    CoArcTarget target = {0};
    CoSite *site = indexer->graph.nodes[node].site;
    if (!open_target(indexer, site, arc, is_payload, &target))
        return;
    bool is_internal = !*arc->asset;
    CoArcSpec spec = {
        .kind = is_payload ? CO_ARC_PAYLOAD : CO_ARC_REFERENCE,
        .parent = node,
        .origin = node,
        .site = co_site(c, target.stack, target.path),
        .to_parent = co_indexer_arc_map(indexer, node, target.path, is_internal, target.offset,
                                        target.scale),
        .sibling = number,
        .namespace_depth = site->path->depth,
        .root_depth = indexer->root_depth,
    };
    CoArcOptions options = {.is_placeholder = target.is_nothing,
                            .has_ancestors = target.path->length > 1};
    uint32_t made = co_indexer_add_arc(indexer, &spec, options, arc->layer, arc->line);
    if (made == CO_NO_NODE || target.is_nothing || spec.site->spec_count)
        return;
    // The prim may still come in by an arc of one of its ancestors.
    bool is_there = false;
    uint32_t count, *order = co_composer_scratch(c, indexer->graph.count, sizeof *order);
    co_graph_order(c, &indexer->graph, made, order, &count);
    for (uint32_t i = 0; i < count && !is_there; i++)
        is_there = indexer->graph.nodes[order[i]].site->spec_count > 0;
    if (!is_there)
        warn(indexer, COHORT_PROBLEM_UNRESOLVED_PRIM_PATH, arc, is_payload, "leads to no prim", "");
}

void co_arc_references(CoIndexer *indexer, uint32_t node, bool payloads)
{
    const CoNode *n = &indexer->graph.nodes[node];
    if (!co_node_contributes(n) ||
        (payloads && !co_population_loads(indexer->c, co_indexer_stage_path(indexer))))
        return;
    const CoSiteArcs *arcs = co_site_arcs(indexer->c, n->site);
    size_t count = payloads ? arcs->payload_count : arcs->reference_count;
    for (size_t i = 0; i < count; i++)
        add(indexer, node, payloads ? &arcs->payloads[i] : &arcs->references[i], (int)i, payloads);
}
