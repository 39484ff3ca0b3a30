#include "shims/ocio.h"

#include "base/error.h"

#include <OpenColorIO/OpenColorIO.h>

#include <algorithm>
#include <exception>
#include <new>
#include <set>
#include <sstream>
#include <string>
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

// OCIO 2.1 overruns the stack on definitions that lead back to themselves. This walks all of them
// first. A node is a color space in one direction (its transforms may differ), a look, a view
// transform or a named transform.
class CycleFinder {
public:
    explicit CycleFinder(const ocio::ConstConfigRcPtr &config) : config_(config) {}

    // The name of something that is defined through itself; empty if there is none.
    std::string find()
    {
        int spaces = config_->getNumColorSpaces(ocio::SEARCH_REFERENCE_SPACE_ALL,
                                                ocio::COLORSPACE_ALL);
        for (int i = 0; i < spaces; i++) {
            const char *name = config_->getColorSpaceNameByIndex(ocio::SEARCH_REFERENCE_SPACE_ALL,
                                                                 ocio::COLORSPACE_ALL, i);
            space(name, true);
            space(name, false);
        }
        for (int i = 0; i < config_->getNumLooks(); i++)
            look(config_->getLookNameByIndex(i));
        for (int i = 0; i < config_->getNumViewTransforms(); i++)
            view_transform(*config_->getViewTransform(config_->getViewTransformNameByIndex(i)));
        return found_;
    }

private:
    const ocio::ConstConfigRcPtr &config_;
    std::set<std::string> open_, closed_;
    std::string found_;

    template <typename Body> void visit(const std::string &node, const char *name, Body inside)
    {
        if (!found_.empty() || closed_.count(node))
            return;
        if (!open_.insert(node).second) {
            found_ = name;
            return;
        }
        inside();
        open_.erase(node);
        closed_.insert(node);
    }

    void space(const char *name, bool to_reference)
    {
        if (ocio::ConstColorSpaceRcPtr s = config_->getColorSpace(name)) {
            auto own = to_reference ? ocio::COLORSPACE_DIR_TO_REFERENCE
                                    : ocio::COLORSPACE_DIR_FROM_REFERENCE;
            auto other = to_reference ? ocio::COLORSPACE_DIR_FROM_REFERENCE
                                      : ocio::COLORSPACE_DIR_TO_REFERENCE;
            visit((to_reference ? "to " : "from ") + std::string(s->getName()), s->getName(), [&] {
                ocio::ConstTransformRcPtr t = s->getTransform(own);
                walk(t ? t : s->getTransform(other), !t);
            });
        } else if (ocio::ConstNamedTransformRcPtr n = config_->getNamedTransform(name)) {
            visit("named " + std::string(n->getName()), n->getName(), [&] {
                walk(n->getTransform(ocio::TRANSFORM_DIR_FORWARD), false);
                walk(n->getTransform(ocio::TRANSFORM_DIR_INVERSE), false);
            });
        }
    }

    void look(const char *name)
    {
        ocio::ConstLookRcPtr l = config_->getLook(name);
        if (!l)
            return;
        visit("look " + std::string(name), name, [&] {
            space(l->getProcessSpace(), true);
            space(l->getProcessSpace(), false);
            walk(l->getTransform(), false);
            walk(l->getInverseTransform(), false);
        });
    }

    void view_transform(const ocio::ViewTransform &v)
    {
        visit("view " + std::string(v.getName()), v.getName(), [&] {
            walk(v.getTransform(ocio::VIEWTRANSFORM_DIR_TO_REFERENCE), false);
            walk(v.getTransform(ocio::VIEWTRANSFORM_DIR_FROM_REFERENCE), false);
        });
    }

    void hop(const char *from, const char *to, bool inverse)
    {
        space(inverse ? to : from, true);
        space(inverse ? from : to, false);
    }

    void walk(const ocio::ConstTransformRcPtr &t, bool inverse)
    {
        if (!t || !found_.empty())
            return;
        inverse = inverse != (t->getDirection() == ocio::TRANSFORM_DIR_INVERSE);
        if (auto group = ocio::DynamicPtrCast<const ocio::GroupTransform>(t)) {
            for (int i = 0; i < group->getNumTransforms(); i++)
                walk(group->getTransform(i), inverse);
        } else if (auto c = ocio::DynamicPtrCast<const ocio::ColorSpaceTransform>(t)) {
            hop(c->getSrc(), c->getDst(), inverse);
        } else if (auto l = ocio::DynamicPtrCast<const ocio::LookTransform>(t)) {
            hop(l->getSrc(), l->getDst(), inverse);
            std::istringstream names(l->getLooks());
            for (std::string name; std::getline(names, name, ',');)
                look(name.substr(std::min(name.find_first_not_of(" +-"), name.size())).c_str());
        } else if (auto d = ocio::DynamicPtrCast<const ocio::DisplayViewTransform>(t)) {
            const char *to = config_->getDisplayViewColorSpaceName(d->getDisplay(), d->getView());
            hop(d->getSrc(), to, inverse);
        }
    }
};

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
        std::string cyclic = CycleFinder(config).find();
        if (!cyclic.empty())
            throw ocio::Exception(("\"" + cyclic + "\" is defined through itself").c_str());
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

const char *co_ocio_space_of_file(const CoOcioConfig *config, const char *path)
{
    return guarded(nullptr, static_cast<const char *>(nullptr), path, [&] {
        if (config->config->filepathOnlyMatchesDefaultRule(path))
            return static_cast<const char *>(nullptr);
        return co_ocio_space(config, config->config->getColorSpaceFromFilepath(path));
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
