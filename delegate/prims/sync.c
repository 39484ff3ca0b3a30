#include "prims/sync.h"

#include "base/clock.h"
#include "base/error.h"
#include "base/stop.h"
#include "math/vec.h"
#include "pass/render_thread.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

size_t co_sync_nearest(const double *first_time, size_t count, size_t stride)
{
    size_t best = 0;
    double best_distance = HUGE_VAL;
    for (size_t i = 0; i < count; i++) {
        double time;
        memcpy(&time, (const char *)first_time + i * stride, sizeof time);
        if (fabs(time) < best_distance) {
            best_distance = fabs(time);
            best = i;
        }
    }
    return best;
}

static bool ran_short(const CoPrim *prim)
{
    return prim->scene->ran_short && prim->scene->ran_short(prim->scene->cookie);
}

void co_sync_begin(CohortRenderIndex *index, const CoPrim *prim)
{
    ran_short(prim);
    co_delegate_has_lost(index->delegate);
}

bool co_sync_is_whole(CohortRenderIndex *index, const CoPrim *prim, const CohortPull *pull,
                      CohortError *err)
{
    bool has_lost = co_delegate_has_lost(index->delegate), is_short = ran_short(prim);
    CO_CHECK(!has_lost && !is_short && !pull->is_short, err, COHORT_ERROR_OUT_OF_MEMORY,
             "out of memory");
    return true;
}

bool co_sync_refuse(CohortRenderIndex *index, const CoPrim *prim, const CohortPull *pull,
                    const char *what, CohortError *reason, CohortError *err)
{
    if (reason->code == COHORT_ERROR_OUT_OF_MEMORY) {
        if (err && err->code == COHORT_OK)
            *err = *reason;
        return false;
    }
    if (!co_sync_is_whole(index, prim, pull, err))
        return false;
    char action[320];
    snprintf(action, sizeof action, "left out: %s",
             reason->message[0] ? reason->message : "the scene delegate gave no reason");
    bool ok = cohort_delegate_report_add(index->delegate, COHORT_SEVERITY_WARNING, prim->path, what,
                                         "", action);
    return ok || CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
}

static bool is_finite_matrix(const double m[4][4])
{
    for (int i = 0; i < 16; i++)
        if (!isfinite(m[i / 4][i % 4]))
            return false;
    return true;
}

// Why a prim cannot stand there; NULL when it can. Lights and cameras judge their own scales.
static const char *why_no_place(const CoPrim *prim, const double matrix[4][4])
{
    if (!is_finite_matrix(matrix))
        return "the transform is not finite";
    CoMat4d m, inverse;
    memcpy(m.m, matrix, sizeof m.m);
    bool has_shape = prim->type == COHORT_PRIM_MESH || prim->type == COHORT_PRIM_INSTANCER;
    if (has_shape && !co_mat4d_invert_placement(&m, &inverse))
        return "the transform is singular or scales beyond 1e18";
    return NULL;
}

static void set_nowhere(CoPrim *prim, bool is_nowhere, bool *changed)
{
    *changed = *changed || prim->is_nowhere != is_nowhere;
    prim->is_nowhere = is_nowhere;
}

static bool sync_transform(CohortRenderIndex *index, CoPrim *prim, CohortPull *pull, bool *changed,
                           CohortError *err)
{
    double matrix[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    if (prim->scene->get_transform) {
        CohortError reason = {0};
        const CohortTransformSample *samples = NULL;
        size_t count = 0;
        if (!prim->scene->get_transform(prim->scene->cookie, pull, prim->path, &samples, &count,
                                        &reason)) {
            set_nowhere(prim, true, changed);
            return co_sync_refuse(index, prim, pull, "transform", &reason, err);
        }
        if (count)
            memcpy(matrix,
                   samples[co_sync_nearest(&samples[0].time, count, sizeof *samples)].matrix,
                   sizeof matrix);
    }
    const char *why = why_no_place(prim, (const double(*)[4])matrix);
    if (why) {
        CohortError reason = {0};
        snprintf(reason.message, sizeof reason.message, "%s", why);
        set_nowhere(prim, true, changed);
        return co_sync_refuse(index, prim, pull, "transform", &reason, err);
    }
    set_nowhere(prim, false, changed);
    if (memcmp(prim->transform, matrix, sizeof matrix) != 0) {
        memcpy(prim->transform, matrix, sizeof matrix);
        *changed = true;
    }
    return true;
}

bool co_sync_placement(CohortRenderIndex *index, CoPrim *prim, CohortPull *pull, bool *changed,
                       CohortError *err)
{
    if (prim->dirty & COHORT_DIRTY_VISIBILITY) {
        bool visible =
            !prim->scene->get_visible || prim->scene->get_visible(prim->scene->cookie, prim->path);
        *changed = *changed || visible != prim->is_visible;
        prim->is_visible = visible;
    }
    if (prim->dirty & COHORT_DIRTY_TRANSFORM)
        return sync_transform(index, prim, pull, changed, err);
    return true;
}

static bool sync_instancer(CohortRenderIndex *index, CoPrim *prim, CohortPull *pull,
                           CohortError *err)
{
    bool changed = (prim->dirty & (COHORT_DIRTY_INSTANCER | COHORT_DIRTY_INSTANCE_INDEX)) != 0;
    if (!co_sync_placement(index, prim, pull, &changed, err))
        return false;
    if (changed)
        index->containers[prim->container].is_dirty = true;
    return true;
}

static bool sync_prim(CohortRenderIndex *index, CoPrim *prim, CohortPull *pull, CohortError *err)
{
    switch (prim->type) {
    case COHORT_PRIM_MESH:
        return co_sync_mesh(index, prim, pull, err);
    case COHORT_PRIM_INSTANCER:
        return sync_instancer(index, prim, pull, err);
    case COHORT_PRIM_CAMERA:
        return co_sync_camera(index, prim, pull, err);
    case COHORT_PRIM_LIGHT:
        return co_sync_light(index, prim, pull, err);
    case COHORT_PRIM_MATERIAL:
        return co_sync_material(index, prim, pull, err);
    case COHORT_PRIM_TYPE_COUNT:
        break;
    }
    return true;
}

static void count_bits(CohortRenderIndex *index, const CoPrim *prim)
{
    for (uint32_t bit = 0; bit < COHORT_DIRTY_BIT_COUNT; bit++)
        if (prim->dirty & (1u << bit))
            index->counts.by_bit[prim->type][bit]++;
}

static bool sync_type(CohortRenderIndex *index, CohortPrimType type, CohortError *err)
{
    CohortPull pull = {.arena = {.tag = CO_MEMORY_DELEGATE}};
    const volatile int *stop = index->delegate->stop;
    bool ok = true;
    for (size_t i = 0; ok && i < index->prim_count; i++) {
        CoPrim *prim = index->prims[i];
        if (!prim || prim->type != type || !prim->dirty)
            continue;
        CoArenaMark mark = co_arena_mark(&pull.arena);
        co_report_begin(&index->delegate->report);
        co_sync_begin(index, prim);
        ok = (!co_is_stopped(stop) || CO_FAIL(err, COHORT_ERROR_CANCELLED, "stopped")) &&
             sync_prim(index, prim, &pull, err) && co_sync_is_whole(index, prim, &pull, err);
        co_arena_rewind(&pull.arena, mark);
        // What is pulled again speaks again.
        co_report_end(&index->delegate->report, ok);
        if (ok) {
            count_bits(index, prim);
            prim->dirty = 0;
        }
    }
    co_arena_clear(&pull.arena);
    return ok;
}

bool cohort_render_index_pull(CohortRenderIndex *index, CohortError *err)
{
    if (!co_index_is_dirty(index))
        return true;
    co_render_thread_drop(index->delegate->thread);
    double start = co_clock_seconds();
    if (index->materials_changed)
        cohort_render_index_mark_all_dirty(index, COHORT_PRIM_MESH, COHORT_DIRTY_MATERIAL_ID);
    index->materials_changed = false;
    // Materials come before the meshes that name them, groups after what they hold.
    bool ok = sync_type(index, COHORT_PRIM_MATERIAL, err) &&
              sync_type(index, COHORT_PRIM_MESH, err) &&
              sync_type(index, COHORT_PRIM_INSTANCER, err) && co_sync_groups(index, err) &&
              sync_type(index, COHORT_PRIM_LIGHT, err) && sync_type(index, COHORT_PRIM_CAMERA, err);
    index->load_seconds += co_clock_seconds() - start;
    return ok;
}

bool cohort_render_index_sync(CohortRenderIndex *index, CohortError *err)
{
    return cohort_render_index_pull(index, err) && co_index_commit(index, err);
}
