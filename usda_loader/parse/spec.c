// Specs: creation while parsing, and the queries of the finished layer.

#include "base/hash.h"
#include "base/mapped_file.h"
#include "parse/parser.h"

#include <string.h>

// Lists up to this length are searched in order; longer ones have a table of their positions.
enum {
    SHORT_LIST = 16,
    RELEASE_BYTES = 4 << 20
};

typedef struct Table {
    uint32_t *slots; // position + 1, 0 = empty
    size_t capacity; // a power of two; 0: there is none
} Table;

struct CoNameIndex {
    Table children, properties, variant_sets;
};

static size_t slot_of(const char *name, size_t capacity)
{
    return (size_t)co_hash64((uint64_t)(uintptr_t)name) & (capacity - 1);
}

static void table_add(Table *table, const char *name, size_t position)
{
    size_t slot = slot_of(name, table->capacity);
    while (table->slots[slot])
        slot = (slot + 1) & (table->capacity - 1);
    table->slots[slot] = (uint32_t)position + 1;
}

// Takes in the last of a long list. Keeps the table at most half full.
static bool table_update(CoParser *p, Table *table, CoSpec *const *list, size_t count)
{
    if (count * 2 <= table->capacity) {
        table_add(table, list[count - 1]->name, count - 1);
        return true;
    }
    if (count >= UINT32_MAX)
        return co_parse_stop(p, p->scan.at, COHORT_ERROR_LIMIT,
                             "more than 2^32 names in one place");
    Table grown = {.capacity = table->capacity ? table->capacity * 4 : 4 * SHORT_LIST * 2};
    grown.slots = co_parse_block(p, grown.capacity, sizeof *grown.slots);
    if (!grown.slots)
        return false;
    for (size_t i = 0; i < count; i++)
        table_add(&grown, list[i]->name, i);
    co_parse_list_free(p, table->slots, table->capacity, sizeof *table->slots);
    *table = grown;
    return true;
}

static CoSpec *find(const Table *table, CoSpec *const *list, size_t count, const char *name)
{
    if (!table || !table->capacity) {
        for (size_t i = 0; i < count; i++)
            if (list[i]->name == name)
                return list[i];
        return NULL;
    }
    for (size_t slot = slot_of(name, table->capacity); table->slots[slot];
         slot = (slot + 1) & (table->capacity - 1))
        if (list[table->slots[slot] - 1]->name == name)
            return list[table->slots[slot] - 1];
    return NULL;
}

const CoContents *co_spec_contents(const CoSpec *spec)
{
    static const CoContents none = {0};
    return spec->contents ? spec->contents : &none;
}

CoSpec *co_parse_child(const CoSpec *spec, const char *name)
{
    const CoContents *in = co_spec_contents(spec);
    return find(in->index ? &in->index->children : NULL, in->children, in->child_count, name);
}

CoSpec *co_parse_property_named(const CoSpec *spec, const char *name)
{
    const CoContents *in = co_spec_contents(spec);
    return find(in->index ? &in->index->properties : NULL, in->properties, in->property_count,
                name);
}

CoSpec *co_parse_variant_set(const CoSpec *spec, const char *name)
{
    const CoContents *in = co_spec_contents(spec);
    return find(in->index ? &in->index->variant_sets : NULL, in->variant_sets,
                in->variant_set_count, name);
}

void co_parse_clear_children(CoSpec *spec)
{
    CoContents *in = spec->contents;
    if (!in)
        return;
    in->child_count = 0;
    in->children = NULL;
    in->index = NULL;
}

void co_parse_children_free(CoParser *p, CoContents *contents)
{
    co_parse_list_free(p, contents->children, contents->child_count, sizeof *contents->children);
    if (contents->index)
        co_parse_list_free(p, contents->index->children.slots, contents->index->children.capacity,
                           sizeof *contents->index->children.slots);
    contents->child_count = 0;
    contents->children = NULL;
    contents->index = NULL;
}

// ---- Creation ----------------------------------------------------------------------------------

static bool append(CoParser *p, CoContents *in, CoSpec *spec)
{
    bool is_set = spec->kind == CO_SPEC_VARIANT_SET;
    bool is_child = spec->kind == CO_SPEC_PRIM || spec->kind == CO_SPEC_VARIANT;
    CoSpec ***list = is_set ? &in->variant_sets : is_child ? &in->children : &in->properties;
    uint32_t *count = is_set     ? &in->variant_set_count
                      : is_child ? &in->child_count
                                 : &in->property_count;
    CoSpec **slot = co_parse_push(p, list, *count, sizeof(CoSpec *));
    if (!slot)
        return false;
    *slot = spec;
    ++*count;
    if (*count <= SHORT_LIST)
        return true;
    if (!in->index)
        in->index = co_parse_alloc(p, 1, sizeof *in->index);
    if (!in->index)
        return false;
    Table *table = is_set     ? &in->index->variant_sets
                   : is_child ? &in->index->children
                              : &in->index->properties;
    return table_update(p, table, *list, *count);
}

static CoContents *contents_of(CoParser *p, CoSpec *spec)
{
    if (!spec->contents)
        spec->contents = co_parse_alloc(p, 1, sizeof *spec->contents);
    return spec->contents;
}

// Text that has been read need not stay in memory.
static void release_text(CoParser *p)
{
    if (!p->is_mapped || p->scan.at - p->released < RELEASE_BYTES)
        return;
    co_mapped_file_release(p->released, p->scan.at);
    p->released = p->scan.at;
}

CoSpec *co_parse_spec(CoParser *p, CoSpec *parent, CoSpecKind kind, const char *name,
                      const char *at)
{
    release_text(p);
    CoSpec *spec = co_parse_alloc(p, 1, sizeof *spec);
    if (!spec)
        return NULL;
    spec->kind = kind;
    spec->name = name;
    spec->line = co_parse_line(p, at);
    spec->type_name = p->empty;
    if (!parent)
        return spec;
    if (!contents_of(p, parent) || !append(p, parent->contents, spec))
        return NULL;
    if (kind != CO_SPEC_VARIANT)
        return spec;
    // A variant tells the name of its set.
    if (!contents_of(p, spec))
        return NULL;
    spec->contents->set = parent->name;
    return spec;
}

bool co_parse_adopt(CoParser *p, CoSpec *parent, CoSpec *const *prims, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (co_parse_child(parent, prims[i]->name))
            return false;
    if (!contents_of(p, parent))
        return false;
    for (size_t i = 0; i < count; i++)
        if (!append(p, parent->contents, prims[i]))
            return false;
    release_text(p);
    return true;
}

// ---- Queries -----------------------------------------------------------------------------------

const CoField *co_spec_field(const CoSpec *spec, const char *name)
{
    for (size_t i = 0; i < spec->field_count; i++)
        if (spec->fields[i].name == name)
            return &spec->fields[i];
    return NULL;
}

const CoSpec *co_spec_child(const CoSpec *spec, const char *name)
{
    return co_parse_child(spec, name);
}

const CoSpec *co_spec_property(const CoSpec *spec, const char *name)
{
    return co_parse_property_named(spec, name);
}
