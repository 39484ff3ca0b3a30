// Writing and reading pictures: scene-linear EXR with metadata, display PNG through OCIO.
//
// Pixel rows go from top to bottom. Files are written under another name and moved into place, so a
// failed write never leaves half a picture. Threads: distinct calls may run at once.

#ifndef COHORT_IMAGE_H
#define COHORT_IMAGE_H

#include "cohort/base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum CohortChannelType {
    COHORT_CHANNEL_FLOAT = 0,
    COHORT_CHANNEL_HALF,
    COHORT_CHANNEL_UINT
} CohortChannelType;

// One EXR channel and where its samples lie in memory.
typedef struct CohortChannel {
    const char *name;       // "R", "normal.X", "Z", ...
    CohortChannelType type; // in the file
    const void *pixels;     // first sample: float, or uint32_t for COHORT_CHANNEL_UINT
    size_t stride;          // bytes from one pixel to the next; rows follow without gaps
} CohortChannel;

typedef enum CohortAttributeType {
    COHORT_ATTRIBUTE_STRING = 0,
    COHORT_ATTRIBUTE_INT,
    COHORT_ATTRIBUTE_FLOAT,
    COHORT_ATTRIBUTE_M44F,          // 16 floats, row vectors
    COHORT_ATTRIBUTE_V2F,           // 2 floats
    COHORT_ATTRIBUTE_CHROMATICITIES // 8 floats: red, green, blue, white xy
} CohortAttributeType;

typedef struct CohortAttribute {
    const char *name;
    CohortAttributeType type;
    const char *text;
    int32_t integer;
    float numbers[16];
} CohortAttribute;

typedef enum CohortCompression {
    COHORT_COMPRESSION_ZIP = 0, // 16 scanlines a block
    COHORT_COMPRESSION_ZIPS,
    COHORT_COMPRESSION_PIZ,
    COHORT_COMPRESSION_RLE,
    COHORT_COMPRESSION_NONE
} CohortCompression;

typedef struct CohortExrDesc {
    uint32_t width, height;
    float pixel_aspect; // 0 = 1
    CohortCompression compression;
    const CohortChannel *channels;
    size_t channel_count;
    const CohortAttribute *attributes;
    size_t attribute_count;
} CohortExrDesc;

// Writes a single-part scanline EXR; channels are stored sorted by name. COHORT_ERROR_ARGUMENT: no
// pixels or channels, a name that is empty, too long (31 bytes) or there twice; _FILE_WRITE: as the
// system says.
bool cohort_exr_write(const char *path, const CohortExrDesc *desc, CohortError *err);

// A picture in memory: every channel as float (UINT converted).
typedef struct CohortImage {
    uint32_t width, height;
    size_t channel_count;
    char (*names)[64]; // [channel_count]
    float *pixels;     // [channel_count][height][width]
} CohortImage;

// Reads the first part of an EXR, scanlines without subsampling. Free with cohort_image_clear. *out
// is as it was when this fails: COHORT_ERROR_FILE_NOT_FOUND, _IMAGE for what is no such EXR, _LIMIT
// where it is too large, _OUT_OF_MEMORY.
bool cohort_exr_read(const char *path, CohortImage *out, CohortError *err);
void cohort_image_clear(CohortImage *image);

// "3.1.5"; static.
const char *cohort_exr_library_version(void);

// Index of a channel by name, -1 if there is none.
int cohort_image_channel(const CohortImage *image, const char *name);

// ---- Views -----------------------------------------------------------------------------------

typedef struct CohortView CohortView;

// From a rendering space through a display and view. config NULL = $OCIO, else the config that
// Cohort carries (ACES CG), whose plain sRGB view is then the default: colors as they are, no tone
// mapping. display, view NULL = the config's default. A display or view that does not exist is
// COHORT_ERROR_ARGUMENT and named, with those that do; a config that cannot be used is
// COHORT_ERROR_COLOR.
CohortView *cohort_view_create(const char *config, const char *rendering_space, const char *display,
                               const char *view, CohortError *err);
void cohort_view_destroy(CohortView *view);

// Names in effect; live as long as the view.
const char *cohort_view_display_name(const CohortView *view);
const char *cohort_view_view_name(const CohortView *view);
const char *cohort_view_config_name(const CohortView *view);
const char *cohort_view_config_cache_id(const CohortView *view);

// Transforms `count` straight RGBA pixels in place; alpha comes back bit for bit. NaN and
// infinities are replaced before (0 and the largest float), and counted in *replaced (may be NULL).
// COHORT_ERROR_COLOR when the config's transform fails. Threads: several may apply one view.
bool cohort_view_apply(const CohortView *view, float *rgba, size_t count, uint64_t *replaced,
                       CohortError *err);

// Writes width x height premultiplied scene-linear RGBA through a view to an 8-bit PNG with
// straight alpha. COHORT_ERROR_ARGUMENT for a size that PNG does not have, else as cohort_exr_write
// and cohort_view_apply.
bool cohort_png_write(const char *path, uint32_t width, uint32_t height, const float *rgba,
                      const CohortView *view, CohortError *err);

// The name and chromaticities (red, green, blue, white xy) of a rendering space, as the EXR header
// states them. name holds 128 bytes. config, rendering_space: as CohortSceneOptions has them.
// COHORT_ERROR_COLOR for what does not exist.
bool cohort_rendering_space(const char *config, const char *rendering_space, char *name,
                            float chromaticities[8], CohortError *err);

#ifdef __cplusplus
}
#endif

#endif
