// A chunked, growing arena with mark and rewind. Nothing in it is freed alone.

#ifndef CO_BASE_ARENA_H
#define CO_BASE_ARENA_H

#include "base/memory.h"

typedef struct CoArenaChunk CoArenaChunk;

// Zero-valid except for the tag: {.tag = CO_MEMORY_USDA} is an empty arena.
typedef struct CoArena {
    CoMemoryTag tag;
    CoArenaChunk *chunk; // the newest chunk
    size_t limit;        // most bytes over all chunks, 0 = none
    size_t total;        // bytes over all chunks
} CoArena;

typedef struct CoArenaMark {
    CoArenaChunk *chunk;
    size_t used;
} CoArenaMark;

// Returns `size` zeroed bytes aligned to 16, or NULL when memory or the limit is at an end.
// A size of 0 gives a valid pointer to nothing.
void *co_arena_alloc(CoArena *arena, size_t size);

// `size` bytes as they come, not zeroed, aligned to `align`: a power of two, at most 64.
void *co_arena_bytes(CoArena *arena, size_t size, size_t align);

// Zeroed: `count` elements of `size` bytes, with the product checked.
void *co_arena_array(CoArena *arena, size_t count, size_t size);

// Copies `length` bytes and adds a NUL.
char *co_arena_string(CoArena *arena, const char *text, size_t length);

CoArenaMark co_arena_mark(const CoArena *arena);
void co_arena_rewind(CoArena *arena, CoArenaMark mark);

// Takes over every chunk of `from`, which is empty then; what it handed out lives as long as this
// arena.
void co_arena_adopt(CoArena *arena, CoArena *from);

// Frees every chunk; the arena is empty and usable again.
void co_arena_clear(CoArena *arena);

#endif
