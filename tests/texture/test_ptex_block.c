// Ptex texels: blocks as they were written, halvings, weighted sums.

#include "texture_support.h"

#include "base/memory.h"
#include "texture/half.h"
#include "texture/ptex_block.h"

static void halves_are_the_formats_own(void **state)
{
    (void)state;
    uint8_t bytes[] = {1, 2, 255, 255, 0, 1, 7, 8};
    co_ptex_halve(CO_PTEX_U8, 1, 2, 1, false, bytes);
    const uint8_t across[] = {1, 255, 0, 7};
    assert_memory_equal(bytes, across, 4);
    co_ptex_halve(CO_PTEX_U8, 1, 1, 1, true, bytes);
    assert_true(bytes[0] == 0 && bytes[1] == 131);
    uint16_t words[] = {65535, 65534};
    co_ptex_halve(CO_PTEX_U16, 1, 1, 0, false, words);
    assert_int_equal(words[0], 65534);
    uint16_t halves[] = {co_half_from_float(1.0f), co_half_from_float(2.0f)};
    co_ptex_halve(CO_PTEX_F16, 1, 1, 0, false, halves);
    assert_true(co_half_to_float(halves[0]) == 1.5f);
    // Channels are planes: two of 1 x 2.
    float floats[] = {1, 3, -10, 10};
    co_ptex_halve(CO_PTEX_F32, 2, 0, 1, true, floats);
    assert_true(floats[0] == 2 && floats[1] == 0);
}

static void sums_are_weighted_by_rows_and_columns(void **state)
{
    (void)state;
    const float ku[] = {.5f, 2}, kv[] = {1, .25f};
    const CoPtexPart part = {.u = 1, .v = 0, .uw = 2, .vw = 2, .ku = ku, .kv = kv};
    const uint8_t bytes[16] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 20, 30, 40, 50, 60, 70};
    const uint16_t channels[] = {1, 0}; // planes of 4 x 2
    float sum[2];
    co_ptex_sum(CO_PTEX_U8, bytes, 2, 1, &part, channels, 2, sum);
    assert_true(sum[1] == (.5f * 2 + 2 * 3) + .25f * (.5f * 6 + 2 * 7));
    assert_true(sum[0] == (.5f * 10 + 2 * 20) + .25f * (.5f * 50 + 2 * 60));
}

static void pixels_are_read_in_their_type(void **state)
{
    (void)state;
    const uint8_t bytes[] = {3, 200};
    const uint16_t words[] = {3, 60000}, halves[] = {0, co_half_from_float(-.5f)};
    const float floats[] = {3, 1e20f};
    assert_true(co_ptex_pixel_value(CO_PTEX_U8, bytes, 1) == 200);
    assert_true(co_ptex_pixel_value(CO_PTEX_U16, words, 1) == 60000);
    assert_true(co_ptex_pixel_value(CO_PTEX_F16, halves, 1) == -.5f);
    assert_true(co_ptex_pixel_value(CO_PTEX_F32, floats, 1) == 1e20f);
    assert_true(co_ptex_one(CO_PTEX_U8) == 255 && co_ptex_one(CO_PTEX_F32) == 1);
}

// Faces of every type, small and so large that the writer cuts them into tiles, come back.
static void blocks_are_as_they_were_written(void **state)
{
    (void)state;
    static const struct {
        CoPtexType type;
        int log2;
    } kinds[] = {{CO_PTEX_U8, 1},  {CO_PTEX_U8, 5},  {CO_PTEX_U16, 4},
                 {CO_PTEX_F16, 3}, {CO_PTEX_F32, 4}, {CO_PTEX_U8, 9}};
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        CohortError err = {0};
        int log2 = kinds[k].log2;
        write_grid(in_folder("kinds.ptx"), 1, log2, kinds[k].type, 2);
        CoPtexFile *file = co_ptex_open(in_folder("kinds.ptx"), &err);
        assert_non_null(file);
        size_t size = co_ptex_block_size(file, log2, log2), count = (size_t)1 << 2 * log2;
        assert_int_equal(size, count * 2 * co_ptex_type_size(kinds[k].type));
        unsigned char *texels = malloc(size);
        CoPtexDecoder decoder = {0};
        assert_true(co_ptex_block_decode(file, file->level_block[0], log2, log2, &decoder, texels));
        size_t step = co_ptex_type_size(kinds[k].type);
        for (size_t i = 0; i < count; i++)
            for (size_t c = 0; c < 2; c++) { // planes here, interleaved there
                float value = random_at(0, 2 * i + c), got;
                got = co_ptex_pixel_value(kinds[k].type, texels + (c * count + i) * step, 0);
                float want = kinds[k].type == CO_PTEX_F32  ? value
                             : kinds[k].type == CO_PTEX_U8 ? (float)(uint8_t)(value * 255.0f)
                                                           : (float)(uint16_t)(value * 65535.0f);
                if (kinds[k].type == CO_PTEX_F16)
                    want = co_half_to_float((uint16_t)(value * 65535.0f));
                assert_true(got == want || (got != got && want != want));
            }
        co_ptex_decoder_clear(&decoder);
        co_ptex_close(file);
        free(texels);
    }
    assert_int_equal(co_memory_live(CO_MEMORY_TEXTURE), 0);
}

static void broken_streams_are_refused(void **state)
{
    (void)state;
    write_grid(in_folder("broken.ptx"), 1, 4, CO_PTEX_U8, 1);
    CoPtexFile *file = co_ptex_open(in_folder("broken.ptx"), NULL);
    unsigned char texels[1 << 8];
    CoPtexDecoder decoder = {0};
    CoPtexBlock *block = &file->blocks[file->level_block[0]];
    assert_true(co_ptex_block_decode(file, file->level_block[0], 4, 4, &decoder, texels));
    block->offset += 1;
    assert_false(co_ptex_block_decode(file, file->level_block[0], 4, 4, &decoder, texels));
    assert_false(co_ptex_decoder_is_short(&decoder));
    co_ptex_decoder_clear(&decoder);
    co_ptex_close(file);
}

// Nor is what was short of memory once short of it ever after: damage is told from it.
static void tiles_without_memory_are_not_broken(void **state)
{
    (void)state;
    write_grid(in_folder("tiles.ptx"), 1, 8, CO_PTEX_U8, 3);
    CohortError err = {0};
    CoPtexFile *file = co_ptex_open(in_folder("tiles.ptx"), &err);
    assert_non_null(file);
    const uint32_t whole = file->level_block[0], tile = file->tilings[0].first;
    const CoPtexTiling *tiling = &file->tilings[0];
    static unsigned char want[3 << 16], got[3 << 16];
    CoPtexDecoder decoder = {0};
    assert_true(co_ptex_block_decode(file, whole, 8, 8, &decoder, want));
    co_ptex_decoder_clear(&decoder);
    co_memory_fail_after(1);
    assert_false(co_ptex_block_decode(file, whole, 8, 8, &decoder, got));
    co_memory_fail_after(0);
    assert_true(co_ptex_decoder_is_short(&decoder));
    file->blocks[tile].offset += 1;
    assert_false(co_ptex_block_decode(file, tile, tiling->ulog2, tiling->vlog2, &decoder, got));
    assert_false(co_ptex_decoder_is_short(&decoder));
    file->blocks[tile].offset -= 1;
    assert_true(co_ptex_block_decode(file, whole, 8, 8, &decoder, got));
    assert_memory_equal(got, want, sizeof want);
    co_ptex_decoder_clear(&decoder);
    co_ptex_close(file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(halves_are_the_formats_own),
        cmocka_unit_test(sums_are_weighted_by_rows_and_columns),
        cmocka_unit_test(pixels_are_read_in_their_type),
        cmocka_unit_test(blocks_are_as_they_were_written),
        cmocka_unit_test(broken_streams_are_refused),
        cmocka_unit_test(tiles_without_memory_are_not_broken),
    };
    return cmocka_run_group_tests(tests, test_folder_make, test_folder_remove);
}
