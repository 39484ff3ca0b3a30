// The folder of converted textures: images as linear tiled mip files, display-encoded Ptex files as
// linear ones. A file there is named by what it was made from (the bytes of the source) and by what
// was done to its colors, so it never goes stale; it is made once and may be deleted at any time.

#ifndef CO_TEXTURE_CONVERTED_H
#define CO_TEXTURE_CONVERTED_H

#include "texture/texture.h"

// How the colors of a file become linear colors of the rendering space.
typedef struct CoTextureColor {
    bool is_raw;
    const char *space; // else: "sRGB" or a named space
    const CoTexturesOptions *options;
} CoTextureColor;

// The colors of a texture as its description has them; `auto_is_raw` decides for COHORT_COLOR_AUTO.
CoTextureColor co_texture_color(const CoTexturesOptions *options, const CohortTextureDesc *desc,
                                bool auto_is_raw);

// A space by name, "raw" among them.
CoTextureColor co_texture_named(const CoTexturesOptions *options, const char *space);

// The colors that the file rules of the color config give a file; false where they have no word for
// it.
bool co_texture_ruled(const CoTexturesOptions *options, const char *path, CoTextureColor *out);

// Converts `count` pixels of `channels` floats in place: one is gray, two are gray and alpha, three
// are RGB, and from the fourth on nothing is color. What is not finite becomes 0. False when the
// color space is unknown.
bool co_texture_to_linear(const CoTextureColor *color, float *pixels, size_t count,
                          uint32_t channels, CohortError *err);

// The sRGB transfer curve (IEC 61966-2-1), decoded; negative values are mirrored.
float co_srgb_decode(float encoded);

// Path of the converted form of `source` with the given extension (".exr", ".ptx"); its folder is
// made. `*out` is freed with co_path_free. `settings` tells further what the result depends on.
bool co_converted_path(const CoTextureColor *color, const char *source, uint64_t settings,
                       const char *extension, char **out, CohortError *err);

// Whether so many bytes can be written beside `path`: limits, free blocks, and quotas, by taking
// them for a moment.
bool co_converted_room(const char *path, size_t bytes, CohortError *err);

// A name beside `path`, which co_converted_path has given, to write to before co_converted_publish
// moves it there in one step. Such files that have not been written to for an hour are removed.
// False, with the way out, where none can be made.
bool co_converted_temporary(const char *path, char **out, CohortError *err);
bool co_converted_publish(const char *temporary, const char *path, CohortError *err);

// Copies a string; NULL without memory.
char *co_path_copy(const char *path);
void co_path_free(char *path);

#endif
