// A PNG writer of stored (uncompressed) data, for making images of known content.

#ifndef TEST_PNG_SUPPORT_H
#define TEST_PNG_SUPPORT_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static inline uint32_t png_crc(uint32_t crc, const unsigned char *p, size_t size)
{
    crc = ~crc;
    for (size_t i = 0; i < size; i++) {
        crc ^= p[i];
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

static inline void png_u32(unsigned char *p, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        p[i] = (unsigned char)(value >> (24 - 8 * i));
}

static inline void png_chunk(FILE *file, const char *type, const unsigned char *data, uint32_t size)
{
    unsigned char head[8], tail[4];
    png_u32(head, size);
    memcpy(head + 4, type, 4);
    png_u32(tail, png_crc(png_crc(0, head + 4, 4), data, size));
    fwrite(head, 1, 8, file);
    fwrite(data, 1, size, file);
    fwrite(tail, 1, 4, file);
}

// Writes width x height pixels of 1 to 4 channels; values are 8 or 16 bits wide.
static inline void write_png(const char *path, uint32_t width, uint32_t height, uint32_t channels,
                             int bits, const uint16_t *values)
{
    static const unsigned char color_types[5] = {0, 0, 4, 2, 6};
    size_t row = (size_t)width * channels * (size_t)(bits / 8) + 1, size = row * height;
    unsigned char *raw = calloc(1, size), *zip = malloc(size + size / 65535 * 5 + 16), *at = zip;
    for (size_t i = 0; i < (size_t)width * height * channels; i++) {
        unsigned char *p =
            raw + i / (width * channels) * row + 1 + i % (width * channels) * (size_t)(bits / 8);
        if (bits == 16)
            *p++ = (unsigned char)(values[i] >> 8);
        *p = (unsigned char)values[i];
    }
    *at++ = 0x78;
    *at++ = 1;
    uint32_t a = 1, b = 0;
    for (size_t begin = 0; begin < size; begin += 65535) {
        size_t part = size - begin < 65535 ? size - begin : 65535;
        *at++ = begin + part == size;
        *at++ = (unsigned char)part, *at++ = (unsigned char)(part >> 8);
        *at++ = (unsigned char)~part, *at++ = (unsigned char)(~part >> 8);
        memcpy(at, raw + begin, part);
        at += part;
    }
    for (size_t i = 0; i < size; i++) {
        a = (a + raw[i]) % 65521;
        b = (b + a) % 65521;
    }
    png_u32(at, b << 16 | a);
    at += 4;
    unsigned char head[13] = {0};
    png_u32(head, width);
    png_u32(head + 4, height);
    head[8] = (unsigned char)bits;
    head[9] = color_types[channels];
    FILE *file = fopen(path, "wb");
    fwrite("\x89PNG\r\n\x1a\n", 1, 8, file);
    png_chunk(file, "IHDR", head, 13);
    png_chunk(file, "IDAT", zip, (uint32_t)(at - zip));
    png_chunk(file, "IEND", head, 0);
    fclose(file);
    free(raw);
    free(zip);
}

#endif
