#include "color/color.h"

#include "base/error.h"
#include "base/memory.h"
#include "color/rgb_space.h"
#include "shims/ocio.h"

#include <pthread.h>
#include <string.h>

#define TAG CO_MEMORY_COLOR

enum {
    NAME_MAX_BYTES = 128,
    PROCESSORS_MAX = 64
};

// How a space becomes the rendering space: through OCIO, then by a matrix, either of which may be
// missing. The curve of one of USD's spaces comes before both.
typedef struct Route {
    char space[NAME_MAX_BYTES];
    const CoRgbSpace *curve;
    CoOcioProcessor *processor;
    bool has_matrix, matrix_first; // matrix_first: built-in space into a config's
    float matrix[9];
} Route;

struct CoColor {
    CoOcioConfig *config;       // NULL: none named
    const CoRgbSpace *built_in; // rendering space, when it is one of USD's
    char name[NAME_MAX_BYTES];  // of the rendering space
    Route routes[PROCESSORS_MAX];
    uint32_t route_count;
    pthread_mutex_t lock; // of routes
};

static const char *interchange(const CoColor *color)
{
    return color->config ? co_ocio_space(color->config, "aces_interchange") : NULL;
}

static bool choose_rendering_space(CoColor *color, const char *wanted, CohortError *err)
{
    const char *name = wanted && wanted[0] ? wanted : NULL;
    const char *in_config =
        color->config ? co_ocio_space(color->config, name ? name : "scene_linear") : NULL;
    if (in_config) {
        snprintf(color->name, sizeof color->name, "%s", in_config);
        return true;
    }
    const CoRgbSpace *space = co_rgb_space_find(name ? name : "lin_rec709_scene");
    CO_CHECK(space && space->curve == CO_CURVE_LINEAR && !space->is_data, err, COHORT_ERROR_COLOR,
             "rendering color space \"%s\" is neither in %s nor one of USD's linear spaces", name,
             color->config ? "the OCIO config" : "a config (none is set)");
    CO_CHECK(!color->config || interchange(color), err, COHORT_ERROR_COLOR,
             "the OCIO config has no aces_interchange role, which \"%s\" needs: name one of the "
             "config's own spaces as rendering space",
             space->name);
    color->built_in = space;
    snprintf(color->name, sizeof color->name, "%s", space->name);
    return true;
}

CoColor *co_color_create(const char *config_path, const char *rendering_space, CohortError *err)
{
    if (!config_path || !config_path[0])
        config_path = getenv("OCIO");
    CoColor *color = co_alloc_zero(TAG, sizeof *color);
    CO_CHECK_NULL(color, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    pthread_mutex_init(&color->lock, NULL);
    bool ok = true;
    if (config_path && config_path[0]) {
        color->config = co_ocio_config_open(config_path, NULL, err);
        ok = color->config != NULL;
    }
    if (!ok || !choose_rendering_space(color, rendering_space, err)) {
        co_color_destroy(color);
        return NULL;
    }
    return color;
}

void co_color_destroy(CoColor *color)
{
    if (!color)
        return;
    for (uint32_t i = 0; i < color->route_count; i++)
        co_ocio_processor_destroy(color->routes[i].processor);
    co_ocio_config_close(color->config);
    pthread_mutex_destroy(&color->lock);
    co_free(TAG, color, sizeof *color);
}

static void set_matrix(Route *route, const CoRgbSpace *from, const CoRgbSpace *to)
{
    route->has_matrix = memcmp(from->xy, to->xy, sizeof from->xy) != 0;
    co_rgb_space_matrix(from, to, route->matrix);
}

// A space of the config, into the config's rendering space or one of USD's.
static bool route_from_config(const CoColor *color, const char *space, Route *route,
                              CohortError *err)
{
    const char *to = color->built_in ? interchange(color) : color->name;
    if (co_ocio_space_is_data(color->config, space))
        return true;
    route->processor = co_ocio_convert(color->config, space, to, err);
    if (!route->processor)
        return false;
    if (color->built_in)
        set_matrix(route, co_rgb_space_find("lin_ap0_scene"), color->built_in);
    return true;
}

static bool route_from_built_in(const CoColor *color, const CoRgbSpace *space, Route *route,
                                CohortError *err)
{
    if (space->is_data)
        return true;
    route->curve = space->curve == CO_CURVE_LINEAR ? NULL : space;
    if (color->built_in) {
        set_matrix(route, space, color->built_in);
        return true;
    }
    const char *hub = interchange(color);
    // A config without interchange roles cannot say where Rec.709 lies; its scene_linear is then
    // taken to have those primaries, as OCIO v1 viewers do.
    if (!hub)
        return true;
    const CoRgbSpace *ap0 = co_rgb_space_find("lin_ap0_scene");
    set_matrix(route, space, ap0);
    route->matrix_first = true;
    route->processor = co_ocio_convert(color->config, hub, color->name, err);
    return route->processor != NULL;
}

static bool make_route(const CoColor *color, const char *space, Route *route, CohortError *err)
{
    const CoRgbSpace *built_in = co_rgb_space_find(space);
    bool in_config = color->config && co_ocio_space(color->config, space);
    snprintf(route->space, sizeof route->space, "%s", space);
    if (in_config && !(built_in && !strcmp(space, "sRGB")))
        return route_from_config(color, space, route, err);
    CO_CHECK(built_in, err, COHORT_ERROR_COLOR,
             "color space \"%s\" is neither in %s nor one of USD's", space,
             color->config ? "the OCIO config" : "an OCIO config (none is set)");
    return route_from_built_in(color, built_in, route, err);
}

static const Route *find_route(CoColor *color, const char *space, CohortError *err)
{
    for (uint32_t i = 0; i < color->route_count; i++)
        if (!strcmp(color->routes[i].space, space))
            return &color->routes[i];
    CO_CHECK_NULL(color->route_count < PROCESSORS_MAX && strlen(space) < NAME_MAX_BYTES, err,
                  COHORT_ERROR_LIMIT, "more than %d color spaces in one scene", PROCESSORS_MAX);
    Route *route = &color->routes[color->route_count];
    if (!make_route(color, space, route, err)) {
        co_ocio_processor_destroy(route->processor);
        memset(route, 0, sizeof *route);
        return NULL;
    }
    color->route_count++;
    return route;
}

bool co_color_to_rendering(void *cookie, const char *space, float *pixels, size_t count,
                           CohortError *err)
{
    CoColor *color = cookie;
    pthread_mutex_lock(&color->lock);
    const Route *route = find_route(color, space, err);
    pthread_mutex_unlock(&color->lock);
    if (!route)
        return false;
    for (size_t i = 0; i < count; i++) {
        float *p = &pixels[4 * i];
        for (int c = 0; c < 3 && route->curve; c++)
            p[c] = co_rgb_space_decode(route->curve, p[c]);
        if (route->has_matrix && (route->matrix_first || !route->processor))
            co_rgb_matrix_apply(route->matrix, p);
    }
    if (route->processor && !co_ocio_apply(route->processor, pixels, count, err))
        return false;
    for (size_t i = 0; i < count && route->processor && route->has_matrix && !route->matrix_first;
         i++)
        co_rgb_matrix_apply(route->matrix, &pixels[4 * i]);
    return true;
}

const char *co_color_space_of_file(void *cookie, const char *path)
{
    const CoColor *color = cookie;
    return color->config ? co_ocio_space_of_file(color->config, path) : NULL;
}

void co_color_rec709_matrix(const CoColor *color, float out[9])
{
    // Basis vectors through the real path, so that the matrix is whatever that path is. The cast
    // drops const for the route table alone, which has its own lock.
    CoColor *mutable_color = (CoColor *)(uintptr_t)color;
    float basis[12] = {1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1};
    if (!co_color_to_rendering(mutable_color, "lin_rec709_scene", basis, 3, NULL)) {
        static const float identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
        memcpy(out, identity, sizeof identity);
        return;
    }
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out[3 * i + j] = basis[4 * j + i];
}

static void xy_of(const double xyz[3], float out[2])
{
    double sum = xyz[0] + xyz[1] + xyz[2];
    out[0] = (float)(xyz[0] / sum);
    out[1] = (float)(xyz[1] / sum);
}

// Chromaticities of a config's space: its primaries and white, sent to ACES2065-1 and on to XYZ.
static bool evaluate_chromaticities(const CoColor *color, float out[8])
{
    const char *hub = interchange(color);
    CoOcioProcessor *p = hub ? co_ocio_convert(color->config, color->name, hub, NULL) : NULL;
    float rgba[16] = {1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1, 1, 1, 1, 1};
    bool ok = p && co_ocio_apply(p, rgba, 4, NULL);
    co_ocio_processor_destroy(p);
    double to_xyz[9];
    co_rgb_space_to_xyz(co_rgb_space_find("lin_ap0_scene"), to_xyz);
    for (int i = 0; i < 4 && ok; i++) {
        double xyz[3];
        for (int k = 0; k < 3; k++)
            xyz[k] = to_xyz[3 * k] * (double)rgba[4 * i] +
                     to_xyz[3 * k + 1] * (double)rgba[4 * i + 1] +
                     to_xyz[3 * k + 2] * (double)rgba[4 * i + 2];
        xy_of(xyz, &out[2 * i]);
    }
    return ok;
}

void co_color_chromaticities(const CoColor *color, float out[8])
{
    const CoRgbSpace *space =
        color->built_in ? color->built_in : co_rgb_space_find("lin_rec709_scene");
    if (!color->built_in && evaluate_chromaticities(color, out))
        return;
    for (int i = 0; i < 8; i++)
        out[i] = (float)space->xy[i];
}

const char *co_color_space_name(const CoColor *color)
{
    return color->name;
}
