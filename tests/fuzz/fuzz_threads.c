// Any bytes among the prims of a big layer: one thread and several make the same of it.

#include "fuzz.h"

#include "base/hash.h"
#include "support/same_for_threads.h"

#include <stdio.h>
#include <string.h>

enum {
    PRIM_BYTES = 1500, // comment mostly, which is quickly read
    PRIMS = 120,
    MOST_BYTES = 32 << 10 // of the input
};

// Prims that have names of their own from number `from` on.
static size_t add_prims(char *out, int from, int count)
{
    size_t length = 0;
    for (int i = from; i < from + count; i++)
        length += (size_t)sprintf(out + length, "def \"f%d\" {\n#%*s\n}\n", i, PRIM_BYTES - 40, "");
    return length;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static char text[PRIMS * PRIM_BYTES + MOST_BYTES + 64];
    static const char header[] = "#usda 1.0\n";
    if (size > MOST_BYTES)
        return 0;
    uint64_t random = co_hash_bytes(data, size, 0);
    bool is_below = random & 1;
    int before = 40 + (int)(random >> 8) % 40;
    size_t skipped =
        size >= sizeof header && !memcmp(data, header, sizeof header - 1) ? sizeof header - 1 : 0;
    size_t length = (size_t)sprintf(text, "%s%s", header, is_below ? "def \"W\"\n{\n" : "");
    length += add_prims(text + length, 0, before);
    if (size > skipped)
        memcpy(text + length, data + skipped, size - skipped);
    length += size - skipped;
    text[length++] = '\n';
    length += add_prims(text + length, before, PRIMS - before);
    if (is_below)
        text[length++] = '}';
    const CohortStageOptions options = {
        .max_depth = 64, .max_prims = 1000, .max_array_length = 1 << 16};
    fuzz_require(same_for_threads(text, length, &options, 2));
    return 0;
}
