// PNG files through OpenImageIO.

#ifndef CO_SHIMS_PNG_H
#define CO_SHIMS_PNG_H

#include "cohort/base.h"

#ifdef __cplusplus
extern "C" {
#endif

// Writes 8-bit RGBA with straight alpha, rows from the top, marked as sRGB. `path` is written as it
// is named, whatever its ending.
bool co_png_write(const char *path, uint32_t width, uint32_t height, const uint8_t *rgba,
                  CohortError *err);

// OpenImageIO's version, "2.4.7"; static.
const char *co_oiio_version(void);

#ifdef __cplusplus
}
#endif

#endif
