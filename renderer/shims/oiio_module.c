// OpenImageIO comes with some 250 libraries: a fifth of a second and 120 MB to load. So it is a
// module, opened when the first image is.

#include "shims/oiio_module.h"

#include "base/error.h"

#include <dlfcn.h>
#include <fenv.h>
#include <pthread.h>

static pthread_once_t once = PTHREAD_ONCE_INIT;
static const CoOiioFunctions *functions; // NULL: could not be loaded
static char reason[200];

static void load(void)
{
    // Any of these libraries could set how this thread rounds, and pixels must not depend on it.
    fenv_t rounding;
    fegetenv(&rounding);
    void *module = dlopen(CO_OIIO_MODULE, RTLD_LAZY | RTLD_LOCAL);
    functions = module ? dlsym(module, CO_OIIO_TABLE) : NULL;
    if (!functions) {
        const char *why = dlerror();
        snprintf(reason, sizeof reason, "%s", why ? why : "it holds nothing");
    }
    fesetenv(&rounding);
}

static const CoOiioFunctions *loaded(CohortError *err)
{
    pthread_once(&once, load);
    CO_CHECK_NULL(
        functions, err, COHORT_ERROR_INSTALLATION,
        "images cannot be read: %.100s; " CO_OIIO_MODULE " belongs into lib/cohort beside "
        "the program's folder: install Cohort again, or name its folder in LD_LIBRARY_PATH",
        reason);
    return functions;
}

bool co_oiio_info(const char *path, CoOiioInfo *out, CohortError *err)
{
    return loaded(err) && functions->info(path, out, err);
}

bool co_oiio_read(const char *path, const CoOiioInfo *info, float *out, CohortError *err)
{
    return loaded(err) && functions->read(path, info, out, err);
}

bool co_oiio_write_mips(const char *path, const CoOiioInfo *info, const float *texels,
                        uint32_t tile, CohortError *err)
{
    return loaded(err) && functions->write_mips(path, info, texels, tile, err);
}

CoOiioFile *co_oiio_open(const char *path, CohortError *err)
{
    return loaded(err) ? functions->open(path, err) : NULL;
}

// A file in hand means that the module is loaded.

void co_oiio_close(CoOiioFile *file)
{
    if (file)
        functions->close(file);
}

bool co_oiio_level(CoOiioFile *file, uint32_t level, uint32_t *width, uint32_t *height,
                   uint32_t *channels, uint32_t *tile)
{
    return functions->level(file, level, width, height, channels, tile);
}

bool co_oiio_tile(CoOiioFile *file, uint32_t level, uint32_t x, uint32_t y, float *out,
                  CohortError *err)
{
    return functions->tile(file, level, x, y, out, err);
}

const char *co_oiio_version(void)
{
    return CO_OIIO_VERSION;
}
