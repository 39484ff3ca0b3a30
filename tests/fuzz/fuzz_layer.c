// Any bytes as a layer: parsed, and written and parsed again when they are one.

#include "fuzz.h"

#include "parse/layer.h"

#include <stdlib.h>
#include <unistd.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const CohortStageOptions options = {
        .max_bytes = 1 << 20, .max_depth = 64, .max_array_length = 1 << 16};
    CohortError err = {0};
    CoLayer *layer =
        co_layer_parse("fuzz.usda", (const char *)data, size, &options, NULL, NULL, &err);
    if (!layer) {
        fuzz_require(err.code != COHORT_OK);
        return 0;
    }
    char path[] = "/tmp/cohort-fuzz-XXXXXX";
    int fd = mkstemp(path);
    fuzz_require(fd >= 0);
    close(fd);
    fuzz_require(co_layer_write(layer, path, &err));
    co_layer_destroy(layer);
    // What is written is longer than what was read, and may nest one level deeper.
    layer = co_layer_open(path, NULL, NULL, NULL, &err);
    unlink(path);
    fuzz_require(layer != NULL);
    co_layer_destroy(layer);
    return 0;
}
