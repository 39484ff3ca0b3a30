// Copies of what is not read again soon.

#ifndef CO_SIMD_STREAM_COPY_H
#define CO_SIMD_STREAM_COPY_H

#include <stddef.h>

// As memcpy, but whole cache lines of `to` go to memory without being read first and without a
// place in the caches, where the machine has that. Other threads see them as they see any store.
void co_stream_copy(void *to, const void *from, size_t bytes);

#endif
