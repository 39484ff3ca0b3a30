// UsdLux lights, as the index pulls them; also the adapter's own: environment and headlight.

#include "stage_adapter/adapter.h"

#include "base/error.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

// usdrecord's camera light: about pi in irradiance on a surface that faces the camera.
static const float headlight_intensity = 15000.0f;

static const struct {
    const char *type;
    CohortLightType light;
} types[] = {{"RectLight", COHORT_LIGHT_RECT},     {"DiskLight", COHORT_LIGHT_DISK},
             {"SphereLight", COHORT_LIGHT_SPHERE}, {"DistantLight", COHORT_LIGHT_DISTANT},
             {"DomeLight", COHORT_LIGHT_DOME},     {"DomeLight_1", COHORT_LIGHT_DOME}};

// The attribute's name: "inputs:x", or "x" as before USD 21.02 when only that is authored.
static const char *name_of(const CohortPrim *prim, const char *input)
{
    const char *old = strchr(input, ':') + 1;
    return !cohort_prim_has_attribute(prim, input) && cohort_prim_has_attribute(prim, old) ? old
                                                                                           : input;
}

// Copies up to three numbers when all of them are finite; what is not is named, and the schema's
// own stay.
static void read_numbers(const CohortAdapter *a, const CohortPrim *prim, const char *input,
                         float *out, size_t count)
{
    const char *name = name_of(prim, input);
    double numbers[3];
    bool is_finite = true;
    if (!cohort_prim_numbers(prim, name, a->time, numbers, count))
        return;
    for (size_t i = 0; i < count; i++)
        is_finite = is_finite && isfinite((float)numbers[i]);
    if (is_finite) {
        for (size_t i = 0; i < count; i++)
            out[i] = (float)numbers[i];
        return;
    }
    CohortValue value;
    char text[64] = "", action[64];
    if (cohort_prim_value(prim, name, a->time, &value))
        co_values_describe(&value, text, sizeof text);
    snprintf(action, sizeof action,
             count > 1 ? "not finite: treated as %g, %g, %g" : "not finite: treated as %g",
             (double)out[0], (double)out[count > 1], (double)out[count > 1 ? 2 : 0]);
    co_adapter_report(a, prim, name, text, action);
}

static void read_texture(const CohortAdapter *a, const CohortPrim *prim, CohortLightDesc *out)
{
    const char *name = name_of(prim, "inputs:texture:file");
    const CohortAsset *assets;
    if (!cohort_prim_assets(prim, name, a->time, &assets) || !assets[0].authored[0])
        return;
    out->texture_asset = assets[0].authored;
    out->texture_file = assets[0].resolved[0] ? assets[0].resolved : assets[0].anchored;
    CohortValue space;
    if (cohort_prim_attribute_metadata(prim, name, "colorSpace", &space) &&
        co_values_text(&space)[0] && strcmp(co_values_text(&space), "auto") != 0) {
        out->texture_color_space = COHORT_COLOR_NAMED;
        out->texture_color_space_name = co_values_text(&space);
    }
    const char *format =
        cohort_prim_token(prim, name_of(prim, "inputs:texture:format"), a->time, "automatic");
    if (out->type == COHORT_LIGHT_DOME && strcmp(format, "automatic") != 0 &&
        strcmp(format, "latlong") != 0)
        co_adapter_report(a, prim, "inputs:texture:format", format, "read as latlong");
}

// ---- What is not honored -----------------------------------------------------------------------

static void report_unless(const CohortAdapter *a, const CohortPrim *prim, const char *input,
                          double harmless, const char *action)
{
    const char *name = name_of(prim, input);
    CohortValue value;
    if (!cohort_prim_value(prim, name, a->time, &value) || value.count == 0 ||
        cohort_prim_double(prim, name, a->time, harmless) == harmless)
        return;
    char text[64];
    co_values_describe(&value, text, sizeof text);
    co_adapter_report(a, prim, name, text, action);
}

static void report_relationship(const CohortAdapter *a, const CohortPrim *prim, const char *name,
                                const char *action)
{
    const char *const *targets;
    if (cohort_prim_targets(prim, name, &targets))
        co_adapter_report(a, prim, name, targets[0], action);
}

static void report_shadow_color(const CohortAdapter *a, const CohortPrim *prim)
{
    const char *name = name_of(prim, "inputs:shadow:color");
    double color[3] = {0};
    if (!cohort_prim_numbers(prim, name, a->time, color, 3) ||
        (color[0] == 0.0 && color[1] == 0.0 && color[2] == 0.0))
        return;
    char value[64];
    snprintf(value, sizeof value, "%g, %g, %g", color[0], color[1], color[2]);
    co_adapter_report(a, prim, name, value, "shadows are black");
}

static void report_unsupported(const CohortAdapter *a, const CohortPrim *prim)
{
    report_relationship(a, prim, "light:filters", "light filters are ignored");
    report_relationship(a, prim, "filters", "light filters are ignored");
    report_relationship(a, prim, "portals", "portals are ignored");
    const char *const links[] = {"collection:lightLink:includes", "collection:lightLink:excludes",
                                 "collection:shadowLink:includes",
                                 "collection:shadowLink:excludes"};
    for (size_t i = 0; i < sizeof links / sizeof links[0]; i++)
        report_relationship(a, prim, links[i], "no linking: lights everything");
    if (!cohort_prim_bool(prim, "collection:lightLink:includeRoot", a->time, true))
        co_adapter_report(a, prim, "collection:lightLink:includeRoot", "false",
                          "no linking: lights everything");
    report_unless(a, prim, "inputs:shadow:distance", -1.0, "shadows at any distance");
    report_unless(a, prim, "inputs:shadow:falloff", -1.0, "shadows without falloff");
    report_shadow_color(a, prim);
    const CohortAsset *ies;
    const char *name = name_of(prim, "inputs:shaping:ies:file");
    if (cohort_prim_assets(prim, name, a->time, &ies) && ies[0].authored[0])
        co_adapter_report(a, prim, name, ies[0].authored, "no IES profile");
}

// ---- Lights ------------------------------------------------------------------------------------

static void read_light(const CohortAdapter *a, const CohortPrim *prim, CohortLightDesc *out)
{
    read_numbers(a, prim, "inputs:color", out->color, 3);
    const struct {
        const char *input;
        float *value;
    } numbers[] = {{"inputs:intensity", &out->intensity},
                   {"inputs:exposure", &out->exposure},
                   {"inputs:colorTemperature", &out->color_temperature},
                   {"inputs:diffuse", &out->diffuse},
                   {"inputs:specular", &out->specular},
                   {"inputs:width", &out->width},
                   {"inputs:height", &out->height},
                   {"inputs:radius", &out->radius},
                   {"inputs:angle", &out->angle_degrees},
                   {"inputs:shaping:focus", &out->shaping_focus},
                   {"inputs:shaping:cone:angle", &out->shaping_cone_angle_degrees},
                   {"inputs:shaping:cone:softness", &out->shaping_cone_softness}};
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
        read_numbers(a, prim, numbers[i].input, numbers[i].value, 1);
    read_numbers(a, prim, "inputs:shaping:focusTint", out->shaping_focus_tint, 3);
    out->enable_color_temperature =
        cohort_prim_bool(prim, name_of(prim, "inputs:enableColorTemperature"), a->time, false);
    out->normalize = cohort_prim_bool(prim, name_of(prim, "inputs:normalize"), a->time, false);
    out->no_shadow = !cohort_prim_bool(prim, name_of(prim, "inputs:shadow:enable"), a->time, true);
    if (out->type == COHORT_LIGHT_RECT || out->type == COHORT_LIGHT_DOME)
        read_texture(a, prim, out);
    report_unsupported(a, prim);
}

bool co_pull_light(void *cookie, CohortPull *pull, const char *path, CohortLightDesc *out,
                   CohortError *err)
{
    CohortAdapter *a = cookie;
    const CoRecord *record = co_record_find(a, path);
    (void)pull;
    CO_CHECK(record, err, COHORT_ERROR_INTERNAL, "the adapter knows no light at %.180s", path);
    if (record->kind == CO_RECORD_ENV) {
        *out = cohort_light_default(COHORT_LIGHT_DOME);
        out->texture_file = out->texture_asset = a->env_file;
        return true;
    }
    if (record->kind == CO_RECORD_HEADLIGHT) {
        *out = cohort_light_default(COHORT_LIGHT_DISTANT);
        out->intensity = headlight_intensity;
        return true;
    }
    for (size_t i = 0; i < sizeof types / sizeof types[0]; i++)
        if (strcmp(types[i].type, cohort_prim_type(record->prim)) == 0)
            *out = cohort_light_default(types[i].light);
    read_light(a, record->prim, out);
    return true;
}
