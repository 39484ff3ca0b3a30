// What can be wrong with a prim of any type.

#include "check.h"

#include <math.h>
#include <string.h>

bool check_value(const CohortPrim *prim, const char *name, CohortValue *out)
{
    const double *times;
    if (cohort_prim_value(prim, name, COHORT_TIME_DEFAULT, out))
        return true;
    return cohort_prim_time_samples(prim, name, &times) > 0 &&
           cohort_prim_value(prim, name, times[0], out);
}

// ---- Paths -------------------------------------------------------------------------------------

static void check_target(Check *check, const CohortPrim *prim, const char *name, const char *target,
                         bool is_connection)
{
    char path[4096];
    size_t length = strcspn(target, ".[");
    if (length >= sizeof path)
        return;
    memcpy(path, target, length);
    path[length] = 0;
    const CohortPrim *there = cohort_stage_prim(check->stage, path);
    const char *property = target[length] == '.' ? target + length + 1 : NULL;
    const char *what = is_connection ? "connected to" : "targets";
    if (!there)
        check_found(check, FINDING_MISSING_TARGET, COHORT_SEVERITY_WARNING, prim, name,
                    "%s <%s>, but there is no such prim", what, target);
    else if (!cohort_prim_is_active(there))
        check_found(check, FINDING_MISSING_TARGET, COHORT_SEVERITY_WARNING, prim, name,
                    "%s <%s>, but that prim is not active", what, target);
    else if (property && !strchr(property, '[') && !cohort_prim_has_attribute(there, property) &&
             !cohort_prim_has_relationship(there, property))
        check_found(check, FINDING_MISSING_TARGET, COHORT_SEVERITY_WARNING, prim, name,
                    "%s <%s>, but that prim has no %s", what, target, property);
}

static void check_targets(Check *check, const CohortPrim *prim, const char *name)
{
    const char *const *paths = NULL;
    bool is_connection = cohort_prim_has_attribute(prim, name);
    size_t count = is_connection ? cohort_prim_connections(prim, name, &paths)
                                 : cohort_prim_targets(prim, name, &paths);
    for (size_t i = 0; i < count; i++)
        check_target(check, prim, name, paths[i], is_connection);
}

static void check_asset(Check *check, const CohortPrim *prim, const char *name,
                        const CohortAsset *asset)
{
    if (!*asset->authored || *asset->resolved)
        return;
    if (strchr(asset->authored, '\\'))
        check_found(check, FINDING_MISSING_ASSET, COHORT_SEVERITY_ERROR, prim, name,
                    "@%s@ does not exist: its backslashes are no folders here", asset->authored);
    else
        check_found(check, FINDING_MISSING_ASSET, COHORT_SEVERITY_ERROR, prim, name,
                    "@%s@ does not exist (looked for %s)", asset->authored, asset->anchored);
}

static void check_assets(Check *check, const CohortPrim *prim, const char *name)
{
    const CohortAsset *assets;
    size_t count = cohort_prim_assets(prim, name, COHORT_TIME_DEFAULT, &assets);
    for (size_t i = 0; i < count; i++)
        check_asset(check, prim, name, &assets[i]);
    const double *times;
    size_t time_count = count ? 0 : cohort_prim_time_samples(prim, name, &times);
    for (size_t k = 0; k < time_count; k++) {
        count = cohort_prim_assets(prim, name, times[k], &assets);
        for (size_t i = 0; i < count; i++)
            check_asset(check, prim, name, &assets[i]);
    }
}

// ---- Transforms --------------------------------------------------------------------------------

static void check_transform(Check *check, const CohortPrim *prim)
{
    CohortValue order;
    if (!check_value(prim, "xformOpOrder", &order) || order.type != COHORT_TYPE_TOKEN)
        return;
    const CohortString *ops = order.data;
    for (size_t i = 0; i < order.count; i++) {
        const char *op = ops[i].text;
        if (!strncmp(op, "!invert!", 8))
            op += 8;
        if (strcmp(op, "!resetXformStack!") != 0 && !cohort_prim_has_attribute(prim, op))
            check_found(check, FINDING_TRANSFORM, COHORT_SEVERITY_ERROR, prim, "xformOpOrder",
                        "xformOpOrder names %s, but the prim has no such op", op);
    }
    double m[4][4];
    bool resets;
    if (!cohort_prim_local_transform(prim, 0, m, &resets))
        return;
    bool is_finite = true;
    for (int i = 0; i < 16; i++)
        is_finite = is_finite && isfinite(m[i / 4][i % 4]);
    double volume = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                    m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                    m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    if (!is_finite)
        check_found(check, FINDING_TRANSFORM, COHORT_SEVERITY_ERROR, prim, "xformOpOrder",
                    "the transform is not finite");
    else if (volume == 0)
        check_found(check, FINDING_TRANSFORM, COHORT_SEVERITY_WARNING, prim, "xformOpOrder",
                    "the transform is flat: it scales an axis to nothing");
}

// ---- Cameras -----------------------------------------------------------------------------------

static void check_camera(Check *check, const CohortPrim *prim)
{
    check->cameras++;
    double focal = cohort_prim_double(prim, "focalLength", 0, 50);
    double f_stop = cohort_prim_double(prim, "fStop", 0, 0);
    double clip[2] = {1, 1000000};
    CohortValue projection;
    bool is_orthographic = check_value(prim, "projection", &projection) &&
                           projection.type == COHORT_TYPE_TOKEN &&
                           !strcmp(((const CohortString *)projection.data)->text, "orthographic");
    double aperture = cohort_prim_double(prim, "horizontalAperture", 0, 20.955);
    double angle = 2 * atan(aperture / (2 * focal)) * 180 / M_PI;
    if (!(aperture > 0))
        check_found(check, FINDING_CAMERA, COHORT_SEVERITY_WARNING, prim, "horizontalAperture",
                    "horizontalAperture is %g: expected more than 0", aperture);
    else if (!is_orthographic && !(focal > 0))
        check_found(check, FINDING_CAMERA, COHORT_SEVERITY_WARNING, prim, "focalLength",
                    "focalLength is %g: expected more than 0", focal);
    else if (!is_orthographic && !(angle >= 0.5 && angle <= 160))
        check_found(check, FINDING_CAMERA, COHORT_SEVERITY_WARNING, prim, "focalLength",
                    "focalLength %g with horizontalAperture %g sees %.3g degrees", focal, aperture,
                    angle);
    if (f_stop < 0 || (f_stop > 0 && !(cohort_prim_double(prim, "focusDistance", 0, 0) > 0)))
        check_found(check, FINDING_CAMERA, COHORT_SEVERITY_WARNING, prim, "fStop",
                    f_stop < 0 ? "fStop is %g: expected 0 or more"
                               : "fStop is %g, but there is no focusDistance: no depth of field",
                    f_stop);
    if (cohort_prim_numbers(prim, "clippingRange", 0, clip, 2) && !(clip[0] < clip[1]))
        check_found(check, FINDING_CAMERA, COHORT_SEVERITY_WARNING, prim, "clippingRange",
                    "clippingRange (%g, %g) leaves nothing", clip[0], clip[1]);
}

// ---- Any prim ----------------------------------------------------------------------------------

static bool is_light(const CohortPrim *prim)
{
    const char *type = cohort_prim_type(prim);
    size_t length = strlen(type);
    return (length > 5 && !strcmp(type + length - 5, "Light")) ||
           cohort_prim_has_api(prim, "LightAPI") || cohort_prim_has_api(prim, "MeshLightAPI");
}

void check_prim(Check *check, const CohortPrim *prim)
{
    const char *type = cohort_prim_type(prim);
    check->lights += is_light(prim);
    if (!strcmp(type, "Mesh"))
        check_mesh(check, prim);
    if (!strcmp(type, "Camera"))
        check_camera(check, prim);
    check_transform(check, prim);
    for (size_t i = 0; i < cohort_prim_property_count(prim); i++) {
        const char *name = cohort_prim_property_name(prim, i);
        check_targets(check, prim, name);
        check_assets(check, prim, name);
    }
}
