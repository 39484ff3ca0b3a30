// OpenColorIO behind C: configs, processors, pixels.
//
// Threads: a config and a processor may be used by any number of threads at once.

#ifndef CO_SHIMS_OCIO_H
#define CO_SHIMS_OCIO_H

#include "cohort/base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct CoOcioConfig CoOcioConfig;
typedef struct CoOcioProcessor CoOcioProcessor;

// Reads a config file, or parses `text` when path is NULL.
CoOcioConfig *co_ocio_config_open(const char *path, const char *text, CohortError *err);
void co_ocio_config_close(CoOcioConfig *config);

// The config's own names. All strings live as long as the config.
const char *co_ocio_config_name(const CoOcioConfig *config);
const char *co_ocio_cache_id(const CoOcioConfig *config);
// The canonical name of a space, alias or role; NULL when the config has none such.
const char *co_ocio_space(const CoOcioConfig *config, const char *name);
bool co_ocio_space_is_data(const CoOcioConfig *config, const char *name);
// The space that the config's file rules give a file of that name, the Default rule aside; NULL
// when none but that one matches it, or it names a space that the config has not.
const char *co_ocio_space_of_file(const CoOcioConfig *config, const char *path);
const char *co_ocio_default_display(const CoOcioConfig *config);
const char *co_ocio_default_view(const CoOcioConfig *config, const char *display);
// Every display, or every view of a display; NULL past the end.
const char *co_ocio_display(const CoOcioConfig *config, uint32_t index);
const char *co_ocio_view(const CoOcioConfig *config, const char *display, uint32_t index);

// From one color space to another, or to what a display shows through a view.
CoOcioProcessor *co_ocio_convert(const CoOcioConfig *config, const char *from, const char *to,
                                 CohortError *err);
CoOcioProcessor *co_ocio_show(const CoOcioConfig *config, const char *from, const char *display,
                              const char *view, CohortError *err);
void co_ocio_processor_destroy(CoOcioProcessor *processor);

// Transforms count RGBA float pixels in place, with straight alpha that comes back bit for bit.
bool co_ocio_apply(const CoOcioProcessor *processor, float *pixels, size_t count, CohortError *err);

// "2.1.2"; static.
const char *co_ocio_version(void);

#ifdef __cplusplus
}
#endif

#endif
