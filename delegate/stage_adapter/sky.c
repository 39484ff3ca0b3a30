// The built-in sky: a clear gradient, a soft sun over the viewer's right shoulder and a gray
// ground, in linear Rec.709. A white floor sends back about 0.8 and no part of the sky but the sun
// reaches 1, so that pictures need no exposure.

#include "stage_adapter/adapter.h"

#include "base/error.h"
#include "math/elementary.h"

#include <math.h>
#include <stdio.h>

enum {
    SKY_WIDTH = 512,
    SKY_HEIGHT = 256
};

static const float zenith[3] = {0.12f, 0.22f, 0.46f}, horizon[3] = {0.50f, 0.58f, 0.68f},
                   ground[3] = {0.20f, 0.19f, 0.18f}, sun[3] = {165.0f, 146.0f, 120.0f};

// cos^512: the sun's disk has no edge, so that any sampling of the image finds it.
static double sun_lobe(const double d[3])
{
    double cosine = d[0] * 0.48 + d[1] * 0.64 + d[2] * 0.60;
    if (cosine <= 0.0)
        return 0.0;
    for (int i = 0; i < 9; i++)
        cosine *= cosine;
    return cosine;
}

static void sky_color(const double d[3], float out[3])
{
    double up = d[1] > 0.0 ? 1.0 - d[1] : 0.0, lobe = d[1] > 0.0 ? sun_lobe(d) : 0.0;
    double haze = up * up * up;
    for (int i = 0; i < 3; i++) {
        double clear = (double)zenith[i] + haze * ((double)horizon[i] - (double)zenith[i]);
        out[i] = (float)(d[1] > 0.0 ? clear + lobe * (double)sun[i] : (double)ground[i]);
    }
}

// Ward's shared exponent: the largest component's mantissa fills a byte.
static void encode(const float rgb[3], unsigned char out[4])
{
    float largest = fmaxf(rgb[0], fmaxf(rgb[1], rgb[2]));
    int exponent;
    float scale = frexpf(largest, &exponent) * 256.0f / largest;
    for (int i = 0; i < 3; i++)
        out[i] = (unsigned char)(rgb[i] * scale);
    out[3] = (unsigned char)(exponent + 128);
}

static bool write_rows(FILE *file)
{
    unsigned char row[SKY_WIDTH * 4];
    for (int y = 0; y < SKY_HEIGHT; y++) {
        double up, level;
        co_sincos_d(CO_PI_D * (0.5 - (y + 0.5) / SKY_HEIGHT), &up, &level);
        for (int x = 0; x < SKY_WIDTH; x++) {
            // Longitude falls from +pi at the left edge; 0 looks at +Z, +pi/2 at +X.
            double east, south;
            co_sincos_d(CO_PI_D * (1.0 - 2.0 * (x + 0.5) / SKY_WIDTH), &east, &south);
            const double direction[3] = {level * east, up, level * south};
            float rgb[3];
            sky_color(direction, rgb);
            encode(rgb, row + (size_t)x * 4);
        }
        if (fwrite(row, 1, sizeof row, file) != sizeof row)
            return false;
    }
    return true;
}

bool co_sky_write(const char *path, CohortError *err)
{
    FILE *file = fopen(path, "wb");
    CO_CHECK(file, err, COHORT_ERROR_FILE_WRITE, "the sky image cannot be created at %.180s", path);
    bool ok = fprintf(file, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n", (int)SKY_HEIGHT,
                      (int)SKY_WIDTH) > 0 &&
              write_rows(file);
    ok = fclose(file) == 0 && ok;
    return ok ||
           CO_FAIL(err, COHORT_ERROR_FILE_WRITE, "the sky image cannot be written to %.180s", path);
}
