// A converted image: tiles of all mip levels, linear float texels, in one file of the folder of
// converted textures. What is looked up is always such a file, whatever the image's format was.
//
// Terms: level 0 = full resolution; tile = square block of one level, row by row, level after
// level; its number is its place in the file.

#ifndef CO_TEXTURE_IMAGE_FILE_H
#define CO_TEXTURE_IMAGE_FILE_H

#include "cohort/scene.h"
#include "texture/inflate.h"

#define CO_IMAGE_LEVELS 24
#define CO_IMAGE_TILE 64 // side of a tile in texels

typedef struct CoImageLevel {
    uint32_t width, height;
    uint32_t across, down; // tiles
    uint32_t first;        // number of the first tile
} CoImageLevel;

typedef struct CoImageFile {
    char *path;
    uint32_t channels; // 1 to 4
    uint32_t level_count;
    CoImageLevel levels[CO_IMAGE_LEVELS];
    uint32_t tile_count;
    CoBlockStamp *stamps; // [tile_count]
} CoImageFile;

// Opens a converted image and checks that it is one. NULL with *err set.
CoImageFile *co_image_open(const char *path, CohortError *err);
void co_image_close(CoImageFile *image);

// One thread's open handles: reading a tile moves a handle's position, so no two threads share one.
#define CO_IMAGE_HANDLES 16
typedef struct CoImageReader {
    const CoImageFile *images[CO_IMAGE_HANDLES];
    void *handles[CO_IMAGE_HANDLES]; // of the OpenImageIO shim
    uint32_t next;                   // to be replaced
} CoImageReader;

void co_image_reader_clear(CoImageReader *reader);

// Reads one tile: CO_IMAGE_TILE^2 texels of `channels` floats, interleaved, rows from the top.
// Texels beyond the image's edge are undefined. Counted like an inflated block.
bool co_image_tile_read(CoImageReader *reader, const CoImageFile *image, uint32_t tile,
                        CoBlockCount *count, float *out);

#endif
