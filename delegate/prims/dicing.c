#include "prims/dicing.h"

#include "base/error.h"
#include "base/hash.h"
#include "math/vec.h"

#include <string.h>

// What lies beside the picture may have edges this many times as long: it is seen in mirrors and by
// its shadow alone.
#define OFF_SCREEN 4.0

static double edge_setting(const CohortRenderIndex *index)
{
    return index->delegate->settings.values[CO_SETTING_EDGE_LENGTH].number;
}

void co_dicing_clear(CoDicing *dicing)
{
    co_free(CO_MEMORY_DELEGATE, dicing->views, dicing->view_count * sizeof *dicing->views);
    *dicing = (CoDicing){0};
}

// ---- What is seen how large --------------------------------------------------------------------

double co_dicing_pixels_at(const CoDicing *d, double distance)
{
    return d->is_orthographic ? d->pixels : d->pixels / fmax(distance, d->clip_near);
}

void co_dicing_to_world(const double m[4][4], const double p[3], double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = p[0] * m[0][k] + p[1] * m[1][k] + p[2] * m[2][k] + m[3][k];
}

double co_dicing_share(const CoDicing *d, const double center[3], double radius)
{
    double p[3] = {0.0, 0.0, 0.0};
    for (int axis = 0; axis < 3; axis++)
        for (int k = 0; k < 3; k++)
            p[axis] += (center[k] - d->eye[k]) * d->axes[axis][k];
    double depth = -p[2], beyond = d->is_orthographic ? 0.0 : d->clip_near - depth;
    for (int side = 0; side < 4; side++) {
        // Left, right, bottom, top: distance from the plane through the eye and that side.
        double sign = side % 2 ? 1.0 : -1.0, window = d->window[side];
        double at = d->is_orthographic ? window : window * depth;
        double slope = d->is_orthographic ? 1.0 : sqrt(1.0 + window * window);
        beyond = fmax(beyond, sign * (p[side / 2] - at) / slope);
    }
    return beyond > radius ? 1.0 / OFF_SCREEN : 1.0;
}

// The most that a placement stretches lengths, at most: the Frobenius norm of its linear part.
static double stretch(const double m[4][4])
{
    double sum = 0.0;
    for (int i = 0; i < 9; i++)
        sum += m[i / 3][i % 3] * m[i / 3][i % 3];
    return sqrt(sum);
}

// Keeps a placement, or of all the one that matters least as a density alone.
static void keep_placement(CoDicingView *view, const double m[4][4], double density)
{
    uint32_t place = co_dicing_places(view);
    view->placements++;
    if (place == CO_DICING_PLACES) {
        place = 0;
        for (uint32_t k = 1; k < CO_DICING_PLACES; k++)
            place = view->densities[k] < view->densities[place] ? k : place;
        bool is_least = !(density > view->densities[place]);
        view->density = fmax(view->density, is_least ? density : view->densities[place]);
        if (is_least)
            return;
    }
    memcpy(view->to_world[place], m, sizeof view->to_world[place]);
    view->densities[place] = density;
}

static void see(void *cookie, uint32_t object, const double m[4][4])
{
    CoDicing *d = cookie;
    if (object >= d->view_count)
        return;
    CoDicingView *view = &d->views[object];
    double world[3], distance = 0.0;
    co_dicing_to_world(m, view->center, world);
    for (int k = 0; k < 3; k++)
        distance += (world[k] - d->eye[k]) * (world[k] - d->eye[k]);
    double size = stretch(m), radius = size * view->radius;
    double density =
        size * co_dicing_pixels_at(d, sqrt(distance) - radius) * co_dicing_share(d, world, radius);
    keep_placement(view, m, isfinite(density) ? density : 0.0);
}

static bool open_view(CohortRenderIndex *index, uint32_t width, CoDicing *d, CohortError *err)
{
    const CohortCameraDesc *camera = &index->camera_set;
    co_dicing_clear(d);
    memcpy(d->eye, camera->transform[3], sizeof d->eye);
    memcpy(d->window, camera->window, sizeof d->window);
    for (int axis = 0; axis < 3; axis++) {
        const double *a = camera->transform[axis];
        double length = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
        for (int k = 0; k < 3; k++)
            d->axes[axis][k] = length > 0.0 ? a[k] / length : 0.0;
    }
    d->clip_near = fmax(camera->clip_near, 1e-6);
    d->is_orthographic = camera->orthographic;
    d->pixels = (double)width / fabs(camera->window[1] - camera->window[0]);
    d->edge_length = edge_setting(index);
    size_t count = 0;
    for (size_t i = 0; i < index->prim_count; i++)
        if (index->prims[i] && index->prims[i]->type == COHORT_PRIM_MESH &&
            index->prims[i]->id != COHORT_INVALID_ID && index->prims[i]->id >= count)
            count = (size_t)index->prims[i]->id + 1;
    d->views = co_alloc_zero(CO_MEMORY_DELEGATE, count * sizeof *d->views);
    CO_CHECK(d->views || count == 0, err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    d->view_count = count;
    for (size_t i = 0; i < index->prim_count; i++) {
        const CoPrim *prim = index->prims[i];
        if (!prim || prim->type != COHORT_PRIM_MESH || prim->id >= count)
            continue;
        memcpy(d->views[prim->id].center, prim->cage_center, sizeof prim->cage_center);
        d->views[prim->id].radius = prim->cage_radius;
    }
    cohort_scene_placements(index->scene, see, d);
    return true;
}

static uint64_t hash_view(const CoDicing *d, const CoDicingView *view)
{
    const double numbers[] = {d->eye[0],
                              d->eye[1],
                              d->eye[2],
                              d->clip_near,
                              d->pixels,
                              d->edge_length,
                              (double)d->is_orthographic};
    uint64_t hash = co_hash_combine(1, view->placements);
    hash = co_hash_bytes(&view->density, sizeof view->density, hash);
    hash = co_hash_bytes(numbers, sizeof numbers, hash);
    hash = co_hash_bytes(d->axes, sizeof d->axes, hash);
    hash = co_hash_bytes(d->window, sizeof d->window, hash);
    return co_hash_bytes(view->to_world, sizeof view->to_world, hash) | 1u;
}

bool co_dicing_update(CohortRenderIndex *index, uint32_t width, CohortError *err)
{
    if (!(edge_setting(index) > 0.0) || !index->has_camera_set)
        return true;
    if (!open_view(index, width, &index->dicing, err))
        return false;
    for (size_t i = 0; i < index->prim_count; i++) {
        CoPrim *prim = index->prims[i];
        if (!prim || prim->type != COHORT_PRIM_MESH || !prim->has_geometry ||
            prim->id >= index->dicing.view_count)
            continue;
        uint64_t hash = hash_view(&index->dicing, &index->dicing.views[prim->id]);
        if (hash != prim->view)
            prim->dirty |= COHORT_DIRTY_DISPLAY_STYLE;
        prim->view = hash;
    }
    return true;
}

void co_dicing_measure(CoPrim *prim, const CohortMeshDesc *desc)
{
    double lo[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, hi[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (size_t i = 0; desc->points && i < 3 * desc->point_count; i++) {
        double x = (double)desc->points[i];
        if (!isfinite(x))
            continue;
        lo[i % 3] = fmin(lo[i % 3], x);
        hi[i % 3] = fmax(hi[i % 3], x);
    }
    prim->cage_radius = 0.0;
    for (int k = 0; k < 3; k++) {
        double side = lo[k] <= hi[k] ? hi[k] - lo[k] : 0.0;
        prim->cage_center[k] = lo[k] <= hi[k] ? 0.5 * (lo[k] + hi[k]) : 0.0;
        prim->cage_radius += 0.25 * side * side;
    }
    prim->cage_radius = sqrt(prim->cage_radius);
}
