#include "shims/png.h"

#include "base/error.h"

#include <OpenImageIO/imageio.h>

#include <exception>

bool co_png_write(const char *path, uint32_t width, uint32_t height, const uint8_t *rgba,
                  CohortError *err)
{
    try {
        auto out = OIIO::ImageOutput::create("png");
        CO_CHECK(out, err, COHORT_ERROR_FILE_WRITE, "OpenImageIO was built without PNG");
        OIIO::ImageSpec spec(static_cast<int>(width), static_cast<int>(height), 4,
                             OIIO::TypeDesc::UINT8);
        spec.attribute("oiio:UnassociatedAlpha", 1);
        spec.attribute("oiio:ColorSpace", "sRGB");
        CO_CHECK(out->open(path, spec) && out->write_image(OIIO::TypeDesc::UINT8, rgba) &&
                     out->close(),
                 err, COHORT_ERROR_FILE_WRITE, "cannot write %.100s: %.120s", path,
                 out->geterror().c_str());
        return true;
    } catch (const std::exception &e) {
        CO_FAIL(err, COHORT_ERROR_FILE_WRITE, "cannot write %.100s: %.120s", path, e.what());
    } catch (...) {
        CO_FAIL(err, COHORT_ERROR_FILE_WRITE, "cannot write %.200s", path);
    }
    return false;
}

const char *co_oiio_version(void)
{
    return OIIO_VERSION_STRING;
}
