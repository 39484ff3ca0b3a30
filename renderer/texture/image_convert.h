// Images on their way in: what color space they are in, decoding, conversion to tiled mip files.

#ifndef CO_TEXTURE_IMAGE_CONVERT_H
#define CO_TEXTURE_IMAGE_CONVERT_H

#include "shims/oiio.h"
#include "texture/converted.h"

// The color space of an image: what the desc says; else what the file's metadata say; else what the
// file rules of the color config say of its name; else sRGB for 8 bits and three or four channels;
// else raw.
CoTextureColor co_image_color(const CoTexturesOptions *options, const CohortTextureDesc *desc,
                              const char *path, const CoOiioInfo *info);

// The same of an image that is a color whatever it holds, as those of lights are: chromaticities
// count among its metadata, and where co_image_color says raw because nobody has a word for it, it
// is linear Rec.709. *unknown: so it is because its chromaticities are of no space known.
CoTextureColor co_light_image_color(const CoTexturesOptions *options, const CohortTextureDesc *desc,
                                    const char *path, const CoOiioInfo *info, bool *unknown);

// The wrap mode of an axis: what the desc says, else what the metadata say, else black.
CohortWrap co_image_wrap(CohortWrap wanted, const char *metadata);

// Decodes a whole image into linear texels of info->channels floats, rows from the top. Freed with
// co_free(CO_MEMORY_TEXTURE, ..., *size). NULL with *err set.
float *co_image_decode(const CoTextureColor *color, const char *path, const CoOiioInfo *info,
                       size_t *size, CohortError *err);

// Makes the converted form of an image unless it is there; *out is its path (co_path_free).
bool co_image_convert(const CoTextureColor *color, const char *path, const CoOiioInfo *info,
                      char **out, CohortError *err);

#endif
