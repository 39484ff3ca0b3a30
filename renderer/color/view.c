// Pictures for people: a display and view of an OCIO config.

#include "cohort/image.h"

#include "base/error.h"
#include "base/memory.h"
#include "color/color.h"
#include "color/png.h"
#include "color/rgb_space.h"
#include "color/shipped_config.h"
#include "shims/ocio.h"

#include <errno.h>
#include <float.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

#define TAG CO_MEMORY_COLOR

// The shipped config's view that shows colors as they are.
static const char plain_display[] = "sRGB - Display", plain_view[] = "Un-tone-mapped";

struct CohortView {
    CoOcioConfig *config;
    CoOcioProcessor *processor;
    bool has_matrix; // rendering space -> from_space, when the config lacks the former
    float matrix[9];
    char from_space[128], display[128], view[128];
};

static void list_names(char *out, size_t size, const CoOcioConfig *config, const char *display)
{
    size_t used = 0;
    out[0] = 0;
    for (uint32_t i = 0; used + 1 < size; i++) {
        const char *name = display ? co_ocio_view(config, display, i) : co_ocio_display(config, i);
        if (!name)
            return;
        int n = snprintf(out + used, size - used, "%s%s", i ? ", " : "", name);
        used += n > 0 ? (size_t)n : 0;
    }
}

static bool has_name(const CoOcioConfig *config, const char *display, const char *wanted)
{
    for (uint32_t i = 0;; i++) {
        const char *name = display ? co_ocio_view(config, display, i) : co_ocio_display(config, i);
        if (!name)
            return false;
        if (!strcmp(name, wanted))
            return true;
    }
}

static bool choose_display_view(CohortView *v, bool is_shipped, const char *display,
                                const char *view, CohortError *err)
{
    char known[128];
    if (!display || !display[0])
        display = is_shipped ? plain_display : co_ocio_default_display(v->config);
    list_names(known, sizeof known, v->config, NULL);
    CO_CHECK(has_name(v->config, NULL, display), err, COHORT_ERROR_ARGUMENT,
             "the OCIO config has no display \"%s\"; it has %s", display, known);
    if (!view || !view[0])
        view = is_shipped && !strcmp(display, plain_display)
                   ? plain_view
                   : co_ocio_default_view(v->config, display);
    list_names(known, sizeof known, v->config, display);
    CO_CHECK(has_name(v->config, display, view), err, COHORT_ERROR_ARGUMENT,
             "display \"%s\" has no view \"%s\"; it has %s", display, view, known);
    snprintf(v->display, sizeof v->display, "%s", display);
    snprintf(v->view, sizeof v->view, "%s", view);
    return true;
}

// Where the view's transform starts: the rendering space if the config knows it, else ACES2065-1,
// reached by the built-in matrices.
static bool choose_from_space(CohortView *v, const char *rendering, CohortError *err)
{
    const char *name = co_ocio_space(v->config, rendering);
    if (name) {
        snprintf(v->from_space, sizeof v->from_space, "%s", name);
        return true;
    }
    const char *hub = co_ocio_space(v->config, "aces_interchange");
    CO_CHECK(hub && co_rgb_space_find(rendering), err, COHORT_ERROR_COLOR,
             "the OCIO config does not know the rendering space \"%s\" and has no aces_interchange "
             "role to reach it by",
             rendering);
    snprintf(v->from_space, sizeof v->from_space, "%s", hub);
    v->has_matrix = true;
    co_rgb_space_matrix(co_rgb_space_find(rendering), co_rgb_space_find("lin_ap0_scene"),
                        v->matrix);
    return true;
}

static bool view_setup(CohortView *v, const char *config, const char *rendering_space,
                       const char *display, const char *view, CohortError *err)
{
    bool is_shipped = !config || !config[0];
    v->config = is_shipped ? co_ocio_config_open(NULL, co_shipped_config, err)
                           : co_ocio_config_open(config, NULL, err);
    if (!v->config)
        return false;
    char rendering[128];
    float chromaticities[8];
    if (!cohort_rendering_space(config, rendering_space, rendering, chromaticities, err) ||
        !choose_display_view(v, is_shipped, display, view, err) ||
        !choose_from_space(v, rendering, err))
        return false;
    v->processor = co_ocio_show(v->config, v->from_space, v->display, v->view, err);
    return v->processor != NULL;
}

CohortView *cohort_view_create(const char *config, const char *rendering_space, const char *display,
                               const char *view, CohortError *err)
{
    if (!config || !config[0])
        config = getenv("OCIO");
    CohortView *v = co_alloc_zero(TAG, sizeof *v);
    CO_CHECK_NULL(v, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    if (!view_setup(v, config, rendering_space, display, view, err)) {
        cohort_view_destroy(v);
        return NULL;
    }
    return v;
}

void cohort_view_destroy(CohortView *v)
{
    if (!v)
        return;
    co_ocio_processor_destroy(v->processor);
    co_ocio_config_close(v->config);
    co_free(TAG, v, sizeof *v);
}

const char *cohort_view_display_name(const CohortView *v)
{
    return v->display;
}

const char *cohort_view_view_name(const CohortView *v)
{
    return v->view;
}

const char *cohort_view_config_name(const CohortView *v)
{
    return co_ocio_config_name(v->config);
}

const char *cohort_view_config_cache_id(const CohortView *v)
{
    return co_ocio_cache_id(v->config);
}

static uint64_t replace_broken(float *rgba, size_t count)
{
    uint64_t replaced = 0;
    for (size_t i = 0; i < count * 4; i++) {
        if (isfinite(rgba[i]))
            continue;
        rgba[i] = isnan(rgba[i]) ? 0.0f : copysignf(FLT_MAX, rgba[i]);
        replaced++;
    }
    return replaced;
}

bool cohort_view_apply(const CohortView *v, float *rgba, size_t count, uint64_t *replaced,
                       CohortError *err)
{
    uint64_t n = replace_broken(rgba, count);
    if (replaced)
        *replaced = n;
    for (size_t i = 0; v->has_matrix && i < count; i++)
        co_rgb_matrix_apply(v->matrix, &rgba[4 * i]);
    return co_ocio_apply(v->processor, rgba, count, err);
}

static void unpremultiply(float *rgba, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        float *p = &rgba[4 * i], a = p[3];
        for (int c = 0; c < 3 && a > 0.0f && a < 1.0f; c++)
            p[c] /= a;
    }
}

static uint8_t to_byte(float x)
{
    return x > 0.0f ? (uint8_t)(fminf(x, 1.0f) * 255.0f + 0.5f) : 0;
}

static bool write_bytes(const char *path, uint32_t width, uint32_t height, const float *rgba,
                        CohortError *err)
{
    size_t count = (size_t)width * height * 4;
    char partial[4096];
    int length = snprintf(partial, sizeof partial, "%s.partial-%ld", path, (long)getpid());
    CO_CHECK(length > 0 && (size_t)length < sizeof partial, err, COHORT_ERROR_FILE_WRITE,
             "the path of the output file is too long");
    uint8_t *bytes = co_alloc(TAG, count);
    CO_CHECK_MEMORY(bytes, err);
    for (size_t i = 0; i < count; i++)
        bytes[i] = to_byte(rgba[i]);
    CohortError why = {0};
    bool ok = co_png_write(partial, width, height, bytes, &why);
    co_free(TAG, bytes, count);
    if (ok && rename(partial, path) == 0)
        return true;
    if (ok)
        CO_FAIL(&why, COHORT_ERROR_FILE_WRITE, "%s", strerror(errno));
    unlink(partial);
    return CO_FAIL(err, why.code, "cannot write %.100s: %.120s", path, why.message);
}

bool cohort_png_write(const char *path, uint32_t width, uint32_t height, const float *rgba,
                      const CohortView *view, CohortError *err)
{
    size_t count = (size_t)width * height, bytes = count * 4 * sizeof(float);
    float *shown = co_alloc(TAG, bytes);
    CO_CHECK_MEMORY(shown, err);
    memcpy(shown, rgba, bytes);
    unpremultiply(shown, count);
    bool ok = cohort_view_apply(view, shown, count, NULL, err) &&
              write_bytes(path, width, height, shown, err);
    co_free(TAG, shown, bytes);
    return ok;
}

bool cohort_rendering_space(const char *config, const char *rendering_space, char *name,
                            float chromaticities[8], CohortError *err)
{
    CoColor *color = co_color_create(config, rendering_space, err);
    if (!color)
        return false;
    snprintf(name, 128, "%s", co_color_space_name(color));
    co_color_chromaticities(color, chromaticities);
    co_color_destroy(color);
    return true;
}
