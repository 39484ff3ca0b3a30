// A map from strings to small numbers, for paths and content keys.
//
// Threads: none; a map belongs to one thread.

#ifndef CO_DELEGATE_STRING_MAP_H
#define CO_DELEGATE_STRING_MAP_H

#include "base/arena.h"

#include "cohort/base.h"

typedef struct CoStringMapSlot {
    const char *key; // NULL = free
    uint32_t value;  // COHORT_INVALID_ID = removed
    uint32_t hash;
} CoStringMapSlot;

// Zero-valid. Keys are copied and stay in memory until the map is cleared.
typedef struct CoStringMap {
    CoStringMapSlot *slots; // open addressing, power of two
    size_t capacity, used;
    CoArena keys;
} CoStringMap;

// The value of a key, COHORT_INVALID_ID if there is none.
uint32_t co_string_map_find(const CoStringMap *map, const char *key);

// Sets the value of a key; false when out of memory, the map is then unchanged. A key that it has,
// or had, takes no memory.
bool co_string_map_set(CoStringMap *map, const char *key, uint32_t value);

void co_string_map_remove(CoStringMap *map, const char *key);
void co_string_map_clear(CoStringMap *map);

#endif
