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

// Prims with names of their own, each PRIM_BYTES long.
static void write_prims(char *out)
{
    for (int i = 0; i < PRIMS; i++) {
        int head = sprintf(out, "def \"f%03d\" {\n#", i);
        memset(out + head, ' ', (size_t)(PRIM_BYTES - head));
        memcpy(out + PRIM_BYTES - 3, "\n}\n", 3);
        out += PRIM_BYTES;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static char prims[PRIMS * PRIM_BYTES], text[sizeof prims + MOST_BYTES + 64];
    static const char header[] = "#usda 1.0\n";
    if (size > MOST_BYTES)
        return 0;
    if (!*prims)
        write_prims(prims);
    uint64_t random = co_hash_bytes(data, size, 0);
    bool is_below = random & 1;
    size_t before = (40 + (random >> 8) % 40) * PRIM_BYTES;
    size_t skipped =
        size >= sizeof header && !memcmp(data, header, sizeof header - 1) ? sizeof header - 1 : 0;
    size_t length = (size_t)sprintf(text, "%s%s", header, is_below ? "def \"W\"\n{\n" : "");
    memcpy(text + length, prims, before);
    length += before;
    if (size > skipped)
        memcpy(text + length, data + skipped, size - skipped);
    length += size - skipped;
    text[length++] = '\n';
    memcpy(text + length, prims + before, sizeof prims - before);
    length += sizeof prims - before;
    if (is_below)
        text[length++] = '}';
    const CohortStageOptions options = {
        .max_depth = 64, .max_prims = 1000, .max_array_length = 1 << 16};
    fuzz_require(same_for_threads(text, length, &options, 2));
    return 0;
}
