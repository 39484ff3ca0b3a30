// What every fuzz target includes.

#ifndef TEST_FUZZ_H
#define TEST_FUZZ_H

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

// The entry that libFuzzer and replay.c call.
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

// A finding that no sanitizer sees.
static inline void fuzz_require(int holds)
{
    if (!holds)
        abort();
}

#endif
