// What to render: options, then the render settings prim, then the stage.

#include "stage_adapter/adapter.h"

#include "base/error.h"
#include "base/hash.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    DEFAULT_WIDTH = 1280,
    MAX_SIDE = 65536
};

// The prim that authors a RenderSettingsBase attribute: the product overrides the settings.
static const CohortPrim *author_of(const CohortAdapter *a, const char *name)
{
    const CohortPrim *const prims[] = {a->product_prim, a->settings_prim};
    for (int i = 0; i < 2; i++)
        if (prims[i] && (cohort_prim_has_attribute(prims[i], name) ||
                         cohort_prim_has_relationship(prims[i], name)))
            return prims[i];
    return NULL;
}

static const CohortPrim *first_target_prim(const CohortAdapter *a, const CohortPrim *prim,
                                           const char *relationship)
{
    const char *const *targets;
    if (!prim || cohort_prim_targets(prim, relationship, &targets) == 0)
        return NULL;
    const CohortPrim *target = cohort_stage_prim(a->stage, targets[0]);
    if (!target)
        co_adapter_report(a, prim, relationship, targets[0], "no such prim: ignored");
    return target;
}

static bool find_settings(CohortAdapter *a, CohortError *err)
{
    const char *path = a->options.render_settings;
    bool is_asked = path && path[0];
    if (!is_asked)
        path = a->info.render_settings_prim_path;
    if (!path[0])
        return true;
    a->settings_prim = cohort_stage_prim(a->stage, path);
    if (a->settings_prim && strcmp(cohort_prim_type(a->settings_prim), "RenderSettings") == 0) {
        a->product_prim = first_target_prim(a, a->settings_prim, "products");
        return true;
    }
    a->settings_prim = NULL;
    CO_CHECK(!is_asked, err, COHORT_ERROR_ARGUMENT, "there is no RenderSettings prim at %.180s",
             path);
    co_adapter_report(a, NULL, "renderSettingsPrimPath", path, "no RenderSettings there: ignored");
    return true;
}

// ---- Attributes --------------------------------------------------------------------------------

static uint32_t read_purposes(const CohortAdapter *a)
{
    static const char *const names[] = {"default", "render", "proxy", "guide"};
    const uint32_t fallback = COHORT_PURPOSE_DEFAULT | COHORT_PURPOSE_RENDER;
    CohortValue value;
    if (a->options.purposes)
        return a->options.purposes;
    if (!a->settings_prim ||
        !cohort_prim_value(a->settings_prim, "includedPurposes", a->time, &value) ||
        value.type != COHORT_TYPE_TOKEN)
        return fallback;
    uint32_t purposes = 0;
    const CohortString *tokens = value.data;
    for (size_t i = 0; i < value.count; i++) {
        uint32_t bit = 0;
        for (int k = 0; k < 4; k++)
            bit |= strcmp(tokens[i].text, names[k]) == 0 ? 1u << k : 0;
        if (!bit)
            co_adapter_report(a, a->settings_prim, "includedPurposes", tokens[i].text,
                              "no such purpose: ignored");
        purposes |= bit;
    }
    return purposes ? purposes : fallback;
}

static CohortConformPolicy read_conform(const CohortAdapter *a)
{
    static const char *const names[] = {"expandAperture", "cropAperture", "adjustApertureWidth",
                                        "adjustApertureHeight", "adjustPixelAspectRatio"};
    const CohortPrim *prim = author_of(a, "aspectRatioConformPolicy");
    if (!prim)
        return COHORT_CONFORM_EXPAND_APERTURE;
    const char *authored = cohort_prim_token(prim, "aspectRatioConformPolicy", a->time, names[0]);
    for (int i = 0; i < 5; i++)
        if (strcmp(authored, names[i]) == 0)
            return (CohortConformPolicy)i;
    co_adapter_report(a, prim, "aspectRatioConformPolicy", authored, "treated as expandAperture");
    return COHORT_CONFORM_EXPAND_APERTURE;
}

static double read_pixel_aspect(const CohortAdapter *a)
{
    const CohortPrim *prim = author_of(a, "pixelAspectRatio");
    double aspect = prim ? cohort_prim_double(prim, "pixelAspectRatio", a->time, 1.0) : 1.0;
    if (aspect > 0.0 && isfinite(aspect))
        return aspect;
    char value[32];
    snprintf(value, sizeof value, "%g", aspect);
    co_adapter_report(a, prim, "pixelAspectRatio", value, "treated as 1");
    return 1.0;
}

// The resolution that the settings author, 0 x 0 for none; what is no size is named.
static void read_resolution(const CohortAdapter *a, double size[2])
{
    size[0] = size[1] = 0.0;
    double authored[2];
    const CohortPrim *prim = author_of(a, "resolution");
    if (!prim || !cohort_prim_numbers(prim, "resolution", a->time, authored, 2))
        return;
    char value[64];
    snprintf(value, sizeof value, "%g, %g", authored[0], authored[1]);
    if (!(authored[0] >= 1.0 && authored[1] >= 1.0)) {
        co_adapter_report(a, prim, "resolution", value, "no size: ignored");
        return;
    }
    if (authored[0] > MAX_SIDE || authored[1] > MAX_SIDE)
        co_adapter_report(a, prim, "resolution", value, "sides are at most 65536");
    memcpy(size, authored, sizeof authored);
}

// RenderVars name AOVs; which of them are written is the host's choice, but only these exist.
static void report_vars(const CohortAdapter *a)
{
    const char *const *vars;
    size_t count = a->product_prim ? cohort_prim_targets(a->product_prim, "orderedVars", &vars) : 0;
    for (size_t i = 0; i < count; i++) {
        const CohortPrim *var = cohort_stage_prim(a->stage, vars[i]);
        const char *name = var ? cohort_prim_token(var, "sourceName", a->time, "") : "";
        bool is_color = strcmp(name, "Ci") == 0 || strcmp(name, "beauty") == 0;
        if (!var)
            co_adapter_report(a, a->product_prim, "orderedVars", vars[i], "no such prim: ignored");
        else if (!is_color && cohort_aov_descriptor(name).format == COHORT_FORMAT_NONE)
            co_adapter_report(a, var, "sourceName", name, "no such AOV: no channel");
    }
}

// The order of purposes is fixed: full, then all-purpose.
static void report_binding_purposes(const CohortAdapter *a)
{
    CohortValue value;
    if (!a->settings_prim ||
        !cohort_prim_value(a->settings_prim, "materialBindingPurposes", a->time, &value) ||
        value.type != COHORT_TYPE_TOKEN)
        return;
    const CohortString *purposes = value.data;
    for (size_t i = 0; i < value.count; i++)
        if (purposes[i].text[0] && strcmp(purposes[i].text, "full") != 0)
            co_adapter_report(a, a->settings_prim, "materialBindingPurposes", purposes[i].text,
                              "full, then all-purpose");
}

static void report_unsupported(const CohortAdapter *a)
{
    report_vars(a);
    report_binding_purposes(a);
    const CohortPrim *prim = author_of(a, "dataWindowNDC");
    double window[4];
    if (prim && cohort_prim_numbers(prim, "dataWindowNDC", a->time, window, 4) &&
        (window[0] != 0.0 || window[1] != 0.0 || window[2] != 1.0 || window[3] != 1.0)) {
        char value[96];
        snprintf(value, sizeof value, "%g, %g, %g, %g", window[0], window[1], window[2], window[3]);
        co_adapter_report(a, prim, "dataWindowNDC", value, "the whole image is rendered");
    }
    const char *const *products;
    size_t count =
        a->settings_prim ? cohort_prim_targets(a->settings_prim, "products", &products) : 0;
    for (size_t i = 1; i < count; i++)
        co_adapter_report(a, a->settings_prim, "products", products[i],
                          "only the first product is rendered");
}

bool co_resolve_settings(CohortAdapter *a, CohortError *err)
{
    if (!find_settings(a, err))
        return false;
    CohortResolvedSettings *r = &a->resolved;
    a->purposes = read_purposes(a);
    r->conform = read_conform(a);
    r->pixel_aspect_ratio = read_pixel_aspect(a);
    const CohortPrim *prim = author_of(a, "disableDepthOfField");
    r->disable_depth_of_field =
        prim && cohort_prim_bool(prim, "disableDepthOfField", a->time, false);
    r->rendering_color_space =
        a->settings_prim ? cohort_prim_token(a->settings_prim, "renderingColorSpace", a->time, "")
                         : "";
    r->settings_path = a->settings_prim ? cohort_prim_path(a->settings_prim) : "";
    r->product_name =
        a->product_prim ? cohort_prim_token(a->product_prim, "productName", a->time, "") : "";
    r->time = a->time;
    r->frames_per_second = a->info.frames_per_second;
    r->meters_per_unit = a->info.meters_per_unit;
    report_unsupported(a);
    return true;
}

// ---- Camera ------------------------------------------------------------------------------------

static const char *camera_named(const CohortAdapter *a, const char *name)
{
    for (size_t i = 0; i < a->camera_count; i++) {
        const char *slash = strrchr(a->cameras[i], '/');
        if (strcmp(name[0] == '/' ? a->cameras[i] : slash + 1, name) == 0)
            return a->cameras[i];
    }
    return NULL;
}

static bool frame_stage(CohortAdapter *a, CohortError *err)
{
    CoRecord record = {
        .kind = CO_RECORD_FRAMING_CAMERA, .path = CO_CAMERA_PATH, .prototype = CO_WORLD};
    bool ok = a->options.inspect ? cohort_render_index_pull(a->index, err)
                                 : cohort_render_index_sync(a->index, err);
    if (!ok)
        return false;
    if (!cohort_render_index_bounds(a->index, a->frame_box))
        memset(a->frame_box, 0, sizeof a->frame_box);
    a->resolved.camera_frames = true;
    a->resolved.camera = CO_CAMERA_PATH;
    return co_record_add(a, &record, COHORT_PRIM_CAMERA, err) != NULL;
}

static bool refuse_camera(const CohortAdapter *a, const char *asked, CohortError *err)
{
    CO_CHECK(a->camera_count, err, COHORT_ERROR_ARGUMENT,
             "the stage has no camera \"%.150s\", nor any other", asked);
    CO_CHECK(a->camera_count > 1, err, COHORT_ERROR_ARGUMENT,
             "the stage has no camera \"%.90s\", but %.90s", asked, a->cameras[0]);
    return CO_FAIL(err, COHORT_ERROR_ARGUMENT,
                   "the stage has no camera \"%.90s\", but %.60s and %zu more", asked,
                   a->cameras[0], a->camera_count - 1);
}

bool co_resolve_camera(CohortAdapter *a, CohortError *err)
{
    const char *asked = a->options.camera;
    if (asked && asked[0]) {
        a->resolved.camera = camera_named(a, asked);
        return a->resolved.camera || refuse_camera(a, asked, err);
    }
    const CohortPrim *author = author_of(a, "camera");
    const CohortPrim *camera = first_target_prim(a, author, "camera");
    if (camera)
        a->resolved.camera = camera_named(a, cohort_prim_path(camera));
    if (camera && !a->resolved.camera)
        co_adapter_report(a, author, "camera", cohort_prim_path(camera), "no camera: ignored");
    if (!a->resolved.camera)
        a->resolved.camera = camera_named(a, "main_cam");
    if (!a->resolved.camera && a->camera_count)
        a->resolved.camera = a->cameras[0];
    return a->resolved.camera || frame_stage(a, err);
}

// ---- Size --------------------------------------------------------------------------------------

static double camera_aspect(CohortAdapter *a)
{
    CohortCameraSource camera;
    if (!co_pull_camera(a, a->resolved.camera, &camera, NULL) ||
        !(camera.horizontal_aperture > 0.0) || !(camera.vertical_aperture > 0.0))
        camera = cohort_camera_source_default();
    return camera.horizontal_aperture / camera.vertical_aperture;
}

static uint32_t side(double value)
{
    return value >= MAX_SIDE ? MAX_SIDE : value >= 1.0 ? (uint32_t)(value + 0.5) : 1;
}

void co_resolve_size(CohortAdapter *a)
{
    CohortResolvedSettings *r = &a->resolved;
    r->width = a->options.width;
    r->height = a->options.height;
    double aspect = camera_aspect(a), size[2];
    read_resolution(a, size);
    if (size[0] > 0.0) {
        aspect = size[0] / size[1];
        if (!r->width && !r->height) {
            r->width = side(size[0]);
            r->height = side(size[1]);
        }
    }
    if (!r->width && !r->height)
        r->width = DEFAULT_WIDTH;
    if (!r->width)
        r->width = side(r->height * aspect);
    if (!r->height)
        r->height = side(r->width / aspect);
    uint64_t hash = co_hash_combine(a->info.hash, a->purposes);
    hash = co_hash_bytes(&a->time, sizeof a->time, hash);
    hash = co_hash_bytes(r->camera, strlen(r->camera), hash);
    r->stage_hash = co_hash_combine(hash, a->options.headlight);
    if (a->options.env)
        r->stage_hash = co_hash_bytes(a->options.env, strlen(a->options.env), r->stage_hash);
    r->light_count = a->light_count;
}
