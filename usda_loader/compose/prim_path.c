#include "compose/prim_path.h"

#include "base/hash.h"
#include "parse/layer.h"

#include <string.h>

void co_path_table_init(CoPathTable *table, CoArena *arena)
{
    *table = (CoPathTable){.arena = arena};
    table->root.name = "";
    table->root.prim = &table->root;
}

static uint64_t hash_element(const CoPath *parent, const char *name, const char *selection)
{
    uint64_t h = co_hash64((uint64_t)(uintptr_t)parent ^ ((uint64_t)(uintptr_t)name << 17));
    return selection ? co_hash_combine(h, (uint64_t)(uintptr_t)selection) : h;
}

static bool grow(CoPathTable *table)
{
    size_t capacity = table->capacity ? table->capacity * 2 : 256;
    const CoPath **slots = co_arena_array(table->arena, capacity, sizeof *slots);
    if (!slots)
        return false;
    for (size_t i = 0; i < table->capacity; i++) {
        const CoPath *path = table->slots[i];
        if (!path)
            continue;
        size_t at = hash_element(path->parent, path->name, path->selection) & (capacity - 1);
        while (slots[at])
            at = (at + 1) & (capacity - 1);
        slots[at] = path;
    }
    table->slots = slots;
    table->capacity = capacity;
    return true;
}

static size_t find_slot(const CoPathTable *table, const CoPath *parent, const char *name,
                        const char *selection)
{
    size_t at = hash_element(parent, name, selection) & (table->capacity - 1);
    for (;; at = (at + 1) & (table->capacity - 1)) {
        const CoPath *path = table->slots[at];
        if (!path || (path->parent == parent && path->name == name && path->selection == selection))
            return at;
    }
}

static const CoPath *intern(CoPathTable *table, const CoPath *parent, const char *name,
                            const char *selection)
{
    if (!parent || !name)
        return NULL;
    if (2 * table->count >= table->capacity && !grow(table))
        return NULL;
    size_t at = find_slot(table, parent, name, selection);
    if (table->slots[at])
        return table->slots[at];
    const CoPath *prim = NULL;
    if (selection)
        prim = parent->prim;
    else if (parent->prim != parent)
        prim = intern(table, parent->prim, name, NULL);
    if (!prim && (selection || parent->prim != parent))
        return NULL;
    CoPath *path = co_arena_alloc(table->arena, sizeof *path);
    if (!path)
        return NULL;
    *path = (CoPath){parent,
                     name,
                     selection,
                     prim ? prim : path,
                     parent->length + 1,
                     parent->depth + (selection ? 0 : 1)};
    // Interning the plain path may have grown the table.
    at = find_slot(table, parent, name, selection);
    table->slots[at] = path;
    table->count++;
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
    return table->capacity ? table->slots[find_slot(table, parent, name, NULL)] : NULL;
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
