#include "color/rgb_space.h"

#include "math/elementary.h"

#include <string.h>

#define D65 0.3127, 0.3290
#define REC709 \
    { \
        0.640, 0.330, 0.300, 0.600, 0.150, 0.060, D65 \
    }
#define P3 \
    { \
        0.680, 0.320, 0.265, 0.690, 0.150, 0.060, D65 \
    }
#define REC2020 \
    { \
        0.708, 0.292, 0.170, 0.797, 0.131, 0.046, D65 \
    }
#define ADOBE \
    { \
        0.640, 0.330, 0.210, 0.710, 0.150, 0.060, D65 \
    }
#define AP0 \
    { \
        0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.0770, 0.32168, 0.33767 \
    }
#define AP1 \
    { \
        0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767 \
    }
#define XYZ \
    { \
        1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0 / 3.0, 1.0 / 3.0 \
    }

static const CoRgbSpace spaces[] = {
    {"lin_rec709_scene", CO_CURVE_LINEAR, 1.0f, false, REC709},
    {"lin_p3d65_scene", CO_CURVE_LINEAR, 1.0f, false, P3},
    {"lin_rec2020_scene", CO_CURVE_LINEAR, 1.0f, false, REC2020},
    {"lin_adobergb_scene", CO_CURVE_LINEAR, 1.0f, false, ADOBE},
    {"lin_ap0_scene", CO_CURVE_LINEAR, 1.0f, false, AP0},
    {"lin_ap1_scene", CO_CURVE_LINEAR, 1.0f, false, AP1},
    {"lin_ciexyzd65_scene", CO_CURVE_LINEAR, 1.0f, false, XYZ},
    {"srgb_rec709_scene", CO_CURVE_SRGB, 2.4f, false, REC709},
    {"sRGB", CO_CURVE_SRGB, 2.4f, false, REC709},
    {"srgb_p3d65_scene", CO_CURVE_SRGB, 2.4f, false, P3},
    {"srgb_ap1_scene", CO_CURVE_SRGB, 2.4f, false, AP1},
    {"g18_rec709_scene", CO_CURVE_GAMMA, 1.8f, false, REC709},
    {"g22_rec709_scene", CO_CURVE_GAMMA, 2.2f, false, REC709},
    {"g24_rec709_scene", CO_CURVE_GAMMA, 2.4f, false, REC709},
    {"g22_ap1_scene", CO_CURVE_GAMMA, 2.2f, false, AP1},
    {"g22_adobergb_scene", CO_CURVE_GAMMA, 2.2f, false, ADOBE},
    {"identity", CO_CURVE_LINEAR, 1.0f, true, REC709},
    {"raw", CO_CURVE_LINEAR, 1.0f, true, REC709},
    {"data", CO_CURVE_LINEAR, 1.0f, true, REC709},
    {"unknown", CO_CURVE_LINEAR, 1.0f, true, REC709},
};

const CoRgbSpace *co_rgb_space_find(const char *name)
{
    for (size_t i = 0; i < sizeof spaces / sizeof spaces[0]; i++)
        if (!strcmp(spaces[i].name, name))
            return &spaces[i];
    return NULL;
}

void co_matrix3_mul(const double a[9], const double b[9], double out[9])
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            out[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
}

bool co_matrix3_invert(const double m[9], double out[9])
{
    double c[9] = {m[4] * m[8] - m[5] * m[7], m[2] * m[7] - m[1] * m[8], m[1] * m[5] - m[2] * m[4],
                   m[5] * m[6] - m[3] * m[8], m[0] * m[8] - m[2] * m[6], m[2] * m[3] - m[0] * m[5],
                   m[3] * m[7] - m[4] * m[6], m[1] * m[6] - m[0] * m[7], m[0] * m[4] - m[1] * m[3]};
    double det = m[0] * c[0] + m[1] * c[3] + m[2] * c[6];
    if (det == 0.0)
        return false;
    for (int i = 0; i < 9; i++)
        out[i] = c[i] / det;
    return true;
}

static void white_xyz(double x, double y, double out[3])
{
    out[0] = x / y;
    out[1] = 1.0;
    out[2] = (1.0 - x - y) / y;
}

static void apply3(const double m[9], const double v[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = m[3 * i] * v[0] + m[3 * i + 1] * v[1] + m[3 * i + 2] * v[2];
}

// Bradford adaptation from a white to D65.
static void adapt_to_d65(const double white[3], double out[9])
{
    static const double cone[9] = {0.8951, 0.2664, -0.1614, -0.7502, 1.7135,
                                   0.0367, 0.0389, -0.0685, 1.0296};
    static const double d65_xy[2] = {D65};
    double d65[3], from[3], to[3], inverse[9], scaled[9];
    white_xyz(d65_xy[0], d65_xy[1], d65);
    apply3(cone, white, from);
    apply3(cone, d65, to);
    for (int i = 0; i < 9; i++)
        scaled[i] = cone[i] * to[i / 3] / from[i / 3];
    co_matrix3_invert(cone, inverse);
    co_matrix3_mul(inverse, scaled, out);
}

void co_rgb_space_to_xyz(const CoRgbSpace *space, double out[9])
{
    const double *xy = space->xy;
    double primaries[9], inverse[9], white[3], scale[3], adapt[9], plain[9];
    if (!strcmp(space->name, "lin_ciexyzd65_scene")) {
        static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
        memcpy(out, identity, sizeof identity);
        return;
    }
    for (int i = 0; i < 3; i++) {
        primaries[i] = xy[2 * i];
        primaries[3 + i] = xy[2 * i + 1];
        primaries[6 + i] = 1.0 - xy[2 * i] - xy[2 * i + 1];
    }
    white_xyz(xy[6], xy[7], white);
    co_matrix3_invert(primaries, inverse);
    apply3(inverse, white, scale);
    for (int i = 0; i < 9; i++)
        plain[i] = primaries[i] * scale[i % 3];
    adapt_to_d65(white, adapt);
    co_matrix3_mul(adapt, plain, out);
}

void co_rgb_space_matrix(const CoRgbSpace *from, const CoRgbSpace *to, float out[9])
{
    double to_xyz[9], from_xyz[9], target[9], m[9];
    co_rgb_space_to_xyz(from, to_xyz);
    co_rgb_space_to_xyz(to, target);
    co_matrix3_invert(target, from_xyz);
    co_matrix3_mul(from_xyz, to_xyz, m);
    for (int i = 0; i < 9; i++)
        out[i] = (float)m[i];
}

void co_rgb_matrix_apply(const float m[9], float *rgb)
{
    float r = rgb[0], g = rgb[1], b = rgb[2];
    for (int i = 0; i < 3; i++)
        rgb[i] = m[3 * i] * r + m[3 * i + 1] * g + m[3 * i + 2] * b;
}

float co_rgb_space_decode(const CoRgbSpace *space, float value)
{
    float x = fabsf(value), y = x;
    if (space->curve == CO_CURVE_SRGB)
        y = x <= 0.04045f ? x / 12.92f : co_powf((x + 0.055f) / 1.055f, 2.4f);
    else if (space->curve == CO_CURVE_GAMMA)
        y = co_powf(x, space->gamma);
    return copysignf(y, value);
}
