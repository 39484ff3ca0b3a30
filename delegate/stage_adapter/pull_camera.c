// Cameras of a stage, and the one that frames everything.

#include "stage_adapter/adapter.h"

#include "base/error.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static void report_number(const CohortAdapter *a, const CohortPrim *prim, const char *name,
                          double harmless, const char *action)
{
    double value = cohort_prim_double(prim, name, a->time, harmless);
    if (value == harmless)
        return;
    char text[32];
    snprintf(text, sizeof text, "%g", value);
    co_adapter_report(a, prim, name, text, action);
}

// What the delegate cannot make a camera of, it replaces (prims/sync_camera.c).
static void report_replaced(const CohortAdapter *a, const CohortPrim *prim,
                            const CohortCameraSource *c)
{
    const struct {
        const char *name;
        double value;
        bool is_good;
        const char *action;
    } checks[] = {
        {"focalLength", c->focal_length, c->focal_length > 0.0 && isfinite(c->focal_length),
         "treated as 50"},
        {"horizontalAperture", c->horizontal_aperture,
         c->horizontal_aperture > 0.0 && isfinite(c->horizontal_aperture), "treated as 20.955"},
        {"verticalAperture", c->vertical_aperture,
         c->vertical_aperture > 0.0 && isfinite(c->vertical_aperture), "treated as 15.2908"},
        {"horizontalApertureOffset", c->horizontal_offset, isfinite(c->horizontal_offset),
         "treated as 0"},
        {"verticalApertureOffset", c->vertical_offset, isfinite(c->vertical_offset),
         "treated as 0"},
        {"fStop", c->f_stop, c->f_stop >= 0.0 && isfinite(c->f_stop), "no depth of field"},
        {"focusDistance", c->focus_distance, c->focus_distance >= 0.0, "no depth of field"},
        {"clippingRange", c->clip_near, isfinite(c->clip_near), "the near end is treated as 1"},
        {"clippingRange", c->clip_far, !isnan(c->clip_far), "the far end is treated as 1e+06"},
        {"clippingRange", c->clip_near, !(c->clip_far <= c->clip_near), "nothing is cut behind"}};
    for (size_t i = 0; i < sizeof checks / sizeof checks[0]; i++) {
        char value[32];
        snprintf(value, sizeof value, "%g", checks[i].value);
        if (!checks[i].is_good)
            co_adapter_report(a, prim, checks[i].name, value, checks[i].action);
    }
    const char *projection = cohort_prim_token(prim, "projection", a->time, "perspective");
    if (!c->orthographic && strcmp(projection, "perspective") != 0)
        co_adapter_report(a, prim, "projection", projection, "treated as perspective");
}

static void report_unsupported(const CohortAdapter *a, const CohortPrim *prim)
{
    CohortValue planes;
    if (cohort_prim_value(prim, "clippingPlanes", a->time, &planes) && planes.count)
        co_adapter_report(a, prim, "clippingPlanes", "", "ignored");
    report_number(a, prim, "shutter:open", 0.0, "no motion blur");
    report_number(a, prim, "shutter:close", 0.0, "no motion blur");
    report_number(a, prim, "exposure", 0.0, "the image is not scaled by it");
    report_number(a, prim, "exposure:time", 1.0, "the image is not scaled by it");
    report_number(a, prim, "exposure:iso", 100.0, "the image is not scaled by it");
    report_number(a, prim, "exposure:fStop", 1.0, "the image is not scaled by it");
    report_number(a, prim, "exposure:responsivity", 1.0, "the image is not scaled by it");
}

static void read_camera(const CohortAdapter *a, const CohortPrim *prim, CohortCameraSource *out)
{
    const struct {
        const char *name;
        double *value;
    } numbers[] = {{"horizontalAperture", &out->horizontal_aperture},
                   {"verticalAperture", &out->vertical_aperture},
                   {"horizontalApertureOffset", &out->horizontal_offset},
                   {"verticalApertureOffset", &out->vertical_offset},
                   {"focalLength", &out->focal_length},
                   {"fStop", &out->f_stop},
                   {"focusDistance", &out->focus_distance}};
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
        *numbers[i].value = cohort_prim_double(prim, numbers[i].name, a->time, *numbers[i].value);
    double range[2];
    if (cohort_prim_numbers(prim, "clippingRange", a->time, range, 2)) {
        out->clip_near = range[0];
        out->clip_far = range[1];
    }
    out->orthographic =
        strcmp(cohort_prim_token(prim, "projection", a->time, "perspective"), "orthographic") == 0;
}

bool co_pull_camera(void *cookie, const char *path, CohortCameraSource *out, CohortError *err)
{
    CohortAdapter *a = cookie;
    const CoRecord *record = co_record_find(a, path);
    CO_CHECK(record, err, COHORT_ERROR_INTERNAL, "the adapter knows no camera at %.180s", path);
    *out = cohort_camera_source_default();
    if (record->kind == CO_RECORD_FRAMING_CAMERA) {
        co_frame_camera(a, out);
        return true;
    }
    read_camera(a, record->prim, out);
    if (a->resolved.camera && strcmp(path, a->resolved.camera) == 0) {
        report_replaced(a, record->prim, out);
        report_unsupported(a, record->prim);
    }
    return true;
}

// ---- Framing -----------------------------------------------------------------------------------

// How far before the box the camera stands: until a circle about the box's front fits the
// horizontal field of view, as usdrecord has it, and the front's height the vertical one, which
// usdrecord cuts.
static double frame_distance(const CohortAdapter *a, int depth_axis, int up_axis)
{
    const double *box = a->frame_box;
    CohortCameraSource lens = cohort_camera_source_default();
    double width = 0.5 * (box[3] - box[0]), height = 0.5 * (box[3 + up_axis] - box[up_axis]);
    double depth = 0.5 * (box[3 + depth_axis] - box[depth_axis]);
    double across = 2.0 * lens.focal_length / lens.horizontal_aperture;
    double upright = 2.0 * lens.focal_length / lens.vertical_aperture;
    double distance =
        fmax(sqrt(width * width + height * height) * across, height * upright) + depth;
    return distance > 0.0 ? distance : 1.0;
}

CoMat4d co_frame_transform(const CohortAdapter *a)
{
    const double *box = a->frame_box;
    bool z_up = strcmp(a->info.up_axis, "Z") == 0;
    CoMat4d m = co_mat4d_identity();
    for (int i = 0; i < 3; i++)
        m.m[3][i] = 0.5 * (box[i] + box[3 + i]);
    if (!z_up) {
        m.m[3][2] += frame_distance(a, 2, 1);
        return m;
    }
    // The camera's up turns from +Y to +Z, so it looks along +Y from the -Y side.
    const double turn[3][3] = {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}};
    for (int r = 0; r < 3; r++)
        memcpy(m.m[r], turn[r], sizeof turn[r]);
    m.m[3][1] -= frame_distance(a, 1, 2);
    return m;
}

void co_frame_camera(const CohortAdapter *a, CohortCameraSource *out)
{
    bool z_up = strcmp(a->info.up_axis, "Z") == 0;
    double distance = frame_distance(a, z_up ? 1 : 2, z_up ? 2 : 1);
    *out = cohort_camera_source_default();
    // usdrecord's range begins at 1 and would cut small scenes.
    out->clip_near = distance * 1e-3 < 1.0 ? distance * 1e-3 : 1.0;
    out->clip_far = distance * 1e3 > out->clip_far ? distance * 1e3 : out->clip_far;
}
