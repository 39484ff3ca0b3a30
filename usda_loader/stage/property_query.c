#include "stage/stage_data.h"

#include "compose/fields.h"

#include <stdlib.h>
#include <string.h>

CoPropertyWalk co_property_walk(const CohortPrim *prim, const char *name)
{
    return (CoPropertyWalk){.prim = prim, .name = name, .kind = CO_SPEC_LAYER};
}

bool co_property_next(CoPropertyWalk *walk)
{
    while (walk->name && walk->next < walk->prim->opinion_count) {
        const CoOpinion *opinion = &walk->prim->opinions[walk->next++];
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

// ---- Names
// ----------------------------------------------------------------------------------------
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
static void reorder(const CohortPrim *prim, const char **names, size_t count, const char **sorted,
                    bool *is_named)
{
    const CoField *field = NULL;
    for (uint32_t i = 0; i < prim->opinion_count && !field; i++)
        field = co_spec_field(prim->opinions[i].spec, prim->stage->composer.names.propertyOrder);
    if (!field || field->value.type != COHORT_TYPE_TOKEN)
        return;
    const CohortString *order = field->value.data;
    for (size_t k = 0; k < field->value.count; k++) {
        size_t at = find_name(names, count, &order[k]);
        if (at < count)
            is_named[at] = true;
    }
    size_t made = 0;
    for (size_t i = 0; i < count && !is_named[i]; i++)
        sorted[made++] = names[i];
    for (size_t k = 0; k < field->value.count; k++) {
        size_t at = find_name(names, count, &order[k]);
        if (at == count || find_name(sorted, made, &order[k]) < made)
            continue;
        do
            sorted[made++] = names[at++];
        while (at < count && !is_named[at]);
    }
    memcpy(names, sorted, count * sizeof *names);
}

static CoAnswer property_names(const CohortPrim *prim)
{
    const CohortStage *stage = prim->stage;
    CoQueryKey key = {prim, NULL, CO_QUERY_PROPERTIES, 0};
    const CoAnswer *known = co_stage_find_answer(stage, &key);
    if (known)
        return *known;
    size_t most = 0, count = 0;
    for (uint32_t i = 0; i < prim->opinion_count; i++)
        most += prim->opinions[i].spec->property_count;
    const char **names = co_stage_alloc(stage, 2 * most + 1, sizeof *names);
    bool *flags = co_stage_alloc(stage, most + 1, sizeof *flags);
    if (!names || !flags)
        return (CoAnswer){0};
    for (uint32_t i = 0; i < prim->opinion_count; i++)
        for (size_t j = 0; j < prim->opinions[i].spec->property_count; j++)
            names[count++] = prim->opinions[i].spec->properties[j]->name;
    if (count > 1)
        qsort(names, count, sizeof *names, compare_names);
    size_t unique = 0;
    for (size_t i = 0; i < count; i++)
        if (!unique || names[unique - 1] != names[i])
            names[unique++] = names[i];
    if (unique > 1)
        reorder(prim, names, unique, names + most, flags);
    CoAnswer answer = {.data = names, .count = unique};
    co_stage_keep_answer(stage, &key, &answer);
    return answer;
}

static CoAnswer locked_names(const CohortPrim *prim)
{
    co_stage_lock(prim->stage);
    CoAnswer answer = property_names(prim);
    co_stage_unlock(prim->stage);
    return answer;
}

size_t cohort_prim_property_count(const CohortPrim *prim)
{
    return locked_names(prim).count;
}

const char *cohort_prim_property_name(const CohortPrim *prim, size_t i)
{
    CoAnswer answer = locked_names(prim);
    return i < answer.count ? ((const char *const *)answer.data)[i] : NULL;
}

static CoSpecKind property_kind(const CohortPrim *prim, const char *name)
{
    CoPropertyWalk walk = co_property_walk(prim, co_token(name, strlen(name)));
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
    CoPropertyWalk walk = co_property_walk(prim, co_token(property, strlen(property)));
    if (!co_property_next(&walk))
        return false;
    *layer = walk.source->file->path;
    *line = walk.spec->line;
    return true;
}

// ---- Opinions
// -------------------------------------------------------------------------------------
static bool is_known_above(const CohortPrim *prim, const CoSource *source)
{
    for (uint32_t i = 0; prim->parent && i < prim->parent->opinion_count; i++)
        if (prim->parent->opinions[i].source == source)
            return true;
    return false;
}

size_t cohort_prim_opinion_count(const CohortPrim *prim)
{
    return prim->opinion_count;
}

bool cohort_prim_opinion(const CohortPrim *prim, size_t i, CohortOpinion *out)
{
    static const char *const arcs[] = {"local",     "inherit", "variant",   "relocate",
                                       "reference", "payload", "specialize"};
    if (i >= prim->opinion_count)
        return false;
    const CoOpinion *opinion = &prim->opinions[i];
    *out = (CohortOpinion){opinion->source->file->path, opinion->spec->line,
                           arcs[opinion->source->arc], !is_known_above(prim, opinion->source)};
    return true;
}
