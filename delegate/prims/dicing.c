#include "prims/dicing.h"

#include "base/error.h"
#include "base/hash.h"
#include "math/vec.h"

#include <string.h>

enum {
    LEVEL_MAX = 8
}; // as cohort:complexity

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

static double pixels_at(const CoDicing *d, double distance)
{
    return d->is_orthographic ? d->pixels : d->pixels / fmax(distance, d->clip_near);
}

static void to_world(const double m[4][4], const double p[3], double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = p[0] * m[0][k] + p[1] * m[1][k] + p[2] * m[2][k] + m[3][k];
}

// The most that a placement stretches lengths, at most: the Frobenius norm of its linear part.
static double stretch(const double m[4][4])
{
    double sum = 0.0;
    for (int i = 0; i < 9; i++)
        sum += m[i / 3][i % 3] * m[i / 3][i % 3];
    return sqrt(sum);
}

static void see(void *cookie, uint32_t object, const double m[4][4])
{
    CoDicing *d = cookie;
    if (object >= d->view_count)
        return;
    CoDicingView *view = &d->views[object];
    double world[3], distance = 0.0;
    to_world(m, view->center, world);
    for (int k = 0; k < 3; k++)
        distance += (world[k] - d->eye[k]) * (world[k] - d->eye[k]);
    double size = stretch(m), density = size * pixels_at(d, sqrt(distance) - size * view->radius);
    if (view->placements++ == 0)
        memcpy(view->to_world, m, sizeof view->to_world);
    if (isfinite(density))
        view->density = fmax(view->density, density);
}

static bool open_view(CohortRenderIndex *index, uint32_t width, CoDicing *d, CohortError *err)
{
    const CohortCameraDesc *camera = &index->camera_set;
    co_dicing_clear(d);
    memcpy(d->eye, camera->transform[3], sizeof d->eye);
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
    if (view->placements > 1)
        return co_hash_bytes(&view->density, sizeof view->density,
                             co_hash_bytes(&d->edge_length, sizeof d->edge_length, hash));
    hash = co_hash_bytes(numbers, sizeof numbers, hash);
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

// ---- Levels ------------------------------------------------------------------------------------

// Pixels of the segment from a to b as if it lay across the line of sight, where it comes nearest.
static double segment_pixels(const CoDicing *d, const double a[3], const double b[3])
{
    double along = 0.0, length = 0.0, distance = 0.0;
    for (int k = 0; k < 3; k++) {
        length += (b[k] - a[k]) * (b[k] - a[k]);
        along += (d->eye[k] - a[k]) * (b[k] - a[k]);
    }
    double t = length > 0.0 ? fmin(fmax(along / length, 0.0), 1.0) : 0.0;
    for (int k = 0; k < 3; k++) {
        double x = a[k] + t * (b[k] - a[k]) - d->eye[k];
        distance += x * x;
    }
    return sqrt(length) * pixels_at(d, sqrt(distance));
}

static double edge_pixels(const CoDicing *d, const CoDicingView *view, const float *p,
                          const float *q)
{
    const double a[3] = {(double)p[0], (double)p[1], (double)p[2]};
    const double b[3] = {(double)q[0], (double)q[1], (double)q[2]};
    if (view->placements > 1) {
        double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
        return view->density * sqrt(x * x + y * y + z * z);
    }
    double from[3], to[3];
    to_world((const double(*)[4])view->to_world, a, from);
    to_world((const double(*)[4])view->to_world, b, to);
    return segment_pixels(d, from, to);
}

static double longest_edge(const CoDicing *d, const CoDicingView *view, const CohortMeshDesc *desc)
{
    double longest = 0.0;
    size_t first = 0;
    for (size_t f = 0; f < desc->face_count; f++) {
        int32_t count = desc->face_vertex_counts[f];
        if (count < 3 || (size_t)count > desc->face_vertex_index_count - first)
            break;
        const int32_t *v = desc->face_vertex_indices + first;
        first += (size_t)count;
        for (int32_t k = 0; k < count; k++) {
            int32_t a = v[k], b = v[(k + 1) % count];
            if (a < 0 || b < 0 || (size_t)a >= desc->point_count || (size_t)b >= desc->point_count)
                continue;
            double pixels =
                edge_pixels(d, view, desc->points + 3 * (size_t)a, desc->points + 3 * (size_t)b);
            if (isfinite(pixels) && pixels > longest)
                longest = pixels;
        }
    }
    return longest;
}

uint32_t co_dicing_level(const CohortRenderIndex *index, const CoPrim *prim,
                         const CohortMeshDesc *desc)
{
    const CoDicing *d = &index->dicing;
    if (prim->view == 0 || prim->id >= d->view_count || d->views[prim->id].placements == 0 ||
        desc->scheme == COHORT_SCHEME_NONE || !desc->points)
        return 0;
    double pixels = longest_edge(d, &d->views[prim->id], desc);
    uint32_t level = 0;
    for (; pixels > d->edge_length && level < LEVEL_MAX; level++)
        pixels *= 0.5;
    return level;
}
