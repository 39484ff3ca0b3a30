#include "color/png.h"

#include "base/error.h"

#include <errno.h>
#include <png.h>
#include <string.h>

bool co_png_write(const char *path, uint32_t width, uint32_t height, const uint8_t *rgba,
                  CohortError *err)
{
    png_image image = {.version = PNG_IMAGE_VERSION, .format = PNG_FORMAT_RGBA};
    image.width = width;
    image.height = height;
    CO_CHECK(width && height && width <= PNG_USER_WIDTH_MAX && height <= PNG_USER_HEIGHT_MAX, err,
             COHORT_ERROR_ARGUMENT, "a PNG file cannot be %u x %u", (unsigned)width,
             (unsigned)height);
    errno = 0;
    FILE *file = fopen(path, "wb");
    bool ok = file && png_image_write_to_stdio(&image, file, false, rgba, 0, NULL);
    int cause = errno;
    if (file && fclose(file) != 0) {
        ok = false;
        cause = errno;
    }
    png_image_free(&image);
    CO_CHECK(ok, err, COHORT_ERROR_FILE_WRITE, "%s", cause ? strerror(cause) : image.message);
    return true;
}
