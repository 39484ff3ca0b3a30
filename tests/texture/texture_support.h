// What the texture tests share: random lookups, generated Ptex grids.

#ifndef TEST_TEXTURE_SUPPORT_H
#define TEST_TEXTURE_SUPPORT_H

#include "base/hash.h"
#include "support/files.h"
#include "texture/ptex_block.h"
#include "texture/ptex_write.h"
#include "texture/texture.h"

// A random number in [0, 1) that depends on nothing but its place.
static inline float random_at(uint64_t seed, uint64_t index)
{
    return (float)(co_hash_combine(seed, index) >> 40) * 0x1p-24f;
}

// A grid of side x side quads, joined at their edges; texels are a function of face and place.
static inline void write_grid(const char *path, uint32_t side, int log2, CoPtexType type,
                              uint32_t channels)
{
    CohortError err = {0};
    CoPtexWriteDesc desc = {.face_count = side * side, .type = type, .channels = channels};
    CoPtexWriter *writer = co_ptex_writer_create(path, &desc, &err);
    assert_non_null(writer);
    size_t size = co_ptex_type_size(type) * channels, count = (size_t)1 << 2 * log2;
    unsigned char *texels = malloc(size * count);
    for (uint32_t face = 0; face < side * side; face++) {
        int x = (int)(face % side), y = (int)(face / side), n = (int)side;
        CoPtexFace info = {.ulog2 = (int8_t)log2,
                           .vlog2 = (int8_t)log2,
                           .adjedges = 2 | 3 << 2 | 0 << 4 | 1 << 6,
                           .adjfaces = {y > 0 ? (int)face - n : -1, x + 1 < n ? (int)face + 1 : -1,
                                        y + 1 < n ? (int)face + n : -1,
                                        x > 0 ? (int)face - 1 : -1}};
        for (size_t i = 0; i < count * channels; i++) {
            float value = random_at(face, i);
            uint16_t word = (uint16_t)(value * 65535.0f);
            uint8_t byte = (uint8_t)(value * 255.0f);
            if (type == CO_PTEX_U8)
                texels[i] = byte;
            else if (type == CO_PTEX_F32)
                memcpy(texels + 4 * i, &value, 4);
            else
                memcpy(texels + 2 * i, &word, 2);
        }
        assert_true(
            co_ptex_writer_face(writer, face, &info, (const void *const[]){texels}, 1, &err));
    }
    free(texels);
    assert_true(co_ptex_writer_finish(writer, &err));
}

// One face of an open file at a resolution that it may not store; free it.
static inline void *texels_of(const CoPtexFile *file, uint32_t face, int ulog2, int vlog2)
{
    CohortError err = {0};
    CoPtexDecoder decoder = {0};
    void *texels = malloc(co_ptex_block_size(file, ulog2, vlog2));
    if (!co_ptex_face_texels(file, face, ulog2, vlog2, &decoder, texels, &err))
        fail_msg("%s", err.message);
    co_ptex_decoder_clear(&decoder);
    return texels;
}

// Warnings are counted, and the last one kept.
typedef struct Warnings {
    int count;
    char text[512];
} Warnings;

static inline void keep_warning(void *cookie, const char *place, const char *text)
{
    Warnings *warnings = cookie;
    warnings->count++;
    snprintf(warnings->text, sizeof warnings->text, "%s: %s", place, text);
}

static inline CoTextures *create_textures(Warnings *warnings, uint64_t resident)
{
    CohortError err = {0};
    CoTexturesOptions options = {.converted_folder = test_folder,
                                 .resident_bytes = resident,
                                 .warn = keep_warning,
                                 .warn_cookie = warnings};
    CoTextures *textures = co_textures_create(&options, &err);
    assert_non_null(textures);
    return textures;
}

// A folder for converted textures alone, which are then made anew.
static inline const char *converted_folder(void)
{
    static char path[320];
    snprintf(path, sizeof path, "%s/converted", test_folder);
    return path;
}

static inline void remove_converted(void *context, const char *path)
{
    (void)context;
    assert_int_equal(unlink(path), 0);
}

static inline void forget_converted(void)
{
    test_each_file(converted_folder(), remove_converted, NULL);
}

#endif
