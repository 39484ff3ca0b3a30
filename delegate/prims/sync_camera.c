// Cameras: from UsdGeomCamera's units to the renderer's, conformed to the image.

#include "prims/sync.h"

#include <math.h>
#include <string.h>

CohortCameraSource cohort_camera_source_default(void)
{
    return (CohortCameraSource){.horizontal_aperture = 20.955,
                                .vertical_aperture = 15.2908,
                                .focal_length = 50.0,
                                .clip_near = 1.0,
                                .clip_far = 1e6};
}

bool co_sync_camera(CohortRenderIndex *index, CoPrim *prim, CohortPull *pull, CohortError *err)
{
    bool moved = false;
    if (!co_sync_placement(index, prim, pull, &moved, err))
        return false;
    if (!(prim->dirty & COHORT_DIRTY_PARAMS))
        return true;
    CohortError reason = {0};
    prim->camera = cohort_camera_source_default();
    if (prim->scene->get_camera &&
        prim->scene->get_camera(prim->scene->cookie, prim->path, &prim->camera, &reason))
        return true;
    prim->camera = cohort_camera_source_default();
    return co_sync_refuse(index, prim, pull, "Camera", &reason, err);
}

// Changes the aperture until its aspect is that of the image (UsdRender's
// aspectRatioConformPolicy).
static void conform(CohortConformPolicy policy, double aspect, double *width, double *height)
{
    double own = *width / *height;
    switch (policy) {
    case COHORT_CONFORM_EXPAND_APERTURE:
        if (own > aspect)
            *height = *width / aspect;
        else
            *width = *height * aspect;
        break;
    case COHORT_CONFORM_CROP_APERTURE:
        if (own > aspect)
            *width = *height * aspect;
        else
            *height = *width / aspect;
        break;
    case COHORT_CONFORM_ADJUST_WIDTH:
        *width = *height * aspect;
        break;
    case COHORT_CONFORM_ADJUST_HEIGHT:
        *height = *width / aspect;
        break;
    case COHORT_CONFORM_ADJUST_PIXEL_ASPECT:
        break;
    }
}

// Rays of a lens are parallel when it is focused there; at infinity itself they would be no
// numbers.
static const double focus_most = 1e18;

static double positive_or(double value, double fallback)
{
    return value > 0.0 && isfinite(value) ? value : fallback;
}

static double finite_or(double value, double fallback)
{
    return isfinite(value) ? value : fallback;
}

void co_camera_desc(const CoPrim *prim, const CohortRenderPassState *state, uint32_t width,
                    uint32_t height, CohortCameraDesc *out)
{
    const CohortCameraSource *c = &prim->camera;
    CohortCameraSource fallback = cohort_camera_source_default();
    double aperture_x = positive_or(c->horizontal_aperture, fallback.horizontal_aperture);
    double aperture_y = positive_or(c->vertical_aperture, fallback.vertical_aperture);
    double pixel_aspect = positive_or(state->pixel_aspect_ratio, 1.0);
    conform(state->conform, pixel_aspect * (double)width / (double)height, &aperture_x,
            &aperture_y);
    // Apertures and focal length are tenths of a scene unit: perspective divides one by the other,
    // orthographic takes the aperture itself.
    double focal = positive_or(c->focal_length, fallback.focal_length);
    double scale = c->orthographic ? 0.1 : 1.0 / focal;
    memset(out, 0, sizeof *out);
    out->orthographic = c->orthographic;
    memcpy(out->transform, prim->transform, sizeof out->transform);
    double offset_x = finite_or(c->horizontal_offset, fallback.horizontal_offset);
    double offset_y = finite_or(c->vertical_offset, fallback.vertical_offset);
    out->window[0] = (offset_x - 0.5 * aperture_x) * scale;
    out->window[1] = (offset_x + 0.5 * aperture_x) * scale;
    out->window[2] = (offset_y - 0.5 * aperture_y) * scale;
    out->window[3] = (offset_y + 0.5 * aperture_y) * scale;
    out->clip_near = finite_or(c->clip_near, fallback.clip_near);
    out->clip_far = isnan(c->clip_far) ? fallback.clip_far : c->clip_far;
    if (!state->disable_depth_of_field && !c->orthographic && c->f_stop > 0.0 &&
        c->focus_distance > 0.0) {
        out->lens_radius = 0.1 * focal / (2.0 * c->f_stop);
        out->focus_distance = fmin(c->focus_distance, focus_most);
    }
}
