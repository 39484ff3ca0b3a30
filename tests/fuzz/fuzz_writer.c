// What is read is written and read again as the same layer, and written the same again.

#include "fuzz.h"

#include "parse/writer.h"
#include "support/same_layer.h"

#include <string.h>

typedef struct Text {
    char *bytes;
    size_t size;
} Text;

static Text write_layer(const CoLayer *layer)
{
    Text text = {0};
    FILE *file = open_memstream(&text.bytes, &text.size);
    fuzz_require(file != NULL);
    co_write_layer(layer, file);
    fuzz_require(fclose(file) == 0);
    return text;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const CohortStageOptions options = {
        .max_bytes = 1 << 20, .max_depth = 64, .max_prims = 10000, .max_array_length = 1 << 16};
    CoLayer *layer =
        co_layer_parse("fuzz.usda", (const char *)data, size, &options, NULL, NULL, NULL);
    if (!layer)
        return 0;
    // What is written is longer than what was read, and may nest one level deeper.
    Text once = write_layer(layer);
    CoLayer *again = co_layer_parse("fuzz.usda", once.bytes, once.size, NULL, NULL, NULL, NULL);
    fuzz_require(again && same_layer(layer, again));
    Text twice = write_layer(again);
    fuzz_require(once.size == twice.size && memcmp(once.bytes, twice.bytes, once.size) == 0);
    free(once.bytes);
    free(twice.bytes);
    co_layer_destroy(again);
    co_layer_destroy(layer);
    return 0;
}
