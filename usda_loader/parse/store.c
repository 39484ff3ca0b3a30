// Where a parse puts what it keeps: tokens, lists, copies of values.

#include "base/hash.h"
#include "parse/parser.h"

#include <string.h>

enum {
    SMALL_BYTES = 128 // of a value that is looked for among those stored before
};

static void *or_stop(CoParser *p, void *memory)
{
    if (!memory)
        co_parse_stop(p, p->scan.at, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    return memory;
}

void *co_parse_alloc(CoParser *p, size_t count, size_t size)
{
    size_t bytes;
    void *memory = NULL;
    if (co_size_mul(count, size, &bytes))
        memory = co_arena_bytes(&p->layer->arena, bytes, _Alignof(double));
    if (memory)
        memset(memory, 0, bytes);
    return or_stop(p, memory);
}

bool co_parse_scratch(CoParser *p, size_t size)
{
    if (size <= p->scratch_size)
        return true;
    size_t grown = p->scratch_size ? p->scratch_size : 4096;
    while (grown < size)
        grown += grown;
    unsigned char *scratch = co_realloc(CO_MEMORY_USDA, p->scratch, p->scratch_size, grown);
    if (!scratch)
        return or_stop(p, NULL) != NULL;
    p->scratch = scratch;
    p->scratch_size = grown;
    return true;
}

// ---- Tokens and types --------------------------------------------------------------------------

const char *co_parse_token(CoParser *p, const char *text, size_t length)
{
    uint64_t hash = co_hash_bytes(text, length, 0);
    CoKnownToken *known = &p->tokens[hash % CO_TOKEN_CACHE];
    if (known->token && known->hash == hash && known->length == length &&
        memcmp(known->token, text, length) == 0)
        return known->token;
    const char *token = co_token_hashed(text, length, hash);
    if (!token) {
        or_stop(p, NULL);
        return NULL;
    }
    *known = (CoKnownToken){token, hash, length};
    return token;
}

bool co_parse_type(CoParser *p, const char *name, CohortType *type, bool *is_array)
{
    CoKnownType *known = &p->types[co_hash64((uint64_t)(uintptr_t)name) % CO_NAME_CACHE];
    if (known->name != name) {
        *known = (CoKnownType){.name = name};
        co_type_from_name(name, strlen(name), &known->type, &known->is_array);
    }
    *type = known->type;
    *is_array = known->is_array;
    return known->type != COHORT_TYPE_NONE;
}

// ---- Lists -------------------------------------------------------------------------------------

// Which pile of spare blocks a size belongs to, or -1.
static int spare_pile(size_t bytes)
{
    if (bytes < sizeof(void *) || bytes >> CO_SPARE_SIZES || (bytes & (bytes - 1)))
        return -1;
    return __builtin_ctzll(bytes);
}

static void *take_block(CoParser *p, size_t count, size_t size)
{
    size_t bytes;
    if (!co_size_mul(count, size, &bytes))
        return or_stop(p, NULL);
    int pile = spare_pile(bytes);
    if (pile < 0 || !p->spare[pile])
        return or_stop(p, co_arena_bytes(&p->layer->arena, bytes, _Alignof(double)));
    void *block = p->spare[pile];
    memcpy(&p->spare[pile], block, sizeof(void *));
    return block;
}

static void give_block(CoParser *p, void *block, size_t bytes)
{
    int pile = spare_pile(bytes);
    if (pile < 0)
        return;
    memcpy(block, &p->spare[pile], sizeof(void *));
    p->spare[pile] = block;
}

void *co_parse_push(CoParser *p, void *list_pointer, size_t count, size_t size)
{
    unsigned char *list;
    memcpy(&list, list_pointer, sizeof list);
    if ((count & (count - 1)) == 0) {
        unsigned char *grown = take_block(p, count ? count * 2 : 1, size);
        if (!grown)
            return NULL;
        if (count) {
            memcpy(grown, list, count * size);
            give_block(p, list, count * size);
        }
        list = grown;
        memcpy(list_pointer, &list, sizeof list);
    }
    return memset(list + count * size, 0, size);
}

void co_parse_list_free(CoParser *p, void *list, size_t count, size_t size)
{
    size_t capacity = 1;
    while (capacity < count)
        capacity *= 2;
    if (count)
        give_block(p, list, capacity * size);
}

void *co_parse_block(CoParser *p, size_t count, size_t size)
{
    void *block = take_block(p, count, size);
    return block ? memset(block, 0, count * size) : NULL;
}

void co_parse_buffers_free(CoParser *p)
{
    co_free(CO_MEMORY_USDA, p->prim_path, p->prim_path_capacity);
    co_free(CO_MEMORY_USDA, p->scratch, p->scratch_size);
    co_free(CO_MEMORY_USDA, p->field_slots, p->field_capacity * sizeof *p->field_slots);
}

// ---- Values ------------------------------------------------------------------------------------

static const void *copy(CoParser *p, const void *data, size_t size, size_t align)
{
    unsigned char *memory = co_arena_bytes(&p->layer->arena, size + (align == 1), align);
    if (!memory)
        return or_stop(p, NULL);
    memcpy(memory, data, size);
    if (align == 1)
        memory[size] = '\0';
    return memory;
}

static uint64_t hash_small(const unsigned char *data, size_t size)
{
    uint64_t hash = size, word = 0;
    for (; size >= sizeof word; size -= sizeof word, data += sizeof word) {
        memcpy(&word, data, sizeof word);
        hash = (hash ^ word) * UINT64_C(0x9e3779b97f4a7c15);
        hash ^= hash >> 32;
    }
    word = 0;
    if (size)
        memcpy(&word, data, size);
    hash = (hash ^ word) * UINT64_C(0x9e3779b97f4a7c15);
    return hash >> 32;
}

static const void *keep(CoParser *p, const void *data, size_t size, size_t align)
{
    if (!size)
        data = ""; // lists without items have no address
    if (size > SMALL_BYTES)
        return copy(p, data, size, align);
    CoKept *kept = &p->kept[hash_small(data, size) % CO_KEPT_CACHE];
    if (kept->data && kept->size == size && kept->align == align &&
        (!size || memcmp(kept->data, data, size) == 0))
        return kept->data;
    const void *made = copy(p, data, size, align);
    if (made)
        *kept = (CoKept){made, size, align};
    return made;
}

const void *co_parse_keep(CoParser *p, const void *data, size_t size)
{
    return keep(p, data, size, _Alignof(double));
}

const char *co_parse_keep_text(CoParser *p, const char *text, size_t length)
{
    return keep(p, text, length, 1);
}
