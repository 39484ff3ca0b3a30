// A light's description in world doubles to the prepared light of the render frame.

#include "light/light_internal.h"
#include "math/elementary.h"

#include "base/error.h"

typedef struct Double3 {
    double x, y, z;
} Double3;

static Double3 row(const CohortLightDesc *desc, int i, double scale)
{
    const double *m = desc->transform[i];
    Double3 v = {m[0] * scale, m[1] * scale, m[2] * scale};
    return v;
}

static double dot(Double3 a, Double3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static Double3 cross(Double3 a, Double3 b)
{
    Double3 c = {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    return c;
}

static Double3 scaled(Double3 a, double s)
{
    Double3 c = {a.x * s, a.y * s, a.z * s};
    return c;
}

static double length(Double3 a)
{
    return sqrt(dot(a, a));
}

static CoVec3 rounded(Double3 a)
{
    return co_vec3((float)a.x, (float)a.y, (float)a.z);
}

// Unit vector, or zero.
static Double3 unit(Double3 a)
{
    double l = length(a);
    return scaled(a, l > 0.0 ? 1.0 / l : 0.0);
}

static bool are_orthogonal(Double3 a, Double3 b)
{
    return fabs(dot(a, b)) <= 1e-6 * length(a) * length(b);
}

// ---- What makes a light dark ----------------------------------------------------------------

static bool is_transform_finite(const CohortLightDesc *desc)
{
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            if (!(fabs(desc->transform[i][j]) <= 1e30))
                return false;
    return true;
}

static bool is_size_usable(double size)
{
    return size > 0.0 && size <= 1e15;
}

static double determinant(const CohortLightDesc *desc)
{
    return dot(cross(row(desc, 0, 1.0), row(desc, 1, 1.0)), row(desc, 2, 1.0));
}

static double half_angle(const CohortLightDesc *desc)
{
    double degrees = (double)desc->angle_degrees / 2.0;
    return (degrees > 0.0 ? degrees < 180.0 ? degrees : 180.0 : 0.0) * (CO_PI_D / 180.0);
}

// Area of an ellipsoid: the length of the cofactor matrix times the normal, over the unit sphere.
static double ellipsoid_area(Double3 ex, Double3 ey, Double3 ez)
{
    enum {
        RINGS = 256,
        SPOKES = 64
    };
    Double3 cx = cross(ey, ez), cy = cross(ez, ex), cz = cross(ex, ey);
    double sum = 0.0;
    for (int i = 0; i < RINGS; i++) {
        double z = (2.0 * i + 1.0) / RINGS - 1.0, r = sqrt(1.0 - z * z);
        for (int j = 0; j < SPOKES; j++) {
            double s, c;
            co_sincos_d((double)j * (2.0 * CO_PI_D / SPOKES), &s, &c);
            Double3 v = {cx.x * r * c + cy.x * r * s + cz.x * z,
                         cx.y * r * c + cy.y * r * s + cz.y * z,
                         cx.z * r * c + cy.z * r * s + cz.z * z};
            sum += length(v);
        }
    }
    return sum * (4.0 * CO_PI_D / (RINGS * SPOKES));
}

static bool is_round(const CohortLightDesc *desc)
{
    Double3 x = row(desc, 0, 1.0), y = row(desc, 1, 1.0), z = row(desc, 2, 1.0);
    double l = length(x);
    return are_orthogonal(x, y) && are_orthogonal(y, z) && are_orthogonal(z, x) &&
           fabs(length(y) - l) <= 1e-6 * l && fabs(length(z) - l) <= 1e-6 * l;
}

// World-space area of the emitting surface; 0 for lights without one.
static double surface_area(const CohortLightDesc *desc)
{
    double r = (double)desc->radius;
    switch (desc->type) {
    case COHORT_LIGHT_RECT:
        return length(cross(row(desc, 0, (double)desc->width), row(desc, 1, (double)desc->height)));
    case COHORT_LIGHT_DISK:
        return CO_PI_D * length(cross(row(desc, 0, r), row(desc, 1, r)));
    case COHORT_LIGHT_SPHERE:
        if (is_round(desc))
            return 4.0 * CO_PI_D * dot(row(desc, 0, r), row(desc, 0, r));
        return ellipsoid_area(row(desc, 0, r), row(desc, 1, r), row(desc, 2, r));
    case COHORT_LIGHT_DISTANT:
    case COHORT_LIGHT_DOME:
        break;
    }
    return 0.0;
}

// What intensity is divided by (UsdLuxLightAPI, inputs:normalize).
static double size_factor(const CohortLightDesc *desc)
{
    if (!desc->normalize || desc->type == COHORT_LIGHT_DOME)
        return 1.0;
    if (desc->type != COHORT_LIGHT_DISTANT)
        return surface_area(desc);
    double h = half_angle(desc), sine, cosine;
    if (!(h > 0.0))
        return 1.0;
    co_sincos_d(h, &sine, &cosine);
    return CO_PI_D * (cosine >= 0.0 ? sine * sine : 2.0 - sine * sine);
}

static double scale_of_color(const CohortLightDesc *desc)
{
    return (double)desc->intensity * co_exp2_d((double)desc->exposure) / size_factor(desc);
}

// Why the light shines nowhere; NULL when it may.
static const char *why_dark(const CohortLightDesc *desc)
{
    bool is_rect = desc->type == COHORT_LIGHT_RECT, is_dome = desc->type == COHORT_LIGHT_DOME;
    bool has_radius = desc->type == COHORT_LIGHT_DISK || desc->type == COHORT_LIGHT_SPHERE;
    if (!is_transform_finite(desc))
        return "has a transform that is not finite: it gives no light";
    if (is_rect && (!is_size_usable((double)desc->width) || !is_size_usable((double)desc->height)))
        return "has a width or height that is not positive: it gives no light";
    if (has_radius && !is_size_usable((double)desc->radius))
        return "has a radius that is not positive: it gives no light";
    if ((is_rect || has_radius) && !(surface_area(desc) > 1e-30))
        return "has no area after its transform: it gives no light";
    if (desc->type == COHORT_LIGHT_SPHERE && determinant(desc) == 0.0)
        return "is flattened to nothing by its transform: it gives no light";
    if (desc->type == COHORT_LIGHT_DISTANT && !(length(row(desc, 2, 1.0)) > 0.0))
        return "has a transform that leaves it no direction: it gives no light";
    if (is_dome && determinant(desc) == 0.0)
        return "has a transform that cannot be inverted: it gives no light";
    double scale = scale_of_color(desc);
    for (int i = 0; i < 3; i++)
        if (!(fabs((double)desc->color[i] * scale) <= 1e30))
            return "has a brightness that is not finite: it gives no light";
    return NULL;
}

const char *co_light_problem(const CohortLightDesc *desc)
{
    const char *darkness = why_dark(desc);
    if (darkness != NULL)
        return darkness;
    for (int i = 0; i < 3; i++)
        if (desc->color[i] * desc->intensity < 0.0f)
            return "has a negative brightness: that counts as none";
    if (isnan(desc->shaping_focus) || isnan(desc->shaping_cone_angle_degrees) ||
        isnan(desc->shaping_cone_softness) ||
        (desc->enable_color_temperature && isnan(desc->color_temperature)))
        return "has a shaping or a color temperature that is no number: it counts as not given";
    if (!(desc->diffuse >= 0.0f) || !(desc->diffuse <= 1e30f))
        return "has a diffuse multiplier that is negative or not finite: it counts as 0";
    if (desc->specular != desc->diffuse)
        return "has a specular multiplier that differs from its diffuse one: the latter counts";
    bool is_shaped = desc->shaping_focus > 0.0f || desc->shaping_cone_angle_degrees < 90.0f;
    if (is_shaped && (desc->type == COHORT_LIGHT_DISTANT || desc->type == COHORT_LIGHT_DOME))
        return "has shaping, which only rect, disk and sphere lights heed: it is ignored";
    return NULL;
}

// ---- Preparation ----------------------------------------------------------------------------

static CoVec3 radiance_of(const CohortLightDesc *desc, const float rgb_to_rendering[9])
{
    CoVec3 tint = co_vec3_splat(1.0f);
    if (desc->enable_color_temperature) {
        CoVec3 rgb = co_blackbody_rgb(desc->color_temperature);
        const float *m = rgb_to_rendering;
        tint = co_vec3(m[0] * rgb.x + m[1] * rgb.y + m[2] * rgb.z,
                       m[3] * rgb.x + m[4] * rgb.y + m[5] * rgb.z,
                       m[6] * rgb.x + m[7] * rgb.y + m[8] * rgb.z);
    }
    double scale = scale_of_color(desc);
    return co_vec3(fmaxf((float)((double)desc->color[0] * scale) * tint.x, 0.0f),
                   fmaxf((float)((double)desc->color[1] * scale) * tint.y, 0.0f),
                   fmaxf((float)((double)desc->color[2] * scale) * tint.z, 0.0f));
}

static void setup_flat(CoLight *light, const CohortLightDesc *desc)
{
    bool is_rect = light->type == COHORT_LIGHT_RECT;
    double sx = is_rect ? 0.5 * (double)desc->width : (double)desc->radius;
    double sy = is_rect ? 0.5 * (double)desc->height : (double)desc->radius;
    Double3 ex = row(desc, 0, sx), ey = row(desc, 1, sy);
    Double3 normal = unit(cross(ey, ex));
    // The side that -Z comes out of, whatever mirrors the transform holds.
    if (dot(normal, row(desc, 2, -1.0)) < 0.0)
        normal = scaled(normal, -1.0);
    Double3 ux = cross(ey, normal), uy = cross(normal, ex);
    light->normal = rounded(normal);
    light->ex = rounded(ex);
    light->ey = rounded(ey);
    light->dir_x = co_normalize(light->ex);
    light->dir_y = co_normalize(light->ey);
    light->half_x = (double)co_length(light->ex);
    light->half_y = (double)co_length(light->ey);
    light->ux = rounded(scaled(ux, 1.0 / dot(ux, ex)));
    light->uy = rounded(scaled(uy, 1.0 / dot(uy, ey)));
    light->is_right_angled = are_orthogonal(ex, ey);
    light->bound = (float)(length(ex) + length(ey));
    if (light->is_right_angled)
        light->bound = (float)(sqrt(dot(ex, ex) + dot(ey, ey)) * 1.000001);
    if (co_dot(light->axis, light->axis) < 0.5f)
        light->axis = light->normal;
}

static void setup_sphere(CoLight *light, const CohortLightDesc *desc)
{
    double r = (double)desc->radius;
    Double3 ex = row(desc, 0, r), ey = row(desc, 1, r), ez = row(desc, 2, r);
    light->is_right_angled = is_round(desc);
    if (light->is_right_angled) {
        light->bound = (float)length(ex);
        return;
    }
    light->ex = rounded(ex);
    light->ey = rounded(ey);
    light->ez = rounded(ez);
    light->bound = (float)sqrt(dot(ex, ex) + dot(ey, ey) + dot(ez, ez));
    double det = dot(cross(ex, ey), ez);
    Double3 rows[3] = {scaled(cross(ey, ez), 1.0 / det), scaled(cross(ez, ex), 1.0 / det),
                       scaled(cross(ex, ey), 1.0 / det)};
    for (int i = 0; i < 3; i++) {
        light->to_local.m[i][0] = (float)rows[i].x;
        light->to_local.m[i][1] = (float)rows[i].y;
        light->to_local.m[i][2] = (float)rows[i].z;
    }
    light->to_local_det = (float)fabs(1.0 / det);
}

static void setup_distant(CoLight *light, const CohortLightDesc *desc)
{
    double h = half_angle(desc), sine, cosine;
    co_sincos_d(0.5 * h, &sine, &cosine);
    light->versine = (float)(2.0 * sine * sine);
    // Narrower than a stored direction can say: parallel, with the irradiance it has.
    light->is_delta = h < 1e-6;
    if (light->is_delta && h > 0.0)
        light->radiance = co_scale(light->radiance, (float)(CO_PI_D * h * h));
}

// Rows of the rotation nearest in the sense of Gram and Schmidt, Y kept.
static void setup_dome_axes(CoLight *light, const CohortLightDesc *desc)
{
    Double3 x = row(desc, 0, 1.0), y = unit(row(desc, 1, 1.0)), z = row(desc, 2, 1.0);
    double along = dot(z, y);
    Double3 flat = {z.x - along * y.x, z.y - along * y.y, z.z - along * y.z};
    z = unit(flat);
    Double3 right = cross(y, z);
    if (dot(right, x) < 0.0)
        right = scaled(right, -1.0);
    const Double3 rows[3] = {right, y, z};
    for (int i = 0; i < 3; i++) {
        light->to_local.m[i][0] = (float)rows[i].x;
        light->to_local.m[i][1] = (float)rows[i].y;
        light->to_local.m[i][2] = (float)rows[i].z;
    }
}

static void setup_shaping(CoLight *light, const CohortLightDesc *desc)
{
    double angle = (double)desc->shaping_cone_angle_degrees;
    double softness = (double)co_clamp(desc->shaping_cone_softness, 0.0f, 1.0f);
    bool has_cone = angle < 180.0 && (angle != 90.0 || softness > 0.0);
    light->focus = desc->shaping_focus > 0.0f ? fminf(desc->shaping_focus, 1e6f) : 0.0f;
    for (int i = 0; i < 3; i++) {
        float tint = desc->shaping_focus_tint[i];
        (&light->focus_tint.x)[i] = tint > 0.0f ? fminf(tint, 1e6f) : 0.0f;
    }
    light->cone_outer = light->cone_inner = 4.0f;
    if (has_cone) {
        double outer = fmax(angle, 0.0) * (CO_PI_D / 180.0);
        light->cone_outer = (float)outer;
        light->cone_inner = (float)(outer * (1.0 - softness));
    }
    light->is_shaped = has_cone || light->focus > 0.0f;
}

static float mean_of_image(const CoLightImage *image)
{
    double sum = 0.0;
    for (uint32_t y = 0; y < image->height; y++)
        for (uint32_t x = 0; x < image->width; x++) {
            CoVec3 c = co_light_image_texel(image, x, y);
            sum += (double)c.x + (double)c.y + (double)c.z;
        }
    return (float)(sum / (3.0 * (double)image->width * (double)image->height));
}

bool co_light_setup(CoLight *light, const CohortLightDesc *desc, const CoLightImage *image,
                    const double frame[3], const float rgb_to_rendering[9], CohortError *err)
{
    *light = (CoLight){.type = desc->type};
    if (desc->hidden || why_dark(desc) != NULL)
        return true;
    light->radiance = radiance_of(desc, rgb_to_rendering);
    light->diffuse = desc->diffuse >= 0.0f && desc->diffuse <= 1e30f ? desc->diffuse : 0.0f;
    Double3 center = {desc->transform[3][0] - frame[0], desc->transform[3][1] - frame[1],
                      desc->transform[3][2] - frame[2]};
    light->center = rounded(center);
    light->axis = rounded(unit(row(desc, 2, -1.0)));
    light->area = (float)surface_area(desc);
    light->inv_area = light->area > 0.0f ? 1.0f / light->area : 0.0f;
    bool takes_image = desc->type == COHORT_LIGHT_RECT || desc->type == COHORT_LIGHT_DOME;
    if (takes_image && image != NULL && image->pixels != NULL && image->width > 0 &&
        image->height > 0)
        light->image = *image;
    switch (desc->type) {
    case COHORT_LIGHT_RECT:
    case COHORT_LIGHT_DISK:
        setup_flat(light, desc);
        setup_shaping(light, desc);
        break;
    case COHORT_LIGHT_SPHERE:
        setup_sphere(light, desc);
        setup_shaping(light, desc);
        break;
    case COHORT_LIGHT_DISTANT:
        setup_distant(light, desc);
        break;
    case COHORT_LIGHT_DOME:
        setup_dome_axes(light, desc);
        break;
    }
    light->strength = (light->radiance.x + light->radiance.y + light->radiance.z) / 3.0f;
    if (light->image.pixels != NULL) {
        if (desc->type == COHORT_LIGHT_RECT)
            light->strength *= mean_of_image(&light->image);
        else if (!co_dome_light_build(light, err))
            return false;
    }
    light->is_active = light->strength > 0.0f;
    return true;
}

void co_light_teardown(CoLight *light)
{
    if (light->type == COHORT_LIGHT_DOME)
        co_dome_light_clear(light);
}
