// Specs: creation while parsing, and the queries of the finished layer.

#include "base/hash.h"
#include "parse/parser.h"

#include <string.h>

// Lists up to this length are searched in order; longer ones have a table of their positions.
enum {
    SHORT_LIST = 16
};

struct CoNameIndex {
    uint32_t *slots; // position + 1, 0 = empty
    size_t capacity; // a power of two
};

static size_t slot_of(const char *name, size_t capacity)
{
    return (size_t)co_hash64((uint64_t)(uintptr_t)name) & (capacity - 1);
}

static void index_add(CoNameIndex *index, const char *name, size_t position)
{
    size_t slot = slot_of(name, index->capacity);
    while (index->slots[slot])
        slot = (slot + 1) & (index->capacity - 1);
    index->slots[slot] = (uint32_t)position + 1;
}

// Keeps the table at most half full; the old one stays in the arena until the layer goes.
static bool index_update(CoParser *p, CoNameIndex **index, CoSpec *const *list, size_t count)
{
    if (count <= SHORT_LIST)
        return true;
    if (*index && count * 2 <= (*index)->capacity) {
        index_add(*index, list[count - 1]->name, count - 1);
        return true;
    }
    if (count >= UINT32_MAX)
        return co_parse_stop(p, p->scan.at, COHORT_ERROR_LIMIT,
                             "more than 2^32 names in one place");
    CoNameIndex *grown = co_parse_alloc(p, 1, sizeof *grown);
    if (!grown)
        return false;
    grown->capacity = *index ? (*index)->capacity * 4 : 4 * SHORT_LIST * 2;
    grown->slots = co_parse_alloc(p, grown->capacity, sizeof *grown->slots);
    if (!grown->slots)
        return false;
    for (size_t i = 0; i < count; i++)
        index_add(grown, list[i]->name, i);
    *index = grown;
    return true;
}

CoSpec *co_parse_known(const CoNameIndex *index, CoSpec *const *list, size_t count,
                       const char *name)
{
    if (!index) {
        for (size_t i = 0; i < count; i++)
            if (list[i]->name == name)
                return list[i];
        return NULL;
    }
    for (size_t slot = slot_of(name, index->capacity); index->slots[slot];
         slot = (slot + 1) & (index->capacity - 1))
        if (list[index->slots[slot] - 1]->name == name)
            return list[index->slots[slot] - 1];
    return NULL;
}

CoSpec *co_parse_spec(CoParser *p, CoSpec *parent, CoSpecKind kind, const char *name,
                      const char *at)
{
    CoSpec *spec = co_parse_alloc(p, 1, sizeof *spec);
    if (!spec)
        return NULL;
    spec->kind = kind;
    spec->name = name;
    spec->parent = parent;
    spec->line = co_parse_line(p, at);
    spec->type_name = p->empty;
    if (!parent)
        return spec;
    bool is_property = kind == CO_SPEC_ATTRIBUTE || kind == CO_SPEC_RELATIONSHIP;
    CoSpec **slot;
    if (kind == CO_SPEC_VARIANT_SET)
        slot = co_parse_push(p, &parent->variant_sets, &parent->variant_set_count, sizeof *slot);
    else if (is_property)
        slot = co_parse_push(p, &parent->properties, &parent->property_count, sizeof *slot);
    else
        slot = co_parse_push(p, &parent->children, &parent->child_count, sizeof *slot);
    if (!slot)
        return NULL;
    *slot = spec;
    bool good =
        kind == CO_SPEC_VARIANT_SET ||
        (is_property
             ? index_update(p, &parent->property_index, parent->properties, parent->property_count)
             : index_update(p, &parent->child_index, parent->children, parent->child_count));
    return good ? spec : NULL;
}

const CoField *co_spec_field(const CoSpec *spec, const char *name)
{
    for (size_t i = 0; i < spec->field_count; i++)
        if (spec->fields[i].name == name)
            return &spec->fields[i];
    return NULL;
}

const CoSpec *co_spec_child(const CoSpec *spec, const char *name)
{
    return co_parse_known(spec->child_index, spec->children, spec->child_count, name);
}

const CoSpec *co_spec_property(const CoSpec *spec, const char *name)
{
    return co_parse_known(spec->property_index, spec->properties, spec->property_count, name);
}
