// Opening a stage again and telling what has become different.

#include "stage/stage_data.h"

#include "base/error.h"

#include <string.h>

typedef struct CoReload {
    CohortStage *stage; // the new one
    CohortChange *changes;
    size_t count, capacity;
    // Prototypes with changes below them: their other instances have them too.
    const CohortPrim **prototypes;
    size_t prototype_count, prototype_capacity;
    bool is_out_of_memory;
} CoReload;

static void *grow(CoReload *reload, void *items, size_t count, size_t *capacity, size_t size)
{
    if (count < *capacity)
        return items;
    size_t wanted = *capacity ? 2 * *capacity : 16;
    co_stage_lock(reload->stage);
    void *moved = co_stage_alloc(reload->stage, wanted, size);
    co_stage_unlock(reload->stage);
    if (!moved) {
        reload->is_out_of_memory = true;
        return NULL;
    }
    if (count)
        memcpy(moved, items, count * size);
    *capacity = wanted;
    return moved;
}

// The text of a path of either stage, kept by the new one.
static const char *keep_path(CoReload *reload, const CohortPrim *prim)
{
    size_t length = co_prim_path_text(prim, NULL, 0);
    co_stage_lock(reload->stage);
    char *text = co_stage_alloc(reload->stage, length + 1, 1);
    co_stage_unlock(reload->stage);
    if (text)
        co_prim_path_text(prim, text, length + 1);
    else
        reload->is_out_of_memory = true;
    return text;
}

static void add_change(CoReload *reload, const CohortPrim *prim, bool is_structural)
{
    CohortChange *changes =
        grow(reload, reload->changes, reload->count, &reload->capacity, sizeof *reload->changes);
    const char *path = keep_path(reload, prim);
    if (!changes || !path)
        return;
    reload->changes = changes;
    changes[reload->count++] = (CohortChange){path, is_structural};
}

static bool same_opinions(const CoPrimData *a, const CoPrimData *b)
{
    if (a->opinion_count != b->opinion_count)
        return false;
    for (uint32_t i = 0; i < a->opinion_count; i++) {
        const CoSource *x = a->opinions[i].source, *y = b->opinions[i].source;
        if (x->file->path != y->file->path || x->arc != y->arc || x->offset != y->offset ||
            x->scale != y->scale || !co_spec_equal(a->opinions[i].spec, b->opinions[i].spec))
            return false;
    }
    return true;
}

static bool same_structure(const CohortPrim *a, const CohortPrim *b)
{
    const CoPrimData *x = a->data, *y = b->data;
    if (strcmp(x->type, y->type) != 0 || x->specifier != y->specifier || x->flags != y->flags ||
        x->child_count != y->child_count)
        return false;
    for (uint32_t i = 0; i < x->child_count; i++)
        if (co_prim_name(&a->children[i]) != co_prim_name(&b->children[i]))
            return false;
    return true;
}

static bool is_changed_prototype(const CoReload *reload, const CohortPrim *prototype)
{
    for (size_t i = 0; i < reload->prototype_count; i++)
        if (reload->prototypes[i] == prototype)
            return true;
    return false;
}

static void note_prototype(CoReload *reload, const CohortPrim *prototype)
{
    const CohortPrim **grown = grow(reload, reload->prototypes, reload->prototype_count,
                                    &reload->prototype_capacity, sizeof *grown);
    if (!grown)
        return;
    reload->prototypes = grown;
    grown[reload->prototype_count++] = prototype;
}

static void compare(CoReload *reload, const CohortPrim *old, const CohortPrim *new);

// Children by name, in the new order; those that are gone come first.
static void compare_children(CoReload *reload, const CohortPrim *old, const CohortPrim *new)
{
    for (uint32_t i = 0; i < old->data->child_count; i++)
        if (!co_prim_find_child(new, co_prim_name(&old->children[i])))
            add_change(reload, &old->children[i], true);
    for (uint32_t i = 0; i < new->data->child_count && !reload->is_out_of_memory; i++) {
        const CohortPrim *child = &new->children[i];
        const CohortPrim *before = co_prim_find_child(old, co_prim_name(child));
        if (before)
            compare(reload, before, child);
        else
            add_change(reload, child, true);
    }
}

static void compare(CoReload *reload, const CohortPrim *old, const CohortPrim *new)
{
    bool is_structural = !same_structure(old, new);
    const CohortPrim *prototype = new->data->prototype;
    bool is_shared = prototype && prototype != new;
    if (is_shared)
        is_structural |= is_changed_prototype(reload, prototype);
    if (is_structural || !same_opinions(old->data, new->data))
        add_change(reload, new, is_structural);
    if (is_shared)
        return;
    size_t before = reload->count;
    compare_children(reload, old, new);
    if (prototype && reload->count > before)
        note_prototype(reload, prototype);
}

CohortStage *cohort_stage_reload(const CohortStage *stage, CohortError *err)
{
    CohortStage *made =
        co_stage_open(stage->stack->root->path, &stage->composer.options, stage, err);
    if (!made)
        return NULL;
    CoReload reload = {.stage = made};
    compare(&reload, &stage->root, &made->root);
    if (reload.is_out_of_memory) {
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
        cohort_stage_destroy(made);
        return NULL;
    }
    made->changes = reload.changes;
    made->change_count = reload.count;
    return made;
}

size_t cohort_stage_change_count(const CohortStage *stage)
{
    return stage->change_count;
}

bool cohort_stage_change(const CohortStage *stage, size_t i, CohortChange *out)
{
    if (i >= stage->change_count)
        return false;
    *out = stage->changes[i];
    return true;
}
