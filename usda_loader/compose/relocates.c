// What a stack moves: the relocates of all its layers, checked against each other.
//
// Source: the reference's rules of relocates, each tried: a root prim cannot be moved, nothing
// moves onto an ancestor or below itself; of several moves of one prim that of the strongest layer
// counts; moves that contradict each other are all left out.

#include "compose/composer.h"
#include "compose/fields.h"

#include "base/hash.h"

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
    CoMoveIndex index;
} CoClaims;

// ---- Finding moves ------------------------------------------------------------------------------
static CoMovesAt *find_slot(const CoMoveIndex *index, const CoPath *path)
{
    size_t at = co_hash64((uint64_t)(uintptr_t)path) & (index->capacity - 1);
    while (index->slots[at].path && index->slots[at].path != path)
        at = (at + 1) & (index->capacity - 1);
    return &index->slots[at];
}

static CoMovesAt *make_slot(CoComposer *c, CoMoveIndex *index, const CoPath *path)
{
    if (2 * index->count >= index->capacity) {
        CoMoveIndex grown = {.count = index->count,
                             .capacity = index->capacity ? 2 * index->capacity : 32};
        grown.slots = co_composer_array(c, grown.capacity, sizeof *grown.slots);
        for (size_t i = 0; i < index->capacity; i++)
            if (index->slots[i].path)
                *find_slot(&grown, index->slots[i].path) = index->slots[i];
        *index = grown;
    }
    CoMovesAt *slot = find_slot(index, path);
    index->count += !slot->path;
    slot->path = path;
    return slot;
}

static void put_first(CoComposer *c, CoMoveIndex *index, CoMove *move, size_t number,
                      CoMoveList list, const CoPath *path)
{
    if (!path)
        return;
    CoMovesAt *slot = make_slot(c, index, path);
    move->next[list] = slot->first[list];
    slot->first[list] = (uint32_t)number + 1;
}

// Later moves are to be added before earlier ones.
static void index_move(CoComposer *c, CoMoveIndex *index, CoMove *move, size_t number)
{
    const CoPath *to = move->target;
    put_first(c, index, move, number, CO_MOVES_FROM, move->source);
    put_first(c, index, move, number, CO_MOVES_TO, to);
    put_first(c, index, move, number, CO_MOVES_OF_CHILDREN, move->source->parent);
    put_first(c, index, move, number, CO_MOVES_TO_CHILDREN, to ? to->parent : NULL);
}

static void mark_above(CoComposer *c, CoMoveIndex *index, const CoPath *path)
{
    for (; path; path = path->parent) {
        CoMovesAt *slot = make_slot(c, index, path);
        if (slot->is_above)
            return;
        slot->is_above = true;
    }
}

const CoMovesAt *co_stack_moves_at(const CoStack *stack, const CoPath *path)
{
    if (!stack->moves.capacity)
        return NULL;
    const CoMovesAt *slot = find_slot(&stack->moves, path);
    return slot->path ? slot : NULL;
}

static const CoMove *first_move(const CoStack *stack, const CoPath *path, CoMoveList list)
{
    const CoMovesAt *at = co_stack_moves_at(stack, path);
    return at && at->first[list] ? &stack->relocates[at->first[list] - 1] : NULL;
}

const CoMove *co_stack_move_from(const CoStack *stack, const CoPath *source)
{
    return first_move(stack, source, CO_MOVES_FROM);
}

const CoMove *co_stack_move_to(const CoStack *stack, const CoPath *target)
{
    return first_move(stack, target, CO_MOVES_TO);
}

// ---- Reading ------------------------------------------------------------------------------------
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
        const CoMovesAt *at =
            claims->index.capacity ? find_slot(&claims->index, claim.move.source) : NULL;
        if (at && at->first[CO_MOVES_FROM])
            continue;
        claims->items = co_composer_grow(c, claims->items, claims->count, &claims->capacity,
                                         sizeof *claims->items);
        claims->items[claims->count++] = claim;
    }
    for (size_t i = claims->count; i-- > before;)
        index_move(c, &claims->index, &claims->items[i].move, i);
}

// ---- Contradictions -----------------------------------------------------------------------------
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

typedef struct CoConflict {
    const CoClaim *with; // the first; NULL: none
    const char *how;
} CoConflict;

static void look_for_conflict(const CoClaims *claims, const CoClaim *claim, const CoPath *path,
                              CoMoveList list, CoConflict *found)
{
    const CoMovesAt *at = find_slot(&claims->index, path);
    for (uint32_t i = at->first[list]; i;) {
        const CoClaim *other = &claims->items[i - 1];
        const char *how = other == claim ? NULL : contradiction(&claim->move, &other->move);
        if (how && (!found->with || other < found->with))
            *found = (CoConflict){other, how};
        i = other->move.next[list];
    }
}

static CoConflict find_conflict(const CoClaims *claims, const CoClaim *claim)
{
    CoConflict found = {0};
    const CoMove *move = &claim->move;
    if (move->target)
        look_for_conflict(claims, claim, move->target, CO_MOVES_TO, &found);
    look_for_conflict(claims, claim, move->source, CO_MOVES_TO, &found);
    for (const CoPath *path = move->target; path; path = path->parent)
        look_for_conflict(claims, claim, path, CO_MOVES_FROM, &found);
    for (const CoPath *path = move->source->parent; path; path = path->parent)
        look_for_conflict(claims, claim, path, CO_MOVES_FROM, &found);
    return found;
}

static void leave_out_contradictions(CoComposer *c, CoClaims *claims)
{
    for (size_t i = 0; i < claims->count; i++) {
        CoClaim *claim = &claims->items[i];
        CoConflict conflict = find_conflict(claims, claim);
        if (!conflict.with)
            continue;
        const CoMove *other = &conflict.with->move;
        char text[256];
        bool is_same_target = claim->move.target && claim->move.target == other->target;
        co_path_text(other->source, text, sizeof text);
        co_composer_warn(c,
                         is_same_target ? COHORT_PROBLEM_SAME_TARGET_RELOCATES
                                        : COHORT_PROBLEM_CONFLICTING_RELOCATE,
                         claim->file, claim->line, claim->move.source,
                         "a relocate %s that of <%s> and is ignored", conflict.how, text);
        claim->is_out = true;
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
            for (const CoPath *path = move->origin; path && !above; path = path->parent)
                above = co_stack_move_to(stack, path);
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
    for (size_t i = stack->relocate_count; i-- > 0;)
        index_move(c, &stack->moves, &stack->relocates[i], i);
    find_origins(c, stack);
    for (size_t i = 0; i < stack->relocate_count; i++) {
        mark_above(c, &stack->moves, stack->relocates[i].source);
        mark_above(c, &stack->moves, stack->relocates[i].origin);
    }
}
