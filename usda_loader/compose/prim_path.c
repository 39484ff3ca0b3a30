#include "compose/prim_path.h"

#include "base/hash.h"
#include "parse/layer.h"

#include <string.h>

enum {
    PAGE_PATHS = 64
};

void co_path_table_init(CoPathTable *table, CoArena *arena)
{
    *table = (CoPathTable){.arena = arena};
    table->root.name = "";
    table->root.prim = &table->root;
}

static uint32_t hash_element(const CoPath *parent, const char *name, const char *selection)
{
    uint64_t h = co_hash64((uint64_t)(uintptr_t)parent ^ ((uint64_t)(uintptr_t)name << 17));
    return (uint32_t)(selection ? co_hash_combine(h, (uint64_t)(uintptr_t)selection) : h);
}

static CoPath *path_of(const CoPathTable *table, uint32_t number)
{
    return &table->pages[(number - 1) / PAGE_PATHS][(number - 1) % PAGE_PATHS];
}

static bool grow(CoPathTable *table)
{
    size_t capacity = table->capacity ? table->capacity * 2 : 256;
    CoPathSlot *slots = co_arena_array(table->arena, capacity, sizeof *slots);
    if (!slots)
        return false;
    for (size_t i = 0; i < table->capacity; i++) {
        CoPathSlot old = table->slots[i];
        if (!old.number)
            continue;
        size_t at = old.hash & (capacity - 1);
        while (slots[at].number)
            at = (at + 1) & (capacity - 1);
        slots[at] = old;
    }
    table->slots = slots;
    table->capacity = capacity;
    return true;
}

// Where the path stands or would stand.
static CoPathSlot *find_slot(const CoPathTable *table, const CoPath *parent, const char *name,
                             const char *selection)
{
    uint32_t hash = hash_element(parent, name, selection);
    for (size_t at = hash & (table->capacity - 1);; at = (at + 1) & (table->capacity - 1)) {
        CoPathSlot *slot = &table->slots[at];
        if (!slot->number)
            return slot;
        const CoPath *path = slot->hash == hash ? path_of(table, slot->number) : NULL;
        if (path && path->parent == parent && path->name == name && path->selection == selection)
            return slot;
    }
}

// Room for one path more.
static CoPath *push_path(CoPathTable *table)
{
    if (table->count == UINT32_MAX)
        return NULL;
    if (table->count == table->page_count * PAGE_PATHS) {
        if (table->page_count == table->page_capacity) {
            size_t capacity = table->page_capacity ? table->page_capacity * 2 : 16;
            CoPath **pages = co_arena_array(table->arena, capacity, sizeof *pages);
            if (!pages)
                return NULL;
            if (table->page_count)
                memcpy(pages, table->pages, table->page_count * sizeof *pages);
            table->pages = pages;
            table->page_capacity = capacity;
        }
        CoPath *page = co_arena_array(table->arena, PAGE_PATHS, sizeof *page);
        if (!page)
            return NULL;
        table->pages[table->page_count++] = page;
    }
    return path_of(table, ++table->count);
}

static const CoPath *intern(CoPathTable *table, const CoPath *parent, const char *name,
                            const char *selection)
{
    if (!parent || !name)
        return NULL;
    if (2 * (size_t)table->count >= table->capacity && !grow(table)) {
        table->is_short = true;
        return NULL;
    }
    CoPathSlot *slot = find_slot(table, parent, name, selection);
    if (slot->number)
        return path_of(table, slot->number);
    const CoPath *prim = NULL;
    if (selection)
        prim = parent->prim;
    else if (parent->prim != parent)
        prim = intern(table, parent->prim, name, NULL);
    if (!prim && (selection || parent->prim != parent))
        return NULL;
    CoPath *path = push_path(table);
    table->is_short = table->is_short || !path;
    if (!path)
        return NULL;
    *path = (CoPath){.parent = parent,
                     .name = name,
                     .selection = selection,
                     .prim = prim ? prim : path,
                     .length = parent->length + 1,
                     .depth = parent->depth + (selection ? 0 : 1),
                     .number = table->count};
    // Interning the plain path may have grown the table.
    slot = find_slot(table, parent, name, selection);
    *slot = (CoPathSlot){hash_element(parent, name, selection), path->number};
    return path;
}

const CoPath *co_path_child(CoPathTable *table, const CoPath *parent, const char *name)
{
    return intern(table, parent, name, NULL);
}

const CoPath *co_path_variant(CoPathTable *table, const CoPath *parent, const char *set,
                              const char *selection)
{
    return selection ? intern(table, parent, set, selection) : NULL;
}

const CoPath *co_path_find_child(const CoPathTable *table, const CoPath *parent, const char *name)
{
    const CoPathSlot *slot = table->capacity ? find_slot(table, parent, name, NULL) : NULL;
    return slot && slot->number ? path_of(table, slot->number) : NULL;
}

const CoPath *co_path_cut(const CoPath *path, uint32_t length)
{
    while (path->length > length)
        path = path->parent;
    return path;
}

bool co_path_has_prefix(const CoPath *path, const CoPath *prefix)
{
    return prefix->length <= path->length && co_path_cut(path, prefix->length) == prefix;
}

const CoPath *co_path_replace_prefix(CoPathTable *table, const CoPath *path, const CoPath *from,
                                     const CoPath *to)
{
    if (path == from)
        return to;
    if (from == to || !path)
        return path;
    const CoPath *parent = co_path_replace_prefix(table, path->parent, from, to);
    return intern(table, parent, path->name, path->selection);
}

// Letters, digits, underscores and anything beyond ASCII; the parser has already judged names.
static bool is_name_byte(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           (unsigned char)c >= 0x80;
}

const CoPath *co_path_parse(CoPathTable *table, const char *text, size_t length,
                            const CoPath *anchor, bool *malformed)
{
    *malformed = true;
    const CoPath *path = anchor;
    size_t at = 0;
    if (length == 0)
        return NULL;
    if (text[0] == '/') {
        path = &table->root;
        at = 1;
    }
    while (at < length) {
        size_t end = at;
        while (end < length && text[end] != '/')
            end++;
        size_t size = end - at;
        if (size == 2 && text[at] == '.' && text[at + 1] == '.') {
            path = path->parent;
            if (!path)
                return NULL;
        } else if (size != 1 || text[at] != '.') {
            for (size_t i = at; i < end; i++)
                if (!is_name_byte(text[i]))
                    return NULL;
            if (size == 0)
                return NULL;
            path = co_path_child(table, path, co_token(text + at, size));
            if (!path) {
                *malformed = false;
                return NULL;
            }
        }
        at = end + 1;
        if (end < length && at == length)
            return NULL; // a trailing slash
    }
    *malformed = false;
    return path;
}

static void put(char *out, size_t size, size_t *at, const char *text)
{
    size_t length = strlen(text);
    for (size_t i = 0; i < length; i++)
        if (*at + i < size)
            out[*at + i] = text[i];
    *at += length;
}

static void put_elements(const CoPath *path, char *out, size_t size, size_t *at)
{
    if (!path->parent)
        return;
    put_elements(path->parent, out, size, at);
    if (path->selection) {
        put(out, size, at, "{");
        put(out, size, at, path->name);
        put(out, size, at, "=");
        put(out, size, at, path->selection);
        put(out, size, at, "}");
        return;
    }
    if (!path->parent->selection)
        put(out, size, at, "/");
    put(out, size, at, path->name);
}

size_t co_path_text(const CoPath *path, char *out, size_t size)
{
    size_t at = 0;
    if (!path->parent)
        put(out, size, &at, "/");
    else
        put_elements(path, out, size, &at);
    if (size)
        out[at < size ? at : size - 1] = 0;
    return at;
}
