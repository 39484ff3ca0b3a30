#include "compose/map.h"

#include <string.h>

static CoMap *alloc_map(CoPathTable *table, size_t pairs)
{
    CoMap *map = co_arena_alloc(table->arena, sizeof *map + pairs * sizeof(CoMapPair));
    if (map)
        map->scale = 1;
    return map;
}

CoMap *co_map_identity(CoPathTable *table)
{
    return co_map_pair(table, &table->root, &table->root, false, 0, 1);
}

// The pair whose source (or target) is the longest prefix of `path`; -1 for none.
static int best_match(const CoMap *map, const CoPath *path, bool by_target, int except)
{
    int best = -1;
    uint32_t length = 0;
    for (int i = 0; i < (int)map->count; i++) {
        const CoPath *side = by_target ? map->pairs[i].target : map->pairs[i].source;
        if (i == except || !side || (best >= 0 && side->length < length))
            continue;
        if (co_path_has_prefix(path, side)) {
            best = i;
            length = side->length;
        }
    }
    return best;
}

static const CoPath *apply(CoPathTable *table, const CoMap *map, const CoPath *path, bool inverse,
                           int except)
{
    int best = best_match(map, path, inverse, except);
    if (best < 0)
        return NULL;
    const CoPath *from = inverse ? map->pairs[best].target : map->pairs[best].source;
    const CoPath *to = inverse ? map->pairs[best].source : map->pairs[best].target;
    if (!to)
        return NULL;
    const CoPath *image = co_path_replace_prefix(table, path, from, to);
    if (!image)
        return NULL;
    // The image must come back to where it started: another pair may claim it more closely.
    int back = best_match(map, image, !inverse, except);
    if (back != best && back >= 0) {
        const CoPath *claim = inverse ? map->pairs[back].source : map->pairs[back].target;
        if (claim->length >= to->length)
            return NULL;
    }
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

// Drops pairs that the others imply, so that equal maps have equal pairs.
static void canonicalize(CoPathTable *table, CoMap *map)
{
    for (int i = 0; i < (int)map->count;) {
        CoMapPair pair = map->pairs[i];
        const CoPath *implied = apply(table, map, pair.source, false, i);
        bool is_redundant = pair.target ? implied == pair.target : !implied;
        // A pair that renames is needed even if a sibling pair would lead to the same place.
        if (is_redundant && pair.target && pair.source->name != pair.target->name)
            is_redundant = false;
        if (!is_redundant) {
            i++;
            continue;
        }
        map->count--;
        memmove(map->pairs + i, map->pairs + i + 1, (map->count - (size_t)i) * sizeof *map->pairs);
    }
}

CoMap *co_map_pairs(CoPathTable *table, const CoMapPair *pairs, size_t count)
{
    CoMap *map = alloc_map(table, count);
    if (!map)
        return NULL;
    for (size_t i = 0; i < count; i++) {
        bool is_new = true;
        for (uint32_t j = 0; j < map->count && is_new; j++)
            is_new = map->pairs[j].source != pairs[i].source;
        if (is_new)
            map->pairs[map->count++] = pairs[i];
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

CoMap *co_map_with_root(CoPathTable *table, const CoMap *map)
{
    CoMap *out = alloc_map(table, map->count + 1);
    if (!out)
        return NULL;
    memcpy(out, map, sizeof *map + map->count * sizeof(CoMapPair));
    if (!has_root_pair(map)) {
        out->pairs[out->count++] = (CoMapPair){&table->root, &table->root};
        canonicalize(table, out);
    }
    return out;
}

CoMap *co_map_compose(CoPathTable *table, const CoMap *outer, const CoMap *inner)
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

// A path that the inner map has no image for, because another pair claims it, has none in the whole
// either; where the pairs of the whole no longer say so, it is cut off by name.
static CoMap *keep_claims(CoPathTable *table, const CoMap *inner, CoMap *map)
{
    for (uint32_t i = 0; map && i < inner->count; i++) {
        const CoPath *claimed = inner->pairs[i].target;
        for (uint32_t j = 0; claimed && map && j < inner->count; j++) {
            const CoMapPair *wide = &inner->pairs[j];
            if (i == j || !wide->target || !co_path_has_prefix(claimed, wide->target))
                continue;
            const CoPath *path =
                co_path_replace_prefix(table, claimed, wide->target, wide->source);
            if (!path || co_map_to_target(table, inner, path) ||
                !co_map_to_target(table, map, path))
                continue;
            CoMap *grown = alloc_map(table, (size_t)map->count + 1);
            if (grown) {
                memcpy(grown, map, sizeof *map + map->count * sizeof *map->pairs);
                grown->pairs[grown->count++] = (CoMapPair){path, NULL};
            }
            map = grown;
        }
    }
    return map;
}

CoMap *co_map_compose_exactly(CoPathTable *table, const CoMap *outer, const CoMap *inner)
{
    CoMap *map = co_map_compose(table, outer, inner);
    return inner->count > 1 ? keep_claims(table, inner, map) : map;
}

CoMap *co_map_inverse(CoPathTable *table, const CoMap *map)
{
    CoMap *out = alloc_map(table, map->count);
    if (!out)
        return NULL;
    for (uint32_t i = 0; i < map->count; i++)
        if (map->pairs[i].target)
            out->pairs[out->count++] = (CoMapPair){map->pairs[i].target, map->pairs[i].source};
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
        for (uint32_t j = 0; j < b->count && !is_there; j++)
            is_there = a->pairs[i].source == b->pairs[j].source &&
                       a->pairs[i].target == b->pairs[j].target;
        if (!is_there)
            return false;
    }
    return true;
}
