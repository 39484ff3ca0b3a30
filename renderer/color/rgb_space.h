// USD's built-in color spaces as numbers: primaries, white and curve, and matrices between them.
//
// Source: the names and definitions of USD's GfColorSpaceNames; white points other than D65 are
// adapted to D65 (Bradford), as USD has them.

#ifndef CO_COLOR_RGB_SPACE_H
#define CO_COLOR_RGB_SPACE_H

#include <stdbool.h>

typedef enum CoCurve {
    CO_CURVE_LINEAR = 0,
    CO_CURVE_SRGB, // IEC 61966-2-1
    CO_CURVE_GAMMA // pure power
} CoCurve;

typedef struct CoRgbSpace {
    const char *name;
    CoCurve curve;
    float gamma;
    bool is_data; // passes unchanged
    double xy[8]; // red, green, blue, white chromaticities
} CoRgbSpace;

// By USD's name, or "sRGB" (sRGB curve, Rec.709 primaries); NULL: not built in.
const CoRgbSpace *co_rgb_space_find(const char *name);

// Row-major linear RGB -> XYZ adapted to D65, and its inverse.
void co_rgb_space_to_xyz(const CoRgbSpace *space, double out[9]);
void co_matrix3_mul(const double a[9], const double b[9], double out[9]);
bool co_matrix3_invert(const double a[9], double out[9]);

// Row-major linear RGB of one space -> linear RGB of another, and its use on three floats in place.
void co_rgb_space_matrix(const CoRgbSpace *from, const CoRgbSpace *to, float out[9]);
void co_rgb_matrix_apply(const float m[9], float *rgb);

// Decodes one channel to linear. Negative values mirror.
float co_rgb_space_decode(const CoRgbSpace *space, float value);

#endif
