// PNG files through libpng: 8-bit RGBA with straight alpha, marked as sRGB.

#ifndef CO_COLOR_PNG_H
#define CO_COLOR_PNG_H

#include "cohort/base.h"

// Writes width * height pixels, rows from the top; `path` is written as it is named, whatever its
// ending. COHORT_ERROR_FILE_WRITE when it cannot be written to the end; what there is of it stays.
// Errors say why alone: the caller knows what name the file is to have in the end.
bool co_png_write(const char *path, uint32_t width, uint32_t height, const uint8_t *rgba,
                  CohortError *err);

#endif
