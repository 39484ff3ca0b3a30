// Color: the rendering space, what converts into it, and views for people (OpenColorIO).
//
// With no config named and none in $OCIO the rendering space is linear Rec.709 and display images
// use the shipped config's sRGB display. Nothing is converted twice; data never.

#ifndef CO_COLOR_COLOR_H
#define CO_COLOR_COLOR_H

#include "cohort/base.h"

typedef struct CoColor CoColor;

// config_path: NULL = $OCIO, else none. rendering_space: NULL or "" = the config's scene_linear
// role, else linear Rec.709. USD's built-in names (lin_rec709_scene, lin_ap1_scene,
// srgb_rec709_scene, raw ...) are understood with and without a config. A space that cannot be
// found is an error naming it.
CoColor *co_color_create(const char *config_path, const char *rendering_space, CohortError *err);
void co_color_destroy(CoColor *color);

// Converts count RGBA pixels in place from a space ("sRGB", a USD name, or one of the config) into
// the rendering space; alpha is kept bit for bit. `color` is the CoColor. Fits
// CoTexturesOptions.to_rendering.
bool co_color_to_rendering(void *color, const char *space, float *pixels, size_t count,
                           CohortError *err);

// The space that the config's file rules give a file of that name, the Default rule aside; NULL
// when none does. `color` is the CoColor. Fits CoTexturesOptions.space_of_file.
const char *co_color_space_of_file(void *color, const char *path);

// Row-major 3x3 from linear Rec.709 into the rendering space, and the space's chromaticities
// (red xy, green xy, blue xy, white xy) for the EXR header.
void co_color_rec709_matrix(const CoColor *color, float out[9]);
void co_color_chromaticities(const CoColor *color, float out[8]);
const char *co_color_space_name(const CoColor *color); // as the config or USD spells it

#endif
