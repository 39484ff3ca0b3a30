// Any bytes as a layer: read or refused, with a place for every error.

#include "fuzz.h"

#include "parse/layer.h"

typedef struct Heard {
    size_t errors;
    const uint8_t *text;
    size_t size;
} Heard;

static void hear(void *cookie, CohortSeverity severity, const char *file, uint32_t line,
                 uint32_t column, const char *prim_path, const char *text)
{
    Heard *heard = cookie;
    heard->errors += severity == COHORT_SEVERITY_ERROR;
    fuzz_require(file && prim_path && text && *text);
    // A place in the text: the line exists, and the column is at most one past its end.
    size_t at = 0;
    for (uint32_t i = 1; line && i < line; i++) {
        while (at < heard->size && heard->text[at] != '\n')
            at++;
        fuzz_require(at < heard->size);
        at++;
    }
    size_t end = at;
    while (end < heard->size && heard->text[end] != '\n')
        end++;
    fuzz_require(!line || (column >= 1 && column <= end - at + 1));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const CohortStageOptions options = {
        .max_bytes = 1 << 20, .max_depth = 64, .max_prims = 10000, .max_array_length = 1 << 16};
    CohortError err = {0};
    Heard heard = {.text = data, .size = size};
    CoLayer *layer =
        co_layer_parse("fuzz.usda", (const char *)data, size, &options, hear, &heard, &err);
    fuzz_require(!layer == (err.code != COHORT_OK) && !layer == (heard.errors > 0));
    co_layer_destroy(layer);
    return 0;
}
