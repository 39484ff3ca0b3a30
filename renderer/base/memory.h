// The one heap of Cohort: counted per subsystem, aligned for SIMD, able to fail on purpose in
// tests.

#ifndef CO_BASE_MEMORY_H
#define CO_BASE_MEMORY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum CoMemoryTag {
    CO_MEMORY_BASE = 0,
    CO_MEMORY_USDA,
    CO_MEMORY_SCENE,
    CO_MEMORY_GEOMETRY,
    CO_MEMORY_ACCEL,
    CO_MEMORY_RAYS,
    CO_MEMORY_TEXTURE,
    CO_MEMORY_LIGHT,
    CO_MEMORY_FILM,
    CO_MEMORY_COLOR,
    CO_MEMORY_DELEGATE,
    CO_MEMORY_TAG_COUNT
} CoMemoryTag;

// Returns `size` bytes aligned to 64, or NULL (also when size is 0). Free with the same tag and
// size.
void *co_alloc(CoMemoryTag tag, size_t size);

// The same, zeroed.
void *co_alloc_zero(CoMemoryTag tag, size_t size);

// Frees; NULL is fine.
void co_free(CoMemoryTag tag, void *ptr, size_t size);

// Moves a block to `new_size` bytes, keeping the smaller of both contents. NULL on failure: the old
// block is then untouched.
void *co_realloc(CoMemoryTag tag, void *ptr, size_t old_size, size_t new_size);

// True and *out = a * b unless that does not fit.
static inline bool co_size_mul(size_t a, size_t b, size_t *out)
{
    return !__builtin_mul_overflow(a, b, out);
}

// Makes room for one more than `count` elements of `size` bytes in an array that has room for
// *capacity; a NULL one of capacity 0 is begun. False without memory: nothing has changed then.
bool co_grow(CoMemoryTag tag, void **array, size_t count, size_t *capacity, size_t size);

size_t co_memory_live(CoMemoryTag tag); // bytes now
size_t co_memory_peak(CoMemoryTag tag); // most bytes at any time

// Bytes of memory that the process has resident, after the heap gave back what it can; 0 where the
// system does not say.
size_t co_memory_resident(void);

// Bytes that can still be taken: what the system calls available, but no more than the control
// groups of the process leave it; 0 where the system does not say.
uint64_t co_memory_available(void);

// Makes the n-th allocation from now (1-based, over all threads) and every later one fail; 0 turns
// it off. For tests of failure paths.
void co_memory_fail_after(uint64_t n);

// The n-th alone: what is large may fail where what is small and comes later does not.
void co_memory_fail_once(uint64_t n);

#endif
