#include "index/string_map.h"

#include "base/hash.h"

#include <string.h>

enum {
    FIRST_CAPACITY = 64
};

static uint32_t hash_key(const char *key)
{
    return (uint32_t)co_hash_bytes(key, strlen(key), 0);
}

// The slot that holds the key, or the free one where it belongs. The table is never full.
static CoStringMapSlot *find_slot(const CoStringMap *map, const char *key, uint32_t hash)
{
    size_t mask = map->capacity - 1;
    size_t i = hash & mask;
    while (map->slots[i].key && (map->slots[i].hash != hash || strcmp(map->slots[i].key, key) != 0))
        i = (i + 1) & mask;
    return &map->slots[i];
}

static bool grow(CoStringMap *map)
{
    size_t capacity = map->capacity ? map->capacity * 2 : FIRST_CAPACITY;
    size_t bytes;
    if (!co_size_mul(capacity, sizeof(CoStringMapSlot), &bytes))
        return false;
    CoStringMap bigger = *map;
    bigger.slots = co_alloc_zero(CO_MEMORY_DELEGATE, bytes);
    if (!bigger.slots)
        return false;
    bigger.capacity = capacity;
    for (size_t i = 0; i < map->capacity; i++) {
        const CoStringMapSlot *slot = &map->slots[i];
        if (slot->key)
            *find_slot(&bigger, slot->key, slot->hash) = *slot;
    }
    co_free(CO_MEMORY_DELEGATE, map->slots, map->capacity * sizeof(CoStringMapSlot));
    *map = bigger;
    return true;
}

uint32_t co_string_map_find(const CoStringMap *map, const char *key)
{
    if (map->capacity == 0)
        return COHORT_INVALID_ID;
    const CoStringMapSlot *slot = find_slot(map, key, hash_key(key));
    return slot->key ? slot->value : COHORT_INVALID_ID;
}

bool co_string_map_set(CoStringMap *map, const char *key, uint32_t value)
{
    uint32_t hash = hash_key(key);
    CoStringMapSlot *slot = map->capacity ? find_slot(map, key, hash) : NULL;
    if (slot && slot->key) {
        slot->value = value;
        return true;
    }
    if (map->used * 2 >= map->capacity && !grow(map))
        return false;
    map->keys.tag = CO_MEMORY_DELEGATE;
    const char *copy = co_arena_string(&map->keys, key, strlen(key));
    if (!copy)
        return false;
    *find_slot(map, key, hash) = (CoStringMapSlot){.key = copy, .hash = hash, .value = value};
    map->used++;
    return true;
}

void co_string_map_remove(CoStringMap *map, const char *key)
{
    if (map->capacity == 0)
        return;
    CoStringMapSlot *slot = find_slot(map, key, hash_key(key));
    if (slot->key)
        slot->value = COHORT_INVALID_ID;
}

void co_string_map_clear(CoStringMap *map)
{
    co_free(CO_MEMORY_DELEGATE, map->slots, map->capacity * sizeof(CoStringMapSlot));
    co_arena_clear(&map->keys);
    memset(map, 0, sizeof *map);
}
