// OpenImageIO behind plain C: decoding images, making tiled mip files, reading their tiles.
//
// Everything here may be slow and is called once per image, but co_oiio_tile. Texels are float,
// interleaved, rows from the top, alpha as stored (never multiplied in). No color is converted
// here. The first call that opens an image loads OpenImageIO; where that fails, this call and
// all that follow fail with COHORT_ERROR_INSTALLATION.
// Threads: calls on different handles may run at once.

#ifndef CO_SHIMS_OIIO_H
#define CO_SHIMS_OIIO_H

#include "cohort/base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct CoOiioInfo {
    uint32_t width, height;
    uint32_t channels;           // that are read: 1 to 4
    bool is_8bit;                // stored so
    char format[16];             // OpenImageIO's name: "png", "openexr" ...
    char color_space[64];        // what OpenImageIO makes of the metadata; empty if nothing
    char wrap_s[16], wrap_t[16]; // "black", "clamp", "periodic", "mirror"; empty if not said
    bool has_chromaticities;
    float chromaticities[8]; // red, green, blue, white xy, as the file has them
} CoOiioInfo;

// Reads an image's header. Images of more than 2^28 texels are refused.
bool co_oiio_info(const char *path, CoOiioInfo *out, CohortError *err);

// Decodes it: `out` holds width * height * channels floats, all as co_oiio_info said; a file that
// has changed since is refused.
bool co_oiio_read(const char *path, const CoOiioInfo *info, float *out, CohortError *err);

// Writes texels and their mip levels (box filter, down to one texel) as a tiled float EXR with
// tiles of `tile` x `tile`. There must be room for it: OpenEXR 3.1 waits forever for a tile that
// could not be written.
bool co_oiio_write_mips(const char *path, const CoOiioInfo *info, const float *texels,
                        uint32_t tile, CohortError *err);

// A handle on such a file, or NULL.
typedef struct CoOiioFile CoOiioFile;
CoOiioFile *co_oiio_open(const char *path, CohortError *err);
void co_oiio_close(CoOiioFile *file);

// Size of one level; false when there is no such level.
bool co_oiio_level(CoOiioFile *file, uint32_t level, uint32_t *width, uint32_t *height,
                   uint32_t *channels, uint32_t *tile);

// Reads the tile at tile column x, row y into tile * tile * channels floats; what lies beyond the
// image is left as it is.
bool co_oiio_tile(CoOiioFile *file, uint32_t level, uint32_t x, uint32_t y, float *out,
                  CohortError *err);

// OpenImageIO's version, "2.4.7.1", of what Cohort was built with; static.
const char *co_oiio_version(void);

#ifdef __cplusplus
}
#endif

#endif
