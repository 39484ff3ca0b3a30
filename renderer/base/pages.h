// Large blocks straight from the system: in huge pages where it has them, moved without a copy, and
// given back the moment they are freed.
//
// For what is walked at random, where small pages cost a walk of the page table at every step.

#ifndef CO_BASE_PAGES_H
#define CO_BASE_PAGES_H

#include <stdbool.h>
#include <stddef.h>

// Whether blocks of `size` bytes should be had from here. The same answer every time.
bool co_pages_suit(size_t size);

// Zeroed, aligned to CO_PAGES_ALIGNMENT; NULL when there is no memory.
#define CO_PAGES_ALIGNMENT ((size_t)1 << 21)
void *co_pages_alloc(size_t size);
void co_pages_free(void *ptr, size_t size);

// Moves a block to another size, both of which suit; NULL when there is no memory, and the block is
// as it was.
void *co_pages_resize(void *ptr, size_t old_size, size_t new_size);

#endif
