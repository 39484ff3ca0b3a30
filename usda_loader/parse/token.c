// The table of interned text: lives as long as the process, one lock per shard.

#include "base/arena.h"
#include "base/hash.h"
#include "parse/parser.h"

#include <pthread.h>
#include <string.h>

enum {
    SHARD_COUNT = 16
};

typedef struct Entry {
    uint64_t hash;
    const char *text;
    size_t length;
} Entry;

typedef struct Shard {
    pthread_mutex_t lock;
    CoArena arena;
    Entry *entries; // open addressing, a power of two
    size_t capacity, count;
} Shard;

#define SHARD \
    { \
        .lock = PTHREAD_MUTEX_INITIALIZER, .arena = {.tag = CO_MEMORY_USDA } \
    }
#define SHARDS4 SHARD, SHARD, SHARD, SHARD

// The only mutable state of the room: equal text must give the same pointer everywhere.
static Shard shards[SHARD_COUNT] = {SHARDS4, SHARDS4, SHARDS4, SHARDS4};

static Entry *find_slot(Entry *entries, size_t capacity, uint64_t hash, const char *text,
                        size_t length)
{
    for (size_t i = (size_t)(hash >> 8);; i++) {
        Entry *entry = &entries[i & (capacity - 1)];
        if (!entry->text || (entry->hash == hash && entry->length == length &&
                             memcmp(entry->text, text, length) == 0))
            return entry;
    }
}

static bool grow(Shard *shard)
{
    size_t capacity = shard->capacity ? shard->capacity * 2 : 64;
    Entry *entries = co_alloc_zero(CO_MEMORY_USDA, capacity * sizeof *entries);
    if (!entries)
        return false;
    for (size_t i = 0; i < shard->capacity; i++) {
        const Entry *old = &shard->entries[i];
        if (old->text)
            *find_slot(entries, capacity, old->hash, old->text, old->length) = *old;
    }
    co_free(CO_MEMORY_USDA, shard->entries, shard->capacity * sizeof *entries);
    shard->entries = entries;
    shard->capacity = capacity;
    return true;
}

static const char *intern(Shard *shard, uint64_t hash, const char *text, size_t length)
{
    Entry *entry = NULL;
    if (shard->capacity)
        entry = find_slot(shard->entries, shard->capacity, hash, text, length);
    if (entry && entry->text)
        return entry->text;
    // Only what is new needs memory.
    if (shard->count * 2 >= shard->capacity) {
        if (!grow(shard))
            return NULL;
        entry = find_slot(shard->entries, shard->capacity, hash, text, length);
    }
    const char *copy = co_arena_string(&shard->arena, text, length);
    if (!copy)
        return NULL;
    *entry = (Entry){hash, copy, length};
    shard->count++;
    return entry->text;
}

const char *co_token(const char *text, size_t length)
{
    return co_token_hashed(text, length, co_hash_bytes(text, length, 0));
}

const char *co_token_hashed(const char *text, size_t length, uint64_t hash)
{
    Shard *shard = &shards[hash % SHARD_COUNT];
    pthread_mutex_lock(&shard->lock);
    const char *token = intern(shard, hash, text, length);
    pthread_mutex_unlock(&shard->lock);
    return token;
}
