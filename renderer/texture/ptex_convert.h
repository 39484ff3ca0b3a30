// Display-encoded Ptex files made linear, so that filters add up light and not codes.

#ifndef CO_TEXTURE_PTEX_CONVERT_H
#define CO_TEXTURE_PTEX_CONVERT_H

#include "texture/converted.h"
#include "texture/ptex_block.h"

// The color space of a Ptex file, which has no word for it itself: what the desc says; else what
// the file rules of the color config say of its name; else sRGB for uint8 and three or four
// channels; else raw.
CoTextureColor co_ptex_color(const CoTexturesOptions *options, const CohortTextureDesc *desc,
                             const CoPtexFile *file);

// Makes the linear form (float32) of an open file unless it is there; *out is its path
// (co_path_free). Coarser levels are rebuilt from linear texels, or with
// options->ptex_reductions_authored converted from those the file has.
bool co_ptex_convert(const CoTextureColor *color, const char *path, const CoPtexFile *file,
                     char **out, CohortError *err);

#endif
