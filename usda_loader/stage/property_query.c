// Properties of a prim: names in their order, kinds, and the opinions on each.

#include "stage/stage_data.h"

#include "compose/fields.h"

#include "base/hash.h"

#include <stdlib.h>
#include <string.h>

const char *co_property_token(const CohortPrim *prim, const char *name)
{
    // Callers mostly have the name from the stage, which gives out tokens.
    for (uint32_t i = 0; i < prim->data->opinion_count; i++)
        if (co_spec_property(prim->data->opinions[i].spec, name))
            return name;
    return co_token(name, strlen(name));
}

CoPropertyWalk co_property_walk(const CohortPrim *prim, const char *name)
{
    return (CoPropertyWalk){.prim = prim, .name = name, .kind = CO_SPEC_LAYER};
}

bool co_property_next(CoPropertyWalk *walk)
{
    while (walk->name && walk->next < walk->prim->data->opinion_count) {
        const CoOpinion *opinion = &walk->prim->data->opinions[walk->next++];
        const CoSpec *spec = co_spec_property(opinion->spec, walk->name);
        if (!spec)
            continue;
        if (walk->kind == CO_SPEC_LAYER)
            walk->kind = spec->kind;
        if (spec->kind != walk->kind)
            continue;
        walk->spec = spec;
        walk->source = opinion->source;
        return true;
    }
    return false;
}

// ---- Names --------------------------------------------------------------------------------------
static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

static char fold(char c)
{
    return c >= 'A' && c <= 'Z' ? (char)(c + 32) : c;
}

int co_name_compare(const char *a, const char *b)
{
    int tie = 0; // what decides when nothing else does
    while (*a && *b) {
        if (is_digit(*a) && is_digit(*b)) {
            size_t zeros_a = strspn(a, "0"), zeros_b = strspn(b, "0");
            size_t n = strspn(a + zeros_a, "0123456789"), m = strspn(b + zeros_b, "0123456789");
            if (n != m)
                return n < m ? -1 : 1;
            int order = strncmp(a + zeros_a, b + zeros_b, n);
            if (order)
                return order;
            if (!tie && zeros_a != zeros_b)
                tie = zeros_a < zeros_b ? -1 : 1;
            a += zeros_a + n;
            b += zeros_b + m;
            continue;
        }
        unsigned char x = (unsigned char)fold(*a), y = (unsigned char)fold(*b);
        if (x != y)
            return x < y ? -1 : 1;
        if (!tie && *a != *b)
            tie = (unsigned char)*a < (unsigned char)*b ? -1 : 1;
        a++;
        b++;
    }
    if (*a || *b)
        return *a ? 1 : -1;
    return tie;
}

static int compare_names(const void *a, const void *b)
{
    return co_name_compare(*(const char *const *)a, *(const char *const *)b);
}

static size_t find_name(const char *const *names, size_t count, const CohortString *name)
{
    size_t i = 0;
    while (i < count && strcmp(names[i], name->text) != 0)
        i++;
    return i;
}

// propertyOrder moves what it names; each takes along the unnamed ones that follow it. `sorted` has
// room for `count` names and as many flags.
static void reorder(const CoField *order_field, const char **names, size_t count,
                    const char **sorted, bool *is_named)
{
    const CohortString *order = order_field->value.data;
    for (size_t k = 0; k < order_field->value.count; k++) {
        size_t at = find_name(names, count, &order[k]);
        if (at < count)
            is_named[at] = true;
    }
    size_t made = 0;
    for (size_t i = 0; i < count && !is_named[i]; i++)
        sorted[made++] = names[i];
    for (size_t k = 0; k < order_field->value.count; k++) {
        size_t at = find_name(names, count, &order[k]);
        if (at == count || find_name(sorted, made, &order[k]) < made)
            continue;
        do
            sorted[made++] = names[at++];
        while (at < count && !is_named[at]);
    }
    memcpy(names, sorted, count * sizeof *names);
}

static const CoField *property_order(const CoPrimData *data)
{
    const CoField *field = NULL;
    for (uint32_t i = 0; i < data->opinion_count && !field; i++)
        field = co_spec_field(data->opinions[i].spec, data->stage->composer.names.propertyOrder);
    return field && field->value.type == COHORT_TYPE_TOKEN ? field : NULL;
}

// A list of `count` authored names, made and put in order in the answers' arena.
static const CoNameList *make_names(const CoPrimData *data, const char *const *authored,
                                    size_t count, const CoField *order)
{
    CoNameList *list = co_stage_alloc(data->stage, 1, sizeof *list);
    const char **names = co_stage_alloc(data->stage, count, sizeof *names);
    if (!list || !names)
        return NULL;
    memcpy(names, authored, count * sizeof *names);
    qsort(names, count, sizeof *names, compare_names);
    for (size_t i = 0; i < count; i++)
        if (!list->count || names[list->count - 1] != names[i])
            names[list->count++] = names[i];
    list->names = names;
    list->authored = authored;
    list->authored_count = count;
    if (order && list->count > 1) {
        const char **sorted = co_stage_alloc(data->stage, list->count, sizeof *sorted);
        bool *flags = co_stage_alloc(data->stage, list->count, sizeof *flags);
        if (!sorted || !flags)
            return NULL;
        reorder(order, names, list->count, sorted, flags);
    }
    return list;
}

// What opinions hold, one after another; NULL when memory is at an end.
static const char **authored_names(const CoPrimData *data, size_t *count)
{
    size_t most = 0;
    for (uint32_t i = 0; i < data->opinion_count; i++)
        most += co_spec_contents(data->opinions[i].spec)->property_count;
    const char **names = co_stage_alloc(data->stage, most, sizeof *names);
    *count = 0;
    for (uint32_t i = 0; names && i < data->opinion_count; i++) {
        const CoContents *in = co_spec_contents(data->opinions[i].spec);
        for (size_t j = 0; j < in->property_count; j++)
            names[(*count)++] = in->properties[j]->name;
    }
    return names;
}

static const CoNameList empty_names = {0};

// The list of a prim (with the lock held): that of another prim with the same names, if any.
static const CoNameList *find_names(const CoPrimData *data)
{
    const CohortStage *stage = data->stage;
    CoArenaMark mark = co_arena_mark(&stage->answers_arena);
    size_t count;
    const char **authored = authored_names(data, &count);
    if (!authored || !count)
        return authored ? &empty_names : NULL;
    const CoField *order = property_order(data);
    uint64_t hash = co_hash_bytes(authored, count * sizeof *authored, 0);
    CoQueryKey key = {NULL, NULL, CO_QUERY_PROPERTIES | hash << 8, 0};
    const CoAnswer *known = order ? NULL : co_stage_find_answer(stage, &key);
    const CoNameList *list = known ? known->data : NULL;
    if (list && list->authored_count == count &&
        !memcmp(list->authored, authored, count * sizeof *authored)) {
        co_arena_rewind(&stage->self->answers_arena, mark);
        return list;
    }
    list = make_names(data, authored, count, order);
    if (list && !order && !known)
        co_stage_keep_answer(stage, &key, &(CoAnswer){.data = list});
    return list;
}

static const CoNameList *property_names(const CohortPrim *prim)
{
    CoPrimData *data = prim->data;
    const CoNameList *list = atomic_load_explicit(&data->properties, memory_order_acquire);
    if (list)
        return list;
    co_stage_lock(data->stage);
    list = find_names(data);
    co_stage_unlock(data->stage);
    // Two threads may both get here, each with a list of the same names that stays.
    if (list)
        atomic_store_explicit(&data->properties, list, memory_order_release);
    return list ? list : &empty_names;
}

size_t cohort_prim_property_count(const CohortPrim *prim)
{
    return property_names(prim)->count;
}

const char *cohort_prim_property_name(const CohortPrim *prim, size_t i)
{
    const CoNameList *list = property_names(prim);
    return i < list->count ? list->names[i] : NULL;
}

static CoSpecKind property_kind(const CohortPrim *prim, const char *name)
{
    CoPropertyWalk walk = co_property_walk(prim, co_property_token(prim, name));
    return co_property_next(&walk) ? walk.kind : CO_SPEC_LAYER;
}

bool cohort_prim_has_attribute(const CohortPrim *prim, const char *name)
{
    return property_kind(prim, name) == CO_SPEC_ATTRIBUTE;
}

bool cohort_prim_has_relationship(const CohortPrim *prim, const char *name)
{
    return property_kind(prim, name) == CO_SPEC_RELATIONSHIP;
}

bool cohort_prim_origin(const CohortPrim *prim, const char *property, const char **layer,
                        uint32_t *line)
{
    CoPropertyWalk walk = co_property_walk(prim, co_property_token(prim, property));
    if (!co_property_next(&walk))
        return false;
    *layer = walk.source->file->path;
    *line = walk.spec->line;
    return true;
}

// ---- Opinions -----------------------------------------------------------------------------------
static bool is_known_above(const CohortPrim *prim, const CoSource *source)
{
    const CoPrimData *above = prim->data->above;
    for (uint32_t i = 0; above && i < above->opinion_count; i++)
        if (above->opinions[i].source == source)
            return true;
    return false;
}

size_t cohort_prim_opinion_count(const CohortPrim *prim)
{
    return prim->data->opinion_count;
}

static CohortOpinion describe(const CohortPrim *prim, const CoSpec *spec, const CoSource *source)
{
    static const char *const arcs[] = {"local",     "inherit", "variant",   "relocate",
                                       "reference", "payload", "specialize"};
    return (CohortOpinion){source->file->path, spec->line, arcs[source->arc],
                           !is_known_above(prim, source)};
}

bool cohort_prim_opinion(const CohortPrim *prim, size_t i, CohortOpinion *out)
{
    if (i >= prim->data->opinion_count)
        return false;
    *out = describe(prim, prim->data->opinions[i].spec, prim->data->opinions[i].source);
    return true;
}

bool cohort_prim_property_opinion(const CohortPrim *prim, const char *property, size_t i,
                                  CohortOpinion *out)
{
    CoPropertyWalk walk = co_property_walk(prim, co_property_token(prim, property));
    do {
        if (!co_property_next(&walk))
            return false;
    } while (i-- > 0);
    *out = describe(prim, walk.spec, walk.source);
    return true;
}
