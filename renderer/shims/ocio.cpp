#include "shims/ocio.h"

#include "base/error.h"

#include <OpenColorIO/OpenColorIO.h>

#include <algorithm>
#include <exception>
#include <new>
#include <sstream>
#include <vector>

namespace ocio = OCIO_NAMESPACE;

struct CoOcioConfig {
    ocio::ConstConfigRcPtr config;
};

struct CoOcioProcessor {
    ocio::ConstCPUProcessorRcPtr cpu;
};

// Runs `body`; an exception becomes an error and `failed`.
template <typename Result, typename Body>
static Result guarded(CohortError *err, Result failed, const char *what, Body body)
{
    try {
        return body();
    } catch (const std::bad_alloc &) {
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory in OpenColorIO");
    } catch (const std::exception &e) {
        CO_FAIL(err, COHORT_ERROR_COLOR, "%s: %s", what, e.what());
    } catch (...) {
        CO_FAIL(err, COHORT_ERROR_COLOR, "%s: OpenColorIO failed without saying why", what);
    }
    return failed;
}

CoOcioConfig *co_ocio_config_open(const char *path, const char *text, CohortError *err)
{
    return guarded(err, static_cast<CoOcioConfig *>(nullptr), path ? path : "OCIO config", [&] {
        ocio::SetLoggingLevel(ocio::LOGGING_LEVEL_NONE);
        ocio::ConstConfigRcPtr config;
        if (path) {
            config = ocio::Config::CreateFromFile(path);
        } else {
            std::istringstream stream(text);
            config = ocio::Config::CreateFromStream(stream);
        }
        return new CoOcioConfig{config};
    });
}

void co_ocio_config_close(CoOcioConfig *config)
{
    delete config;
}

const char *co_ocio_config_name(const CoOcioConfig *config)
{
    return config->config->getName();
}

const char *co_ocio_cache_id(const CoOcioConfig *config)
{
    return guarded(nullptr, "", "cache id", [&] { return config->config->getCacheID(); });
}

const char *co_ocio_space(const CoOcioConfig *config, const char *name)
{
    return guarded(nullptr, static_cast<const char *>(nullptr), name, [&] {
        ocio::ConstColorSpaceRcPtr space = config->config->getColorSpace(name);
        return space ? space->getName() : nullptr;
    });
}

bool co_ocio_space_is_data(const CoOcioConfig *config, const char *name)
{
    return guarded(nullptr, false, name, [&] {
        ocio::ConstColorSpaceRcPtr space = config->config->getColorSpace(name);
        return space && space->isData();
    });
}

const char *co_ocio_default_display(const CoOcioConfig *config)
{
    return config->config->getDefaultDisplay();
}

const char *co_ocio_default_view(const CoOcioConfig *config, const char *display)
{
    return config->config->getDefaultView(display);
}

const char *co_ocio_display(const CoOcioConfig *config, uint32_t index)
{
    int i = static_cast<int>(index);
    return i < config->config->getNumDisplays() ? config->config->getDisplay(i) : nullptr;
}

const char *co_ocio_view(const CoOcioConfig *config, const char *display, uint32_t index)
{
    int i = static_cast<int>(index);
    return i < config->config->getNumViews(display) ? config->config->getView(display, i) : nullptr;
}

static CoOcioProcessor *make_processor(const ocio::ConstProcessorRcPtr &processor)
{
    return new CoOcioProcessor{processor->getOptimizedCPUProcessor(ocio::OPTIMIZATION_LOSSLESS)};
}

CoOcioProcessor *co_ocio_convert(const CoOcioConfig *config, const char *from, const char *to,
                                 CohortError *err)
{
    return guarded(err, static_cast<CoOcioProcessor *>(nullptr), from,
                   [&] { return make_processor(config->config->getProcessor(from, to)); });
}

CoOcioProcessor *co_ocio_show(const CoOcioConfig *config, const char *from, const char *display,
                              const char *view, CohortError *err)
{
    return guarded(err, static_cast<CoOcioProcessor *>(nullptr), view, [&] {
        return make_processor(
            config->config->getProcessor(from, display, view, ocio::TRANSFORM_DIR_FORWARD));
    });
}

void co_ocio_processor_destroy(CoOcioProcessor *processor)
{
    delete processor;
}

bool co_ocio_apply(const CoOcioProcessor *processor, float *pixels, size_t count, CohortError *err)
{
    constexpr size_t chunk = 1 << 16; // pixels: PackedImageDesc counts in long, alpha is kept aside
    return guarded(err, false, "color transform", [&] {
        std::vector<float> alpha(std::min(count, chunk));
        for (size_t first = 0; first < count; first += chunk) {
            size_t n = std::min(chunk, count - first);
            float *p = pixels + 4 * first;
            for (size_t i = 0; i < n; i++)
                alpha[i] = p[4 * i + 3];
            ocio::PackedImageDesc image(p, static_cast<long>(n), 1, 4);
            processor->cpu->apply(image);
            for (size_t i = 0; i < n; i++)
                p[4 * i + 3] = alpha[i];
        }
        return true;
    });
}

const char *co_ocio_version(void)
{
    return ocio::GetVersion();
}
