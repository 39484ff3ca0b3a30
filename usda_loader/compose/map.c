#include "compose/map.h"

#include "base/hash.h"

#include <string.h>

// More pairs than this are found by their hash.
enum {
    SMALL_MAP = 8
};

static CoMap *alloc_map(CoPathTable *table, size_t pairs)
{
    CoMap *map = co_arena_alloc(table->arena, sizeof *map + pairs * sizeof(CoMapPair));
    if (!map)
        return NULL;
    map->scale = 1;
    if (pairs <= SMALL_MAP)
        return map;
    size_t capacity = 32;
    while (capacity < 2 * pairs)
        capacity *= 2;
    map->slots = co_arena_array(table->arena, 2 * capacity, sizeof *map->slots);
    map->capacity = (uint32_t)capacity;
    return map->slots ? map : NULL;
}

const CoMap *co_map_identity(CoPathTable *table)
{
    if (!table->identity)
        table->identity = co_map_pair(table, &table->root, &table->root, false, 0, 1);
    return table->identity;
}

// ---- Finding pairs ------------------------------------------------------------------------------
static uint32_t first_slot(const CoMap *map, const CoPath *path)
{
    return (uint32_t)co_hash64((uint64_t)(uintptr_t)path) & (map->capacity - 1);
}

static void note_pair(CoMap *map, const CoPath *path, bool by_target, uint32_t pair)
{
    uint32_t *slots = map->slots + (by_target ? map->capacity : 0);
    uint32_t at = first_slot(map, path);
    while (slots[at])
        at = (at + 1) & (map->capacity - 1);
    slots[at] = pair + 1;
}

static void add_pair(CoMap *map, CoMapPair pair)
{
    if (map->capacity) {
        note_pair(map, pair.source, false, map->count);
        if (pair.target)
            note_pair(map, pair.target, true, map->count);
    }
    map->pairs[map->count++] = pair;
}

static const CoPath *side_of(const CoMap *map, int pair, bool by_target)
{
    return by_target ? map->pairs[pair].target : map->pairs[pair].source;
}

// One pair after the other whose source (or target) is `path`: -1 at the end. *cursor starts at 0.
static int next_pair(const CoMap *map, const CoPath *path, bool by_target, uint32_t *cursor)
{
    if (!map->capacity) {
        while (*cursor < map->count) {
            int pair = (int)(*cursor)++;
            if (side_of(map, pair, by_target) == path)
                return pair;
        }
        return -1;
    }
    const uint32_t *slots = map->slots + (by_target ? map->capacity : 0);
    while (true) {
        uint32_t at = (first_slot(map, path) + (*cursor)++) & (map->capacity - 1);
        if (!slots[at])
            return -1;
        if (side_of(map, (int)slots[at] - 1, by_target) == path)
            return (int)slots[at] - 1;
    }
}

// The last pair whose source (or target) is the longest prefix of `path`; -1 for none.
static int best_match(const CoMap *map, const CoPath *path, bool by_target, int except)
{
    int best = -1;
    for (; path && best < 0; path = path->parent) {
        uint32_t cursor = 0;
        for (int i; (i = next_pair(map, path, by_target, &cursor)) >= 0;)
            if (i != except && i > best)
                best = i;
    }
    return best;
}

static const CoPath *apply(CoPathTable *table, const CoMap *map, const CoPath *path, bool inverse,
                           int except)
{
    int best = best_match(map, path, inverse, except);
    if (best < 0)
        return NULL;
    const CoPath *from = side_of(map, best, inverse), *to = side_of(map, best, !inverse);
    if (!to)
        return NULL;
    const CoPath *image = co_path_replace_prefix(table, path, from, to);
    if (!image)
        return NULL;
    // The image must come back to where it started: another pair may claim it more closely.
    int back = best_match(map, image, !inverse, except);
    if (back != best && back >= 0 && side_of(map, back, !inverse)->length >= to->length)
        return NULL;
    return image;
}

const CoPath *co_map_to_target(CoPathTable *table, const CoMap *map, const CoPath *path)
{
    return apply(table, map, path, false, -1);
}

const CoPath *co_map_to_source(CoPathTable *table, const CoMap *map, const CoPath *path)
{
    return apply(table, map, path, true, -1);
}

// ---- Making maps --------------------------------------------------------------------------------
// The pairs that were not taken out, found anew.
static void compact(CoMap *map)
{
    uint32_t count = map->count;
    if (map->capacity)
        memset(map->slots, 0, 2 * (size_t)map->capacity * sizeof *map->slots);
    map->count = 0;
    for (uint32_t i = 0; i < count; i++)
        if (map->pairs[i].source)
            add_pair(map, map->pairs[i]);
}

// Drops pairs that the others imply, so that equal maps have equal pairs.
static void canonicalize(CoPathTable *table, CoMap *map)
{
    bool any = false;
    for (int i = 0; i < (int)map->count; i++) {
        CoMapPair pair = map->pairs[i];
        const CoPath *implied = apply(table, map, pair.source, false, i);
        bool is_redundant = pair.target ? implied == pair.target : !implied;
        // A pair that renames is needed even if a sibling pair would lead to the same place.
        if (is_redundant && pair.target && pair.source->name != pair.target->name)
            is_redundant = false;
        if (is_redundant)
            map->pairs[i] = (CoMapPair){NULL, NULL};
        any |= is_redundant;
    }
    if (any)
        compact(map);
}

CoMap *co_map_pairs(CoPathTable *table, const CoMapPair *pairs, size_t count)
{
    CoMap *map = alloc_map(table, count);
    if (!map)
        return NULL;
    for (size_t i = 0; i < count; i++) {
        uint32_t cursor = 0;
        if (next_pair(map, pairs[i].source, false, &cursor) < 0)
            add_pair(map, pairs[i]);
    }
    canonicalize(table, map);
    return map;
}

CoMap *co_map_pair(CoPathTable *table, const CoPath *source, const CoPath *target, bool has_root,
                   double offset, double scale)
{
    CoMapPair pairs[2] = {{source, target}, {&table->root, &table->root}};
    CoMap *map = co_map_pairs(table, pairs, has_root ? 2 : 1);
    if (map) {
        map->offset = offset;
        map->scale = scale;
    }
    return map;
}

static bool has_root_pair(const CoMap *map)
{
    for (uint32_t i = 0; i < map->count; i++)
        if (!map->pairs[i].source->parent && map->pairs[i].target && !map->pairs[i].target->parent)
            return true;
    return false;
}

// The same pairs and times, with room for `more` pairs.
static CoMap *copy_map(CoPathTable *table, const CoMap *map, size_t more)
{
    CoMap *out = alloc_map(table, map->count + more);
    if (!out)
        return NULL;
    out->offset = map->offset;
    out->scale = map->scale;
    out->is_in_steps = map->is_in_steps;
    for (uint32_t i = 0; i < map->count; i++)
        add_pair(out, map->pairs[i]);
    return out;
}

const CoMap *co_map_with_root(CoPathTable *table, const CoMap *map)
{
    if (has_root_pair(map))
        return map;
    CoMap *out = copy_map(table, map, 1);
    if (out) {
        add_pair(out, (CoMapPair){&table->root, &table->root});
        canonicalize(table, out);
    }
    return out;
}

static CoMap *compose(CoPathTable *table, const CoMap *outer, const CoMap *inner)
{
    CoMapPair stack[16];
    size_t most = (size_t)inner->count + outer->count, count = 0;
    CoMapPair *pairs = most <= 16 ? stack : co_arena_array(table->arena, most, sizeof(CoMapPair));
    if (!pairs)
        return NULL;
    for (uint32_t i = 0; i < inner->count; i++) {
        const CoPath *target = inner->pairs[i].target;
        target = target ? co_map_to_target(table, outer, target) : NULL;
        pairs[count++] = (CoMapPair){inner->pairs[i].source, target};
    }
    for (uint32_t i = 0; i < outer->count; i++) {
        const CoPath *source = co_map_to_source(table, inner, outer->pairs[i].source);
        if (source)
            pairs[count++] = (CoMapPair){source, outer->pairs[i].target};
    }
    CoMap *map = co_map_pairs(table, pairs, count);
    if (map) {
        map->scale = outer->scale * inner->scale;
        map->offset = outer->scale * inner->offset + outer->offset;
    }
    return map;
}

// The paths that `inner` has no image for, because another pair claims it, and `map` has. `out` may
// be NULL. Returns how many.
static size_t find_claims(CoPathTable *table, const CoMap *inner, const CoMap *map,
                          const CoPath **out)
{
    size_t count = 0;
    for (uint32_t i = 0; i < inner->count; i++) {
        const CoPath *claimed = inner->pairs[i].target;
        for (const CoPath *above = claimed; above; above = above->parent) {
            uint32_t cursor = 0;
            for (int j; (j = next_pair(inner, above, true, &cursor)) >= 0;) {
                const CoPath *path = j == (int)i ? NULL
                                                 : co_path_replace_prefix(table, claimed, above,
                                                                          inner->pairs[j].source);
                if (!path || co_map_to_target(table, inner, path) ||
                    !co_map_to_target(table, map, path))
                    continue;
                if (out)
                    out[count] = path;
                count++;
            }
        }
    }
    return count;
}

// A path that the inner map has no image for, because another pair claims it, has none in the whole
// either; where the pairs of the whole no longer say so, it is cut off by name.
static const CoMap *keep_claims(CoPathTable *table, const CoMap *inner, const CoMap *map)
{
    size_t count = find_claims(table, inner, map, NULL);
    if (!count)
        return map;
    const CoPath **claims = co_arena_array(table->arena, count, sizeof *claims);
    CoMap *out = copy_map(table, map, count);
    if (!claims || !out)
        return NULL;
    find_claims(table, inner, map, claims);
    for (size_t i = 0; i < count; i++)
        if (co_map_to_target(table, out, claims[i]))
            add_pair(out, (CoMapPair){claims[i], NULL});
    return out;
}

// ---- What was composed before -------------------------------------------------------------------
typedef struct CoComposition {
    const CoMap *outer, *inner, *whole;
    bool is_exact;
} CoComposition;

static CoComposition *find_composition(CoComposition *slots, size_t capacity,
                                       const CoComposition *key)
{
    uint64_t h = co_hash_combine((uint64_t)(uintptr_t)key->outer, (uint64_t)(uintptr_t)key->inner);
    for (size_t at = h & (capacity - 1);; at = (at + 1) & (capacity - 1)) {
        CoComposition *slot = &slots[at];
        if (!slot->whole || (slot->outer == key->outer && slot->inner == key->inner &&
                             slot->is_exact == key->is_exact))
            return slot;
    }
}

static bool keep_composition(CoPathTable *table, const CoComposition *composition)
{
    if (2 * table->composition_count >= table->composition_capacity) {
        size_t capacity = table->composition_capacity ? 2 * table->composition_capacity : 64;
        CoComposition *slots = co_arena_array(table->arena, capacity, sizeof *slots);
        if (!slots)
            return false;
        for (size_t i = 0; i < table->composition_capacity; i++)
            if (table->compositions[i].whole)
                *find_composition(slots, capacity, &table->compositions[i]) =
                    table->compositions[i];
        table->compositions = slots;
        table->composition_capacity = capacity;
    }
    *find_composition(table->compositions, table->composition_capacity, composition) = *composition;
    table->composition_count++;
    return true;
}

static const CoMap *compose_once(CoPathTable *table, const CoMap *outer, const CoMap *inner,
                                 bool is_exact)
{
    if (co_map_is_identity(outer))
        return inner;
    if (co_map_is_identity(inner))
        return outer;
    CoComposition key = {outer, inner, NULL, is_exact};
    bool is_large = outer->capacity || inner->capacity;
    if (is_large && table->composition_capacity) {
        const CoMap *known =
            find_composition(table->compositions, table->composition_capacity, &key)->whole;
        if (known)
            return known;
    }
    CoMap *whole = compose(table, outer, inner);
    if (!whole)
        return NULL;
    whole->is_in_steps = outer->is_in_steps || inner->is_in_steps;
    key.whole = whole;
    if (is_exact && whole->is_in_steps && inner->count > 1)
        key.whole = keep_claims(table, inner, whole);
    if (!key.whole || (is_large && !keep_composition(table, &key)))
        return NULL;
    return key.whole;
}

const CoMap *co_map_compose(CoPathTable *table, const CoMap *outer, const CoMap *inner)
{
    return compose_once(table, outer, inner, false);
}

const CoMap *co_map_compose_exactly(CoPathTable *table, const CoMap *outer, const CoMap *inner)
{
    return compose_once(table, outer, inner, true);
}

CoMap *co_map_inverse(CoPathTable *table, const CoMap *map)
{
    CoMap *out = alloc_map(table, map->count);
    if (!out)
        return NULL;
    for (uint32_t i = 0; i < map->count; i++)
        if (map->pairs[i].target)
            add_pair(out, (CoMapPair){map->pairs[i].target, map->pairs[i].source});
    out->scale = 1 / map->scale;
    out->offset = -map->offset / map->scale;
    return out;
}

bool co_map_is_identity(const CoMap *map)
{
    return map->count == 1 && has_root_pair(map) && map->offset == 0 && map->scale == 1;
}

bool co_map_equal(const CoMap *a, const CoMap *b)
{
    if (a == b)
        return true;
    if (a->count != b->count || a->offset != b->offset || a->scale != b->scale)
        return false;
    for (uint32_t i = 0; i < a->count; i++) {
        bool is_there = false;
        uint32_t cursor = 0;
        for (int j; !is_there && (j = next_pair(b, a->pairs[i].source, false, &cursor)) >= 0;)
            is_there = a->pairs[i].target == b->pairs[j].target;
        if (!is_there)
            return false;
    }
    return true;
}
