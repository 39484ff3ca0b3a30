#include "color/png.h"

#include "base/error.h"
#include "base/memory.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#define ZLIB_CONST
#include <zlib.h>

enum {
    CHUNK_SIZE = 1 << 16,
    FILTERS = 5,
    PIXEL = 4,
    MOST_PIXELS = 1 << 24 // a side
};

typedef struct Png {
    FILE *file;
    z_stream stream;
    uint8_t *filtered; // [FILTERS][1 + row]: each row of pixels behind the number of its filter
    uint8_t chunk[CHUNK_SIZE];
} Png;

static void put_u32(uint8_t out[4], uint32_t x)
{
    for (int i = 0; i < 4; i++)
        out[i] = (uint8_t)(x >> (24 - 8 * i));
}

static bool put_chunk(FILE *file, const char *type, const uint8_t *data, uint32_t size)
{
    uint8_t head[8], tail[4];
    put_u32(head, size);
    memcpy(head + 4, type, 4);
    uLong sum = crc32(0, head + 4, 4);
    put_u32(tail, (uint32_t)(size ? crc32(sum, data, size) : sum));
    return fwrite(head, sizeof head, 1, file) == 1 && fwrite(data, 1, size, file) == size &&
           fwrite(tail, sizeof tail, 1, file) == 1;
}

static bool put_head(FILE *file, uint32_t width, uint32_t height)
{
    static const uint8_t signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    const uint8_t perceptual = 0;
    uint8_t header[13] = {[8] = 8, [9] = 6}; // 8 bits each of RGBA
    put_u32(header, width);
    put_u32(header + 4, height);
    return fwrite(signature, sizeof signature, 1, file) == 1 &&
           put_chunk(file, "IHDR", header, sizeof header) &&
           put_chunk(file, "sRGB", &perceptual, 1);
}

// ---- Filters: what is predicted of a byte from its neighbors is taken from it -------------------

static int paeth(int left, int up, int corner)
{
    int p = left + up - corner;
    int a = p > left ? p - left : left - p, b = p > up ? p - up : up - p;
    int c = p > corner ? p - corner : corner - p;
    return a <= b && a <= c ? left : b <= c ? up : corner;
}

static int predict(int filter, int left, int up, int corner)
{
    switch (filter) {
    case 1:
        return left;
    case 2:
        return up;
    case 3:
        return (left + up) / 2;
    case 4:
        return paeth(left, up, corner);
    default:
        return 0;
    }
}

// Filters a row; returns how far from zero its bytes are in sum, as signed numbers.
static uint64_t filter_row(int filter, const uint8_t *row, const uint8_t *above, size_t size,
                           uint8_t *out)
{
    uint64_t sum = 0;
    *out++ = (uint8_t)filter;
    for (size_t i = 0; i < size; i++) {
        int left = i < PIXEL ? 0 : row[i - PIXEL], up = above ? above[i] : 0;
        int corner = i < PIXEL || !above ? 0 : above[i - PIXEL];
        out[i] = (uint8_t)(row[i] - predict(filter, left, up, corner));
        sum += out[i] < 128 ? out[i] : 256u - out[i];
    }
    return sum;
}

// The filter that leaves the least, as the standard advises (12.8).
static const uint8_t *best_filter(Png *png, const uint8_t *row, const uint8_t *above, size_t size)
{
    const uint8_t *best = NULL;
    uint64_t least = UINT64_MAX;
    for (int filter = 0; filter < FILTERS; filter++) {
        uint8_t *out = png->filtered + (size_t)filter * (size + 1);
        uint64_t sum = filter_row(filter, row, above, size, out);
        if (sum < least) {
            least = sum;
            best = out;
        }
    }
    return best;
}

// ---- The stream ---------------------------------------------------------------------------------

static bool put_data(Png *png)
{
    uint32_t size = CHUNK_SIZE - png->stream.avail_out;
    png->stream.next_out = png->chunk;
    png->stream.avail_out = CHUNK_SIZE;
    return size == 0 || put_chunk(png->file, "IDAT", png->chunk, size);
}

static bool compress_bytes(Png *png, const uint8_t *bytes, size_t size, int flush)
{
    z_stream *z = &png->stream;
    z->next_in = bytes;
    z->avail_in = (uInt)size;
    int status = Z_OK;
    while (status == Z_OK && (z->avail_in || flush == Z_FINISH)) {
        status = deflate(z, flush);
        if ((z->avail_out == 0 || status == Z_STREAM_END) && !put_data(png))
            return false;
    }
    return status == Z_OK || status == Z_STREAM_END;
}

static bool put_image(Png *png, uint32_t width, uint32_t height, const uint8_t *rgba)
{
    size_t row = (size_t)width * PIXEL;
    bool ok = put_head(png->file, width, height);
    for (uint32_t y = 0; ok && y < height; y++) {
        const uint8_t *pixels = rgba + y * row;
        const uint8_t *filtered = best_filter(png, pixels, y ? pixels - row : NULL, row);
        ok = compress_bytes(png, filtered, row + 1, Z_NO_FLUSH);
    }
    return ok && compress_bytes(png, NULL, 0, Z_FINISH) && put_chunk(png->file, "IEND", NULL, 0);
}

static bool write_png(Png *png, uint32_t width, uint32_t height, const uint8_t *rgba)
{
    if (deflateInit(&png->stream, Z_DEFAULT_COMPRESSION) != Z_OK)
        return false;
    png->stream.next_out = png->chunk;
    png->stream.avail_out = CHUNK_SIZE;
    bool ok = put_image(png, width, height, rgba);
    deflateEnd(&png->stream);
    return ok;
}

bool co_png_write(const char *path, uint32_t width, uint32_t height, const uint8_t *rgba,
                  CohortError *err)
{
    CO_CHECK(width && height && width <= MOST_PIXELS && height <= MOST_PIXELS, err,
             COHORT_ERROR_ARGUMENT, "a PNG file cannot be %u x %u", (unsigned)width,
             (unsigned)height);
    size_t size = FILTERS * ((size_t)width * PIXEL + 1);
    Png *png = co_alloc_zero(CO_MEMORY_COLOR, sizeof *png);
    uint8_t *filtered = co_alloc(CO_MEMORY_COLOR, size);
    bool ok = png && filtered;
    if (ok) {
        png->filtered = filtered;
        errno = 0;
        png->file = fopen(path, "wb");
        ok = png->file && write_png(png, width, height, rgba);
        if (png->file)
            ok = fclose(png->file) == 0 && ok;
        if (!ok)
            CO_FAIL(err, COHORT_ERROR_FILE_WRITE, "cannot write %.150s: %s", path,
                    errno ? strerror(errno) : "compressing failed");
    } else {
        CO_FAIL(err, COHORT_ERROR_OUT_OF_MEMORY, "out of memory");
    }
    co_free(CO_MEMORY_COLOR, filtered, size);
    co_free(CO_MEMORY_COLOR, png, sizeof *png);
    return ok;
}
