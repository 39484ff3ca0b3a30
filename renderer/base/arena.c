#include "base/arena.h"

#include <string.h>

#define CHUNK_BYTES ((size_t)64 << 10)
#define CHUNK_BYTES_MAX ((size_t)8 << 20)

struct CoArenaChunk {
    CoArenaChunk *previous;
    size_t size, used; // of the data behind this header, in bytes
    char pad[40];      // keeps the data 64-byte aligned
};

_Static_assert(sizeof(CoArenaChunk) == 64, "chunk data starts on a cache line");

// Under AddressSanitizer what is not handed out may not be touched, and a gap between blocks
// catches who runs over the end of one.
#if defined(__SANITIZE_ADDRESS__)
#define HAS_POISON 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define HAS_POISON 1
#endif
#endif
#ifdef HAS_POISON
#include <sanitizer/asan_interface.h>
#define GAP_BYTES 16
#define MIN_ALIGN 8 // of what can be told apart
#define POISON(at, size) ASAN_POISON_MEMORY_REGION(at, size)
#define UNPOISON(at, size) ASAN_UNPOISON_MEMORY_REGION(at, size)
#else
#define GAP_BYTES 0
#define MIN_ALIGN 1
#define POISON(at, size) ((void)0)
#define UNPOISON(at, size) ((void)0)
#endif

static CoArenaChunk *push_chunk(CoArena *arena, size_t size)
{
    size_t wanted = CHUNK_BYTES;
    while (wanted < arena->total / 2 && wanted < CHUNK_BYTES_MAX)
        wanted *= 2;
    if (wanted < size)
        wanted = size;
    if (arena->limit && (wanted > arena->limit || arena->total > arena->limit - wanted))
        return NULL;
    CoArenaChunk *chunk = co_alloc(arena->tag, sizeof *chunk + wanted);
    if (!chunk)
        return NULL;
    chunk->previous = arena->chunk;
    chunk->size = wanted;
    chunk->used = 0;
    arena->chunk = chunk;
    arena->total += wanted;
    POISON(chunk + 1, wanted);
    return chunk;
}

void *co_arena_bytes(CoArena *arena, size_t size, size_t align)
{
    if (size > SIZE_MAX / 4)
        return NULL;
    align = align < MIN_ALIGN ? MIN_ALIGN : align;
    CoArenaChunk *chunk = arena->chunk;
    size_t taken = size + GAP_BYTES;
    size_t from = chunk ? (chunk->used + align - 1) & ~(align - 1) : 0;
    if (!chunk || from > chunk->size || chunk->size - from < taken) {
        chunk = push_chunk(arena, taken);
        from = 0;
    }
    if (!chunk)
        return NULL;
    chunk->used = from + taken;
    char *ptr = (char *)(chunk + 1) + from;
    UNPOISON(ptr, size);
    return ptr;
}

void *co_arena_alloc(CoArena *arena, size_t size)
{
    void *ptr = co_arena_bytes(arena, size, 16);
    if (ptr)
        memset(ptr, 0, size);
    return ptr;
}

void *co_arena_array(CoArena *arena, size_t count, size_t size)
{
    size_t bytes;
    return co_size_mul(count, size, &bytes) ? co_arena_alloc(arena, bytes) : NULL;
}

char *co_arena_string(CoArena *arena, const char *text, size_t length)
{
    char *copy = co_arena_alloc(arena, length + 1);
    if (copy && length)
        memcpy(copy, text, length);
    return copy;
}

CoArenaMark co_arena_mark(const CoArena *arena)
{
    return (CoArenaMark){arena->chunk, arena->chunk ? arena->chunk->used : 0};
}

void co_arena_rewind(CoArena *arena, CoArenaMark mark)
{
    while (arena->chunk != mark.chunk) {
        CoArenaChunk *chunk = arena->chunk;
        arena->chunk = chunk->previous;
        arena->total -= chunk->size;
        UNPOISON(chunk + 1, chunk->size);
        co_free(arena->tag, chunk, sizeof *chunk + chunk->size);
    }
    if (!arena->chunk)
        return;
    POISON((char *)(arena->chunk + 1) + mark.used, arena->chunk->used - mark.used);
    arena->chunk->used = mark.used;
}

// They go beneath the newest chunk, which may have room left.
void co_arena_adopt(CoArena *arena, CoArena *from)
{
    CoArenaChunk **slot = arena->chunk ? &arena->chunk->previous : &arena->chunk;
    CoArenaChunk *older = *slot;
    *slot = from->chunk;
    while (*slot)
        slot = &(*slot)->previous;
    *slot = older;
    arena->total += from->total;
    from->chunk = NULL;
    from->total = 0;
}

void co_arena_clear(CoArena *arena)
{
    co_arena_rewind(arena, (CoArenaMark){NULL, 0});
}
