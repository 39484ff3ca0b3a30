// What a stack moves: the relocates of all its layers, checked against each other.
//
// Source: the reference's rules of relocates, each tried: a root prim cannot be moved, nothing
// moves onto an ancestor or below itself; of several moves of one prim that of the strongest layer
// counts; moves that contradict each other are all left out.

#include "compose/composer.h"
#include "compose/fields.h"

#include <string.h>

// A move and who says so.
typedef struct CoClaim {
    CoMove move;
    const CoLayerFile *file;
    uint32_t line;
    bool is_out;
} CoClaim;

typedef struct CoClaims {
    CoClaim *items;
    size_t count, capacity;
} CoClaims;

static bool is_below(const CoPath *path, const CoPath *above)
{
    return path != above && co_path_has_prefix(path, above);
}

static const CoPath *parse_prim_path(CoComposer *c, const char *text)
{
    bool malformed;
    return co_path_parse(&c->paths, text, strlen(text), &c->paths.root, &malformed);
}

static bool is_allowed(CoComposer *c, const CoClaim *claim, bool deletes)
{
    const CoPath *source = claim->move.source, *target = claim->move.target;
    const char *why = NULL;
    if (!source || (!target && !deletes))
        why = "is no prim path";
    else if (source->depth < 2)
        why = "would move a root prim";
    else if (source == target)
        why = "leads to itself";
    else if (target && is_below(source, target))
        why = "would move a prim onto its ancestor";
    else if (target && is_below(target, source))
        why = "would move a prim below itself";
    if (why)
        co_composer_warn(c, COHORT_PROBLEM_INVALID_RELOCATE, claim->file, claim->line, source,
                         "a relocate %s and is ignored", why);
    return !why;
}

static void read_layer(CoComposer *c, CoClaims *claims, const CoLayerFile *file)
{
    const CoField *field = co_layer_field(file, c->names.relocates);
    if (!field || field->value.type != COHORT_TYPE_RELOCATES)
        return;
    size_t before = claims->count;
    const CoRelocate *items = field->value.data;
    for (size_t i = 0; i < field->value.count; i++) {
        CoClaim claim = {.file = file, .line = field->line};
        claim.move.source = parse_prim_path(c, items[i].source);
        claim.move.target = *items[i].target ? parse_prim_path(c, items[i].target) : NULL;
        if (!is_allowed(c, &claim, !*items[i].target))
            continue;
        bool is_overridden = false;
        for (size_t j = 0; j < before && !is_overridden; j++)
            is_overridden = claims->items[j].move.source == claim.move.source;
        if (is_overridden)
            continue;
        claims->items = co_composer_grow(c, claims->items, claims->count, &claims->capacity,
                                         sizeof *claims->items);
        claims->items[claims->count++] = claim;
    }
}

static const char *contradiction(const CoMove *move, const CoMove *other)
{
    if (move->target && move->target == other->target)
        return "leads to the same target as";
    if (move->target && move->target == other->source)
        return "leads to the source of";
    if (move->source == other->target)
        return "moves the target of";
    if (move->target && is_below(move->target, other->source))
        return "leads below the source of";
    if (is_below(move->source, other->source))
        return "moves what is below the source of";
    return NULL;
}

static void leave_out_contradictions(CoComposer *c, CoClaims *claims)
{
    for (size_t i = 0; i < claims->count; i++) {
        CoClaim *claim = &claims->items[i];
        for (size_t j = 0; j < claims->count && !claim->is_out; j++) {
            const CoClaim *other = &claims->items[j];
            const char *how = i == j ? NULL : contradiction(&claim->move, &other->move);
            if (!how)
                continue;
            char text[256];
            bool is_same_target = claim->move.target && claim->move.target == other->move.target;
            co_path_text(other->move.source, text, sizeof text);
            co_composer_warn(c,
                             is_same_target ? COHORT_PROBLEM_SAME_TARGET_RELOCATES
                                            : COHORT_PROBLEM_CONFLICTING_RELOCATE,
                             claim->file, claim->line, claim->move.source,
                             "a relocate %s that of <%s> and is ignored", how, text);
            claim->is_out = true;
        }
    }
}

// Traces each source back through the moves of its ancestors.
static void find_origins(CoComposer *c, CoStack *stack)
{
    for (size_t i = 0; i < stack->relocate_count; i++) {
        CoMove *move = &stack->relocates[i];
        move->origin = move->source;
        // No more steps than moves: more would be a loop.
        for (size_t step = 0; step < stack->relocate_count; step++) {
            const CoMove *above = NULL;
            for (size_t j = 0; j < stack->relocate_count; j++) {
                const CoMove *other = &stack->relocates[j];
                bool is_above = other->target && co_path_has_prefix(move->origin, other->target);
                if (is_above && (!above || other->target->length > above->target->length))
                    above = other;
            }
            if (!above)
                break;
            move->origin = co_composer_need(
                c, co_path_replace_prefix(&c->paths, move->origin, above->target, above->source));
        }
    }
}

void co_stack_relocates(CoComposer *c, CoStack *stack)
{
    CoClaims claims = {0};
    for (size_t i = 0; i < stack->layer_count; i++)
        read_layer(c, &claims, stack->layers[i].file);
    if (!claims.count)
        return;
    leave_out_contradictions(c, &claims);
    stack->relocates = co_composer_array(c, claims.count, sizeof *stack->relocates);
    for (size_t i = 0; i < claims.count; i++)
        if (!claims.items[i].is_out)
            stack->relocates[stack->relocate_count++] = claims.items[i].move;
    find_origins(c, stack);
}
