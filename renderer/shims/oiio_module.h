// What the OpenImageIO module (oiio.cpp) hands to who opens it (oiio_module.c): oiio.h, as a table.

#ifndef CO_SHIMS_OIIO_MODULE_H
#define CO_SHIMS_OIIO_MODULE_H

#include "shims/oiio.h"

typedef struct CoOiioFunctions {
    bool (*info)(const char *path, CoOiioInfo *out, CohortError *err);
    bool (*read)(const char *path, const CoOiioInfo *info, float *out, CohortError *err);
    bool (*write_mips)(const char *path, const CoOiioInfo *info, const float *texels, uint32_t tile,
                       CohortError *err);
    CoOiioFile *(*open)(const char *path, CohortError *err);
    void (*close)(CoOiioFile *file);
    bool (*level)(CoOiioFile *file, uint32_t level, uint32_t *width, uint32_t *height,
                  uint32_t *channels, uint32_t *tile);
    bool (*tile)(CoOiioFile *file, uint32_t level, uint32_t x, uint32_t y, float *out,
                 CohortError *err);
} CoOiioFunctions;

#define CO_OIIO_MODULE "cohort_oiio.so"
#define CO_OIIO_TABLE "co_oiio_functions" // the table's name in the module

#endif
