// Colors of black bodies by their temperature.

#include "light/light_internal.h"

// Planck's law through the CIE 1931 observer (c2 = 1.4387769e-2 m K) in linear Rec.709, from 1000 K
// in steps of 500 K, largest channel 1. Where blue would be negative (below 2000 K) white is added
// until it is zero; this is what UsdLuxBlackbodyTemperatureAsRgb's values show, too.
enum {
    KNOTS = 19
};
static const float knots[KNOTS][3] = {
    {1.000000f, 0.027728f, 0.000000f}, {1.000000f, 0.149789f, 0.000000f},
    {1.000000f, 0.256765f, 0.008140f}, {1.000000f, 0.372147f, 0.067534f},
    {1.000000f, 0.476837f, 0.153729f}, {1.000000f, 0.570486f, 0.259377f},
    {1.000000f, 0.653586f, 0.377396f}, {1.000000f, 0.726980f, 0.501918f},
    {1.000000f, 0.791638f, 0.628439f}, {1.000000f, 0.848548f, 0.753699f},
    {1.000000f, 0.898656f, 0.875460f}, {1.000000f, 0.942834f, 0.992283f},
    {0.906351f, 0.889915f, 1.000000f}, {0.827693f, 0.841302f, 1.000000f},
    {0.765270f, 0.801364f, 1.000000f}, {0.714762f, 0.768049f, 1.000000f},
    {0.673212f, 0.739894f, 1.000000f}, {0.638540f, 0.715831f, 1.000000f},
    {0.609245f, 0.695060f, 1.000000f},
};

static CoVec3 knot(int i)
{
    return co_vec3_load(knots[i < 0 ? 0 : i >= KNOTS ? KNOTS - 1 : i]);
}

CoVec3 co_blackbody_rgb(float kelvin)
{
    float x = (co_clamp(isnan(kelvin) ? 6500.0f : kelvin, 1000.0f, 10000.0f) - 1000.0f) / 500.0f;
    int i = x >= (float)(KNOTS - 2) ? KNOTS - 2 : (int)x;
    float u = x - (float)i;
    CoVec3 a = knot(i - 1), b = knot(i), c = knot(i + 1), d = knot(i + 2);

    // Catmull-Rom, weights of the four knots.
    float wa = 0.5f * u * (u * (2.0f - u) - 1.0f);
    float wb = 0.5f * (u * u * (3.0f * u - 5.0f) + 2.0f);
    float wc = 0.5f * u * (u * (4.0f - 3.0f * u) + 1.0f);
    float wd = 0.5f * u * u * (u - 1.0f);
    CoVec3 rgb = co_scale(a, wa);
    rgb = co_madd(rgb, b, wb);
    rgb = co_madd(rgb, c, wc);
    rgb = co_madd(rgb, d, wd);
    float luminance = 0.2126f * rgb.x + 0.7152f * rgb.y + 0.0722f * rgb.z;
    return co_vec3(fmaxf(rgb.x / luminance, 0.0f), fmaxf(rgb.y / luminance, 0.0f),
                   fmaxf(rgb.z / luminance, 0.0f));
}
